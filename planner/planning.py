"""Plans a Fourier excitation from start to proof."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limits import PROOF_RATE
from identification.model import Model, identification_model
from identification.parameters import body_parameters, physical_form
from identification.reference import reference_scaling
from planner.bound import box_bound
from planner.fourier import FourierFamily
from planner.plan import LONGEST, Plan
from planner.problem import mean_information
from planner.solving import EXPLORE, Start, keep_limits, optimise

SAMPLES_PER_SECOND = 1000.0  # of the recording, for predicted standard deviations
DEFAULT_NOISE = 1.0  # [N] where the case says nothing about its sensors


@dataclass(frozen=True, slots=True)
class Request:
    """What to plan.

    Args:
        case_file: name or file of the case.
        criterion: letter of Table 4.
        order: N of (34).
        period: [s].
        duration: a whole number of periods [s].
        model: number in Table 2.
        starts: random starts.
        seed: of these.
    """

    case_file: str
    criterion: str = "D"
    order: int = 5
    period: float = 3.0
    duration: float = 12.0
    model: int = 9
    starts: int = 8
    seed: int = 0

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise HexciteError(f"criterion {self.criterion!r} is unknown; choose {', '.join(CRITERIA)}")
        if self.criterion != "D":
            raise HexciteError(f"criterion {self.criterion} is not optimised for this family yet; choose D")
        if not 2 <= self.order <= 7:
            raise HexciteError(f"order {self.order} is outside 2 to 7; 1 cannot start at rest, above 7 only jerk grows")
        if not self.period > 0.0 or not np.isfinite(self.period):
            raise HexciteError(f"period {self.period:g} s is not positive; choose about 3 s")
        if not self.duration <= LONGEST:
            raise HexciteError(f"duration {self.duration:g} s is longer than {LONGEST:g} s; choose about 12 s")
        repeats = self.duration / self.period
        if not (round(repeats) >= 1 and abs(repeats - round(repeats)) < 1e-9):
            raise HexciteError(
                f"duration {self.duration:g} s is not a whole number of periods of {self.period:g} s; choose "
                f"{max(1, round(repeats)) * self.period:g} s"
            )
        if not 1 <= self.starts <= 1000:
            raise HexciteError(f"{self.starts} starts; choose 1 to 1000")
        if self.seed < 0:
            raise HexciteError(f"seed {self.seed} is negative; choose 0 or more")


def plan_fourier(request: Request, case: Case, case_file: str, done: Callable[[Start], None]) -> Plan:
    """Optimises, proves and rates an excitation.

    Args:
        request: what to plan.
        case: machine and limits.
        case_file: name or file that finds the case again from any folder.
        done: called with each start as it is finished.

    Raises:
        InfeasiblePlan: no motion keeps the limits.
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
    """
    machine, _, limits = case.need_machine("planning")
    model = identification_model(case, request.model)
    box = limits.motion
    repeats = round(request.duration / request.period)
    middle = machine.home.vector + (box.pose[0] + box.pose[1]) / 2
    half = (box.pose[1] - box.pose[0]) / 2
    family = FourierFamily(request.order, request.period, repeats, middle, half, EXPLORE.density)
    began = perf_counter()
    starts = optimise(case, request.model, family, request.seed, request.starts, done)
    unknowns, report = keep_limits(case, family, starts[0].unknowns, PROOF_RATE)
    seconds = perf_counter() - began
    if not report.kept:
        raise InfeasiblePlan(f"no feasible motion: {report.violations[0].sentence()}; widen that limit")
    motion = family.motion(unknowns)
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, motion)
    mu = singular_values(information, model.names)
    noise = case.simulation.force_noise_N if case.simulation is not None else DEFAULT_NOISE
    return Plan(
        case=case,
        case_file=case_file,
        model=request.model,
        criterion=request.criterion,
        motion=motion,
        seed=request.seed,
        starts=tuple(starts),
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
