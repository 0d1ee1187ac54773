"""What columns of recordings are, by their names and labels: words, families, meanings."""
