"""Checks of a run beyond its samples: contact, causes, and what every fit is asked."""
