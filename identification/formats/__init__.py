"""Files of recorded runs, as tables of numbers in batches: one file a format, shared by all of them what is common."""
