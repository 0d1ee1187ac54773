"""Families of excitations: unknowns to motions, with exact derivatives, and what users ask of them."""
