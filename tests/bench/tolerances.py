"""Machines off their cases by drawn tolerances: are errors as large as the reported deviations say?

python tests/bench/tolerances.py            # 24 runs: hexapods and chains that are drawn, noise of four kinds
python tests/bench/tolerances.py 40 --built-in          # and after them the built-in machines
python tests/bench/tolerances.py 40 --understated 2     # off by twice of what the cases state: do runs tell?
"""

import argparse
import itertools
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.base.errors import HexciteError
from cases.base.units import MM
from cases.schema import Case
from identification.identify import estimate_parameters
from tests.bench.silent import MACHINES, NOISES, drawn_machines, way_of
from tests.damaged.runs import SOUND, Machine, machine, recorded

KINDS = ("white", "remembers 50 ms", "remembers 0.3 s", "hum of 50 Hz")
HEXAPOD = {"joints_mm": 0.03, "bars_mm": 0.03, "gain_percent": 0.2, "gravity_deg": 0.05}
CHAIN = {"joint_zeros_deg": 0.02, "sensor_mm": 0.1, "gain_percent": 0.2, "gravity_deg": 0.05}


def case_off(of: Machine, draw: np.random.Generator, times: float = 1.0) -> Case:
    """The case of a machine, off its truth by tolerances that it states, or by so many times these."""
    data = of.case.model_dump(mode="json", exclude_unset=True)
    chain = of.case.chain is not None
    data["tolerances"] = stated = CHAIN if chain else HEXAPOD
    if chain:
        sensor = data["machine"]["chain"].setdefault("sensor", {})
        at = np.array(sensor.get("origin_mm", (0.0,) * 3)) + draw.normal(0.0, times * stated["sensor_mm"], 3)
        sensor["origin_mm"] = at.tolist()
    else:
        tables = [(data["machine"], k, getattr(of.case.hexapod, k)) for k in ("base", "platform")]
        bars = of.case.sensor_frame.bars
        if bars is None:
            data["tolerances"] = stated = {key: size for key, size in HEXAPOD.items() if key != "bars_mm"}
        else:
            tables += [(data["sensor_frame"]["bars"], k, getattr(bars, k)) for k in ("lower", "upper")]
        for table, key, joints in tables:
            size = stated["joints_mm" if table is data["machine"] else "bars_mm"]
            table[key] = {"points_mm": (joints.points / MM + draw.normal(0.0, times * size, (6, 3))).tolist()}
    gravity = np.array(of.case.gravity_m_s2)
    lean = np.radians(stated["gravity_deg"]) * np.linalg.norm(gravity)
    across = np.linalg.svd(gravity[None])[2][1:]
    data["gravity_m_s2"] = (gravity + draw.normal(0.0, times * lean, 2) @ across).tolist()
    return Case.model_validate(data)


def errors(seed: int, name: str, kind: str, times: float = 1.0) -> tuple[list[float], tuple[str, ...]]:
    """Errors of physical parameters over reported deviations, and the warnings of the run."""
    of, draw = machine(name), np.random.default_rng(seed)
    run = recorded(of, way_of(of, seed, 4.0 + seed % 3), seed, NOISES[kind], SOUND)
    case = case_off(of, draw, times)
    forces = run.forces * (1.0 + draw.normal(0.0, times * case.tolerances.gain_percent.deviation / 100.0, 6))
    struts = run.drives
    if case.tolerances.joint_zeros_deg is not None:
        zeros = np.radians(draw.normal(0.0, times * case.tolerances.joint_zeros_deg.deviation, struts.shape[1]))
        struts = struts + zeros * np.array([joint.turns for joint in case.chain.joints])
    estimate = estimate_parameters(replace(run, forces=forces, drives=struts), case)
    found = [(p.value - of.truth[k]) / p.reported for k, p in estimate.physical.items() if k in of.truth]
    return found, estimate.warnings


FAR = 1.5  # rms of a run's errors over deviations, from which on it should be told


def main() -> None:
    """Prints each run, then all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=24)
    parser.add_argument("--understated", type=float, default=1.0)
    parser.add_argument("--built-in", action="store_true")
    asked = parser.parse_args()
    names = itertools.islice(drawn_machines(90_000), asked.count)
    every, far, told, quiet = [], [], [], 0
    for seed, name in enumerate([*names, *(MACHINES if asked.built_in else ())], 90_000):
        kind = KINDS[seed % len(KINDS)]
        try:
            errs, warnings = errors(seed, name, kind, asked.understated)
        except HexciteError as error:  # a run that is refused is shown, and not counted
            print(f"{name} | {kind} | {type(error).__name__}: {error}", flush=True)
            continue
        found = np.array(errs)
        every.append(found)
        rms = float(np.sqrt(np.mean(found**2)))
        far.append(rms > FAR)
        told.append(bool(warnings))
        quiet += not warnings
        said = f" | {warnings[0][:110]}" if warnings else ""
        print(f"{name} | {kind} | rms {rms:.2f} | largest {np.abs(found).max():.1f}{said}", flush=True)
    size = np.abs(np.concatenate(every))
    rms, beyond, inside = np.sqrt(np.mean(size**2)), 100.0 * np.mean(size > 3.0), 100.0 * np.mean(size < 1.96)
    print(f"{len(every)} runs, {len(size)} parameters: rms {rms:.2f}, beyond 3: {beyond:.1f} %, 1.96: {inside:.1f} %")
    warned = sum(one and other for one, other in zip(far, told, strict=True))
    print(f"rms above {FAR}: {sum(far)} runs, {warned} of them with a warning; runs without a warning: {quiet}")


if __name__ == "__main__":
    main()
