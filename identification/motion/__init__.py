"""Motions in the coordinates of a machine: time laws, moves, curves; no machine in it."""
