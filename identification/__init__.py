"""What a recorded run says about the parameters of the measurement model."""
