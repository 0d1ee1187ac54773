"""Plans an excitation from start to proof."""

import os
from collections.abc import Sequence
from dataclasses import replace
from threading import Event
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError, IdentificationError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limits import PROOF_RATE, LimitReport, prove
from identification.model import Model, identification_model
from identification.motion import Trajectory
from identification.noise.pose_field import PoseField
from identification.reference import reference_scaling
from planner.bounds.kept import box_bound, known_tight_bound
from planner.controlled import Controlled, move_count, planned_for
from planner.deviations import predicted_std_of, worst_std
from planner.families.family import Family, box_middle
from planner.families.fourier import FourierFamily
from planner.families.manual import manual_motion, sequence_file
from planner.families.ptp import PointToPointFamily
from planner.families.shipped import shipped_start
from planner.families.spline import SplineFamily
from planner.infeasible import remedy
from planner.interruption import Interrupted, first_ctrl_c_calls
from planner.noise import ExpectedNoise, expected_noise, seen_through
from planner.plan import Plan
from planner.pose_errors import PoseErrors, without_pose_errors
from planner.readiness import require_plannable
from planner.request import LONGEST, Request
from planner.search.choices import choices
from planner.search.inside import keep_limits
from planner.search.parallel import Listener, Outcome, Runner, run_here, workers
from planner.search.patience import FEWEST, Patience
from planner.search.problem import information_of, mean_information
from planner.search.solving import Failed, Start, Step, Task, seeds_of
from planner.vibration import both_laws

Array = NDArray[np.float64]

AT_REST = 1e-6  # [m/s, rad/s; m/s^2, rad/s^2] of rounding
KEPT = 3  # of several orders and periods, the best get more starts
ROUND = max(2, min(8, os.cpu_count() or 1))  # starts at a time


class Found(NamedTuple):
    """What came of a search.

    Args:
        motion: the best, proven.
        family: the name of its family.
        settings: of the family.
        limits: the proof.
        starts: the best first.
        failed: starts that led nowhere.
        interrupted: whether Ctrl-C ended the search early.
        rival: what another family found in seconds.
        white: what one start reaches where errors of the pose do not count.
    """

    motion: Trajectory
    family: str
    settings: dict[str, Any]
    limits: LimitReport
    starts: tuple[Start, ...]
    failed: tuple[Failed, ...]
    interrupted: bool
    rival: Start | None = None
    white: Start | None = None


def first_family(request: Request, case: Case) -> Family:
    """The family from which the starts of a request are drawn."""
    if request.family == "fourier":
        middle, half = box_middle(case)
        order, period = request.order, request.base_period
        return FourierFamily.lasting(order, period, request.periods, middle, half, request.centred)
    if request.family == "spline":
        return SplineFamily.of(case, request.intervals, request.duration)
    return PointToPointFamily.of(case, move_count(request, case), request.duration)


def _rival(request: Request, case: Case) -> Task | None:
    """One start of another family that takes seconds, to compare with."""
    if request.starts == 1 or request.criterion != "D":  # one start was asked for, or what D does not measure
        return None
    other = "ptp" if request.family == "fourier" else "fourier"
    wanted = replace(
        request,
        family=other,
        period=None,
        order=5,
        moves=None,
        free_order=False,
        free_period=False,
        starts=1,
        controller=None,
    )
    try:
        require_plannable(replace(wanted, targets=()), case)
    except HexciteError:  # too short for it, or too fast for the filter
        return None
    family = first_family(wanted, case)
    return Task(case, request.model, family, "D", request.seed, request.payload, Step.GLANCE, shipped_start(family))


def search(request: Request, case: Case, listener: Listener, run: Runner) -> Found:
    """Explores from start after start until more of them stop paying, refines the best, proves the winner.

    Raises:
        InfeasiblePlan: every start failed; the message is that of the first.
        Interrupted: Ctrl-C before any start was done.
    """
    own = planned_for(request, case)
    patience = Patience.of(request, len(identification_model(case, request.model).names))
    results, rivals, interrupted = _explored(request, own, case, listener, run, patience.exploring())
    done = max((s.score for s in results if isinstance(s, Start) and s.refined), default=-np.inf)
    # What an exploration promises is too much, never too little: what is less than has been reached leads nowhere.
    rough = [s for s in results if isinstance(s, Start) and not s.refined and s.promise > done]
    best = [Task(own.case, request.model, s.family, request.criterion, s.seed, request.payload, Step.REFINE, s.begin)
            for s in sorted(rough, key=lambda s: -s.promise)[: patience.refined]]  # fmt: skip
    if best and not interrupted:
        second = run(best, listener, patience)
        results, interrupted = results + second.results, second.interrupted
    starts = sorted((r for r in results if isinstance(r, Start)), key=lambda s: -s.score)
    failed = [r for r in results if isinstance(r, Failed)]
    if not starts:
        if interrupted:
            raise Interrupted
        raise InfeasiblePlan(failed[0].reason)
    white = None
    if PoseField.of(case.sensors) is not None and not interrupted:
        fresh, best_family = first_family(request, own.case), starts[0].family
        fresh = fresh if fresh.settings == best_family.settings else best_family
        one = Task(without_pose_errors(own.case), request.model, fresh, "D", starts[0].seed, request.payload,
                   begin=shipped_start(fresh))  # fmt: skip
        last = run([one], Listener(lambda start: None, listener.news), patience)
        white, interrupted = next((r for r in last.results if isinstance(r, Start)), None), last.interrupted
    winner = starts[0].family
    unknowns, report, _ = keep_limits(own.case, winner, starts[0].unknowns, PROOF_RATE)
    motion = winner.motion(unknowns)
    report = own.reported(prove(motion, case)) if own.step_time else report
    return Found(
        motion,
        winner.name,
        {**winner.settings, **({} if own.controller is None else {"made_for": own.controller})},
        report,
        tuple(starts),
        tuple(failed),
        interrupted,
        next(iter(rivals), None),
        white,
    )


