"""Machines off their cases by tolerances that their runs tell: sizes, errors and deviations, with and without them.

python tests/bench/told.py panda 20      # sensor turned on its flange of a 7-joint arm, by 1 deg about each axis, 10 s
python tests/bench/told.py hexapod_5 8    # joints and bars drawn at 0.03 mm
python tests/bench/told.py ur10_wrist 8  # the base leans by 0.3 deg
"""

import sys
import time
import tomllib
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.base.units import DEG, MM
from cases.schema import Case
from identification.identify import estimate_parameters
from identification.recording.recording import Recording
from tests.damaged.runs import STATED, Machine, Moves, machine, recorded
from tests.machines_in_numpy import plant_of

ROBOTS = Path(__file__).parent / "robots"
WORDS = {"gain": "errors", "lower": "deviations"}
TURNED, TILTED = 1.0, 0.3  # standard deviations [deg]


def robot(name: str) -> Machine:
    """A robot of the bench with a load like its nominal one."""
    tables = tomllib.loads((ROBOTS / name / "case.toml").read_text(encoding="utf-8"))
    nominal, sensors = tables["nominal"], tables["sensors"]
    body = {key: nominal[key] for key in ("mass_kg", "centre_of_gravity_mm", "inertia_kg_m2")}
    body["mass_kg"] *= 1.05
    noise = {key: sensors[key] for key in ("force_noise_N", "moment_noise_Nm")}
    parameters = {"body": body, "offsets_N": [3.2, -5.1, 8.4, 0.31, -0.22, 0.12]}
    tables["simulation"] = noise | {"encoder_resolution_mdeg": 1.0, "parameters": parameters}
    case = Case.model_validate({k: v for k, v in tables.items() if k != "simulation"}).found_at(name)
    return Machine(name, tables, case, plant_of(tables), 500.0)


def off_its_case(
    name: str, seed: int, duration: float = 10.0
) -> tuple[Machine, Case, Recording, dict[str, np.ndarray]]:
    """A machine, its case that is off by drawn tolerances, its run, and the sizes by keys [SI]."""
    of, draw = robot(name) if (ROBOTS / name).exists() else machine(name), np.random.default_rng([seed, 7])
    data = of.case.model_dump(mode="json", exclude_unset=True)
    if name.startswith("hexapod"):
        data["tolerances"] = {"joints_mm": 0.03, "bars_mm": 0.03}
        bars, sizes = of.case.sensor_frame.bars, {}
        tables = [(data["machine"], key, getattr(of.case.hexapod, key)) for key in ("base", "platform")]
        if bars is None:
            data["tolerances"] = {"joints_mm": 0.03}
        else:
            tables += [(data["sensor_frame"]["bars"], key, getattr(bars, key)) for key in ("lower", "upper")]
        for table, key, joints in tables:
            by = draw.normal(0.0, 0.03, (6, 3))
            table[key] = {"points_mm": (joints.points / MM - by).tolist()}
            sizes.setdefault("joints_mm" if table is data["machine"] else "bars_mm", []).append(by.ravel() * MM)
        sizes = {key: np.concatenate(parts) for key, parts in sizes.items()}
    elif name == "ur10_wrist":
        data["tolerances"] = {"gravity_deg": TILTED}
        lean = draw.normal(0.0, TILTED * DEG, 2)
        sizes = {"gravity_deg": lean}
        gravity = np.array(of.case.gravity_m_s2)
        data["gravity_m_s2"] = (gravity - np.linalg.norm(gravity) * np.r_[lean, 0.0]).tolist()
    else:
        data["tolerances"] = {"sensor_deg": TURNED}
        turn = draw.normal(0.0, TURNED * DEG, 3)
        sizes = {"sensor_deg": turn}
        sensor = of.case.chain.sensor
        own = Rotation.from_euler("xyz", sensor.rpy) * Rotation.from_rotvec(turn).inv()
        data["machine"]["chain"].setdefault("sensor", {})["rpy_deg"] = own.as_euler("xyz", degrees=True).tolist()
    run = recorded(of, Moves(of, seed, duration), seed, STATED)
    return of, Case.model_validate(data).found_at(name), run, sizes


def main() -> None:
    """Prints each run, then all."""
    name, count = sys.argv[1], int(sys.argv[2])
    every: dict[str, list[np.ndarray]] = {}
    for seed in range(count):
        of, case, run, sizes = off_its_case(name, seed)
        start = time.process_time()
        found = estimate_parameters(run, case)
        seconds = time.process_time() - start
        with patch("identification.fitting.told_by", return_value=None):
            plain = estimate_parameters(run, case)  # tolerances are counted, sizes not estimated
        right = estimate_parameters(run, of.case)
        names = [key for key in found.physical if key in of.truth]
        errors = {
            words: np.array([estimate.physical[k].value - of.truth[k] for k in names])
            for words, estimate in (("estimated", found), ("least squares", plain), ("case right", right))
        }
        reported = np.array([found.physical[k].reported for k in names])
        every.setdefault("errors", []).append(errors["estimated"] / reported)
        every.setdefault("beside", []).append(errors["case right"] / [right.physical[k].reported for k in names])
        every.setdefault("plain", []).append(errors["least squares"] / [plain.physical[k].reported for k in names])
        every.setdefault("gain", []).append(
            np.abs(errors["estimated"]) / np.maximum(np.abs(errors["least squares"]), 1e-12)
        )
        told = found.quantities.get("told", [])
        deviations = [
            (entry["value"] - size) / entry["std"]
            for key in sizes
            for entry, size in zip([e for e in told if e["key"] == key], sizes[key], strict=False)
            if len([e for e in told if e["key"] == key]) == len(sizes[key])
        ]
        every.setdefault("sizes", []).append(np.array(deviations))
        line = ", ".join(f"{value:+.2f}" for value in deviations)
        print(
            f"{seed} | {seconds:.1f} s | rms {np.sqrt(np.mean(every['errors'][-1] ** 2)):.2f} | sizes {line}",
            flush=True,
        )
        every.setdefault("lower", []).append(reported / [plain.physical[k].reported for k in names])
    for key, parts in every.items():
        values = np.concatenate(parts)
        if not len(values):
            continue
        if key in ("gain", "lower"):
            print(f"{WORDS[key]} over those of least squares: median {np.median(values):.2f}")
            continue
        print(f"{key}: rms {np.sqrt(np.mean(values**2)):.2f}, largest {np.abs(values).max():.2f} of {len(values)}")


if __name__ == "__main__":
    main()
