"""Checks of a run beyond its samples: contact, wiring, and what every fit is asked."""
