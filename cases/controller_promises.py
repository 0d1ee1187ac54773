"""Which limits of a case a controller keeps by itself, as far as its machine data have been set to them."""

from typing import Annotated, Literal

from pydantic import AfterValidator

Kept = Literal["velocity", "acceleration", "jerk", "strut velocity", "strut acceleration"]


def _once(names: tuple[Kept, ...]) -> tuple[Kept, ...]:
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise ValueError(f"names {twice[0]!r} twice; name each limit once")
    return names


Promises = Annotated[tuple[Kept, ...], AfterValidator(_once)]
"""Families of limits; each covers translations and rotations. An empty list promises nothing."""
