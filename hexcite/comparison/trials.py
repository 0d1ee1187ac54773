"""The payload experiment of section 8: known weights are mounted one after the other and identified by each method.

The methods are tables of `cases/hexapod/validation.toml`, or results of a real machine are one. Theoretical values are
those of the platform as identified without payload plus the known weights, as in Table 7. Errors are also given in
reported standard deviations: of a simulated machine from its true values, of a real one of what was added from what is
known of the weights.
"""

import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from cases.base.doors import checks_arguments
from cases.base.errors import CaseError, Code, HexciteError, IdentificationError, Interrupted, choice, option
from cases.base.options import documented
from cases.controller import ControllerName
from cases.readiness import readiness
from cases.schema import Case, fingerprint
from cases.sensors import Disturbances, RigidBody, together
from cases.tables import Part
from hexcite._run import carried_out
from hexcite._write import write
from hexcite.comparison.methods import METHOD_TABLES, ValidationOptions
from identification.estimation.criteria import Criterion
from identification.estimation.fit import Value
from identification.identify import estimate_parameters
from identification.limits.limit import KINETIC
from identification.machines.executed import Execution
from identification.model.blocks import RIGID
from identification.model.model import Model, full_model
from identification.model.parameters import body_parameters, linear_parameters, physical_form
from identification.motion.motion import Array
from identification.recording.recording import Recording
from identification.results.estimate import entries_of
from identification.results.payload import payload
from identification.results.result import Result
from identification.samples.standstills import average, find_standstills, match
from identification.simulate import Circumstances, loaded_truth, simulate_recording
from planner._plan import planned
from planner.controller_limits import controlled
from planner.families.settings import family_class
from planner.plans.plan import Plan
from planner.poses.planned_poses import poses_planned
from planner.request import PoseRequest, Request
from postprocessors.controllers.executed_run import stood
from postprocessors.program import DIALECTS

SHOWN = ("m", "zC", "IC33", "f_q0_3", "k0", "k1")  # parameters of Table 7
BODY = ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")  # parameters whose errors are reported


@dataclass(frozen=True, slots=True)
class Trial:
    """Identification by a method with some of the weights mounted: one row of Table 7."""

    method: str  # its name
    weights: int  # number of mounted weights
    load: float  # their mass [kg]
    duration: float | None  # measuring time [s]; None where a result does not say
    result: Result
    theory: Mapping[str, float]  # values by the identification without payload plus the weights, by name [SI]
    errors: Mapping[str, float]  # of mass, centre of gravity and inertia, in reported standard deviations, by name

    @property
    def load_words(self) -> str:
        """The load to a kilogram, a lighter one to three digits."""
        return f"{self.load:.0f} kg" if self.load >= 10.0 else f"{self.load:.3g} kg"

    @property
    def s0(self) -> float:
        """The value of (27) for the recorded forces [N]."""
        return self.result.record.s0

    def deviation(self, name: str) -> float | None:
        """Relative deviation from theory; None where there is no theory."""
        if name not in self.theory or name not in self.result.parameters:
            return None
        return self.result[name].value / self.theory[name] - 1.0

    def to_json(self) -> dict[str, Any]:
        """One row of the answer, SI units."""
        return {
            "method": self.method,
            "weights": self.weights,
            "load_kg": self.load,
            "duration_s": self.duration,
            "model": self.result.record.model,
            "samples": self.result.record.samples,
            "s0_N": self.s0,
            "parameters": {name: value._asdict() for name, value in self.result.parameters.items()},
            "relative_deviation": {n: self.deviation(n) for n in SHOWN if self.deviation(n) is not None},
            "error_in_std": dict(self.errors),
            "warnings": list(self.result.warnings),
        }


