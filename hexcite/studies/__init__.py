"""Studies: many plans over a grid of settings, on all cores or a cluster, each cell kept."""
