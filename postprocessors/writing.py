"""From a planned motion to a program's text that has been read back and proven; this module returns nothing else."""

from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.phrases import phrase
from cases.base.units import DEG, MM
from cases.schema import Case
from identification.limits.limit import NAMED, LimitKind
from identification.motion.motion import Trajectory
from identification.motion.moves import StraightMove
from identification.texts import bounds_text
from postprocessors.blocks import Blocks
from postprocessors.dialects.dialect import Dialect
from postprocessors.excitation import excitation_program
from postprocessors.program import Program, left_out
from postprocessors.proof.guarantees import Guarantees
from postprocessors.proof.proof import ProgramProof, override_remarks, prove_program, remarks
from postprocessors.reading import Reading
from postprocessors.same_motion import moved_lines, require_same, same_stretches


def proven_program(
    trajectory: Trajectory,
    case: Case,
    dialect: Dialect,
    file: Path | str,
    header: tuple[str, ...],
    speed: float = 1.0,
    accepted: Collection[str] = (),
) -> Program:
    """Writes a program and proves what it wrote.

    Args:
        trajectory: the excitation, from rest to rest.
        case: machine, limits, controller.
        file: name of the program.
        header: comment lines, those of `leaving_out` too, which the proof reads there; the proven limits are added.
        speed: share of the planned speed, above 0 and at most 1.
        accepted: families of limits that may stay without enforcement.

    Raises:
        ProgramError: the text, as read back, is not the planned motion, exceeds a limit, or relies on one that nobody
            enforces and that is not accepted.
        CaseError: the case has no machine or no controller.
    """
    path = Path(file)
    named = case if speed == 1.0 else case.named_slow()

    def read_back(slower: float) -> _ReadBack:
        return _read_back(trajectory, case, dialect, path, header, speed * slower, named)

    made = read_back(1.0)
    made, slowed = _slowed(made, read_back) if made.proof.violations else (made, ())
    program, reading, guarantees, proof = made
    proof.require_accepted(accepted)
    if dialect.same is None:
        require_same(program, reading, guarantees)
    else:
        dialect.same(program, reading, case)
    findings = (*_findings(proof), *slowed, *override_remarks(reading, guarantees))
    content = dialect.form(dialect.write((*header, *findings, *program), named), path.suffix.lower(), case)
    again = dialect.read(content, str(path), case)
    if not same_stretches(again, reading):
        raise ProgramError(
            file=path, problem="the header changes how the program reads", remedy="report this", code=Code.INTERNAL
        )
    proven = replace(proof, remarks=tuple(remarks(again, guarantees))).at_lines(moved_lines(reading, again))
    return Program(path, dialect, content, again, guarantees, case, remarks=slowed, proven=proven)


class _ReadBack(NamedTuple):
    """A motion as blocks, and what is read back from them."""

    program: Blocks
    reading: Reading
    guarantees: Guarantees
    proof: ProgramProof


def _read_back(
    trajectory: Trajectory, case: Case, dialect: Dialect, path: Path, header: tuple[str, ...], speed: float, named: Case
) -> _ReadBack:
    """Writes a program, reads it back and proves it; `named` is the case with the program's names."""
    promised = dialect.guarantees(Reading(file=str(path), stretches=(), blocks=0), case)
    blocks = excitation_program(trajectory, case, speed, promised)
    program = _without_nothing(dialect.prepare(blocks, case), promised.resolution, case)
    written = dialect.write((*header, *program), named)
    text = dialect.form(written, path.suffix.lower(), case)
    if lost := left_out(written) - left_out(text):
        raise ProgramError(
            file=path,
            problem=f"files that end in {path.suffix} hold no comment, which must say that the plan leaves out "
            f"{', '.join(sorted(lost))}",
            remedy=f"write {path.with_suffix(dialect.suffix).name}",
            code=Code.NOT_SUPPORTED,
        )
    reading = dialect.read(text, str(path), case)
    guarantees = replace(dialect.guarantees(reading, case), without=left_out(text))
    return _ReadBack(program, reading, guarantees, prove_program(reading, guarantees))


LONGER = 0.01  # share of its duration by which an excitation may last longer, so that its own points keep limits
INSIDE = 1e-5  # share of a limit that is left then
TRIES = 3  # for at another speed a controller has other points
ORDERS = {
    LimitKind.VELOCITY: 1, LimitKind.STRUT_VELOCITY: 1, LimitKind.ACCELERATION: 2, LimitKind.STRUT_ACCELERATION: 2,
    LimitKind.JERK: 3,
}  # fmt: skip
"""Powers of a motion's speed with which limited quantities grow."""


def _slowed(first: _ReadBack, read_back: Callable[[float], _ReadBack]) -> tuple[_ReadBack, tuple[str, ...]]:
    """A program that is slower by so little as its own points need, and the remark on that; else the first one.

    A controller goes through the points of a path as it does, which differs from the plan between them: where jerk
    steps in a plan that uses all of its limit, by up to a percent.
    """
    made, share = first, 1.0
    for _ in range(TRIES):
        orders = [ORDERS.get(check.kind.family) for check in made.proof.violations]
        if None in orders:
            return first, ()
        share *= min(
            ((1.0 - INSIDE) / check.ratio) ** (1.0 / order)
            for check, order in zip(made.proof.violations, orders, strict=True)
            if order is not None
        )
        if share * (1.0 + LONGER) < 1.0:
            return first, ()
        made = read_back(share)
        longer = _duration(made) / _duration(first) - 1.0  # controllers round to cycles of theirs
        if longer > LONGER:
            return first, ()
        if not made.proof.violations:
            worst = first.proof.violations[0]
            remark = phrase(
                "slowed_for_points",
                "{share} % slower than planned: at the plan's speed its points would take {limit} to {ratio} % of its "
                "limit",
                share=f"{100.0 * max(longer, 1.0 / share - 1.0):.2g}",
                limit=phrase(NAMED, "{name}", name=worst.name),
                ratio=f"{100.0 * worst.ratio:.2f}",
            )
            return made, (remark,)
    return first, ()


def _duration(made: _ReadBack) -> float:
    """Duration of what may last longer [s]: of the excitation; of standing poses, of the whole program."""
    return made.proof.excitation or made.proof.duration


def _without_nothing(program: Blocks, resolution: float, case: Case) -> Blocks:
    """The program without moves whose ends the control cannot tell apart, by its `resolution` [mm, deg]."""
    least = 2.0 * resolution * np.where(case.need_motion("a program")[1].turns, DEG, MM)
    return tuple(b for b in program if not (isinstance(b, StraightMove) and np.all(np.abs(b.end - b.start) <= least)))


PLUS_MINUS, PLAIN = "±", "+-"  # headers are plain ASCII


def _findings(proof: ProgramProof) -> tuple[str, ...]:
    """Lines of the header on the proof, which claim no more than was proven."""
    lines = [f"duration {proof.duration:.3f} s, excitation {proof.excitation:.3f} s", f"limits: {proof.verdict}"]
    for check in proof.limits.checks:
        text = f"{check.worst:.5g} {check.unit}, allowed {bounds_text(check).replace(PLUS_MINUS, PLAIN)}"
        lines.append(f"{check.name}: {text}; {check.status}{'' if check.binding else ' (predicted)'}")
    return tuple(lines)