@dataclass(frozen=True, slots=True)
class Excitation:
    """A method as a controller executed its program, without payload."""

    case: Case  # case with a simulated machine
    name: str  # method
    duration: float  # measuring time as executed [s]
    execution: Execution  # motion that the controller executed
    trigger: Array  # start and end of each time the trigger was on, shape (k, 2) [s]
    poses: Array  # poses at which the program measures standing still, shape (k, 6), empty for motions [m, rad]
    seed: int  # seed of the sensors' noise
    controller: str = ""  # controller that executed it, with a remark on the run

    def recorded(self, weights: int, disturbances: Disturbances | None) -> Recording:
        """The run with some weights mounted, averaged where it stands."""
        around, source = (
            Circumstances(_weights(self.case, weights), disturbances),
            f"{self.name} with {weights} weights",
        )
        run = simulate_recording(self.case, self.execution, self.trigger, self.seed + weights, source, around)
        if not len(self.poses):
            return run
        return match(average(run, find_standstills(run, 0.0)), self.case, self.poses, source)[0]


def _weights(case: Case, count: int) -> tuple[RigidBody, ...]:
    if case.payloads is None:
        case.missing("payloads", "a validation with payloads")
    return case.payloads.weights[:count]


def trials(excitation: Excitation, mounted: Sequence[int], disturbances: Disturbances | None) -> Iterator[Trial]:
    """The simulated machine identified with numbers of weights on it, ascending from 0."""
    case = excitation.case
    bare: Result | None = None
    for k in mounted:
        estimate = estimate_parameters(excitation.recorded(k, disturbances), case)
        result = Result(case, entries_of(estimate), estimate)
        bare = result if bare is None else bare
        weights = _weights(case, k)
        body = loaded_truth(case.need_simulation("the validation").parameters, weights)
        truth = _physical(result.model, linear_parameters(result.model, body))
        errors = {n: (result[n].value - truth[n]) / result[n].reported for n in BODY if n in result.parameters}
        yield Trial(excitation.name, k, _mass(weights), excitation.duration, result, _theory(bare, weights), errors)


MEASURED = "measured"
"""Name of the method of results that were measured."""


def measured_trials(results: Sequence[Result], mounted: Sequence[int]) -> Iterator[Trial]:
    """Results of one machine with numbers of weights on it, ascending from 0.

    Raises:
        HexciteError: there is not one result a number, or models differ.
        IdentificationError: two are of one recording, or what was added is nearer to another number of weights.
    """
    if len(results) != len(mounted):
        raise HexciteError(
            problem=f"{len(results)} results, and {len(mounted)} numbers of weights: {', '.join(map(str, mounted))}",
            remedy=f"name one result for each number, in this order, or say how many were mounted: "
            f"{option('weights')} 0,3",
            code=Code.CONTRADICTION,
        )
    bare = results[0]
    for result, k in zip(results, mounted, strict=True):
        if result.model.names != bare.model.names:
            raise IdentificationError(
                place=result.source,
                problem=f"is of model {result.record.model}, and {bare.source} of model {bare.record.model}",
                remedy="identify all runs with the same model",
                code=Code.CONTRADICTION,
            )
        weights = _weights(bare.case, k)
        errors: dict[str, float] = {}
        if weights:
            added = payload(bare, result).parameters
            _require_nearest(result, added["m"].value, k)
            errors = _errors_of_added(added, weights)
        theory = _theory(bare, weights)
        yield Trial(MEASURED, k, _mass(weights), result.record.measuring_s, result, theory, errors)


def _require_nearest(result: Result, added: float, count: int) -> None:
    """Raises IdentificationError where another number of weights is nearer to what was added [kg]: another order."""
    masses = np.cumsum([0.0, *(weight.mass_kg for weight in _weights(result.case, 99))])
    nearest = int(np.argmin(np.abs(masses - added)))
    if nearest != count:
        raise IdentificationError(
            place=result.source,
            problem=f"{added:.4g} kg were added, which is {nearest} weights ({masses[nearest]:.4g} kg) rather than "
            f"{count} ({masses[count]:.4g} kg)",
            remedy=f"name the results in the order of the weights, and say how many are mounted: {option('weights')} "
            f"0,{nearest}",
            code=Code.CONTRADICTION,
        )


