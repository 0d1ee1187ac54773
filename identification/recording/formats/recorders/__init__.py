"""Formats of text that recorders write, each a value; `known` lists them."""
