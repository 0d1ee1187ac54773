"""What no case is in: errors, units and their names, files written whole, lazy doors of packages."""
