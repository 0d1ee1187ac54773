"""Quasi-static measurement: which poses to stand still at, in which order, and what they determine."""
