"""A machine that is off its case by sizes that the case tolerates: parts in words, and run and case without them."""

import itertools
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.errors import Remedy
from cases.base.phrases import NOTHING, OPEN, Phrase, phrase
from cases.base.units import MM, Array
from cases.machine import Joints, turned
from cases.schema import Case
from identification.findings.causes.channels import rpy_of, scaled
from identification.findings.causes.remedies import keys_to_write, remedy
from identification.findings.left_out import drives_named, gravity_axes
from identification.findings.tolerances import UNITS
from identification.recording.recording import Recording

SYMBOLS = {"mm": "mm", "deg": "deg", "percent": "%", "ppm": "ppm"}
SHOWABLE = frozenset(
    {"joints_mm", "bars_mm", "joint_zeros_deg", "joint_zeros_mm", "links_mm", "sensor_mm", "sensor_deg"}
    | {"gravity_deg", "gravity_percent", "gain_percent", "encoder_scale_ppm", "clock_ppm"}
)
"""Keys of tolerances without which a run can be evaluated anew; a gain that all channels have in common is not seen."""

Sizes = Mapping[str, Array]
"""By keys of tolerances how far a machine is off its case, shapes (k,) [SI]."""


class Size(NamedTuple):
    """One of the sizes that a tolerance is of."""

    key: str  # of the tolerance
    words: Phrase  # what is off, with an open place `size`, for the value with its deviation and unit
    remedy: Phrase = NOTHING  # what to do where no key of the case mends it

    @property
    def unit(self) -> float:
        """SI value of the unit in which people read it."""
        return UNITS[self.key.rpartition("_")[2]]

    @property
    def symbol(self) -> str:
        """That unit."""
        return SYMBOLS[self.key.rpartition("_")[2]]


def sizes_named(case: Case, key: str) -> list[Size]:
    """The sizes that a tolerance of a case is of, in the order of their effects."""
    channels = [case.recording.file_name(name) for name in case.sensor_frame.channels]
    places = list(itertools.product(range(1, 7), "xyz"))
    if key == "joints_mm":
        off = phrase("told_joint", "joint {k} of the {ring} is off by {size} along {axis}", **_OPEN, ring=OPEN)
        rings = (phrase("base", "base"), phrase("platform", "platform"))
        return [Size(key, off.filled(ring=ring, k=k, axis=axis)) for ring in rings for k, axis in places]
    if key == "bars_mm":
        off = phrase("told_bar", "the {end} end of bar {k} is off by {size} along {axis}", **_OPEN, end=OPEN)
        ends = (phrase("lower", "lower"), phrase("upper", "upper"))
        return [Size(key, off.filled(end=end, k=k, axis=axis)) for end in ends for k, axis in places]
    if key == "sensor_mm":
        off = phrase("told_sensor", "the sensor is off by {size} along its {axis}", size=OPEN, axis=OPEN)
        return [Size(key, off.filled(axis=axis)) for axis in "xyz"]
    if key == "sensor_deg":
        off = phrase(
            "told_turned", "the sensor is turned on its flange by {size} about its {axis}", size=OPEN, axis=OPEN
        )
        return [Size(key, off.filled(axis=axis)) for axis in "xyz"]
    if key == "gravity_percent":
        return [Size(key, phrase("told_gravity", "gravity is larger by {size}", size=OPEN))]
    if key == "gravity_deg":
        off = phrase("told_tilted", "gravity leans by {size} towards ({way}): the base is tilted", size=OPEN, way=OPEN)
        ways = [", ".join(f"{v + 0.0:.2g}" for v in axis) for axis in gravity_axes(case.gravity)[1:]]
        return [Size(key, off.filled(way=way)) for way in ways]
    if key == "gain_percent":
        off = phrase("told_gain", "{name} reads {size} too much", name=OPEN, size=OPEN)
        return [Size(key, off.filled(name=name)) for name in channels]
    if key == "clock_ppm":
        off = phrase("told_clock", "seconds of the recording are longer than true ones by {size}", size=OPEN)
        return [Size(key, off, phrase("true_rate", "state its true rate"))]
    drives = drives_named(case)
    if key == "encoder_scale_ppm":
        off = phrase("told_scale", "{name} moves {size} more than its encoder says", name=OPEN, size=OPEN)
        cure = phrase("mend_scale", "correct the scale in the drive")
        return [Size(key, off.filled(name=name), cure) for name in drives]
    if key == "links_mm":
        off = phrase(
            "told_link",
            "{name} is off by {size} along {axis} of {before}",
            name=OPEN,
            size=OPEN,
            axis=OPEN,
            before=OPEN,
        )
        pairs = itertools.pairwise(drives)
        return [Size(key, off.filled(name=n, axis=axis, before=before)) for before, n in pairs for axis in "xyz"]
    turns = [] if case.chain is None else [joint.turns for joint in case.chain.joints]
    off = phrase("told_zero", "{name} stands {size} farther than it reads", name=OPEN, size=OPEN)
    cure = phrase("mend_zero", "correct its zero in the controller")
    return [
        Size(key, off.filled(name=name), cure)
        for name, turn in zip(drives, turns, strict=False)
        if turn == key.endswith("deg")
    ]


