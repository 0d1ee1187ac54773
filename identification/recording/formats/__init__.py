"""Files of recorded runs, one file a format: tables of numbers in batches, and from these the streams of a run."""
