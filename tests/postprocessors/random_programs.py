"""Random programs that are proven, and where what LinuxCNC executes differs from what was proven: poses over time."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from cases.base.errors import ProgramError
from cases.schema import Case, load_case
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.controllers.linuxcnc.configuration import AxisLayout
from postprocessors.program import Program, dialect
from postprocessors.proof.homing import motions
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Reading, Still, Timed, Untimed

Array = np.ndarray
Step = Callable[[], list[str]]

CASES = {name: load_case(name) for name in ("hexapod", "five_axis_table")}
PIECES = 8  # steps of a program that are tried; what the reader refuses or the proof finds exceeded is left out
CYCLES = 4.0  # by which a move may begin, end and be at a pose earlier or later; 3.6 in 1 of 1 000 programs
LONGER = 2e-3  # share of its duration by which it may last longer or shorter
CUT = 5e-5  # [m, rad] by which the path may leave the lines between timed points, and a move its course


class RandomProgram:
    """Draws a program step by step.

    Args:
        seed: of all that is drawn.
        case: the machine; its axes are those of a pose, or its own.
    """

    def __init__(self, seed: int, case: Case) -> None:
        self.draw, self.case = np.random.default_rng(seed), case
        self.layout = AxisLayout.of(case)
        home, limits = case.need_motion("a test")
        self.home, self.turns = home / self.layout.units, self.layout.turns
        self.room = 0.5 * np.minimum(np.abs(limits.coordinates).min(axis=0) / self.layout.units, 1e3)
        self.rates = limits.rate / self.layout.units
        self.place, self.way = self.home.copy(), np.zeros(len(self.home))
        words = " ".join(f"{a}{v:g}" for a, v in zip(self.layout.axes, self.home, strict=True))
        self.head = ["G17 G21 G40 G49 G54 G80 G90 G91.1 G94", "G92.1", "G61.1", f"G1 {words} F300"]

    def body(self) -> list[str]:
        """Lines of a program that is read and proven, from home and back."""
        steps: list[Step] = [self.move, self.move, self.rapid, self.collinear, self.collinear, self.dwell, self.mode]
        steps += (
            [self.trigger] if not self.layout.kinematics.startswith("genhex") else [self.trigger, self.arc, self.path]
        )
        body: list[str] = []
        for _ in range(PIECES):
            place, way = self.place.copy(), self.way.copy()
            lines = steps[self.draw.integers(len(steps))]()
            words = " ".join(f"{a}{v:.5f}" for a, v in zip(self.layout.axes, place, strict=True))
            # in its place, and readable behind all before it; feeds of lines that state none are those of the body
            if self.proven([f"G94 G1 {words} F3000", *lines]) is None or self.read([*body, *lines]) is None:
                self.place, self.way = place, way
            else:
                body += lines
        return [*body, "M65 P0", "G61.1", "G4 P0.01", self.head[-1]]

    def whole(self, body: list[str]) -> str:
        """The text around some lines."""
        return "\n".join([*self.head, *body, "G61.1", "G4 P0.01", self.head[-1], "M2", ""])

    def read(self, body: list[str]) -> Reading | None:
        """The reading of the program, where it is read."""
        try:
            return dialect("linuxcnc").read(self.whole(body).encode(), "p.ngc", self.case)
        except ProgramError:
            return None

    def proven(self, body: list[str]) -> Program | None:
        """The program, if it is read and inside its limits."""
        return proven(self.whole(body), self.case)

    def a_way(self) -> Array:
        """Of some axes, from a thousandth of a millimetre or degree to half of the room."""
        size = 10.0 ** self.draw.uniform(-3.0, 0.0, len(self.room)) * self.room
        return (
            size
            * self.draw.choice([-1.0, 1.0], len(size))
            * (self.draw.random(len(size)) < self.draw.uniform(0.2, 1.0))
        )

    def to(self, way: Array) -> str:
        """Words of the end of a way, of all axes or of those alone that move; sets the place."""
        end = np.clip(self.place + way, self.home - self.room, self.home + self.room).round(4)
        stated = (np.abs(end - self.place) > 0.0) | (self.draw.random() < 0.3)
        if not stated.any():
            stated[self.draw.integers(len(stated))] = True
        self.way, self.place = end - self.place, end
        return " ".join(f"{a}{v:.4f}" for a, v, own in zip(self.layout.axes, end, stated, strict=True) if own)

    def feed(self) -> str:
        """F from a crawl to full speed, or none."""
        most = 60.0 * float(self.rates[~self.turns].min())
        return "" if self.draw.random() < 0.15 else f" F{most * 10.0 ** self.draw.uniform(-1.5, 0.0):.3f}"

    def move(self) -> list[str]:
        return [f"G1 {self.to(self.a_way())}{self.feed()}"]

    def rapid(self) -> list[str]:
        return [f"G0 {self.to(self.a_way())}"]

    def collinear(self) -> list[str]:
        """Some moves on in the direction of the one before, or back."""
        way = self.way * self.draw.uniform(0.1, 0.6)
        return [f"G1 {self.to(way * self.draw.choice([1.0, 1.0, -1.0]))}{self.feed()}" for _ in range(3)]

    def dwell(self) -> list[str]:
        return [f"G4 P{self.draw.uniform(0.02, 0.1):.3f}"]

    def mode(self) -> list[str]:
        return [str(self.draw.choice(["G61", "G61.1", "G61.1", "G64 P0.05 Q0"]))]

    def trigger(self) -> list[str]:
        """A switch between dwells, or one with the next motion; the log of a run must show it."""
        switch = str(self.draw.choice(["M64 P0", "M65 P0"]))
        return (
            ["G4 P0.03", switch, "G4 P0.03"] if self.draw.random() < 0.7 else [switch.replace("64", "62"), *self.move()]
        )

    def arc(self) -> list[str]:
        """An arc in any plane, a full circle at times; angles may ride along."""
        plane = self.draw.integers(3)
        first, second = ((0, 1), (2, 0), (1, 2))[plane]
        radius, begin = 10.0 ** self.draw.uniform(-0.3, 1.3), self.draw.uniform(0, 2 * np.pi)
        angle = self.draw.choice([-1.0, 1.0]) * self.draw.uniform(0.2, 6.0)
        centre = -radius * np.array([np.cos(begin), np.sin(begin)])
        way = np.zeros(6)
        full = self.draw.random() < 0.2
        if not full:
            way[[first, second]] = centre + radius * np.array([np.cos(begin + angle), np.sin(begin + angle)])
        if self.draw.random() < 0.4:
            way[3:] = self.draw.uniform(-3, 3, 3)
        ends = "" if full and not way.any() else self.to(way)
        if full:
            ends = " ".join(word for word in ends.split() if word[0] in "ABC")
        offsets = {"XYZ"[first]: centre[0], "XYZ"[second]: centre[1]}
        words = " ".join(f"{'IJK'['XYZ'.index(a)]}{offsets[a]:.5f}" for a in sorted(offsets))
        return [f"{('G17', 'G18', 'G19')[plane]} {'G3' if angle > 0 else 'G2'} {ends} {words}{self.feed()}"]

    def path(self) -> list[str]:
        """A smooth path in timed blocks of some milliseconds, there and on."""
        way, count = self.a_way() * 0.3, int(self.draw.integers(8, 40))
        period = int(self.draw.integers(8, 25))  # [ms]
        start, lines = self.place.copy(), []
        for k in range(1, count + 1):
            share = (1.0 - np.cos(np.pi * k / count)) / 2
            end = (start + share * way).round(5)
            words = " ".join(f"{a}{v:.5f}" for a, v in zip(self.layout.axes, end, strict=True))
            lines.append(f"G1 {words} F{60e3 / period:.6f}")
            self.place = end
        self.way = way
        return ["G64 P1 Q0", "G93", *lines, "G94", "G61.1"]


def proven(text: str, case: Case) -> Program | None:
    """The program of a text, if it is read and inside its limits."""
    language, content = dialect("linuxcnc"), text.encode()
    try:
        reading = language.read(content, "p.ngc", case)
        guarantees = language.guarantees(reading, case)
        proof = prove_program(reading, guarantees)
    except ProgramError:
        return None
    return Program(Path("p.ngc"), language, content, reading, guarantees, case) if proof.ok else None


def one_after_the_other(seeds: Sequence[int], case: Case) -> Program:
    """The random programs of some seeds as one, for LinuxCNC takes long to start."""
    found, lines = None, list[str]()
    for seed in seeds:
        drawn = RandomProgram(seed, case)
        body = [*lines, *drawn.body()]
        if (program := drawn.proven(body)) is not None:
            found, lines = program, body
    assert found is not None
    return found


def differences(program: Program, log: ControllerLog) -> list[str]:
    """Where the log is not what was proven: a sentence for each line that moves otherwise."""
    found: list[str] = []
    moved = np.append(np.any(np.abs(np.diff(log.poses, axis=0)) > 1e-12, axis=1), False)
    limits = program.guarantees.limits
    for part, motion in motions(program.reading, program.guarantees):
        if isinstance(part, Still):
            continue
        lines = part.lines if isinstance(part, Timed) else (part.line,)
        rows = np.flatnonzero(moved & np.isin(log.lines, lines))
        if not len(rows):
            if motion.duration > CYCLES * log.period:
                found.append(f"line {part.line}: nothing moves, {motion.duration:.3f} s proven")
            continue
        first = int(rows[0]) - 1  # the first cycle of a motion shows the line before it
        taken = (int(rows[-1]) + 1 - first) * log.period
        # Slow blocks of a path last up to a cycle longer, and LinuxCNC gets into a path and out of it within a block.
        late = len(lines) * log.period + float(np.diff(part.points.times).max()) if isinstance(part, Timed) else 0.0
        allowed = CYCLES * log.period + LONGER * motion.duration + late
        longer = log.period if isinstance(part, Untimed) and part.arc is not None else 0.0  # measured, of fast arcs
        if not -allowed <= taken - motion.duration <= allowed + longer:
            found.append(f"line {part.line}: takes {taken:.4f} s, {motion.duration:.4f} s proven")
        t = np.arange(max(1, rows[-1] - 1 - first)) * log.period  # the last ones may be of the motion after it
        if len(t) < 3:
            continue
        if isinstance(part, Timed):
            knots, poses = part.points.times, part.points.at(part.points.times).coordinates
            planned = np.column_stack([np.interp(t, knots, column) for column in poses.T])
        else:
            planned = motion.at(np.minimum(t, motion.duration)).coordinates
        span = CYCLES * log.period + late
        rates = np.minimum(limits.rate, np.abs(np.gradient(planned, log.period, axis=0)).max(axis=0) + 1e-6)
        off = np.abs(log.poses[first : first + len(t)] - planned[: len(log.poses) - first])
        if np.any(off > span * rates + CUT):
            k, axis = np.unravel_index(int(np.argmax(off - span * rates)), off.shape)
            found.append(f"line {part.line}: {off[k, axis]:.3g} off in axis {axis} after {t[k]:.3f} s")
    return found
