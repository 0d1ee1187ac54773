"""Causes of residuals far above the noise: hypotheses of what is wrong with a run or its case, all tried alike."""
