"""A hexapod in few numbers, and the case that they make: what the machines of the portfolio are described by."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cases.schema import Case
from cases.tables import CASE_FILE
from tests.helpers import pose_shares

Range = tuple[float, float]
Six = tuple[float, float, float, float, float, float]

BASE_CENTRES, FRAME_CENTRES = [90.0, 210.0, 330.0], [0.0, 120.0, 240.0]


@dataclass(frozen=True, kw_only=True)
class Hexapod:
    """A hexapod with sensors; lengths in mm and angles in degrees unless a field says otherwise.

    Args:
        title: what kind of machine it is.
        base: radius of the ring of base joints, and half of the angle between the joints of a pair.
        platform: the same of the platform.
        home: x, y, z, a, b, c.
        struts: shortest and longest strut.
        box: lower and upper end of each coordinate relative to home; one number where they differ in sign alone.
        rates: of translations [mm/s] and rotations [deg/s].
        accelerations: [m/s^2] and [rad/s^2].
        jerks: [m/s^3] and [rad/s^3].
        drives: velocity [m/s] and acceleration [m/s^2] of the struts.
        joints: largest angles of the joints of base and platform.
        frame: radii of the lower and of the upper points of the bars, and height between them; None for a six-axis
            force/torque sensor.
        range_N: of a sensor.
        mass: of what the sensors carry [kg].
        height: of its centre of gravity above the origin of {P}.
        gyration: its radius of gyration.
        payloads: masses of weights, mounted one upon the other [kg].
        cycle_ms: of the controller.
        cutoff: of the filter of the evaluation [Hz].
        hangs: whether the base is at the ceiling.
        keep_out: boxes in {B}: name -> x, y and z, from where to where.
        tools: bodies on the platform: name -> far end in {P}, and radius.
    """

    title: str
    base: Range
    platform: Range
    home: Six
    struts: Range
    box: tuple[float | Range, ...]
    rates: Range
    accelerations: Range
    jerks: Range
    drives: Range
    joints: Range = (60.0, 80.0)
    frame: tuple[float, float, float] | None
    range_N: float
    mass: float
    height: float
    gyration: float
    payloads: tuple[float, ...] = ()
    cycle_ms: float = 1.0
    cutoff: float = 40.0
    hangs: bool = False
    keep_out: tuple[tuple[str, tuple[Range, ...]], ...] = ()
    tools: tuple[tuple[str, tuple[float, float, float], float], ...] = ()

    @property
    def strut_radius(self) -> float:
        """Of the struts where they pass boxes."""
        return self.base[0] / 40.0

    @property
    def ranges(self) -> list[list[float]]:
        """Lower and upper end of each coordinate of the box."""
        return [[-b, b] if isinstance(b, float) else list(b) for b in self.box]


def case_of(name: str, hexapod: Hexapod) -> Case:
    """The validated case of a hexapod, as its file says it."""
    return Case.model_validate(tomllib.loads(case_text(name, hexapod)))


def case_tables(name: str, hexapod: Hexapod) -> dict[str, Any]:
    """The tables of a hexapod's case file."""
    h = hexapod
    lengths, angles = ("x_mm", "y_mm", "z_mm"), ("a_deg", "b_deg", "c_deg")
    box = dict(zip((*lengths, *angles), h.ranges, strict=True))
    most = [2.0 * max(map(abs, ends)) for ends in h.ranges[:2]]  # of x and y, twice what excitations may use
    workspace: dict[str, Any] = {
        "x_mm": [-most[0], most[0]],
        "y_mm": [-most[1], most[1]],
        "strut_length_mm": list(h.struts),
        "base_joint_angle_deg": h.joints[0],
        "platform_joint_angle_deg": h.joints[1],
    }
    if h.keep_out:
        keep_out = [{"name": what} | dict(zip(lengths, map(list, ends), strict=True)) for what, ends in h.keep_out]
        tools = [{"name": what, "to_mm": list(end), "radius_mm": radius} for what, end, radius in h.tools]
        workspace |= {"keep_out": keep_out, "strut_radius_mm": h.strut_radius} | ({"tool": tools} if tools else {})
    motion = box | {
        "velocity_mm_s": [h.rates[0]] * 3,
        "angular_velocity_deg_s": [h.rates[1]] * 3,
        "acceleration_m_s2": [h.accelerations[0]] * 3,
        "angular_acceleration_rad_s2": [h.accelerations[1]] * 3,
        "jerk_m_s3": [h.jerks[0]] * 3,
        "angular_jerk_rad_s3": [h.jerks[1]] * 3,
        "strut_length_mm": list(h.struts),
        "strut_velocity_m_s": h.drives[0],
        "strut_acceleration_m_s2": h.drives[1],
    }
    case = {
        "schema_version": 1,
        "name": name,
        "title": h.title,
        "setup": "R" if h.frame is None else "1b",
        "gravity_m_s2": [0.0, 0.0, 9.81 if h.hangs else -9.81],
        "machine": {
            "base": _ring(*h.base, BASE_CENTRES, 0.0),
            "platform": _ring(*h.platform, BASE_CENTRES, 0.0),
            "home": dict(zip((*lengths, *angles), h.home, strict=True)),
        },
        "workspace": workspace,
        "limits": {"motion": motion},
        "sensor_frame": _frame(h),
        "sensors": {"range_N": h.range_N, "weights": "per_unit" if h.frame is None else "equal"},
        "recording": {"filter_cutoff_Hz": h.cutoff},
        "controller": {
            "block_ms": 10.0,
            "safe_feed_mm_min": 0.1 * h.rates[0] * 60.0,
            "settle_s": 0.3,
            "cycle_ms": h.cycle_ms,
            "linuxcnc": {"acceleration_headroom": 25.0},
        },
        "nominal": _body(h.mass, (0.0, 0.0, h.height), h.gyration, (1.0, 0.0, 0.0, 1.0, 0.0, 0.8)),
        "simulation": _simulation(h),
    }
    if h.payloads:
        heights = [h.height + h.gyration * (0.5 + k) for k in range(len(h.payloads))]
        flat = (0.25, 0.0, 0.0, 0.25, 0.0, 0.45)
        case["payloads"] = {
            "source": "assumed: discs, each upon the one before",
            "weights": [
                _body(mass, (0.0, 0.1 * h.gyration, z), h.gyration, flat)
                for mass, z in zip(h.payloads, heights, strict=True)
            ],
        }
    return case


