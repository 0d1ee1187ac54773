"""Programs for tests: written from random smooth motions, or typed line by line; and how to read and prove a text."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from cases.schema import Case, load_case
from identification.limits.proof import prove
from identification.motion.motion import Standstill, TimedPoints
from identification.motion.moves import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.blocks import Blocks, TimedPath, ToHome, Trigger, timed_path
from postprocessors.dialects.linuxcnc import read as linuxcnc
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.dialects.linuxcnc.write import with_moving_blocks, write_linuxcnc
from postprocessors.proof.proof import ProgramProof, prove_program
from postprocessors.reading import Reading, Stretch

Array = NDArray[np.float64]

HOME = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])
HEAD = "G17 G21 G40 G49 G54 G80 G90 G91.1 G94\nG92.1 G61.1\nG1 X0 Y0 Z900 A0 B0 C0 F3000\n"  # three lines
FIRST = 4
RANGE = np.array([0.25, 0.25, 0.1, 0.35, 0.35, 0.35])


def typed(body: str, head: str = HEAD, end: str = "M2\n") -> str:
    """A program around some lines, which begin in line `FIRST` from home at rest."""
    return f"{head}{body.rstrip()}\n{end}"


def there_and_back(count: int = 20, size: float = 2.0, seconds: float = 0.05, letter: str = "X") -> list[str]:
    """Timed lines along one axis: half a cosine of `size` mm or degrees, in equal blocks."""
    way = size * (1 - np.cos(np.linspace(0.0, 2 * np.pi, count + 1)[1:])) / 2
    return [f"G1 {letter}{x:.5f} F{60 / seconds:.6f}" for x in way]


def timed(lines: list[str]) -> str:
    """The lines as a timed path, blended as the writer does it."""
    return "\n".join(["G64 P1 Q0", "G93", *lines, "G94", "G61.1"])


def read_linuxcnc(text: str, file: str) -> Reading:
    """What a program for the built-in hexapod says."""
    return linuxcnc.read_linuxcnc(text.encode(), file, load_case("hexapod"))


def parts(text: str, case: Case) -> tuple[Stretch, ...]:
    """Stretches of a program's text."""
    return read_linuxcnc(text, "p.ngc").stretches


def proof(text: str, case: Case) -> ProgramProof:
    """Proof of a program's text."""
    reading = read_linuxcnc(text, "p.ngc")
    return prove_program(reading, linuxcnc_guarantees(reading, case))


def linuxcnc_text(program: Blocks) -> str:
    """A program for the built-in hexapod."""
    return write_linuxcnc(program, load_case("hexapod")).decode("ascii")


def small_excitation(case: Case, seed: int = 1, share: float = 0.85, period: float = 1.2) -> str:
    """A valid program around a Fourier motion of one period that uses `share` of its tightest limit."""
    box, home = case.limits.motion, case.machine.home.vector
    family = FourierFamily(3, period, 1, home, (box.coordinates[1] - box.coordinates[0]) / 2)
    unknowns = np.random.default_rng(seed).normal(size=family.unknowns * 6)
    for _ in range(6):
        unknowns *= share / prove(family.motion(unknowns), case, 2000.0).worst_ratio
    path = timed_path("excitation", family.motion(unknowns), case.controller.block, 1.0)
    program = ("small", ToHome(path.poses[0], 0.05), Trigger(True), path, Trigger(False))
    return write_linuxcnc(program, case).decode("ascii")


poses = st.tuples(*(st.floats(-r, r) for r in RANGE)).map(lambda p: np.round(HOME + np.array(p), 9))


def path_through(name: str, times: np.ndarray, poses: np.ndarray) -> TimedPath:
    """A path of which nothing is known but its points."""
    return TimedPath(name, times, poses, TimedPoints.through(times, poses))


@st.composite
def paths(draw: st.DrawFn, start: Array = HOME) -> TimedPath:
    """A straight move or a random walk of timed poses, in even blocks or in uneven ones."""
    duration = draw(st.floats(0.02, 2.0))
    if draw(st.booleans()):
        end = draw(poses.filter(lambda p: np.abs(p - start).max() > 1e-3))
        move = StraightMove.fastest(start, end, np.ones(6), np.full(6, 5.0), np.full(6, 50.0))
        return with_moving_blocks(timed_path("straight", move, duration / 3, draw(st.floats(0.1, 1.0))))
    count = draw(st.integers(1, 8))
    seed = draw(st.integers(0, 2**32 - 1))
    walk = np.vstack([start, HOME + np.random.default_rng(seed).uniform(-RANGE, RANGE, (count, 6))])
    if np.abs(walk[1] - start).max() < 1e-3:  # the same seed again
        walk[1:] = 2 * HOME - walk[1:]
    steps = np.array(draw(st.lists(st.floats(1e-3, 2.0), min_size=count, max_size=count)))
    return path_through("walk", np.r_[0.0, np.cumsum(steps)], walk)


@st.composite
def programs(draw: st.DrawFn) -> Blocks:
    """Home, then timed paths, dwells and triggers in any order."""
    blocks: list[ToHome | TimedPath | Standstill | Trigger] = [ToHome(HOME, draw(st.floats(1e-3, 0.5)))]
    pose = HOME
    for _ in range(draw(st.integers(1, 4))):
        path = draw(paths(pose))
        pose = path.poses[-1]
        blocks += [replace(path), Standstill(pose, draw(st.floats(0.0, 3.0))), Trigger(draw(st.booleans()))]
    return ("random", draw(st.text(max_size=80)), *blocks)