def _errors_of_added(added: Mapping[str, Value], weights: Sequence[RigidBody]) -> dict[str, float]:
    """What was added less what is known of the weights, in reported standard deviations."""
    body = reduce(together, weights)
    values = (body.mass_kg, *body.centre_of_gravity, *np.diag(body.inertia))
    known = dict(zip(BODY, map(float, values), strict=True))
    return {n: (added[n].value - known[n]) / added[n].reported for n in BODY if n in added}


def _theory(bare: Result, mounted: Sequence[RigidBody]) -> dict[str, float]:
    """The platform as identified without payload, with weights on it; offsets stay.

    Linear parameters of bodies add; the estimate need not be one of a real body.
    """
    bodies = [body_parameters(weight) for weight in mounted]
    linear = bare.values + [sum(body.get(name, 0.0) for body in bodies) for name in bare.model.names]
    return {name: value for name, value in _physical(bare.model, linear).items() if name[0] not in "kK"}


def _mass(weights: Sequence[RigidBody]) -> float:
    return sum(weight.mass_kg for weight in weights)


def _physical(model: Model, linear: Array) -> dict[str, float]:
    """Physical parameters of linear ones, by name."""
    form = physical_form(model)
    values, _ = form.of(linear, np.zeros((len(linear), len(linear))))
    return {p.name: float(value) for p, value in zip(form.parameters, values, strict=True)}


def require_platform(case: Case) -> None:
    """Raises CaseError where no methods can be compared: their motions are those of a hexapod's platform."""
    if case.limits is not None and full_model(case) == RIGID:
        problem = f"is {case.setup}: a validation compares methods for sensors in a hexapod's platform"
        raise CaseError(
            file=f"case {case.name}",
            key="setup",
            problem=problem,
            remedy="identify runs of the machine without and with weights, and name their results",
            code=Code.NOT_SUPPORTED,
        )


def mounted_weights(case: Case, wanted: str | Sequence[int] | None) -> tuple[int, ...]:
    """Numbers of weights to mount, by default all; raises HexciteError where `wanted` is not such, as in 0,3,5."""
    most = len(_weights(case, 99))
    if wanted is None:
        return tuple(range(most + 1))
    words = [word.strip() for word in wanted.split(",")] if isinstance(wanted, str) else [str(n) for n in wanted]
    numbers = tuple(int(word) for word in words if word.isdecimal())
    if len(numbers) < len(words) or numbers[:1] != (0,) or list(numbers) != sorted(set(numbers)) or numbers[-1] > most:
        raise HexciteError(
            problem=f"weights {wanted!r} are not numbers of weights that can be mounted",
            remedy=f"give how many are mounted, from 0 upwards to at most {most}, as in 0,{most}",
            code=Code.OUT_OF_RANGE,
        )
    return numbers


class MethodSpec(Part):
    """A method, as a table of `cases/hexapod/validation.toml` states it."""

    label: str
    family: str
    criterion: Criterion = Criterion.D
    settings: dict[str, Any] = Field(default_factory=dict)
    program: Literal[ControllerName.SINUMERIK, ControllerName.LINUXCNC] = ControllerName.SINUMERIK

    @property
    def request(self) -> Request | PoseRequest:
        """What is planned."""
        if self.family == PoseRequest.name:
            return PoseRequest(self.criterion, **self.settings)
        return Request(family_class(self.family)(**self.settings), criterion=self.criterion)


METHODS = {name: MethodSpec.model_validate(entries) for name, entries in METHOD_TABLES.items()}

Remark = Callable[[str], None]
"""Function that is called with the present step in words."""


@checks_arguments
@documented(ValidationOptions)
@dataclass(frozen=True, slots=True)
class ValidationSettings(ValidationOptions):
    """How `hx.validate` carries out its methods.

    >>> hx.ValidationSettings(starts=1)
    ValidationSettings(on='virtual', starts=1, seed=0, workers=None)

    Args:
        OPTIONS
    """

    def __post_init__(self) -> None:
        Request(starts=self.starts, seed=self.seed, workers=self.workers)  # which says what these can be


