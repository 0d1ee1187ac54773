"""Pages and figures: self-contained HTML, and the pictures that stand beside it as files."""
