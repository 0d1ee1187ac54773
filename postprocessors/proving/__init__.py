"""The proof of a program: what its text shows, what the controller answers for, and what nobody keeps."""
