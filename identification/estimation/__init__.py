"""Estimators: from a regressor and forces to parameters with their covariance."""
