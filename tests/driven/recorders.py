"""Recorders of a robot: a bag of ROS 2, a table of a host, a file of Universal Robots' RTDE client.

Stamps come late, samples are lost, encoders step and are noisy, as in logs of real robots.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from tests.driven.plant import Course

Array = NDArray[np.float64]
EPOCH = 1_700_000_000  # [s]
OFFSETS = np.array([3.1, -2.2, 5.4, 0.11, 0.23, -0.08])  # of the sensor [N, N m]
NOISE = np.array([0.25, 0.25, 0.35, 0.008, 0.008, 0.006])  # of a reading [N, N m]
DELAY = 2.4e-3  # of the sensor's readings behind the encoders' [s]
ENCODERS = (16e-6, 22e-6)  # noise of the joints [rad], each its own between these
TYPES = get_typestore(Stores.ROS2_HUMBLE)


def sampled(course: Course, rate: float, seed: int, first: float = 0.0) -> tuple[Array, Array, Array]:
    """Instants (n,) [s] of a recorder's cycle, positions of the joints and readings of the sensor at them."""
    draw = np.random.default_rng(seed)
    t = np.arange(first, course.t[-1] - 2 * DELAY, 1.0 / rate)
    q = np.stack([np.interp(t, course.t, column) for column in course.q.T], axis=1)
    wrench = np.stack([np.interp(t - DELAY, course.t, column) for column in course.wrench.T], axis=1)
    q += draw.normal(size=q.shape) * draw.uniform(*ENCODERS, q.shape[1])
    return t, q, wrench + OFFSETS + draw.normal(size=wrench.shape) * NOISE


def table(file: Path, course: Course, seed: int) -> Path:
    """CSV of a host: 500 rows a second, stamps late by tenths of milliseconds, of four decimals, some rows lost."""
    draw = np.random.default_rng([seed, 1])
    t, q, wrench = sampled(course, 500.0, seed)
    kept = draw.random(len(t)) > 0.004
    stamps = EPOCH + np.round(t + draw.exponential(2e-4, len(t)), 5)
    names = [
        "time",
        *(f"q{k}_rad" for k in range(1, q.shape[1] + 1)),
        "fx_N",
        "fy_N",
        "fz_N",
        "mx_Nm",
        "my_Nm",
        "mz_Nm",
    ]
    rows = np.hstack([q, wrench])[kept]
    lines = [f"{s:.5f}," + ",".join(f"{v:.7g}" for v in row) for s, row in zip(stamps[kept], rows, strict=True)]
    file.write_text("\n".join([",".join(names), *lines]) + "\n")
    return file


def rtde(file: Path, course: Course, seed: int, switched: Sequence[float], bit: int) -> Path:
    """A file of the RTDE client: 500 rows a second by the controller's clock, output bits, some rows lost."""
    draw = np.random.default_rng([seed, 2])
    t, q, wrench = sampled(course, 500.0, seed)
    kept = draw.random(len(t)) > 0.004
    on = np.searchsorted(switched, t, side="right") % 2
    bits = (on << bit) + 1  # another output is on all the time
    names = ["timestamp", *(f"actual_q_{k}" for k in range(6)), *(f"ft_raw_wrench_{k}" for k in range(6))]
    rows = zip((86_400.0 + t)[kept], np.hstack([q, wrench])[kept], bits[kept], strict=True)
    lines = [f"{s:.4f} {' '.join(repr(float(f'{v:.9g}')) for v in row)} {b}" for s, row, b in rows]
    file.write_text("\n".join([" ".join([*names, "actual_digital_output_bits"]), *lines]) + "\n")
    return file


def bag(folder: Path, course: Course, seed: int, names: Sequence[str]) -> Path:
    """A bag: joints at 250 a second, the raw wrench at 1000, each with late stamps and lost messages."""
    draw = np.random.default_rng([seed, 3])
    messages: list[tuple[str, int, Any]] = []
    t, q, _ = sampled(course, 250.0, seed)
    for now, row in zip(t, q, strict=True):
        if draw.random() > 0.005:
            messages.append(("/joint_states", _stamp(now + draw.exponential(2e-4)), _state(names, row)))
    t, _, wrench = sampled(course, 1000.0, seed + 1_000_000, 0.0003)
    for now, row in zip(t, wrench, strict=True):
        if draw.random() > 0.002:
            messages.append(("/ft/wrench_raw", _stamp(now + draw.exponential(5e-5)), _wrench(row)))
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics: dict[str, Any] = {}
        for topic, stamp, (kind, fields) in sorted(messages, key=lambda message: message[1]):
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            message = TYPES.types[kind](header=_header(stamp, kind), **fields)
            writer.write(topics[topic], stamp + 150_000, TYPES.serialize_cdr(message, kind))
    return folder


def _stamp(now: float) -> int:
    return EPOCH * 10**9 + round(1e9 * now)


def _header(stamp: int, kind: str) -> Any:
    time = TYPES.types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    frame = "ft" if kind.endswith("WrenchStamped") else ""
    return TYPES.types["std_msgs/msg/Header"](stamp=time, frame_id=frame)


def _state(names: Sequence[str], row: Array) -> tuple[str, dict[str, Any]]:
    empty = np.zeros(0)
    return "sensor_msgs/msg/JointState", {"name": list(names), "position": row, "velocity": empty, "effort": empty}


def _wrench(row: Array) -> tuple[str, dict[str, Any]]:
    vector = TYPES.types["geometry_msgs/msg/Vector3"]
    force, torque = (vector(x=float(x), y=float(y), z=float(z)) for x, y, z in (row[:3], row[3:]))
    return "geometry_msgs/msg/WrenchStamped", {
        "wrench": TYPES.types["geometry_msgs/msg/Wrench"](force=force, torque=torque)
    }
