"""The proof of a program: what its text shows, what the controller enforces, and what remains open."""
