"""Who answers for which limit in which kind of block of which dialect: proven, enforced, or nobody.

From first principles. A text fixes geometry and feeds. Time laws are the controller's, so that accelerations, jerks and
struts are its own, as far as its machine data (or LinuxCNC's nature) keep them. No controller knows forces of sensors:
they are proven where velocities and accelerations are kept and no motion within these could be too much.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from cases.schema import Case
from identification.limits.limit import KINETIC, Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Status, worst_of
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove
from postprocessors.program import dialect
from postprocessors.proof.proof import ProgramProof
from postprocessors.writing import proven_program
from tests.postprocessors.changed_case import changed
from tests.postprocessors.other_dialects import CASE, SINUMERIK, TWINCAT, Typed, smooth_points
from tests.postprocessors.programs import proof, there_and_back, timed, typed

P, E, N, F = Status.PROVEN, Status.ENFORCED, Status.NOT_ENFORCED, Status.FOLLOWS
HOME, OWN = ", way home", ", untimed moves"


@dataclass(frozen=True)
class Controller:
    """A controller as set up: how its programs are typed, and its case."""

    name: str
    typed: Typed | None
    case: Case

    def proof(self, kind: str) -> ProgramProof:
        if self.typed is None:
            body = {
                "home": "",
                "feed": "G1 X5 A1 F3000",
                "rapid": "G0 X5 A1",
                "arc": "G17 G3 X0 Y0 I5 J0 F3000",
                "path": timed(there_and_back()),
            }[kind]
            return proof(typed(body), self.case)
        exact = "G60 " if self.typed is TWINCAT else ""
        body = {
            "home": "",
            "feed": f"G1 {exact}X5 {self.typed.angle}1 F3000",
            "rapid": f"G0 {exact}X5 {self.typed.angle}1",
            "arc": f"G17 G3 {exact}X0 Y0 I5 J0 F3000",
            "path": self.typed.timed(smooth_points(self.typed, "X", 2.0)),
            "poly": "G64 G93\nPOLY PO[X]=(0.01,0,0.01) F600\nPOLY PO[X]=(0.02,0.01,-0.01) F600\nG94 G60 G1\nG4 F0.1",
        }[kind]
        return self.typed.proof(self.typed.text(body), self.case)


def keeps(dialect: str, *limits: str) -> Case:
    return changed(CASE, **{f"controller__{dialect}__controller_keeps": limits})


def headroom(factor: float) -> Case:
    return changed(CASE, controller__linuxcnc__acceleration_headroom=factor)


EVERY = ("velocity", "acceleration", "jerk", "strut velocity", "strut acceleration")
CONTROLLERS = {
    c.name: c
    for c in (
        Controller("linuxcnc", None, CASE),
        Controller("linuxcnc, headroom 1", None, headroom(1.0)),
        Controller("sinumerik", SINUMERIK, keeps("sinumerik", *EVERY)),
        Controller("sinumerik, nothing kept", SINUMERIK, keeps("sinumerik")),
        Controller("sinumerik, pose kept", SINUMERIK, keeps("sinumerik", "velocity", "acceleration")),
        Controller("twincat", TWINCAT, keeps("twincat", *EVERY)),
        Controller("twincat, nothing kept", TWINCAT, keeps("twincat")),
    )
}

# Columns: velocity, acceleration, jerk, strut velocity, strut acceleration, sensor force.
WAY_HOME = {
    "linuxcnc": (E, E, N, E, N, P),
    "sinumerik": (E, E, E, E, E, P),
    "sinumerik, nothing kept": (N, N, N, N, N, N),
    # The feed and the kept rates of A, B and C together bound the struts' velocity below its limit.
    "sinumerik, pose kept": (E, E, N, E, N, P),
}
MOVES = {
    # Struts follow from the axes' accelerations, which it keeps, and from its law in straight moves, which is known.
    ("linuxcnc", "feed"): (P, E, N, P, F, P),
    ("linuxcnc", "arc"): (P, E, N, P, N, P),
    ("linuxcnc", "rapid"): (E, E, N, E, F, P),  # struts: at no kept rates too fast on this way
    # With timed blocks its accelerations get the headroom; a block is a straight line at its mean rates.
    ("linuxcnc", "path"): (P, N, N, P, N, N),
    ("linuxcnc, headroom 1", "path"): (P, E, N, P, N, P),
    ("sinumerik", "feed"): (P, E, E, P, E, P),
    ("sinumerik", "arc"): (P, E, E, P, E, P),
    ("sinumerik", "rapid"): (E, E, E, E, E, P),
    # How time passes within a block of a curve is the controller's, and with it the rates of each coordinate.
    ("sinumerik", "path"): (E, E, E, E, E, P),
    ("sinumerik", "poly"): (E, E, E, E, E, P),
    ("sinumerik, nothing kept", "feed"): (P, N, N, P, N, N),
    ("sinumerik, nothing kept", "rapid"): (N, N, N, N, N, N),
    ("sinumerik, nothing kept", "path"): (N, N, N, N, N, N),
    ("sinumerik, nothing kept", "poly"): (N, N, N, N, N, N),
    ("sinumerik, pose kept", "rapid"): (E, E, N, E, N, P),
    ("sinumerik, pose kept", "path"): (E, E, N, N, N, P),
    ("twincat", "feed"): (P, E, E, P, E, P),
    ("twincat", "arc"): (P, E, E, P, E, P),
    ("twincat", "rapid"): (E, E, E, E, E, P),
    ("twincat", "path"): (E, E, E, E, E, P),
    ("twincat, nothing kept", "feed"): (P, N, N, P, N, N),
    ("twincat, nothing kept", "path"): (N, N, N, N, N, N),
}


def said(result: ProgramProof, home: bool) -> dict[LimitKind, set[Status]]:
    """Status by family of kinetic limits: of the way home, or of all else."""
    found: dict[LimitKind, set[Status]] = {}
    for check in result.limits.checks:
        if check.kind.kinetic and (check.of.move is OwnMove.WAY_HOME) == home:
            found.setdefault(check.kind.family, set()).add(check.status)
    return found


@pytest.mark.parametrize("name", WAY_HOME)
def test_on_the_way_home_from_an_unknown_pose_only_the_feed_is_the_programs(name: str):
    result = CONTROLLERS[name].proof("home")
    assert said(result, True) == {k: {v} for k, v in zip(KINETIC, WAY_HOME[name], strict=False)}
    assert said(result, False) == {}
    assert result.limits.to_json()["feed to home"]["status"] == "proven"


@pytest.mark.parametrize(("name", "kind"), MOVES)
def test_each_limit_in_each_kind_of_block_has_the_one_who_answers_for_it(name: str, kind: str):
    result = CONTROLLERS[name].proof(kind)
    assert said(result, False) == {k: {v} for k, v in zip(KINETIC, MOVES[name, kind], strict=False)}
    for check in result.limits.checks:
        if not check.kind.kinetic:
            assert check.status is P, "geometry is the text's"


def test_a_table_of_setpoints_is_proven_in_all_its_limits():
    from identification.motion.motion import Joined
    from postprocessors.program import dialect
    from postprocessors.writing import proven_program
    from tests.postprocessors.test_dialects_of_plans import moves

    result = proven_program(Joined((moves(),)), keeps("setpoints"), dialect("setpoints"), "p", ()).proof
    assert said(result, False) == {k: {P} for k in KINETIC[:6]}
    assert said(result, True) == {}


def test_forces_that_kept_accelerations_could_make_too_large_are_nobodys():
    """Sensors of a range that the planned motion keeps, but not every motion that the controller would let pass."""
    weak = changed(CASE, sensors__range_N=1.1 * 400.0)
    result = SINUMERIK.proof(SINUMERIK.text(SINUMERIK.timed(smooth_points(SINUMERIK, "X", 2.0))), weak)
    assert result.ok
    assert "sensor force" in result.relies_on


def test_the_weaker_answer_stands_where_two_moves_have_different_ones():
    """A rapid that nobody limits is not hidden by a faster move whose feed is proven."""
    case = keeps("sinumerik")
    result = SINUMERIK.proof(SINUMERIK.text("G1 X1 F30000\nG0 X0\nG1 X200 F36000"), case)
    rows = result.limits.to_json()
    assert rows["velocity"]["status"] == "proven"
    assert rows[f"velocity{OWN}"]["status"] == "NOT enforced"
    assert "velocity" in result.relies_on


def test_the_worst_of_two_reports_is_proven_only_where_both_are():
    slow = LimitCheck(Limit(LimitKind.VELOCITY), "x", 1.0, 10.0, "mm/s", 0.1, 0.0, N)
    fast = LimitCheck(Limit(LimitKind.VELOCITY), "y", 9.0, 10.0, "mm/s", 0.9, 1.0, P)
    for order in ([slow, fast], [fast, slow]):
        (check,) = worst_of([LimitReport((c,)) for c in order]).checks
        assert (check.name, check.worst, check.status) == ("velocity (y)", 9.0, N)


@pytest.mark.parametrize("seed", range(4))
def test_a_law_that_just_reaches_a_limit_does_not_exceed_it(seed: int):
    """The law of the control keeps the jerk of each coordinate exactly: rounding is not an excess."""
    case = keeps("sinumerik", "velocity", "acceleration")
    home, box = case.need_motion("a test")
    places = home + np.random.default_rng(seed).uniform(*(0.6 * box.coordinates), (4, len(home)))
    limits = box.rate, box.acceleration, box.jerk
    walk = Joined(tuple(StraightMove.fastest(a, b, *limits) for a, b in pairwise(places)))
    accepted = "jerk", "strut acceleration"
    program = proven_program(walk, case, dialect("sinumerik"), "walk.mpf", ("a walk",), accepted=accepted)
    reached = max(c.ratio for c in program.proof.limits.checks if c.kind.family is LimitKind.JERK)
    assert reached == pytest.approx(1.0, abs=1e-9)
    _, _, over = program.proof.verdict.partition("EXCEEDED")
    assert "jerk" not in over
