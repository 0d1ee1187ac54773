"""What a plan, poses, a recording or a result say about the parameters of a model, before or after measuring."""

from collections.abc import Callable
from dataclasses import replace

from threadpoolctl import threadpool_limits

from cases.base.errors import Code, HexciteError, IdentificationError
from cases.base.units import Array
from cases.schema import Case
from identification.identify import default_model, samples_of
from identification.machines.casadi_batch import over_samples
from identification.model.model import Model, identification_model, regressors
from identification.motion.motion import sample
from identification.recording.recording import Recording
from identification.results.identifiability import Identifiability, analysed, models_of, of_models
from identification.results.result import Result
from identification.samples.moving import MovingRun
from identification.samples.samples import Samples
from planner.plans.plan import Plan
from planner.poses.given import given_poses

RATE = 100.0  # [1/s] at which a motion is looked at, less where that makes more instants than
MOST_INSTANTS = 1500


def identifiability(
    thing: Plan | Recording | Result | Array, model: int | None = None, case: Case | None = None
) -> Identifiability:
    """Which parameters of a model a motion or poses can tell apart, with W = 1 (Figure 3).

    >>> hx.identifiability(hx.Plan.load("plan")).words
    'all 20 parameters can be told apart'

    Args:
        thing: a plan, before anything is measured; poses to stand at, shape (n, k) [m or rad]; a recording; a result
            that was identified here, not loaded.
        model: number in Table 2; by default that of the plan or result, and what the poses or the recording can carry.
        case: case of the machine; that of the plan, recording or result unless given.

    Raises:
        HexciteError: poses or a recording without a case, a result without its recording, or no such model.
    """
    machine, number, evaluate, _ = _looked_at(thing, case)
    chosen = identification_model(machine, number if model is None else model)
    with _one_thread():
        return analysed(evaluate(chosen), chosen.names, chosen.number)


def identifiability_of_models(
    thing: Plan | Recording | Result | Array, case: Case | None = None
) -> tuple[Identifiability, ...]:
    """The same of all models that the sensors can have, by number; errors as of `identifiability`."""
    machine, _, evaluate, known = _looked_at(thing, case)
    with _one_thread():
        return of_models({number: model for number, model in models_of(machine).items() if known(model)}, evaluate)


def _one_thread() -> threadpool_limits:
    """One thread for linear algebra: of matrices so small a second one would wait for the first."""
    return threadpool_limits(limits=1, user_api="blas")


def _looked_at(
    thing: Plan | Recording | Result | Array, case: Case | None
) -> tuple[Case, int, Callable[[Model], Array], Callable[[Model], bool]]:
    """The case, the number of the usual model, what gives A for a model, and of which models it can."""
    match thing:
        case Plan():
            machine = thing.case if case is None else case
            if len(thing.poses):
                return machine, thing.model, lambda model: _at_poses(model, thing.poses), _any
            motion = sample(thing.motion, min(RATE, MOST_INSTANTS / thing.duration))
            states = motion.coordinates, motion.rates, motion.accelerations
            return machine, thing.model, lambda model: over_samples(model.coordinate_regressor, *states)[0], _any
        case Recording():
            own_case = thing.machine_case(case)
            usual = default_model(thing, own_case)
            samples = samples_of(thing, own_case, identification_model(own_case, usual))
            return own_case, usual, *_at_samples(samples, 0.0)
        case Result():
            if thing.estimate is None:
                raise HexciteError(
                    place=thing.source,
                    problem="was loaded without its samples",
                    remedy="give its recording",
                    code=Code.MISSING,
                )
            machine = thing.case if case is None else case
            return machine, thing.record.model, *_at_samples(thing.estimate.samples, thing.estimate.at)
        case _:
            if case is None:
                raise HexciteError(
                    place="identifiability",
                    problem="poses belong to a machine",
                    remedy="give its case",
                    code=Code.MISSING,
                )
            poses = given_poses(thing, case, "identifiability")
            usual = 5 if 5 in models_of(case) else 0
            return case, usual, lambda model: _at_poses(model, poses), _any


def _at_poses(model: Model, poses: Array) -> Array:
    """A for standing still, also of a model with inertia, whose columns are zero then, shape (n, 6, u)."""
    return over_samples(model.coordinate_regressor, poses, 0.0 * poses, 0.0 * poses)[0]


def _any(model: Model) -> bool:
    """Of every model: the whole motion is known."""
    del model
    return True


def _at_samples(samples: Samples, delay: float) -> tuple[Callable[[Model], Array], Callable[[Model], bool]]:
    """What gives A for a model at samples, or a part of many that stands for all, and of which models it can."""
    part = samples.excerpt()
    motion = None if isinstance(part, MovingRun) else part.motion(delay)

    def known(model: Model) -> bool:
        if isinstance(part, MovingRun) or model.names == part.model.names:
            return True
        return motion is not None and (motion.drives is not None or not model.needs_position)

    def evaluate(model: Model) -> Array:
        if model.names == part.model.names:
            return part.regressors(delay)
        if isinstance(part, MovingRun):
            return replace(part, model=model).regressors(delay)
        if motion is None or not known(model):  # as `require_position` says of a fit
            raise IdentificationError(
                place=f"model {model.number}",
                problem="needs more of the motion than the recording holds",
                remedy="choose model 0 or 6, or record the drives",
                code=Code.MISSING,
            )
        return regressors(model, motion.load)[motion.known]

    return evaluate, known