def _explored(
    request: Request, own: Controlled, case: Case, listener: Listener, run: Runner, patience: Patience
) -> tuple[list[Start | Failed], list[Start], bool]:
    """Results of all starts, of other families to compare with, and whether Ctrl-C ended them.

    `own` holds the limits that the controller keeps. Of several orders and periods each is looked at once; the starts
    that follow go to the best of them.
    """
    families = [first_family(choice, own.case) for choice in choices(request, case)]
    seeds, several = iter(seeds_of(request.seed, patience.most + len(families))), len(families) > 1

    def fresh(family: Family) -> Task:
        return Task(own.case, request.model, family, request.criterion, next(seeds), request.payload)

    first = max(len(families), min(FEWEST, patience.most))
    tasks = [fresh(families[k % len(families)]) for k in range(first)]
    tasks[0] = replace(tasks[0], begin=shipped_start(tasks[0].family))
    rival = _rival(request, case)
    results: list[Start | Failed] = []
    rivals: list[Start] = []
    while True:
        found = run([*tasks, *([] if rival is None else [rival])], listener, patience)
        for result in found.results:
            if isinstance(result, Start) and rival is not None and result.family.name != request.family:
                rivals.append(result)
            else:
                results.append(result)
        rival = None
        if found.interrupted or patience.over() or patience.enough(results) or len(results) >= patience.most:
            return results, rivals, found.interrupted
        starts = sorted((r for r in results if isinstance(r, Start)), key=lambda s: -s.promise)
        names = [family.settings for family in families]
        ranked = dict.fromkeys(names.index(s.family.settings) for s in starts) if several else {}
        best = [families[k] for k in ranked] or families
        tasks = [fresh(best[k % min(KEPT, len(best))]) for k in range(min(ROUND, patience.most - len(results)))]


def _made_by_hand(request: Request, case: Case) -> Found:
    file = request.sequence if request.sequence is not None else sequence_file(request.case_file)
    motion = manual_motion(case, file)
    if not motion.duration <= LONGEST:
        raise InfeasiblePlan(f"{file}: takes {motion.duration:.0f} s, longer than {LONGEST:g} s; take steps out")
    return Found(motion, "manual", {"sequence": str(file)}, prove(motion, case), (), (), False)


def make(request: Request, case: Case, case_file: str, listener: Listener, run: Runner) -> Plan:
    """Optimises, proves and rates an excitation.

    Args:
        request: what to plan.
        case: machine and limits.
        case_file: name or file that finds the case again from any folder.
        listener: is told how the starts are getting on.
        run: runs the starts.

    Raises:
        InfeasiblePlan: no motion keeps the limits.
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
        HexciteError: what no search can mend; see `require_plannable`.
        Interrupted: Ctrl-C before any start was done.
    """
    require_plannable(request, case)
    began = perf_counter()
    found = _made_by_hand(request, case) if request.family == "manual" else search(request, case, listener, run)
    seconds = perf_counter() - began
    if not found.limits.kept:
        worst = found.limits.violations[0]
        raise InfeasiblePlan(f"no feasible motion: {worst.sentence()}; {remedy(worst)}")
    try:
        return rated(request, case, case_file, found, seconds)
    except IdentificationError as error:
        place = found.settings.get("sequence", f"no plan for model {request.model}")
        raise IdentificationError(f"{place}: {error}") from error


def make_until_ctrl_c(request: Request, case: Case, case_file: str, listener: Listener) -> Plan:
    """`make`, in the main thread; the first Ctrl-C keeps what a search has found, be it in its proof or its rating."""
    if request.family == "manual":
        return make(request, case, case_file, listener, run_here)
    pressed = Event()
    with first_ctrl_c_calls(pressed.set), workers() as run_all:

        def run(tasks: Sequence[Task], listener: Listener, patience: Patience) -> Outcome:
            return Outcome([], True) if pressed.is_set() else run_all(tasks, listener, patience)

        plan = make(request, case, case_file, listener, run)
    return replace(plan, interrupted=True) if pressed.is_set() else plan


