"""The proof of a program: what its controller guarantees, predicts and nobody enforces."""
