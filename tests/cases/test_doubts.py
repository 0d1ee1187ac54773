"""Values that contradict each other: a mistaken unit is named beside what it contradicts, sound machines never are."""

import logging
import re
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from cases.schema import Case, load_case
from cases.tables import built_in_cases
from tests.cases.editing import edited
from tests.helpers import seeds

Data = dict[str, Any]


def with_change(name: str, change: Callable[[Data], object]) -> Case:
    data = deepcopy(load_case(name).model_dump())
    change(data)
    return Case.model_validate(data)


def box(**values: object) -> Callable[[Data], object]:
    return lambda data: data["limits"]["motion"].update(values)


def each_joint(key: str, factor: float) -> Callable[[Data], object]:
    def change(data: Data) -> None:
        for joint in data["limits"]["motion"]["joints"]:
            joint[key] *= factor

    return change


def nominal(**values: object) -> Callable[[Data], object]:
    return lambda data: data["nominal"].update(values)


def ends(data: Data) -> None:
    for joint in data["machine"]["chain"]["joints"]:
        joint["position_deg"] = (-9740.0, 9740.0)


def metres(data: Data) -> None:
    for end in ("lower", "upper"):
        for key in ("radius_mm", "z_mm"):
            data["sensor_frame"]["bars"][end]["ring"][key] /= 1000.0


