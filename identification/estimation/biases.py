"""Offsets that another measurement gave: taken as known, their uncertainty carried into what is estimated.

Errors of what is not estimated reach the estimate through its own normal equations (Schmidt 1966, Adv. Control Syst.
3:293, the "consider" covariance): with u = u0(b) + B v, v = (A^T W A)^-1 A^T W (f - C b), an error db moves v by
-(A^T W A)^-1 A^T W C db.

Afterwards a channel that reads too much all along has drifted, or something presses on it all along.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import BaseModel, Field, NonNegativeFloat

from cases.errors import IdentificationError
from cases.schema import Case
from cases.units import Array
from identification.estimation.fit import Fit
from identification.finding import Finding, Kind, note, warning
from identification.model import Model
from identification.parameters import MASS, OFFSETS, offset_columns

OFFSET_NAMES = tuple(p.name for p in OFFSETS.parameters)
FEWEST_POSES = 3  # with fewer, biases and small turns of an accelerometer cannot be separated
DRIFTED = 3.0  # standard deviations between offsets of a run and those that it was given


Numbers = Annotated[list[float], Field(min_length=3, max_length=3)]


class AccelerometerBias(BaseModel, strict=True, frozen=True, allow_inf_nan=False):
    """What an accelerometer reads beside the specific force, in the axes of {P}: its entry in `result.json`."""

    bias_m_s2: Numbers
    std_m_s2: Numbers
    covariance_m2_s4: Annotated[list[Numbers], Field(min_length=3, max_length=3)]
    turn_rad: Numbers  # small rotation of the readings against the orientations, estimated beside
    rms_m_s2: NonNegativeFloat  # rms residual of the readings


def accelerometer_bias(specific_forces: Array, rotations: Array, gravity: Array) -> AccelerometerBias | None:
    """Biases of an accelerometer from standstills, least squares; None where poses are too few or too alike.

    Args:
        specific_forces: readings in the axes of {P}, shape (n, 3) [m/s^2].
        rotations: R of each standstill, shape (n, 3, 3).
        gravity: gravity in {B}, shape (3,) [m/s^2].
    """
    at_rest = -np.einsum("nji,j->ni", rotations, gravity)
    matrix = np.zeros((len(at_rest), 3, 6))
    matrix[:, :, :3] = np.eye(3)
    matrix[:, :, 3:] = np.cross(np.eye(3)[None], at_rest[:, None, :]).transpose(0, 2, 1)
    flat, right = matrix.reshape(-1, 6), (specific_forces - at_rest).ravel()
    if len(at_rest) < FEWEST_POSES or np.linalg.cond(flat / np.linalg.norm(flat, axis=0)) > 1e3:
        return None
    solution = np.linalg.lstsq(flat, right, rcond=None)[0]
    residuals = right - flat @ solution
    covariance = np.linalg.inv(flat.T @ flat) * float(residuals @ residuals) / (len(right) - 6)
    return AccelerometerBias(
        bias_m_s2=solution[:3].tolist(),
        std_m_s2=np.sqrt(np.diag(covariance)[:3]).tolist(),
        covariance_m2_s4=covariance[:3, :3].tolist(),
        turn_rad=solution[3:].tolist(),
        rms_m_s2=float(np.sqrt(np.mean(residuals**2))),
    )


@dataclass(frozen=True, slots=True)
class Biases:
    """Offsets from another result."""

    source: str  # file of that result
    values: Array  # f_q0, shape (6,) [N, or N and N m]
    covariance: Array  # covariance of them, the larger of white and robust, shape (6, 6)
    accelerometer: AccelerometerBias | None  # where that result has it
    stale: tuple[str, ...] = ()  # what has changed in the case since that result, where the user went on

    @property
    def known(self) -> dict[str, float]:
        """The offsets as known values by name."""
        return dict(zip(OFFSET_NAMES, map(float, self.values), strict=True))

    def require_accelerometer(self) -> AccelerometerBias:
        """The accelerometer's biases, without which fixed offsets would put them on the mass.

        Raises:
            IdentificationError: that result has none.
        """
        if self.accelerometer is None:
            raise IdentificationError(
                f"--biases {self.source}",
                "has no biases of the accelerometer, and with fixed offsets they would fall "
                "on the mass; identify standstills in different orientations that have its readings too",
            )
        return self.accelerometer


def drift_findings(biases: Biases, model: Model, free: Fit) -> list[Finding]:
    """A warning where offsets have drifted since they were taken, by a fit that was free to choose its own."""
    offsets = offset_columns(model)
    spread = max(free.covariance, free.covariance_robust, key=lambda c: float(np.trace(c[np.ix_(offsets, offsets)])))
    values = free.values[offsets]
    deviation = np.abs(values - biases.values)
    std = np.sqrt(np.diag(spread)[offsets] + np.diag(biases.covariance))
    worst = int(np.argmax(deviation / std))
    if not deviation[worst] > DRIFTED * std[worst]:
        return []
    unit, mass = model.parameters[offsets[worst]].unit, ""
    if MASS in model.blocks:
        place = model.names.index("m")
        value, deviation_of_mass = free.values[place], spread[place, place] ** 0.5
        mass = f": with offsets of its own the run gives {value:.4g} +- {deviation_of_mass:.2g} kg"
    sentence = (
        f"{OFFSET_NAMES[worst]} of this run is {values[worst]:.4g} {unit}, {deviation[worst]:.2g} {unit} or "
        f"{deviation[worst] / std[worst]:.0f} standard deviations from that of {biases.source}: offsets have drifted, "
        f"or the two runs err differently; the other parameters carry it{mass}"
    )
    return [warning(Kind.OFFSETS, sentence)]


STRETCHES = 10  # of a recording, in each of which a channel reads too much
WARM_UP = "let the sensor warm up, and run hexcite tare shortly before its readings count"


def shifted_all_along(residuals: Array, variance: Array, case: Case) -> list[Finding]:
    """A warning where a channel reads more, or less, than a result expects in every part of a recording.

    By residuals, measured less expected, in the order of time, shape (n, 6) [N, or N and N m], and the variance of the
    result's offsets, shape (6,).
    """
    if len(residuals) < STRETCHES:
        return []
    means = np.array([part.mean(axis=0) for part in np.array_split(residuals, STRETCHES)])
    std = np.sqrt(variance + means.var(axis=0, ddof=1))
    one_way = np.abs(np.sign(means).sum(axis=0)) == STRETCHES
    least = np.where(one_way, np.abs(means).min(axis=0), 0.0) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(least))
    if not least[worst] > DRIFTED:
        return []
    channel, unit = channel_words(case, worst)
    sentence = f"{channel} reads {means[:, worst].mean():+.2g} {unit} more than the result expects all along: its "
    return [warning(Kind.OFFSETS, f"{sentence}offset has drifted, or something presses all along; {WARM_UP}")]


def drifted_since(change: Array, std: Array, case: Case, source: str) -> list[Finding]:
    """A note where a tare finds other offsets than a result.

    By the change of the offsets, shape (6,) [N, or N and N m], and its standard deviation; `source` is the result.
    """
    sure = np.abs(change) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(sure))
    if not sure[worst] > DRIFTED:
        return []
    channel, unit = channel_words(case, worst)
    sentence = f"the offset of {channel} has drifted by {change[worst]:+.2g} {unit} ({sure[worst]:.0f} standard "
    sentence += f"deviations) since {source}: what was computed with that meanwhile is off by it"
    return [note(Kind.OFFSETS, sentence)]


def channel_words(case: Case, k: int) -> tuple[str, str]:
    """Name of a channel in the file, and its unit."""
    name, _, unit = case.sensor_frame.channels[k].rpartition("_")
    return case.recording.file_name(f"{name}_{unit}"), {"Nm": "N m"}.get(unit, unit)
