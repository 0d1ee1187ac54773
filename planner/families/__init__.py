"""Families of excitations: what the unknowns of an optimisation mean as a motion from rest to rest."""
