"""Studies: grids of plans, runs and identifications on a Dask cluster, resumable."""
