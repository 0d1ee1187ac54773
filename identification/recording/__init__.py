"""Recorded runs in SI units, and the formats of files that they are read from."""
