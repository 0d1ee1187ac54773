"""What of a machine is kept apart: bodies of its links, of its tool and of its surroundings."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from cases.machine import Tool
from cases.schema import Case


class Bodies(NamedTuple):
    """The bodies of one part of a machine."""

    part: str  # surroundings, a joint by its name, whose link carries them, or tool
    bodies: tuple[Tool, ...]

    def to_json(self) -> dict[str, Any]:
        """The part, and each body with its shape."""
        shapes = [{"name": body.name, "shape": shape_of(body)} for body in self.bodies]
        return {"part": self.part, "bodies": shapes}


class Kept(NamedTuple):
    """Bodies and boxes of a case."""

    parts: tuple[Bodies, ...]  # all parts of a chain, the tool of a machine with struts
    boxes: tuple[str, ...]  # names of `keep_out`
    may_touch: tuple[tuple[str, str], ...] = ()  # pairs of bodies that are not kept apart

    def to_json(self) -> dict[str, Any]:
        """Parts, boxes, and pairs that may touch."""
        pairs = [list(pair) for pair in self.may_touch]
        return {"parts": [part.to_json() for part in self.parts], "boxes": list(self.boxes), "may_touch": pairs}

    def __repr__(self) -> str:
        """A line, with what has no body."""
        shown = [f"{part.part}: {_listed(part.bodies)}" for part in self.parts if part.bodies]
        bare = [part.part for part in self.parts if not part.bodies and part.part != SURROUNDINGS]
        lines = [f"kept apart: {'; '.join(shown) or 'no bodies'}; boxes: {', '.join(self.boxes) or 'none'}"]
        if self.may_touch:
            lines.append(f"may touch: {'; '.join(' and '.join(pair) for pair in self.may_touch)}")
        if bare:
            lines.append(f"without a body, so that nothing keeps it clear: {', '.join(bare)}")
        if any(shape_of(body) == HULL for part in self.parts for body in part.bodies):
            lines.append("hulls are measured as they are in proofs; searches keep the capsules around them apart")
        return "\n".join(lines)


ROUND, HULL = "round", "hull"
SURROUNDINGS, TOOL = "surroundings", "tool"


def shape_of(body: Tool) -> str:
    """Whether a body is round about an axis, or the convex hull of corners."""
    return ROUND if body.corners_mm is None else HULL


def _listed(bodies: Sequence[Tool]) -> str:
    return ", ".join(f"{body.name} ({shape_of(body)})" for body in bodies)


def kept_apart(case: Case) -> Kept | None:
    """The bodies and boxes of a case; None where it describes no machine."""
    if case.chain is not None:
        return Kept(tuple(_of_chain(case)), tuple(box.name for box in case.chain.keep_out), case.chain.may_touch)
    if case.hexapod is None or case.workspace is None:
        return None
    space = case.workspace
    return Kept((Bodies(TOOL, space.tool),), tuple(box.name for box in space.keep_out))


def _of_chain(case: Case) -> Iterator[Bodies]:
    assert case.chain is not None
    yield Bodies(SURROUNDINGS, case.chain.base)
    for joint in case.chain.joints:
        yield Bodies(joint.name, joint.bodies)
    yield Bodies(TOOL, case.chain.tool)
