"""The payload experiment of section 8: known weights are mounted one after the other and identified by each method.

Theoretical values are those of the platform as identified without payload plus the known weights, as in Table 7; a
simulated machine knows its true values too, and errors are also told in reported standard deviations of these.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cases.errors import FileProblem, HexciteError
from cases.schema import Case
from cases.sensors import Disturbances, RigidBody
from identification.identify import identify
from identification.motion import Array
from identification.parameters import linear_parameters, physical_form
from identification.recording import Recording, read
from identification.result import Estimate
from identification.runs.rates import on_one_clock
from identification.runs.standstills import average, find_standstills, match
from identification.simulate import Circumstances, ForceParts, Moved, loaded_truth, moved, pose_covariance, sensed
from identification.trajectories.executed import Execution
from planner.comparison.step import BODY, LinearAnswer, MethodStep, error_budget, linear_answer
from planner.runs.identifying import standing_of

METHODS = ("Q5M", "Q5N", "D9M", "D9N", "ptp", "ptp-steps", "spline")


@dataclass(frozen=True, slots=True)
class Excitation:
    """A method as a controller executed its program, without payload."""

    case: Case  # case with a simulated machine
    name: str  # one of METHODS
    duration: float  # measuring time as executed [s]
    execution: Execution  # what the controller did
    trigger: Array  # start and end of each time the trigger was on, shape (k, 2) [s]
    poses: Array  # poses at which the program measures standing still, shape (k, 6), empty for motions [m, rad]
    seed: int  # of the sensors' noise
    controller: str = ""  # controller that executed it, and what to know about the run

    def moved(self, weights: int, disturbances: Disturbances | None) -> Moved:
        """What the machine did with some weights mounted; its drives ripple anew in each run."""
        return moved(self.case, self.execution, Circumstances((), disturbances), self.seed + weights)

    def recorded(
        self, weights: int, disturbances: Disturbances | None, run: Moved | None = None
    ) -> tuple[Recording, ForceParts]:
        """The run with some weights mounted, averaged where it stands, and what its forces consist of."""
        around = Circumstances(_weights(self.case, weights), disturbances)
        run = self.moved(weights, disturbances) if run is None else run
        source = f"{self.name} with {weights} weights"
        recording, parts = sensed(self.case, run, self.trigger, self.seed + weights, source, around)
        if not len(self.poses):
            return recording, parts
        windows = find_standstills(recording, 0.0)
        averages, those = match(average(recording, windows), self.case, self.poses, source)
        return averages, ForceParts(*(np.array([part[w].mean(axis=0) for w in windows[those]]) for part in parts))


def _weights(case: Case, count: int) -> tuple[RigidBody, ...]:
    if case.payloads is None:
        case.missing("payloads", "a validation with payloads")
    return case.payloads.weights[:count]


def steps(excitation: Excitation, mounted: Sequence[int], disturbances: Disturbances | None) -> Iterator[MethodStep]:
    """The simulated machine identified with numbers of weights on it, ascending from 0.

    A set of poses is travelled through once: its standstills do not tell one way there from another.
    """
    case = excitation.case
    once = excitation.moved(0, disturbances) if len(excitation.poses) else None
    bare: Estimate | None = None
    for k in mounted:
        recording, parts = excitation.recorded(k, disturbances, once)
        estimate = identify(recording, case)
        bare = estimate if bare is None else bare
        weights = _weights(case, k)
        body = loaded_truth(case.need_simulation("the validation").parameters, weights)
        model = estimate.model
        linear = linear_parameters(model, body)
        form = physical_form(model)
        values, _ = form.of(linear, np.zeros((len(linear), len(linear))))
        truth = {p.name: float(v) for p, v in zip(form.parameters, values, strict=True) if p.name in BODY}
        load, budget, scatter = sum(w.mass_kg for w in weights), {}, {}
        if disturbances is not None:
            answer = linear_answer(case, recording, estimate)
            budget = error_budget(answer, recording, parts, estimate, linear)
            scatter = true_deviations(case, answer, estimate, disturbances, load)
        theory = _theory(bare, weights)
        yield MethodStep(excitation.name, k, load, excitation.duration, estimate, theory, truth, budget, scatter)


def recorded_steps(case: Case, folder: Path) -> Iterator[MethodStep]:
    """Recordings of a machine: in `folder` the runs 0, 1, .. with so many weights, as folders or files.

    Raises:
        FileProblem: there is none without payload, fewer than two, or one of those between is missing.
        HexciteError: a run cannot be evaluated.
    """
    runs = {
        k: p
        for k in range(len(_weights(case, 99)) + 1)
        for p in (folder / f"{k}.parquet", folder / f"{k}.csv", folder / str(k))
        if p.exists()
    }
    files = [runs[k] for k in sorted(runs)]
    for k in range(len(files)):
        if k not in runs:
            raise FileProblem(folder, f"holds runs up to {max(runs)}, but not {k}", "each number of weights is wanted")
    if len(files) < 2:
        raise FileProblem(
            folder,
            f"holds {len(files)} of the runs 0, 1, .. (folders or CSV files, named after the number of weights "
            "mounted)",
            "a validation needs at least 0 and 1",
        )
    bare: Estimate | None = None
    for k, file in enumerate(files):
        estimate = identify(standing_of(on_one_clock(read(file, case), case), case)[0], case)
        bare = estimate if bare is None else bare
        weights = _weights(case, k)
        load = sum(w.mass_kg for w in weights)
        yield MethodStep(folder.name, k, load, None, estimate, _theory(bare, weights), {})


def _theory(bare: Estimate, mounted: Sequence[RigidBody]) -> dict[str, float]:
    """The platform as identified without payload, with weights on it; offsets stay.

    Masses, first moments and moments about the origin of {P} add; the estimate need not be one of a real body.
    """
    value = {name: v.value for name, v in bare.physical.items()}
    centres = np.array([[value["xC"], value["yC"], value["zC"]], *(w.centre_of_gravity for w in mounted)])
    masses = np.array([value["m"], *(w.mass_kg for w in mounted)])
    centre = masses @ centres / masses.sum()
    theory = {name: v for name, v in value.items() if name.startswith("f_q0")} | {"m": float(masses.sum())}
    theory |= dict(zip(("xC", "yC", "zC"), centre.tolist(), strict=True))
    if "IC33" in value:  # a static model knows no inertia
        own = value["IC33"] + sum(float(w.inertia[2, 2]) for w in mounted)
        offsets = centres[:, :2] - centre[:2]
        theory["IC33"] = float(own + masses @ np.sum(offsets**2, axis=1))
    return theory


def mounted_weights(case: Case, wanted: str | None) -> tuple[int, ...]:
    """Numbers of weights to mount, by default 0 and each up to all of them.

    Raises:
        HexciteError: no numbers, more weights than there are, not from 0 upwards.
    """
    most = len(_weights(case, 99))
    if wanted is None:
        return tuple(range(most + 1))
    words = [word.strip() for word in wanted.split(",")]
    numbers = tuple(int(word) for word in words if word.isdecimal())
    if len(numbers) < len(words) or numbers[0] != 0 or list(numbers) != sorted(set(numbers)) or numbers[-1] > most:
        raise HexciteError(
            f"weights {wanted!r}: give how many are mounted, from 0 upwards to at most {most}, as in 0,{most}"
        )
    return numbers


def require_methods(names: Sequence[str]) -> None:
    """Refuses names that are none of `METHODS`, and names given twice.

    Raises:
        HexciteError: one of them is unknown, or there is none.
    """
    for name in names:
        if name not in METHODS:
            raise HexciteError(f"method {name!r} is unknown; choose {', '.join(METHODS)}")
    if not names or len(set(names)) < len(names):
        raise HexciteError(f"methods {', '.join(names)!r}: name each once, of {', '.join(METHODS)}")


def true_deviations(
    case: Case, answer: LinearAnswer, estimate: Estimate, disturbances: Disturbances, load: float
) -> dict[str, float]:
    """Standard deviations of parameters over machines that differ in their pose errors, by name [SI].

    The errors of the pose have the covariance that the simulated machine draws them from; all the rest is white, as
    (28) has it.

    Args:
        load: mass of the weights on it [kg].
    """
    model = estimate.model
    home = case.need_machine("a validation")[0].home.vector
    weight = load * float(np.linalg.norm(case.gravity))
    common = pose_covariance(disturbances, home, answer.poses, weight)
    covariance = sum(part @ common @ part.T for part in np.moveaxis(answer.answer, 2, 0))
    form = physical_form(model)
    _, by_pose = form.of(estimate.fit.values, np.asarray(covariance))
    return {
        p.name: float(np.sqrt(variance + estimate.physical[p.name].std ** 2))
        for p, variance in zip(form.parameters, np.diag(by_pose), strict=True)
    }
