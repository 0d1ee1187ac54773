"""Runs that repeat themselves: their period, its average, and derivatives without differences."""