_OPEN = dict.fromkeys(("k", "size", "axis"), OPEN)


def without(recording: Recording, case: Case, sizes: Sizes) -> tuple[Recording, Case]:
    """Run and case of a machine as it is, where it is off its case by sizes."""
    for key, size in sizes.items():
        recording = _recorded(recording, case, key, size)
    return recording, edited(case, sizes)


def _recorded(recording: Recording, case: Case, key: str, size: Array) -> Recording:
    """A recording without what a size does to it."""
    drives, t = recording.drives, recording.t
    if key == "gain_percent":
        return replace(recording, forces=recording.forces / (1.0 + size))
    if key == "clock_ppm" and t is not None:
        return replace(recording, t=t[0] + (t - t[0]) / (1.0 + size[0]))
    if drives is not None and key == "encoder_scale_ppm":
        middle = np.nanmean(drives, axis=0)
        return replace(recording, drives=middle + (drives - middle) * (1.0 + size))
    if drives is not None and key.startswith("joint_zeros") and case.chain is not None:
        turns = np.array([joint.turns for joint in case.chain.joints])
        zeros = np.zeros(len(turns))
        zeros[turns == key.endswith("deg")] = size
        return replace(recording, drives=drives + zeros)
    return recording


def edited(case: Case, sizes: Sizes) -> Case:
    """The case with what of sizes stands in keys of machine, sensor frame and gravity."""
    chain, machine, bars = case.chain, case.machine, case.sensor_frame.bars
    if chain is not None and machine is not None and {"sensor_mm", "sensor_deg"} & sizes.keys():
        turn = turned(chain.sensor.rpy) @ Rotation.from_rotvec(sizes.get("sensor_deg", np.zeros(3))).as_matrix()
        origin = chain.sensor.origin + turn @ sizes.get("sensor_mm", np.zeros(3))
        entries = {"rpy_deg": _row(np.degrees(rpy_of(turn))), "origin_mm": _row(origin / MM)}
        frame = chain.sensor.model_copy(update=entries)
        chain = chain.model_copy(update={"sensor": frame})
        case = case.model_copy(update={"machine": machine.model_copy(update={"chain": chain})})
    if chain is not None and machine is not None and "links_mm" in sizes:
        first, *others = chain.joints
        moved = (
            joint.model_copy(update={"origin_mm": _row((joint.origin + by) / MM)})
            for joint, by in zip(others, sizes["links_mm"].reshape(-1, 3), strict=True)
        )
        chain = chain.model_copy(update={"joints": (first, *moved)})
        case = case.model_copy(update={"machine": machine.model_copy(update={"chain": chain})})
    if "joints_mm" in sizes and case.hexapod is not None and machine is not None:
        rings = zip(("base", "platform"), sizes["joints_mm"].reshape(2, 6, 3), strict=True)
        joints = {ring: _moved(getattr(case.hexapod, ring), by) for ring, by in rings}
        case = case.model_copy(update={"machine": machine.model_copy(update=joints)})
    if "bars_mm" in sizes and bars is not None:
        ends = zip(("lower", "upper"), sizes["bars_mm"].reshape(2, 6, 3), strict=True)
        bars = bars.model_copy(update={end: _moved(getattr(bars, end), by) for end, by in ends})
        case = case.model_copy(update={"sensor_frame": case.sensor_frame.model_copy(update={"bars": bars})})
    if {"gravity_deg", "gravity_percent"} & sizes.keys():
        along = np.r_[sizes.get("gravity_percent", np.zeros(1)), sizes.get("gravity_deg", np.zeros(2))]
        gravity = case.gravity + np.linalg.norm(case.gravity) * along @ gravity_axes(case.gravity)
        case = case.model_copy(update={"gravity_m_s2": _row(gravity)})
    return case


def mended(case: Case, size: Size, sizes: Sizes) -> Case:
    """The case with what mends it in its keys where a machine is off by a size; sizes: those of its key."""
    if size.key == "gain_percent":
        names = case.sensor_frame.channels
        factors = {name: 1.0 / (1.0 + float(v)) for name, v in zip(names, sizes[size.key], strict=True) if v != 0.0}
        return scaled(factors)(case)
    return edited(case, sizes)


def remedy_of(case: Case, size: Size, sizes: Sizes) -> Phrase:
    """What to write, or to do, where a machine is off by a size; sizes: those of its key."""
    return keys_to_write(case, mended(case, size, sizes)) or size.remedy


def remedies_of(words: str, case: Case, size: Size, sizes: Sizes) -> tuple[Remedy, ...]:
    """The same keys for programs that write them; words: how the machine is off."""
    return remedy(words, case, mended(case, size, sizes))


def _moved(joints: Joints, by: Array) -> Joints:
    """Joints moved by, shape (6, 3) [m]."""
    return Joints(points_mm=tuple(_row(point) for point in (joints.points + by) / MM))


def _row(values: Array) -> tuple[float, ...]:
    return tuple(float(value) + 0.0 for value in values)
