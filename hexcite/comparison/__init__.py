"""Plans, runs and results side by side, and what known weights say of each method."""
