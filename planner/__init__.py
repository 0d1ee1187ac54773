"""Which motion is worth running: excitation families, their optimisation, comparison and the command line."""
