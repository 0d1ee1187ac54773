"""What an identification gives: estimates, results as folders, and their use for forces and payloads."""
