"""The last words of solvers, as people read them."""


def last_words(status: object) -> str:
    """A solver's return status in plain words."""
    return str(status).replace("_", " ").lower()


def solver_text(words: str) -> str:
    """A solver's last words as tables show them: to stop at the iterations that a stage has is not a failure."""
    plain = last_words(words)
    return "at its iteration limit" if "maximum iterations" in plain else plain
