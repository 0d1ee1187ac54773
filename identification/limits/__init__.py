"""What a case limits, how close a motion comes to it, and the numeric proof; shares nothing with the search."""
