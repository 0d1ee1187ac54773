"""Quasi-static measurement: which poses are worth standing still at, in which order, and what they will tell."""