def _ring(radius: float, half_angle: float, centres: list[float], z: float) -> dict[str, Any]:
    return {"ring": {"radius_mm": radius, "half_angle_deg": half_angle, "pair_centres_deg": centres, "z_mm": z}}


def _frame(h: Hexapod) -> dict[str, Any]:
    if h.frame is None:
        return {"transducer": {"sense": "load_on_sensor"}}
    lower, upper, height = h.frame
    return {
        "bars": {
            "lower": _ring(lower, 20.0, FRAME_CENTRES, 0.0),
            "upper": _ring(upper, 52.0, FRAME_CENTRES, height),
        }
    }


def _body(mass: float, centre: tuple[float, float, float], gyration: float, shape: tuple[float, ...]) -> dict[str, Any]:
    inertia = [mass * (gyration * 1e-3) ** 2 * share for share in shape]
    return {"mass_kg": mass, "centre_of_gravity_mm": list(centre), "inertia_kg_m2": inertia}


def _simulation(h: Hexapod) -> dict[str, Any]:
    """A machine a little off its nominal values, whose errors and noise have the scale of its sensors."""
    centre = (0.01 * h.gyration, -0.02 * h.gyration, 0.95 * h.height)
    offsets = [h.range_N * share for share in (-0.01, 0.008, 0.06, -0.03, -0.003, -0.004)]
    reach = 1e-3 * max(max(map(abs, ends)) for ends in h.ranges[:3])  # [m]
    return {
        "source": "assumed",
        "parameters": {
            "offsets_N": offsets,
            "compensation": {
                "k0_N_m": 0.001 * h.range_N / reach,
                "k1_Nm_m": -0.001 * h.range_N * h.gyration * 1e-3 / reach,
                "k2_N": 0.007 * h.range_N,
                "k3_Nm": 0.007 * h.range_N * h.gyration * 1e-3,
            },
            "body": _body(0.96 * h.mass, centre, h.gyration, (0.9, 0.02, -0.01, 0.86, 0.015, 0.7)),
        },
        "encoder_resolution_um": 0.1,
        "encoder_rate_Hz": 1000.0,
        "force_noise_N": 2e-4 * h.range_N,
        "force_delay_ms": 2.0,
        "force_sampling_offset_cycles": 0.5,
    }


def case_text(name: str, hexapod: Hexapod) -> str:
    """The case file of a hexapod."""
    tables = case_tables(name, hexapod)
    lines = [f"{key} = {_toml(value)}" for key, value in tables.items() if not isinstance(value, Mapping)]
    for table, content in tables.items():
        if isinstance(content, Mapping):
            lines += ["", f"[{table}]", *(f"{key} = {_toml(value)}" for key, value in content.items())]
    return "\n".join(lines) + "\n"


def write_machine(folder: Path, name: str, hexapod: Hexapod) -> Path:
    """Writes `folder/name/case.toml` and returns `folder/name`, which commands take as a case."""
    (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / name / CASE_FILE).write_text(case_text(name, hexapod), encoding="utf-8")
    return folder / name


def _toml(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(float(f"{value:.6g}")) if isinstance(value, float) else str(value)


class Reachable(NamedTuple):
    """Shares of the poses of a motion box.

    Args:
        struts: within the strut lengths.
        all_limits: within every limit of poses.
    """

    struts: float
    all_limits: float


def reachable(case: Case, poses: int = 4000, seed: int = 0) -> Reachable:
    """How much of the motion box is within reach.

    Args:
        case: with machine and limits.
        poses: how many are drawn uniformly from the box.
        seed: of these.
    """
    machine, _, limits = case.need_machine("the share of the box within reach")
    low, high = limits.coordinates
    places = machine.home.vector + np.random.default_rng(seed).uniform(low, high, (poses, 6))
    shares = {kind: share.max(axis=1) for kind, share in pose_shares(case, places).items()}
    within = (shares["strut length"], np.max(list(shares.values()), axis=0))
    return Reachable(*(float(np.mean(share <= 1.0)) for share in within))
