"""A program leaves hexcite only with the proof that its text keeps every limit."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from cases.base.errors import HexciteError, NotProven, ProgramError
from cases.controller import SINUMERIK_NAME
from cases.schema import Case
from identification.limits.limit import LimitKind
from identification.limits.proof import prove
from identification.motion.curves import FourierMotion, PolynomialMotion
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import StraightMove, unit_profile
from planner.families.fourier import FourierFamily
from postprocessors.blocks import TimedPath
from postprocessors.excitation import APPROACH_SHARE, excitation_program
from postprocessors.program import dialect, dialect_of_file
from postprocessors.reading import Timed
from postprocessors.writing import LONGER, proven_program
from tests.helpers import one_line, polynomials_of, tells
from tests.postprocessors.changed_case import changed
from tests.postprocessors.programs import proof as reproof
from tests.postprocessors.programs import read_linuxcnc

LINUXCNC = dialect("linuxcnc")
ACCEPTED = ("acceleration", "jerk", "strut-acceleration", "sensor-force")


def proven_text(motion, case, language, file, header, speed=1.0):
    written = proven_program(motion, case, language, file, header, speed, ACCEPTED)
    return written.content.decode("ascii"), written.proof


@pytest.fixture(scope="module")
def motion(hexapod_case: Case) -> FourierMotion:
    """A motion that uses 90 % of its tightest limit."""
    box = hexapod_case.limits.motion
    family = FourierFamily(2, 1.0, 1, hexapod_case.machine.home.vector, (box.coordinates[1] - box.coordinates[0]) / 2)
    unknowns = np.random.default_rng(4).normal(size=18)
    for _ in range(6):
        unknowns *= 0.9 / prove(family.motion(unknowns), hexapod_case, 2000.0).worst_ratio
    return family.motion(unknowns)


def test_the_text_of_a_motion_within_the_limits_comes_with_its_proof(motion: FourierMotion, hexapod_case: Case):
    text, proof = proven_text(motion, hexapod_case, LINUXCNC, "p.ngc", ("a",))
    assert proof.ok
    again = reproof(text, hexapod_case)
    assert again.limits == proof.limits
    assert proof.excitation == pytest.approx(1.0)


def up_and_down(case: Case, share: float) -> PolynomialMotion:
    """In z and back, with jerks that step between a share of both limits every 30 ms."""
    assert case.limits is not None
    home, way, length = case.machine.home.vector, np.zeros(6), 0.03
    way[2] = 2.0 * share * case.limits.motion.jerk[2] * length**3
    ends = (home, home + way, home)
    return polynomials_of([StraightMove(a, b, unit_profile(length, 0.0, 0.0)) for a, b in pairwise(ends)])


@pytest.mark.parametrize("file", ["p.nc", "p.mpf"])
def test_points_that_just_exceed_a_limit_are_passed_by_so_much_slower(file: str, hexapod_case: Case):
    language, motion = dialect_of_file(file), up_and_down(hexapod_case, 1.006)
    program = proven_program(motion, hexapod_case, language, file, (), 1.0, ACCEPTED)
    assert program.proof.ok
    assert 1.0 + 0.006 / 3 - 1e-4 < program.proof.excitation / motion.duration <= 1.0 + LONGER
    [remark] = program.remarks
    assert tells(remark, "% slower", "jerk (z)", "100.6")
    assert tells(program.text, "% slower than planned")
    with pytest.raises(NotProven, match=r"jerk \(z\) reaches .*104"):
        proven_program(up_and_down(hexapod_case, 1.04), hexapod_case, language, file, (), 1.0, ACCEPTED)


@pytest.mark.parametrize("file", ["p.nc", "p.csv"])
def test_the_same_between_measurements_at_standing_poses(file: str, hexapod_case: Case):
    """Whose program has no excitation: the trigger is on where the machine stands."""
    stay = Standstill(hexapod_case.machine.home.vector, 0.5, 0.5)
    motion = Joined((stay, up_and_down(hexapod_case, 1.006), stay))
    program = proven_program(motion, hexapod_case, dialect_of_file(file), file, (), 1.0, (*ACCEPTED, "velocity"))
    assert program.proof.ok
    [remark] = program.remarks
    assert tells(remark, "0.2", "% slower", "jerk (z)")


@pytest.mark.parametrize("file", ["p.nc", "p.mpf", "p.ngc", "p.csv"])
def test_poses_may_end_at_home(file: str, hexapod_case: Case):
    """Where no way back follows the trigger of the last measurement."""
    home = hexapod_case.machine.home.vector
    stay, away = Standstill(home, 0.5, 0.5), up_and_down(hexapod_case, 0.5)
    program = proven_program(Joined((stay, away, stay)), hexapod_case, dialect_of_file(file), file, (), 1.0, ACCEPTED)
    assert program.proof.ok
    assert not program.reading.left_on


def test_a_motion_that_breaks_a_limit_is_not_written_and_the_limit_is_named(motion: FourierMotion, hexapod_case: Case):
    bigger = replace(motion, a=1.2 * motion.a, b=1.2 * motion.b)
    tightest = prove(bigger, hexapod_case, 2000.0).violations[0].kind
    with pytest.raises(ProgramError, match=rf"p\.ngc, line [0-9]+: {tightest} .*reaches .+, limit \S") as caught:
        proven_text(bigger, hexapod_case, LINUXCNC, "p.ngc", ())
    one_line(caught.value)


def test_at_a_tenth_of_the_speed_the_same_way_takes_ten_times_as_long(motion: FourierMotion, hexapod_case: Case):
    paths = []
    for speed in (1.0, 0.1):
        text, _ = proven_text(motion, hexapod_case, LINUXCNC, "p.ngc", (), speed)
        read = read_linuxcnc(text, "p.ngc").stretches
        paths.append([s.points for s in read if isinstance(s, Timed)])
    for fast, slow in zip(*paths, strict=True):
        assert slow.times == pytest.approx(10 * fast.times, rel=1e-7, abs=10e-3)  # a cycle of LinuxCNC at most
        assert np.abs(fast.at(slow.times.clip(max=10 * fast.duration) / 10).coordinates - slow.poses).max() < 1e-3
    assert np.array_equal(paths[0][1].poses, paths[1][1].poses)  # the excitation lasts whole cycles


@pytest.mark.parametrize(("name", "title"), [("sinumerik", "%_N_{}_MPF"), ("twincat", "%{}")])
def test_a_slow_program_has_another_name_in_the_memory_of_a_controller(
    name: str, title: str, motion: FourierMotion, hexapod_case: Case
):
    """Loaded beside each other, the slow one does not replace the other, nor is it started for it."""
    language = dialect(name)
    titles = [
        proven_text(motion, hexapod_case, language, f"a{language.suffix}", ("a",), speed)[0].split("\n")[0]
        for speed in (1.0, 0.1)
    ]
    assert titles == [title.format("HEXCITE"), title.format("HEXCITE_SLOW")]


def test_names_of_slow_programs_are_not_too_long(hexapod_case: Case):
    longest = changed(hexapod_case, controller__sinumerik__program_name="A" * 24)
    named = longest.named_slow().controller
    assert named is not None
    assert named.sinumerik is not None
    assert re.fullmatch(SINUMERIK_NAME, named.sinumerik.program_name)
    assert named.sinumerik.program_name.endswith("_SLOW")


def test_a_slow_start_keeps_the_limits_with_room_to_spare(motion: FourierMotion, hexapod_case: Case):
    """At share s of the speed rates fall with s, accelerations with s squared, jerks with its cube."""
    fast, slow = (proven_text(motion, hexapod_case, LINUXCNC, "p", (), s)[1].limits.to_json() for s in (1.0, 0.5))
    for name, power in (("velocity", 1), ("acceleration", 2), ("jerk", 3), ("position", 0)):
        assert slow[name]["ratio"] == pytest.approx(fast[name]["ratio"] * 0.5**power, rel=0.04)  # cycles of LinuxCNC


@pytest.mark.parametrize("change", ["pose", "time", "missing"])
def test_a_writer_that_writes_something_else_is_found_out(change: str, motion: FourierMotion, hexapod_case: Case):
    def wrong(program, case):
        blocks = list(program)
        k = next(k for k, b in enumerate(blocks) if isinstance(b, TimedPath) and b.name == "excitation")
        path = blocks[k]
        poses, times = path.poses.copy(), path.times.copy()
        if change == "pose":
            poses[:, 0] += 1e-7 * np.sin(np.linspace(0.0, np.pi, len(poses))) ** 4
        elif change == "time":
            times = times * 2.0
        else:
            poses, times = poses[[*range(0, len(poses) - 1, 2), -1]], times[[*range(0, len(times) - 1, 2), -1]]
        blocks[k] = TimedPath(path.name, times, poses, path.motion)
        return LINUXCNC.write(tuple(blocks), case)

    broken = replace(LINUXCNC, write=wrong)
    with pytest.raises(ProgramError, match="the motion reads back differently"):
        proven_text(motion, hexapod_case, broken, "p.ngc", ())


def test_an_unknown_dialect_or_suffix_lists_the_known_ones():
    with pytest.raises(HexciteError, match="'fanuc' is unknown; choose linuxcnc"):
        dialect("fanuc")
    with pytest.raises(ProgramError, match=r"a/b\.min: .*no controller; .*\.ngc"):
        dialect_of_file("a/b.min")
    assert dialect_of_file("a/b.ngc") is dialect("linuxcnc")


def test_ways_from_and_to_home_are_as_slow_as_the_sensors_need(motion: FourierMotion, hexapod_case: Case):
    """A plan keeps forces in its excitation; what the program adds to it must not be what is refused."""

    def force(case: Case, trajectory: Trajectory) -> float:
        checks = prove(trajectory, case, 250.0, in_box=False).checks
        return next(check.ratio for check in checks if check.kind is LimitKind.SENSOR_FORCE)

    home, box = hexapod_case.need_motion("a test")
    start = motion.at([0.0]).coordinates[0]
    limits = (box.rate, box.acceleration, box.jerk)
    fast, slow = (StraightMove.fastest(home, start, *(s * v for v in limits)) for s in (APPROACH_SHARE, 1e-3))
    least, most = force(hexapod_case, slow), force(hexapod_case, fast)
    assert least < 0.99 * most
    weaker = 0.5 * (least + most) * hexapod_case.sensors.range_N
    case = hexapod_case.model_copy(update={"sensors": hexapod_case.sensors.model_copy(update={"range_N": weaker})})
    program = excitation_program(motion, case)
    approach, *_, back = (block for block in program if isinstance(block, TimedPath))
    assert (approach.name, back.name) == ("approach", "return")
    assert force(case, fast) > 1.0 >= force(case, approach.motion)
    assert force(case, back.motion) <= 1.0