# machine, mistake, the value that is accused, what it is beside, and the cure
MISTAKES: dict[str, tuple[str, Callable[[Data], object], str]] = {
    "mm/s^2": (
        "hexapod",
        box(acceleration_m_s2=(6e3,) * 3),
        r"acceleration_m_s2 = \[6000.* beside .*velocity_mm_s = .*\[6, 6, 6\]",
    ),
    "mm/s^3": ("hexapod", box(jerk_m_s3=(1e5,) * 3), r"jerk_m_s3 = \[1e\+05.* beside .*; .*\[100, 100, 100\]"),
    "deg/s^2": (
        "hexapod",
        box(angular_acceleration_rad_s2=(573.0,) * 3),
        r"rad_s2 = \[573.* beside .*deg_s = .*\[10, 10, 10\]",
    ),
    "rad/s^2 in deg": (
        "hexapod",
        box(angular_acceleration_rad_s2=None, angular_acceleration_deg_s2=(10.0,) * 3),
        r"acceleration_deg_s2 = \[10,.* beside .*rad/s\^2: .*\[573, 573, 573\]",
    ),
    "m/s": ("hexapod", box(strut_velocity_m_s=1000.0), r"strut_velocity_m_s = 1000 beside .*mm/s: write .* = 1$"),
    "rad": ("hexapod", box(**{f"{c}_deg": (-0.35, 0.35) for c in "abc"}), r"a_deg, b_deg, c_deg .* beside .*radians"),
    "rad twice": (
        "hexapod",
        box(**{f"{c}_deg": (-0.35, 0.35) for c in "abc"}, angular_velocity_deg_s=(1.0472,) * 3),
        r"a_deg, b_deg, c_deg .*angular_velocity_deg_s = \[1.047.* beside .*radians .*\[60, 60, 60\]",
    ),
    "one axis": ("hexapod", box(acceleration_m_s2=(6.0, 6.0, 6000.0)), r"\[6, 6, 6000\].*\[6, 6, 6\]"),
    "all joints in deg": (
        "ur10_wrist",
        each_joint("acceleration_rad_s2", 57.3),
        r"\[1, 2, 3, 4, 5, 6\].acceleration_rad_s2 = 286",
    ),
    "all joints in rad/s": ("ur10_wrist", each_joint("velocity_deg_s", 1 / 57.3), r"velocity_deg_s = 2.09.* rad/s: "),
    "ends in degrees": ("ur10_wrist", ends, r"\[1, 2, 3, 4, 5, 6\].position_deg = .*27.1 turns.*\[-170, 170\]"),
    "centre in m": ("hexapod", nominal(centre_of_gravity_mm=(0.0, 0.0, 0.128)), r"0.128 mm .*270 mm.*\[0, 0, 128\]"),
    "centre in um": (
        "hexapod",
        nominal(centre_of_gravity_mm=(7e3, 0.0, 2.03e5)),
        r"gravity_mm = \[7000, 0, 2.03e\+05\]: .*250 mm",
    ),
    "inertia in kg mm^2": (
        "hexapod",
        nominal(inertia_kg_m2=(1.65e6, 0.0, 0.0, 1.65e6, 0.0, 1.51e6)),
        r"inertia_kg_m2 = .*kg mm\^2",
    ),
    "no matter": (
        "hexapod",
        nominal(inertia_kg_m2=(2e-3, 0.0, 0.0, 2e-3, 0.0, 2e-3)),
        r"inertia_kg_m2 = .* beside nominal.mass_kg = 33: no matter",
    ),
    "range in kN": (
        "hexapod",
        lambda d: d["sensors"].update(range_N=5.0),
        r"range_N = 5 beside nominal.mass_kg = 33.*N; .*kN: .*5000",
    ),
    "noise in mN": (
        "ur10_wrist",
        lambda d: d["sensors"].update(force_noise_N=500.0),
        r"force_noise_N = 500 beside sensors.range_N",
    ),
    "frame in m": (
        "hexapod",
        metres,
        r"lower.ring.radius_mm = 0.146; .*upper.* = 0.171: .*metres: write radius_mm = 146",
    ),
    "time in ms": (
        "hexapod",
        lambda d: d["controller"].update(settle_s=300.0),
        r"controller.settle_s = 300: .*ms: .*0.3",
    ),
    "block in s": (
        "hexapod",
        lambda d: d["controller"].update(block_ms=0.01),
        r"block_ms = 0.01 beside controller.cycle_ms = 1",
    ),
    "filter above half the rate": (
        "hexapod",
        lambda d: d["recording"].update(rate_Hz=50.0),
        r"filter_cutoff_Hz = 40 beside recording.rate_Hz = 50",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_value_that_cannot_be_is_named_beside_what_it_contradicts(mistake: str) -> None:
    name, change, says = MISTAKES[mistake]
    (doubt,) = with_change(name, change).doubts
    assert re.search(says, doubt), doubt


def test_two_mistakes_are_both_named() -> None:
    case = with_change("hexapod", box(acceleration_m_s2=(6e3,) * 3, angular_velocity_deg_s=(1.0472,) * 3))
    text = " ".join(case.doubts)
    assert re.search(r"write [^:]*acceleration_m_s2 = \[6, 6, 6\]", text)
    assert re.search(r"write [^:]*angular_velocity_deg_s = \[60, 60, 60\]", text)


def test_a_positioning_stage_is_not_told_that_its_angles_are_radians() -> None:
    """A hexapod of a telescope: millimetres, a third of a degree, a tenth of a degree a second."""
    slow = box(
        **{f"{c}_mm": (-11.4, 11.4) for c in "xyz"},
        **{f"{c}_deg": (-0.36, 0.36) for c in "abc"},
        velocity_mm_s=(2.0,) * 3,
        angular_velocity_deg_s=(0.1146,) * 3,
        acceleration_m_s2=(5e-4,) * 3,
        angular_acceleration_rad_s2=(5e-4,) * 3,
        jerk_m_s3=(0.01,) * 3,
        angular_jerk_rad_s3=(0.01,) * 3,
        strut_velocity_m_s=5e-4,
        strut_acceleration_m_s2=5e-4,
    )

    def change(data: Data) -> None:
        slow(data)
        data["controller"]["safe_feed_mm_min"] = 20.0

    assert with_change("hexapod", change).doubts == ()


def test_links_whose_mass_is_counted_from_the_base_are_named_and_others_are_not() -> None:
    """As files of makers have it: each centre of gravity at the height where it is with all joints at 0."""

    def links(*centres: float) -> Any:
        def change(data: Data) -> None:
            for joint, z in zip(data["machine"]["chain"]["joints"], centres, strict=True):
                joint["link"] = {
                    "mass_kg": 2.0, "centre_of_gravity_mm": [0.0, 40.0, z], "inertia_kg_m2": [0.02, 0, 0, 0.02, 0, 0.02]
                }  # fmt: skip

        return change

    (doubt,) = with_change("ur10_wrist", links(20.0, 60.0, 80.0, 1100.0, 1200.0, 1400.0)).doubts
    assert re.search(r"of wrist_1, wrist_2, wrist_3: that of wrist_3 lies 1401 mm", doubt.replace("_joint", ""))
    assert doubt.keys == tuple(f"machine.chain.joints[{k}].link.centre_of_gravity_mm" for k in (4, 5, 6))
    assert with_change("ur10_wrist", links(20.0, 300.0, -250.0, 60.0, 60.0, 30.0)).doubts == ()


SCATTER = 2.0  # factor by which each limit of a sound machine may differ from that of a built-in one


def other_machine(name: str, seed: int) -> Data:
    """A sound machine: a built-in one with other velocities, accelerations and jerks."""
    draw = np.random.default_rng(seed)
    data = deepcopy(load_case(name).model_dump())
    motion = data["limits"]["motion"]
    for table in motion.get("joints", [motion]):
        for key in (
            k for k, v in table.items() if v is not None and re.search("velocity|acceleration|jerk|^[abc]_", k)
        ):
            factor = float(SCATTER ** draw.uniform(-1.0, 1.0))
            table[key] = tuple(factor * v for v in table[key]) if isinstance(table[key], tuple) else factor * table[key]
    if data["controller"]["safe_feed_mm_min"] is not None:
        data["controller"]["safe_feed_mm_min"] = 1.0
    return data


MACHINES = ("hexapod", "strut_sensors", "ur10_wrist", "five_axis_table")


@seeds(100, at_once=15)
def test_sound_machines_are_not_accused(seed: int) -> None:
    for name in MACHINES:
        assert Case.model_validate(other_machine(name, seed)).doubts == ()
    assert all(load_case(name).doubts == () for name in built_in_cases())


UNITS = {"mm_s": 1e-3, "m_s2": 1e3, "m_s3": 1e3, "deg_s": np.pi / 180.0, "rad_s2": 180.0 / np.pi, "m_s": 1e3}


@seeds(20, at_once=3)
def test_any_limit_in_a_mistaken_unit_is_the_one_that_is_accused(seed: int) -> None:
    """Angular jerks are left out, which nothing but angular accelerations tells: they are found in three of four."""
    for name in ("hexapod", "strut_sensors"):
        sound = other_machine(name, seed)
        for key in sound["limits"]["motion"]:
            unit = re.search("_(mm_s|m_s2|m_s3|deg_s|rad_s2|m_s)$", key)
            value = sound["limits"]["motion"][key]
            if unit is None or value is None:
                continue
            data = deepcopy(sound)
            factor = UNITS[unit[1]]
            wrong = tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value
            data["limits"]["motion"][key] = wrong
            data["controller"]["safe_feed_mm_min"] = 1e-3
            (doubt,) = Case.model_validate(data).doubts
            assert doubt.startswith(f"limits.motion.{key} = "), (name, key, doubt)


def test_loading_a_case_logs_what_is_odd(tmp_path: Any, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "hexcite"):
        load_case("hexapod")
        assert caplog.text == ""
        load_case(file := edited(tmp_path, "mass_kg = 33.0", "mass_kg = 33000.0"))
    assert re.search(rf"{file}: look at nominal.mass_kg = 3.3e\+04 beside", caplog.text)
