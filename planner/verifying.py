"""Whether the figures of a saved plan are those of its motion: what somebody typed into plan.json is not believed."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.model import Model, identification_model
from identification.motion import Joined, Measurement, Trajectory
from identification.reference import reference_scaling
from planner.deviations import predicted_std_at_poses, worst_std
from planner.families.settings import FAMILIES
from planner.noise import ExpectedNoise, expected_noise, seen_through, standing_model
from planner.pose_errors import PoseErrors
from planner.poses.pose_criteria import pose_regressors, total_information
from planner.search.problem import information_of, mean_information

Array = NDArray[np.float64]

ALIKE = 1e-3  # of figures that are computed anew: another computer rounds otherwise, nobody reads further

CLOCK = 1e-6  # [s] of durations


class Mismatch(NamedTuple):
    """A figure that is not the motion's: the key of plan.json, what it says there and what it should be."""

    key: str
    said: object
    found: float


def mismatches(data: dict[str, Any], motion: Trajectory, case: Case) -> Iterator[Mismatch]:
    """Figures of plan.json that the motion beside them does not have, one after the other.

    Args:
        data: all of plan.json.
        motion: motion that its entries describe.
        case: unchanged since.

    Raises:
        KeyError: a figure is missing.
        TypeError: a figure of the wrong kind.
        ValueError: a figure that is not a number.
        HexciteError: the motion does not determine the model, or the model is unknown.
    """
    if data["family"] not in (*FAMILIES, "poses"):
        raise ValueError("family")
    yield from _unlike("duration_s", data["duration_s"], motion.duration, CLOCK)
    if data["family"] == "poses":
        yield from _of_poses(data, motion, case)
    else:
        yield from _of_excitation(data, motion, case)


def _of_excitation(data: dict[str, Any], motion: Trajectory, case: Case) -> Iterator[Mismatch]:
    case = _recorded_as_planned(case, data)
    model = identification_model(case, _whole(data, "model"))
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, motion)
    mu = singular_values(information, model.names)
    logdet = CRITERIA["D"].of(mu)
    yield from _unlike("logdet", data["logdet"], logdet, ALIKE * len(mu))
    yield from _unlike("condition", data["condition"], -CRITERIA["K"].of(mu))
    efficiency = float(np.exp((logdet - float(data["bound"]["logdet"])) / len(mu)))
    yield from _unlike("d_efficiency", data["d_efficiency"], efficiency)
    payload = _whole(data, "payload")
    noise = expected_noise(case, model, payload)
    chosen = _chosen(case, model, noise, scaling, motion, information)
    yield from _of_criterion(data, singular_values(chosen, model.names))
    yield from _unlike("assumed_noise_N", data["assumed_noise_N"], noise.sensors)
    first = _whole(data, "payload_from") if "payload_from" in data else payload
    worst = worst_std(case, model, scaling, motion, range(first, payload + 1))
    yield from _unlike_deviations(data, {name: std for name, (std, _) in worst.items()})


def _chosen(case: Case, model: Model, noise: ExpectedNoise, scaling: Array, motion: Trajectory, plain: Array) -> Array:
    """The information that the search maximised: by the weights of the case, and what errors of the pose leave."""
    errors = PoseErrors.of(case, noise)
    if noise.whitening is None and errors is None:
        return plain
    return information_of(seen_through(model, noise.whitening), scaling, motion, errors)


def _of_criterion(data: dict[str, Any], mu: Array) -> Iterator[Mismatch]:
    letter = str(data["criterion"])
    if letter not in CRITERIA:
        raise ValueError("criterion")
    score = CRITERIA[letter].of(mu)
    within = ALIKE * (len(mu) if letter == "D" else abs(score))
    yield from _unlike("criterion_value", data["criterion_value"], score, within)


def _of_poses(data: dict[str, Any], motion: Trajectory, case: Case) -> Iterator[Mismatch]:
    parts = motion.parts if isinstance(motion, Joined) else ()
    poses = np.array([part.pose for part in parts if isinstance(part, Measurement)])
    yield from _unlike("count", data["count"], float(len(poses)), 0.0)
    if len(poses):
        model = standing_model(case, _whole(data, "model"))
        scaling = reference_scaling(case, model)
        regressors = pose_regressors(model, poses) * scaling
        singular_values(total_information(regressors), model.names)
        expected = predicted_std_at_poses(case, model, scaling, regressors, poses, float(data["assumed_noise_N"]))
        yield from _unlike_deviations(data, expected)


def _recorded_as_planned(case: Case, data: dict[str, Any]) -> Case:
    """The case with the rate of recording that the plan assumed."""
    recording = case.recording.model_copy(update={"rate_Hz": float(data.get("assumed_rate_Hz", 1000.0))})
    return case.model_copy(update={"recording": recording})


def _whole(data: dict[str, Any], key: str) -> int:
    if not isinstance(data[key], int) or isinstance(data[key], bool):
        raise ValueError(key)
    return int(data[key])


def _unlike_deviations(data: dict[str, Any], expected: dict[str, float]) -> Iterator[Mismatch]:
    said = data["predicted_std"]
    if list(said) != list(expected):
        raise ValueError("predicted_std")
    for name, std in expected.items():
        yield from _unlike(f"predicted_std.{name}", said[name], std)


def _unlike(key: str, said: object, found: float, within: float | None = None) -> Iterator[Mismatch]:
    within = ALIKE * abs(found) if within is None else within
    if isinstance(said, bool) or not isinstance(said, int | float) or not abs(said - found) <= within:
        yield Mismatch(key, said, found)


def problem_of(data: dict[str, Any], motion: Trajectory, case: Case) -> str | None:
    """What is wrong with the figures of a plan, in words; None where they are those of its motion."""
    try:
        first = next(mismatches(data, motion, case), None)
    except HexciteError as error:
        return f"its motion does not have its figures ({error})"
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
        return f"entry {error} is missing or damaged"
    if first is None:
        return None
    said = f"{first.said:.6g}" if isinstance(first.said, int | float) else repr(first.said)
    return f"{first.key} is {said}, but {first.found:.6g} by its motion: changed by hand or by another version"
