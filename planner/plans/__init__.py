"""A plan: made from a request, rated, saved and loaded."""
