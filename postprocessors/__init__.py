"""A planned motion as a program for a controller, and back."""