USUAL = ValidationSettings()
OF_JERK_LIMITS = ControllerName.SINUMERIK, ControllerName.TWINCAT
"""Languages of controllers that limit the jerk of a hexapod's moves by themselves."""


def require_methods(names: Sequence[str]) -> None:
    """Raises HexciteError where a name is none of `METHODS` or given twice, or there is none."""
    for name in names:
        if name not in METHODS:
            raise HexciteError(problem=f"method {name!r} is unknown", remedy=choice(name, METHODS), code=Code.UNKNOWN)
    if not names or len(set(names)) < len(names):
        raise HexciteError(
            problem=f"methods {', '.join(names)!r} name none, or one twice",
            remedy=f"name each once, of {', '.join(METHODS)}",
            code=Code.CONTRADICTION,
        )


@contextmanager
def unfinished(output: Path, case: Case, settings: ValidationSettings) -> Iterator[Path]:
    """Yields the folder that holds the plans until the validation is written, also after an interruption.

    It stands beside `output`, and a fingerprint of case and settings in its name lets the same command find it again.
    """
    key = fingerprint([case.hash, settings.starts, settings.seed])[:8]
    folder = output.absolute().with_name(f"{output.name}.unfinished-{key}")
    try:
        yield folder
    except Interrupted:
        if folder.exists():
            raise Interrupted(f"finished plans are kept in {folder.name}, the same command uses them") from None
        raise
    shutil.rmtree(folder, ignore_errors=True)


def language_of_method(case: Case, method: str, on: str) -> str:
    """The language of a method's program: the one that its table names, else one that limits jerk alike.

    Raises:
        CaseError: the case has the settings of none of them.
    """
    program = METHODS[method].program
    if on != ControllerName.VIRTUAL or program == ControllerName.LINUXCNC:
        return ControllerName.LINUXCNC
    ready = [name for name in OF_JERK_LIMITS if not readiness(case)[f"post --dialect {name}"]]
    for name in (program, *OF_JERK_LIMITS):
        if name in ready and not controlled(case, name)[1]:
            return name
    return case.missing(" or ".join(f"controller.{name}" for name in OF_JERK_LIMITS), f"the method {method}")


def executed(case: Case, method: str, settings: ValidationSettings, folder: Path, remark: Remark) -> Excitation:
    """A method planned, written as a proven program and executed; a plan that `folder` holds is not made again."""
    remark(f"{method}: planning")
    plan = _planned(case, method, settings, folder)
    language = DIALECTS[language_of_method(case, method, settings.on)]
    accepted = KINETIC if language.name == ControllerName.LINUXCNC else ()
    file = folder / "programs" / f"{method}{language.suffix}"
    program = write(plan, language.name, accept=accepted, file=file)
    program.save(file, overwrite=True)
    remark(f"{method}: on {settings.on}")
    run = carried_out(program, program.case, settings.on)
    poses, duration = np.zeros((0, 6)), run.excitation
    if program.reading.measures_at_poses:
        poses = program.reading.measured_poses
        duration = stood(run, poses, program.path)[0]
    controller = f"{run.controller}; {run.remark}" if run.remark else run.controller
    return Excitation(program.case, method, duration, run.execution, run.trigger, poses, settings.seed, controller)


def _planned(case: Case, method: str, settings: ValidationSettings, folder: Path) -> Plan:
    """The plan of a method: an earlier one, or made now; one that Ctrl-C ended early is none."""
    place = folder / "plans" / method
    if (place / "plan.json").is_file():
        return Plan.load(place, case)
    request = METHODS[method].request
    if isinstance(request, PoseRequest):
        plan = poses_planned(request, case)
    else:
        if request.family.optimised:
            request = replace(request, starts=settings.starts, seed=settings.seed, workers=settings.workers)
        plan = planned(request, case)
        if plan.interrupted:
            raise Interrupted
    plan.save(place)
    return Plan.load(place, case)