def rated(request: Request, case: Case, case_file: str, found: Found, seconds: float) -> Plan:
    """The plan of a motion that keeps all limits: what it is worth.

    Args:
        request: what was asked for.
        case: machine and limits.
        case_file: name or file that finds the case again from any folder.
        found: the motion, and where it comes from.
        seconds: spent on it [s].

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
    """
    model = identification_model(case, request.model)
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, found.motion)
    mu = singular_values(information, model.names)
    noise = expected_noise(case, model, request.payload)
    worst = worst_std(case, model, scaling, found.motion, request.payloads)
    chosen, errors = mu, PoseErrors.of(case, noise)
    if noise.whitening is not None or errors is not None:
        weighted = information_of(seen_through(model, noise.whitening), scaling, found.motion, errors)
        chosen = singular_values(weighted, model.names)
    return Plan(
        case=case,
        case_file=case_file,
        request=request,
        motion=found.motion,
        family=found.family,
        settings=found.settings,
        starts=found.starts,
        failed=found.failed,
        interrupted=found.interrupted,
        rival=found.rival,
        score=CRITERIA[request.criterion].of(chosen),
        logdet=CRITERIA["D"].of(mu),
        condition=-CRITERIA["K"].of(mu),
        bound=box_bound(case, model),
        predicted_std={name: std for name, (std, _) in worst.items()},
        worst_payload={name: payload for name, (_, payload) in worst.items()},
        noise=noise,
        noise_note=(
            *_told(case, model, scaling, found.motion, noise, request.payload),
            *_of_pose_errors(case, model, scaling, found, request, {n: s for n, (s, _) in worst.items()}),
        ),
        limits=found.limits,
        solve_seconds=seconds,
        tight=known_tight_bound(case, model) if _from_rest_to_rest(found.motion) else None,
        laws=both_laws(case, request.model, found.motion, request.payload),
    )


def _from_rest_to_rest(motion: Trajectory) -> bool:
    """Whether nothing moves or speeds up at either end: the tighter bound is one of such motions only."""
    ends = motion.at([0.0, motion.duration])
    return bool(max(np.abs(ends.rates).max(), np.abs(ends.accelerations).max()) < AT_REST)


def _told(
    case: Case, model: Model, scaling: Array, motion: Trajectory, noise: ExpectedNoise, payload: int
) -> tuple[str, ...]:
    """What noise of the accelerations does to a plan."""
    if not noise.shaken:
        return ()
    mounted = f"with {payload} payloads" if payload else "without payload"
    told = f"noise of the accelerations: a force sample errs by {_rms(noise):.3g} N rms {mounted}"
    if payload:
        told += f", by {_rms(expected_noise(case, model)):.3g} N without"
    told += f"; the sensors alone by {noise.sensors:.3g} N"
    if noise.weights == "stated":
        return (told,)
    stated = expected_noise(case, model, payload, "stated")
    pairs = [predicted_std_of(case, model, scaling, motion, n, payload) for n in (stated, noise)]
    less = 1.0 - float(np.exp(np.mean([np.log(pairs[0][name] / pairs[1][name]) for name in pairs[0]])))
    return (
        told,
        f'identify --weights stated, or sensors.weights = "stated" in the case, makes the standard deviations '
        f"{100 * less:.0f} % smaller than the weights {noise.weights} (geometric mean, this motion)",
    )


def _of_pose_errors(
    case: Case, model: Model, scaling: Array, found: Found, request: Request, predicted: dict[str, float]
) -> tuple[str, ...]:
    """What errors that depend on the pose cost a plan, and what it gave up for them."""
    field = PoseField.of(case.sensors)
    if field is None:
        return ()
    white = worst_std(without_pose_errors(case), model, scaling, found.motion, request.payloads)
    times = float(np.exp(np.mean([np.log(predicted[name] / std) for name, (std, _) in white.items()])))
    told = (
        f"errors that depend on the pose ({field.words}) make the standard deviations {times:.3g} times those of white "
    )
    told += "noise alone (geometric mean); "
    if found.white is None:
        return (told + "D-efficiency counts white noise alone",)
    plain = np.linalg.slogdet(mean_information(model, scaling, found.motion))[1]
    other = found.white.family.motion(found.white.unknowns)
    best = np.linalg.slogdet(mean_information(model, scaling, other))[1]
    bound = box_bound(case, model)
    return (
        f"{told}D-efficiency, which counts white noise alone, is {bound.efficiency(float(plain)):.3f}; a plan for it "
        f"reaches {bound.efficiency(float(max(best, plain))):.3f}",
    )


def _rms(noise: ExpectedNoise) -> float:
    return float(np.sqrt(np.mean(noise.std[:3] ** 2)))
