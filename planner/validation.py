"""The payload experiment of section 8: known weights are mounted one after the other and identified by each method.

Theoretical values are those of the platform as identified without payload plus the known weights, as in Table 7; a
simulated machine knows its true values too, and errors are also told in reported standard deviations of these.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.disturbances import Disturbances
from cases.errors import FileProblem, HexciteError
from cases.schema import Case
from cases.sensors import RigidBody
from identification.executed import Execution
from identification.identify import identify
from identification.loaded import Circumstances, joined_body
from identification.recording import Recording, read_recording
from identification.result import Estimate
from identification.simulate import simulate_recording, simulate_standstills

Array = NDArray[np.float64]

RATE = 1000.0  # [1/s] of the sensors, averaged at standstills
COMPARED = ("m", "zC", "IC33")  # what Table 7 compares with theory
SHOWN = (*COMPARED, "f_q0_3", "k0", "k1")
SUSPICIOUS = 3.0  # reported standard deviations; more is a systematic error
RIGID = 1e5  # [Hz]: a mode that no motion reaches

METHODS = {
    "Q5M": "480 poses, model 5",
    "Q5N": "30 N-optimal poses, model 5",
    "D9M": "hand-made motion, model 9",
    "D9N": "N-optimal Fourier series of order 3, 12 s, model 9",
    "ptp": "D-optimal point-to-point moves, 12 s, model 9",
    "spline": "D-optimal jerk-limited spline, 12 s, model 9",
}


@dataclass(frozen=True, slots=True)
class Excitation:
    """A method as it was carried out without payload.

    Args:
        name: key of METHODS, or a folder of recordings.
        meaning: in words.
        duration: measuring time [s]; None where recordings do not tell.
        recorded: (weights mounted, what disturbs) -> the recording.
    """

    name: str
    meaning: str
    duration: float | None
    recorded: Callable[[int, Disturbances | None], Recording]


@dataclass(frozen=True, slots=True)
class Step:
    """What a method says with some of the weights mounted.

    Args:
        method: its name.
        weights: so many.
        load: their mass [kg].
        duration: measuring time [s].
        estimate: the identification.
        theory: values by the identification without payload plus the weights, by name [SI].
        truth: of a simulated machine, by name [SI]; empty for recordings.
    """

    method: str
    weights: int
    load: float
    duration: float | None
    estimate: Estimate
    theory: Mapping[str, float]
    truth: Mapping[str, float]

    def deviation(self, name: str) -> float | None:
        """Relative deviation from theory; None where there is no theory."""
        if name not in self.theory or name not in self.estimate.physical:
            return None
        return self.estimate.physical[name].value / self.theory[name] - 1.0

    def error(self, name: str) -> float | None:
        """Estimate less truth in reported standard deviations; None where the truth is unknown."""
        if name not in self.truth or name not in self.estimate.physical:
            return None
        value = self.estimate.physical[name]
        return (value.value - self.truth[name]) / value.reported

    def to_json(self) -> dict[str, Any]:
        """One row of the answer, SI units."""
        return {
            "method": self.method,
            "weights": self.weights,
            "load_kg": self.load,
            "duration_s": self.duration,
            "model": self.estimate.model,
            "samples": self.estimate.samples,
            "s0_N": self.estimate.s0_N,
            "parameters": {name: value._asdict() for name, value in self.estimate.physical.items()},
            "relative_deviation": {n: self.deviation(n) for n in SHOWN if self.deviation(n) is not None},
            "error_in_std": {n: self.error(n) for n in COMPARED if self.error(n) is not None},
            "warnings": list(self.estimate.warnings),
        }


@dataclass(frozen=True, slots=True)
class Cause:
    """What made an estimate of a simulated machine err by more than `SUSPICIOUS` standard deviations.

    Args:
        method: its name.
        weights: mounted.
        parameter: its name.
        error: relative, with all disturbances.
        without: relative error without each of the disturbances, by name.
    """

    method: str
    weights: int
    parameter: str
    error: float
    without: Mapping[str, float]

    @property
    def name(self) -> str:
        """The disturbance without which the error is smallest."""
        return min(self.without, key=lambda k: abs(self.without[k]))

    def sentence(self) -> str:
        """In words."""
        left = f"{100 * self.without[self.name]:+.2f} %"
        return (
            f"{self.method} with {self.weights} weights: {self.parameter} is off by {100 * self.error:+.2f} %, more "
            f"than {SUSPICIOUS:g} reported standard deviations; without {self.name} it would be off by {left}"
        )

    def to_json(self) -> dict[str, Any]:
        """For the answer."""
        return {
            "method": self.method,
            "weights": self.weights,
            "parameter": self.parameter,
            "relative_error": self.error,
            "cause": self.name,
            "relative_error_without": dict(self.without),
        }


def dynamic(
    case: Case, name: str, meaning: str, duration: float, run: tuple[Execution, Array], seed: int
) -> Excitation:
    """A motion that a controller executed, recorded with any weights on the simulated machine.

    Args:
        case: with a simulated machine.
        name: of the method.
        meaning: in words.
        duration: executed excitation [s].
        run: the motion, and when the trigger was on.
        seed: of the sensors' noise.
    """

    def recorded(weights: int, disturbances: Disturbances | None) -> Recording:
        around = Circumstances(_weights(case, weights), disturbances)
        return simulate_recording(case, *run, seed + weights, f"{name} with {weights} weights", around)

    return Excitation(name, meaning, duration, recorded)


def static(case: Case, name: str, meaning: str, duration: float, poses: Array, seed: int) -> Excitation:
    """Poses in which the simulated machine stands still; see `dynamic`."""
    samples = max(1, round(case.need_poses("a measurement at poses").average_s * RATE))

    def recorded(weights: int, disturbances: Disturbances | None) -> Recording:
        around = Circumstances(_weights(case, weights), disturbances)
        return simulate_standstills(case, poses, samples, seed + weights, around, f"{name} with {weights} weights")

    return Excitation(name, meaning, duration, recorded)


def _weights(case: Case, count: int) -> tuple[RigidBody, ...]:
    if case.payloads is None:
        case.missing("payloads", "a validation with payloads")
    return case.payloads.weights[:count]


def steps(case: Case, excitation: Excitation, disturbances: Disturbances | None) -> Iterator[Step]:
    """The simulated machine identified without payload and after each weight.

    Args:
        case: with payloads and a simulated machine.
        excitation: the method.
        disturbances: of the machine.
    """
    count = len(_weights(case, 99))
    recordings = (excitation.recorded(k, disturbances) for k in range(count + 1))
    truth = case.need_simulation("the validation").parameters
    yield from _identified(case, excitation.name, excitation.duration, recordings, truth.body)


def recorded_steps(case: Case, folder: Path) -> Iterator[Step]:
    """Recordings of a machine: in `folder` the runs 0, 1, .. with so many weights, as folders or CSV files.

    Raises:
        FileProblem: there is none without payload, or fewer than two.
        HexciteError: a run cannot be evaluated.
    """
    files = []
    for k in range(len(_weights(case, 99)) + 1):
        found = [p for p in (folder / str(k), folder / f"{k}.csv", folder / f"{k}.parquet") if p.exists()]
        if not found:
            break
        files.append(found[0])
    if len(files) < 2:
        raise FileProblem(
            f"{folder}: holds {len(files)} of the runs 0, 1, .. (folders or CSV files, named after the number of "
            "weights mounted); a validation needs at least 0 and 1"
        )
    yield from _identified(case, folder.name, None, (read_recording(f, case) for f in files), None)


def _identified(
    case: Case, name: str, duration: float | None, recordings: Iterator[Recording], body: RigidBody | None
) -> Iterator[Step]:
    bare: Estimate | None = None
    for k, recording in enumerate(recordings):
        estimate = identify(recording, case)
        bare = bare or estimate
        mounted = _weights(case, k)
        truth = {} if body is None else _values(joined_body((body, *mounted)))
        load = sum(w.mass_kg for w in mounted)
        yield Step(name, k, load, duration, estimate, _theory(bare, mounted), truth)


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
        apart = centres[:, :2] - centre[:2]
        theory["IC33"] = float(own + masses @ np.sum(apart**2, axis=1))
    return theory


def _values(body: RigidBody) -> dict[str, float]:
    centre = dict(zip(("xC", "yC", "zC"), (float(v) for v in body.centre_of_gravity), strict=True))
    return {"m": body.mass_kg} | centre | {"IC33": float(body.inertia[2, 2])}


def without_each(found: Disturbances) -> dict[str, Disturbances]:
    """The disturbances with one of them taken away, by the name of what was taken away."""
    return {
        "the structural mode": found.model_copy(update={"mode_Hz": RIGID}),
        "the ripple of the struts": found.model_copy(update={"strut_velocity_noise_mm_s": 0.0}),
        "the errors of the pose": found.model_copy(update={"pose_error_N": 0.0, "pose_error_of_load": 0.0}),
    }


def causes(case: Case, excitation: Excitation, found: Sequence[Step], disturbances: Disturbances) -> list[Cause]:
    """Why compared parameters are off by more than `SUSPICIOUS` standard deviations, where they are most.

    The same run is recorded again without each of the disturbances, and identified.

    Args:
        case: with a simulated machine.
        excitation: the method of the steps.
        found: its steps.
        disturbances: of their recordings.
    """
    tries: dict[int, dict[str, Estimate]] = {}
    result = []
    for name in COMPARED:
        step = max(found, key=lambda s: abs(s.error(name) or 0.0))
        if abs(step.error(name) or 0.0) <= SUSPICIOUS:
            continue
        if step.weights not in tries:
            fewer = without_each(disturbances).items()
            tries[step.weights] = {k: identify(excitation.recorded(step.weights, d), case) for k, d in fewer}
        truth = step.truth[name]
        without = {k: e.physical[name].value / truth - 1.0 for k, e in tries[step.weights].items()}
        error = step.estimate.physical[name].value / truth - 1.0
        result.append(Cause(step.method, step.weights, name, error, without))
    return result


def models(case: Case, excitation: Excitation, disturbances: Disturbances | None) -> dict[int, Estimate]:
    """Table 3's dynamic columns: the run without payload, identified with models 6 to 9."""
    recording = excitation.recorded(0, disturbances)
    return {number: identify(recording, case, number) for number in (6, 7, 8, 9)}


def chosen(names: str) -> list[str]:
    """Methods by their names, separated by commas.

    Raises:
        HexciteError: one of them is unknown.
    """
    found = [name.strip() for name in names.split(",") if name.strip()]
    for name in found:
        if name not in METHODS:
            raise HexciteError(f"method {name!r} is unknown; choose {', '.join(METHODS)}")
    if not found or len(set(found)) < len(found):
        raise HexciteError(f"methods {names!r}: name each once, of {', '.join(METHODS)}")
    return found
