"""Plans and programs come back as they were saved, whatever the motion and whatever a search said of it."""

import dataclasses
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import hexcite as hx
from cases.schema import load_case
from identification.estimation.criteria import Criterion
from identification.limits.proof import PROOF_RATE, prove
from planner.families.ptp import PointToPointFamily
from planner.families.settings import FamilySettings
from planner.plans.folder import motion_entries
from planner.plans.plan import Plan
from planner.plans.rating import PlannedMotion, rated_plan
from planner.poses.planned_poses import poses_planned
from planner.request import PoseRequest, Request
from planner.search.feasibility import keep_limits
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.solving import Start
from tests.helpers import examples

CASE = load_case("hexapod")
DURATION = 3.0
NUMBERS = st.floats(-1e6, 1e6)
FAMILIES = st.sampled_from([hx.Fourier(order=5, period=DURATION), hx.PointToPoint(moves=10), hx.Spline(knots=30)])
RECORDS = st.builds(
    StartRecord, st.integers(0, 2**32), st.booleans(), NUMBERS, NUMBERS,
    st.sampled_from(SolverStatus), st.booleans(), st.integers(0, 3000), st.floats(0.0, 1e5),
)  # fmt: skip
SEARCHES = st.tuples(
    st.lists(RECORDS, max_size=3),
    st.lists(st.builds(Failed, st.integers(0, 2**32), st.text(max_size=30)), max_size=2),
    st.booleans(),
)
pytestmark = pytest.mark.usefixtures("cache")


def planned(family: FamilySettings, request: Request, share: float, seed: int, search: Any) -> Plan:
    """The plan of some motion of a family, of which a search is made up."""
    (sets,) = family.families(CASE, DURATION)
    draw = np.random.default_rng(seed)
    begin = sets.start(draw, lambda unknowns: 1.0)
    # a walk begins as a standstill, and so does a spline stand between its steps
    change = draw.uniform(-0.5, 0.5, begin.shape)
    if isinstance(sets, PointToPointFamily):
        change[-3 * sets.moves :] = 0.0  # times of moves
    begin = begin + change
    unknowns, _ = keep_limits(CASE, sets, sets.shrunk(begin, share), PROOF_RATE)
    records, failed, interrupted = search
    starts = tuple(Start(r, unknowns, sets, 1.0, unknowns, r.logdet) for r in records)
    motion = sets.motion(unknowns)
    found = PlannedMotion(motion, sets.settings, prove(motion, CASE), starts, tuple(failed), interrupted)
    return rated_plan(request, CASE, found, 0.25)


def require_same(again: Plan, plan: Plan) -> None:
    """Every field is equal; of a motion, which knows no equality, all that defines it."""
    for field in dataclasses.fields(Plan):
        if field.name not in ("motion", "folder", "digest"):
            assert getattr(again, field.name) == getattr(plan, field.name), field.name
    assert motion_entries(again.motion) == motion_entries(plan.motion)
    assert again.to_json() == plan.to_json()


@pytest.mark.slow
@given(
    family=FAMILIES,
    criterion=st.sampled_from(Criterion),
    model=st.sampled_from([6, 9]),
    payloads=st.tuples(st.integers(0, 2), st.integers(2, 5)),
    seed=st.integers(0, 2**31),
    share=st.floats(0.6, 1.0),
    search=SEARCHES,
)
@settings(max_examples=examples(6))
def test_a_plan_of_any_motion_comes_back(
    family: FamilySettings, criterion: Criterion, model: int, payloads: tuple[int, int], seed: int, share: float,
    search: Any,
):  # fmt: skip
    fewest, most = payloads
    request = Request(family, DURATION, criterion, model, most, fewest, seed=seed)
    plan = planned(family, request, share, seed, search)
    with tempfile.TemporaryDirectory() as folder:
        plan.save(Path(folder) / "plan")
        require_same(Plan.load(Path(folder) / "plan"), plan)


@given(count=st.integers(8, 16), seed=st.integers(0, 99), criterion=st.sampled_from(Criterion))
@settings(max_examples=examples(5))
@pytest.mark.repeats
def test_a_plan_of_poses_comes_back(count: int, seed: int, criterion: Criterion):
    request = PoseRequest(criterion, count, "backward", candidates=50, seed=seed)
    plan = poses_planned(request, CASE)
    with tempfile.TemporaryDirectory() as folder:
        plan.save(Path(folder) / "plan")
        require_same(Plan.load(Path(folder) / "plan"), plan)


@pytest.mark.slow
@given(family=FAMILIES, dialect=st.sampled_from(["linuxcnc", "sinumerik", "twincat", "setpoints"]),
       share=st.floats(0.6, 1.0), seed=st.integers(0, 2**31))  # fmt: skip
@example(family=hx.Spline(knots=30), dialect="setpoints", share=0.9, seed=0)
@settings(max_examples=examples(5))
def test_a_program_of_any_plan_comes_back(family: FamilySettings, dialect: str, share: float, seed: int):
    plan = planned(family, Request(family, DURATION, seed=seed), share, seed, ((), (), False))
    accept = ("acceleration", "jerk", "strut velocity", "strut acceleration", "sensor force")
    program = hx.write(plan, dialect, accept=accept)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"p{program.path.suffix}"
        program.save(file)
        again = hx.Program.load(file, CASE)
    assert again.content == program.content
    assert (again.dialect, again.case) == (program.dialect, program.case)
    for field in dataclasses.fields(program.guarantees):
        if field.name != "law":  # a function, which knows no equality
            assert np.all(getattr(again.guarantees, field.name) == getattr(program.guarantees, field.name)), field.name
    assert dataclasses.replace(again.proof, file="") == dataclasses.replace(program.proof, file="")
