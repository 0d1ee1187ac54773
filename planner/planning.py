"""Plans an excitation from start to proof."""

from time import perf_counter

import numpy as np

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limits import PROOF_RATE
from identification.model import Model, identification_model
from identification.parameters import body_parameters, physical_form
from identification.reference import reference_scaling
from planner.bound import box_bound
from planner.families.family import Family, box_middle
from planner.families.fourier import COARSE, FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.interruption import Interrupted
from planner.parallel import Listener, run_all
from planner.plan import Plan
from planner.problem import mean_information
from planner.request import Request
from planner.solving import Failed, Stage, Start, Task, keep_limits, require_rest, seeds_of

SAMPLES_PER_SECOND = 1000.0  # of the recording, for predicted standard deviations
DEFAULT_NOISE = 1.0  # [N] where the case says nothing about its sensors
REFINED = 2  # of the starts, the best are refined: one a core of the smallest machine

# A look from every start, then the full problem from the best of them: the many local optima differ more than what the
# last iterations bring.
STAGES = {
    "fourier": (Stage("explore", 100, False), Stage("refine", 150, True)),
    "ptp": (Stage("explore", 200, False), Stage("refine", 300, True)),
}


def family_of(request: Request, case: Case) -> Family:
    """The family that a request names, with its settings."""
    if request.family == "fourier":
        middle, half = box_middle(case)
        repeats = round(request.duration / request.period)
        return FourierFamily(request.order, request.period, repeats, middle, half, COARSE)
    return PointToPointFamily.of(case, request.moves, request.duration)


def optimise(
    request: Request, case: Case, family: Family, listener: Listener
) -> tuple[list[Start], list[Failed], bool]:
    """Explores from all starts, refines the best.

    Returns:
        Starts of both stages, the best first; those that failed; whether Ctrl-C ended the search early.

    Raises:
        InfeasiblePlan: every start failed; the message is that of the first.
        Interrupted: Ctrl-C before any start was done.
    """
    explore, refine = STAGES[request.family]
    settings = (request.criterion, request.solver)
    tasks = [Task(case, request.model, family, *settings, explore, s) for s in seeds_of(request.seed, request.starts)]
    first = run_all(tasks, listener)
    results, interrupted = list(first.results), first.interrupted
    best = sorted((r for r in results if isinstance(r, Start)), key=lambda s: -s.score)[:REFINED]
    if best and not interrupted:
        again = [Task(case, request.model, s.family, *settings, refine, s.seed, s.unknowns) for s in best]
        second = run_all(again, listener)
        results, interrupted = results + second.results, second.interrupted
    starts = sorted((r for r in results if isinstance(r, Start)), key=lambda s: -s.score)
    failed = [r for r in results if isinstance(r, Failed)]
    if not starts:
        if interrupted:
            raise Interrupted
        raise InfeasiblePlan(failed[0].reason)
    return starts, failed, interrupted


def make(request: Request, case: Case, case_file: str, listener: Listener) -> Plan:
    """Optimises, proves and rates an excitation.

    Args:
        request: what to plan.
        case: machine and limits.
        case_file: name or file that finds the case again from any folder.
        listener: is told how the starts are getting on.

    Raises:
        InfeasiblePlan: no motion keeps the limits.
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
        Interrupted: Ctrl-C before any start was done.
    """
    model = identification_model(case, request.model)
    require_rest(case)
    family = family_of(request, case)
    began = perf_counter()
    starts, failed, interrupted = optimise(request, case, family, listener)
    best = starts[0]
    unknowns, report = keep_limits(case, best.family, best.unknowns, PROOF_RATE)
    seconds = perf_counter() - began
    if not report.kept:
        raise InfeasiblePlan(f"no feasible motion: {report.violations[0].sentence()}; widen that limit")
    motion = best.family.motion(unknowns)
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, motion)
    mu = singular_values(information, model.names)
    noise = case.simulation.force_noise_N if case.simulation is not None else DEFAULT_NOISE
    return Plan(
        case=case,
        case_file=case_file,
        request=request,
        motion=motion,
        settings=family.settings,
        starts=tuple(starts),
        failed=tuple(failed),
        interrupted=interrupted,
        score=CRITERIA[request.criterion].of(mu),
        logdet=CRITERIA["D"].of(mu),
        condition=-CRITERIA["K"].of(mu),
        bound=box_bound(case, model),
        predicted_std=predicted_std(case, model, scaling, information, motion.duration, noise),
        assumed_noise=noise,
        limits=report,
        solve_seconds=seconds,
    )


def predicted_std(
    case: Case, model: Model, scaling: np.ndarray, information: np.ndarray, duration: float, noise: float
) -> dict[str, float]:
    """Standard deviations of the physical parameters for one run at 1 kHz with white force noise, at nominal values.

    Raises:
        CaseError: the case has no nominal body.
    """
    if case.nominal is None:
        case.missing("nominal", "predicted standard deviations")
    covariance = noise**2 / (duration * SAMPLES_PER_SECOND) * np.linalg.inv(information)
    covariance *= np.outer(scaling, scaling)
    form = physical_form(model)
    body = body_parameters(case.nominal)
    nominal = np.array([body.get(name, 0.0) for name in model.names])  # the rest is linear: its values do not matter
    _, physical = form.of(nominal, covariance)
    std = np.sqrt(np.diag(physical))
    return {p.name: float(s) for p, s in zip(form.parameters, std, strict=True)}
