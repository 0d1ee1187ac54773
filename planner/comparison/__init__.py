"""Plans, runs and results side by side, which excitation to prefer, and what known weights say of each method."""
