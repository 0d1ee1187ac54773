"""Moving runs of a force/torque sensor whose orientations and accelerations are recorded, made by a robot in NumPy."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from cases.schema import Case
from identification.recording.formats.table import Stream
from identification.recording.recording import Recording
from tests.damaged.runs import Machine, Waves, machine

Array = NDArray[np.float64]
RATE, DELAY = 250.0, 0.004  # of all streams [1/s], of the forces [s]


def wrist_machine() -> Machine:
    """The robot that carries the sensor."""
    return machine("ur10_wrist")


def case_of_wrist(cutoff: float = 10.0) -> Case:
    """The case of a sensor that does not know what carries it; its noise is stated."""
    of = wrist_machine()
    tables: dict[str, Any] = {
        "schema_version": 1, "name": "wrist", "title": "A sensor on a wrist", "setup": "R",
        "gravity_m_s2": of.tables["gravity_m_s2"],
        "sensor_frame": of.tables["sensor_frame"], "recording": {"filter_cutoff_Hz": cutoff},
        "sensors": {"weights": "per_unit", "force_noise_N": 0.3, "moment_noise_Nm": 0.01},
    }  # fmt: skip
    return Case.model_validate(tables).found_at("wrist")


def wrist_recording(
    seed: int,
    duration: float = 8.0,
    felt: float = 0.02,
    turned: float = 1e-4,
    memory: float | None = None,
    arm: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Recording:
    """A run with noise.

    Args:
        seed: of motion and noise.
        duration: of the run [s].
        felt: noise of the accelerometer [m/s^2].
        turned: noise of the orientations [rad].
        memory: of the noise of the forces [s]; white by default.
        arm: from the sensor's origin to the accelerometer, in its axes [m].
    """
    of, draw = wrist_machine(), np.random.default_rng([seed, 29])
    t = np.arange(round(duration * RATE)) / RATE
    way = Waves(of, seed, duration)
    now, late = of.plant.motion(way, t), of.plant.motion(way, t - DELAY)
    noise = draw.normal(size=(len(t), 6))
    if memory is not None:
        keep = np.exp(-1.0 / (RATE * memory))
        slow = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], draw.normal(size=(len(t) * 2, 6)), axis=0)[len(t) :]
        noise = 0.7 * noise + 0.6 * slow
    forces = of.plant.forces(late) + noise * np.repeat([0.3, 0.01], 3)
    place = now.turn @ np.array(arm)
    swing = np.cross(now.alpha, place) + np.cross(now.omega, np.cross(now.omega, place))
    gravity = np.array(of.tables["gravity_m_s2"])
    specific = np.einsum("nji,nj->ni", now.turn, now.acceleration + swing - gravity)
    specific = specific + felt * draw.normal(size=specific.shape)
    shaken = Rotation.from_matrix(now.turn) * Rotation.from_rotvec(turned * draw.normal(size=(len(t), 3)))
    turning = Stream("turns.csv", t, None, shaken.as_matrix(), None, None)
    accelerometer = replace(turning, source="felt.csv", rotations=None, specific_forces=specific)
    return Recording(
        "run.csv", t, None, None, forces, None, others=(turning, accelerometer), case=case_of_wrist()
    )  # fmt: skip
