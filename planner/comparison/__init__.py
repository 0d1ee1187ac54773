"""Plans, runs and results side by side, and which excitation to prefer."""
