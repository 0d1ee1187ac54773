"""Motions in continuous time: time laws, straight, circular and re-timed moves, and motions that were executed."""
