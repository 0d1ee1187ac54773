"""More room, looser limits and more starts never give a worse plan, within 1 % of an efficiency."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.model.model import identification_model
from planner.families.settings import Spline, family_class
from planner.noise import mean_information
from planner.plans.making import search
from planner.request import Request
from planner.search.parallel import Listener, Outcome, Schedule, run_here, silent
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.rounds import seeds_of
from planner.search.solving import Start
from tests.bench.machines.description import case_of
from tests.bench.machines.designed import DESIGNED
from tests.helpers import seeds
from tests.postprocessors.changed_case import changed

WORSE = 0.01  # share of an efficiency
FAMILIES = {"fourier": {"order": 2}, "ptp": {"moves": 8}, "spline": {"knots": 20}}
SMALL = case_of("small", DESIGNED["small"])
MOTION = SMALL.limits.motion
MODEL = 0


@cache
def logdet(family: str, box: float = 1.0, limits: float = 1.0, starts: int = 1) -> float:
    """Of the plan's mean information, always in the scaling of the same case."""
    case = looser(wider(SMALL, box), limits)
    request = Request(family_class(family)(**FAMILIES[family]), model=MODEL, duration=2.0, starts=starts)
    motion = search(request, case, silent, run_here).motion
    model = identification_model(SMALL, MODEL)
    return float(np.linalg.slogdet(mean_information(model, reference_scaling(SMALL, model), motion))[1])


def wider(case: Case, share: float) -> Case:
    """The machine with a larger box."""
    box = {name: [share * end for end in getattr(MOTION, name)]
           for name in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")}  # fmt: skip
    return changed(case, **{f"limits__motion__{name}": ends for name, ends in box.items()})


def looser(case: Case, share: float) -> Case:
    """The machine with larger limits of rates, accelerations and jerks, of coordinates and struts."""
    names = [n for n in MOTION.model_fields_set if n.startswith(("velocity", "angular", "acc", "jerk"))]
    three = {f"limits__motion__{n}": [share * v for v in getattr(MOTION, n)] for n in names}
    struts = {f"limits__motion__strut_{n}": share * getattr(MOTION, f"strut_{n}")
              for n in ("velocity_m_s", "acceleration_m_s2")}  # fmt: skip
    return changed(case, **three, **struts)


def not_worse(values: list[float]) -> None:
    best = np.maximum.accumulate(values)[:-1]
    efficiencies = np.exp((np.array(values[1:]) - best) / len(identification_model(SMALL, MODEL).names))
    assert efficiencies.min() > 1.0 - WORSE, (values, efficiencies)


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_a_wider_box_never_gives_less(family: str):
    not_worse([logdet(family, box=share) for share in (0.5, 1.0)])


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_looser_limits_never_give_less(family: str):
    not_worse([logdet(family, limits=share) for share in (0.7, 1.0)])


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_more_starts_never_give_less(family: str):
    not_worse([logdet(family, starts=starts) for starts in (1, 2, 3)])


@seeds(2)
def test_what_is_refined_of_some_starts_is_refined_of_more(seed: int):
    """Explorations that promise much may come to less: none that fewer starts refined is left out."""
    promises = np.random.default_rng(seed).normal(-9.0, 0.1, 6)
    settings, every = Spline(knots=20), seeds_of(0, len(promises))
    (family,) = settings.families(SMALL, 2.0)
    unknowns = family.start(np.random.default_rng(1), lambda unknowns: 9.0 * float(np.abs(unknowns).max()))
    refined = list[set[int]]()

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        results = list[Start | Failed]()
        while not schedule.enough(results) and (task := schedule.task(len(results), results)) is not None:
            promise = float(promises[every.index(task.seed)])
            refined[-1].update([task.seed] if task.refine else [])
            record = StartRecord(task.seed, task.refine, promise, promise, SolverStatus.SETTLED, True, 9, 1.0)
            results.append(Start(record, unknowns, family, 1.0, unknowns, promise))
        return results, False

    for starts in range(1, len(promises) + 1):
        refined.append(set())
        search(Request(settings, model=MODEL, duration=2.0, starts=starts), SMALL, silent, run)
        assert every[int(np.argmax(promises[:starts]))] in refined[-1]
    assert all(fewer <= more for fewer, more in pairwise(refined))


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_neither_do_many_small_steps(family: str):
    not_worse([logdet(family, box=share) for share in (0.2, 0.35, 0.6, 0.8, 1.0)])
    not_worse([logdet(family, limits=share) for share in (0.3, 0.5, 0.75, 1.0)])
