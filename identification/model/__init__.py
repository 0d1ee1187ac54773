"""The model of the measurement: regressors of Table 2, and the parameters behind the linear unknowns."""
