"""What a structural mode makes of planned moves, against a simulated machine that is identified from its recording."""

from itertools import pairwise

import numpy as np
import pytest

from cases.schema import Case
from identification.criteria import reference_scaling
from identification.identify import estimate_parameters
from identification.model import identification_model
from identification.motion import Joined
from identification.trajectories.curves import FourierMotion
from identification.trajectories.moves import StraightMove, has_steps
from planner.comparison.trials import Excitation, trials
from planner.families.settings import PointToPoint
from planner.noise import expected_noise
from planner.plan_figures import predicted_std_of
from planner.planning import make
from planner.plans import Plan
from planner.request import Request
from planner.search.parallel import Listener, run_here, silent
from planner.vibration import both_laws, vibration, with_other_law
from postprocessors.dialects import dialect
from postprocessors.execute.virtual import run_virtual
from postprocessors.writing import proven_program
from tests.helpers import few
from tests.postprocessors.changed_case import changed

ACCEPTED = ("jerk", "strut velocity", "strut acceleration", "sensor force")


def walk(case: Case, limited: bool) -> Joined:
    """Moves between random places of half the box, as fast as their coordinates may."""
    machine, _, box = case.need_machine("a test")
    draw = np.random.default_rng(4)
    places = machine.home.vector + 0.5 * draw.uniform(box.pose[0], box.pose[1], (25, 6))
    law = [0.99 * limit for limit in (box.rate, box.acceleration, *([box.jerk] if limited else []))]
    return Joined(tuple(StraightMove.fastest(a, b, *law) for a, b in pairwise(places)))


def with_mode(case: Case, frequency: float) -> Case:
    """The machine has nothing else that disturbs it, and is the one that the plan assumes."""
    assert case.simulation is not None
    body = case.simulation.parameters.body.model_dump()
    still = {"pose_error_N": 0.0, "pose_error_of_load": 0.0, "strut_velocity_noise_percent": 0.0}
    for key, value in ({"mode_Hz": frequency} | still).items():
        case = changed(case, **{f"simulation__disturbances__{key}": value})
    return changed(case, nominal=body)


def white(case: Case, motion: Joined) -> dict[str, float]:
    model = identification_model(case, 9)
    return predicted_std_of(case, model, reference_scaling(case, model), motion, expected_noise(case, model, 0), 0)


@pytest.mark.parametrize("limited", [True, False])
def test_a_stiff_machine_errs_as_white_noise_alone_has_it(limited: bool, hexapod_case: Case):
    case = with_mode(hexapod_case, 20_000.0)
    motion = walk(case, limited)
    found = vibration(case, 9, motion, 0, motion.duration)
    assert found is not None
    assert found.times == pytest.approx(1.0, abs=0.02)
    assert found.s0 == pytest.approx(1.0, abs=0.01)
    assert found.errors == pytest.approx(white(case, motion), rel=0.1)


def test_softer_is_worse_and_equal_time_is_what_white_noise_counts(hexapod_case: Case):
    motion = walk(hexapod_case, False)
    times = [vibration(with_mode(hexapod_case, f), 9, motion, 0, motion.duration).times for f in (60.0, 100.0, 200.0)]
    assert times[0] > times[1] > times[2] > 1.0
    stiff = with_mode(hexapod_case, 20_000.0)
    once, thrice = (vibration(stiff, 9, motion, 0, k * motion.duration) for k in (1.0, 3.0))
    assert once.over(thrice) == pytest.approx(np.sqrt(3.0), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("pose_error", [0.0, 1.45])
@pytest.mark.parametrize("limited", few(True, False))
def test_the_error_is_that_of_the_simulated_machine(limited: bool, pose_error: float, hexapod_case: Case):
    """Identified from a recording of the run, the mode's part of the error of the mass is the one that is predicted.

    With errors of the pose residuals are larger, so that less is estimated beside the parameters.
    """
    case = changed(with_mode(hexapod_case, 80.0), simulation__disturbances__pose_error_N=pose_error)
    motion = walk(case, limited)
    found = vibration(case, 9, motion, 0, motion.duration)
    language = dialect("sinumerik" if limited else "linuxcnc")
    written = proven_program(motion, case, language, "walk", (), accepted=ACCEPTED)
    run = run_virtual(written.reading, written.guarantees)
    excitation = Excitation(case, "ptp", run.excitation, run.execution, run.trigger, np.zeros((0, 6)), 0)
    (step,) = trials(excitation, [0], case.simulation.disturbances)
    (stiff,) = trials(excitation, [0], case.simulation.disturbances.model_copy(update={"mode_Hz": 1e5}))
    by_mode = step.estimate.physical["m"].value - stiff.estimate.physical["m"].value
    predicted = np.sqrt(found.errors["m"] ** 2 - white(case, motion)["m"] ** 2)
    assert predicted == pytest.approx(abs(by_mode), rel=0.25)
    assert estimate_parameters(excitation.recorded(0, case.simulation.disturbances), case).fit.s0 == pytest.approx(
        found.s0, rel=0.15
    )


def test_the_better_law_follows_from_the_mode(hexapod_case: Case):
    """On a stiff machine steps carry more information; on a soft one they shake it."""
    motion = walk(hexapod_case, False)
    stiff, soft = (both_laws(with_mode(hexapod_case, f), 9, motion, 0) for f in (5000.0, 60.0))
    assert (stiff.better, soft.better) == ("steps of acceleration", "limited jerk")
    smooth = with_other_law(motion, hexapod_case)
    assert has_steps(motion)
    assert not has_steps(smooth)
    assert both_laws(with_mode(hexapod_case, 60.0), 9, smooth, 0).better == "limited jerk"
    assert both_laws(with_mode(hexapod_case, 5000.0), 9, smooth, 0).better == "steps of acceleration"


def chosen(frequency: float, case: Case, may_be_smooth: bool = True, told: Listener = silent) -> Plan:
    """What a second of search finds for a controller whose accelerations step."""
    request = Request(PointToPoint(controller="linuxcnc"), 3.0, seconds=1.0, may_be_smooth=may_be_smooth)
    return make(request, with_mode(case, frequency), told, run_here)


def test_where_steps_shake_the_machine_a_spline_takes_their_place(hexapod_case: Case):
    """Unless moves were asked for; the errors to be expected of what is chosen are the smaller ones."""
    begun: list[str] = []

    def told(event: object) -> None:
        if isinstance(event, Request):
            begun.append(event.family.name)

    smooth, moves = chosen(40.0, hexapod_case, told=told), chosen(40.0, hexapod_case, may_be_smooth=False)
    assert (smooth.family, moves.family) == ("spline", "ptp")
    assert begun == ["ptp", "spline"]  # progress tells which of them is searched for
    assert smooth.limits.kept
    assert any("spline in place of ptp" in note for note in smooth.worth.notes)
    own, other = (vibration(smooth.case, 9, plan.motion, 0, 3.0) for plan in (smooth, moves))
    assert own.over(other) < 0.5


def test_on_a_stiff_machine_moves_stay(hexapod_case: Case):
    assert chosen(5000.0, hexapod_case).family == "ptp"


def test_nothing_is_said_where_no_mode_is_stated_or_nothing_is_moves(hexapod_case: Case):
    motion = walk(hexapod_case, False)
    assert both_laws(changed(hexapod_case, simulation=None), 9, motion, 0) is None
    share = np.zeros((2, 6))
    assert both_laws(hexapod_case, 9, FourierMotion(np.zeros(6), share, share, 3.0, 4), 0) is None
