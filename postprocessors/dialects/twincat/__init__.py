"""TwinCAT CNC (TF5200) and other ISG kernels."""
