"""Runs of any length in constant memory: overlapping blocks, and one triangle for all of them."""
