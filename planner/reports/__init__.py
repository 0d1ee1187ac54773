"""Pages, and pictures in files."""
