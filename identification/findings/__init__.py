"""What is wrong with a run, or with its estimate: found, named with its rows, and left out where that is possible."""
