"""Estimators: from a regressor and forces to parameters with their covariance, and what noise makes of them."""
