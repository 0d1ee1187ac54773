"""SINUMERIK 840D sl and ONE."""
