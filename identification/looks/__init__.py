"""Looks at files of unknown format."""
