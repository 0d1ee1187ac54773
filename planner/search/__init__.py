"""The search for a motion: the non-linear program, its solvers, and starts in parallel; the record of it in a plan."""
