"""Plans that count on errors of the pose beside plans that do not, on the built-in machine, whose errors are known.

python tests/bench/pose_errors.py            # rows for every family
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.schema import load_case
from cases.tables import find_case
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from identification.model.parameters import body_parameters, physical_form
from identification.motion.motion import Trajectory
from planner.plans.plan import Plan
from tests.bench.tables import print_table
from tests.helpers import pose_covariance

Command = Callable[..., tuple[float, str]]

STATED = "pose_error_N = 1.45\npose_error_length_mm = 28.0"  # as identify finds them of runs of this machine
SAMPLES = 2000
FAMILIES = ("ptp", "spline", "fourier")
WANTED = {"ptp": "at most 0.65, none above 1"}


def pose_error_rows(folder: Path, command: Command) -> list[list[str]]:
    """True deviations of both plans of each family, D-efficiencies, and predicted over true deviations."""
    (folder / "erring").mkdir()
    text = find_case("hexapod").read_text(encoding="utf-8")
    stated = text.replace('weights = "equal"', f'weights = "equal"\n{STATED}', 1)
    (folder / "erring" / "case.toml").write_text(stated, encoding="utf-8")
    rows = []
    for family in FAMILIES:
        plans = []
        for case in ("hexapod", str(folder / "erring")):
            place = folder / f"{family}-{Path(case).name}"
            words = ("--family", family, "--starts", "1", "--json", "-o", str(place))
            plans.append((json.loads(command("plan", case, *words)[1]), over_machines(Plan.load(place).motion)))
        (plain, true), (counting, less) = plans
        predicted = counting["predicted_std"]
        rows += [
            [f"{family}: true deviations, counting on errors of the pose over not",
             _ratios([less[n] / true[n] for n in true]), WANTED.get(family, "below 1")],
            ["  D-efficiency of both", f"{counting['d_efficiency']:.3f}, {plain['d_efficiency']:.3f}", ""],
            ["  deviations predicted over true", _ratios([predicted[n] / less[n] for n in less]), "0.75 to 1.25"],
        ]  # fmt: skip
    return rows


def _ratios(values: list[float]) -> str:
    return f"{np.exp(np.mean(np.log(values))):.2f} ({min(values):.2f} to {max(values):.2f})"


def over_machines(motion: Trajectory) -> dict[str, float]:
    """Standard deviations over simulated machines that differ in their errors of the pose, by least squares."""
    case = load_case("hexapod")
    model = identification_model(case, 9)
    states = motion.at((np.arange(SAMPLES) + 0.5) * motion.duration / SAMPLES)
    regressors = over_samples(model.coordinate_regressor, states.coordinates, states.rates, states.accelerations)[0]
    rows = regressors.reshape(SAMPLES * 6, -1)
    scale = 1.0 / np.linalg.norm(rows, axis=0)
    answer = (scale[:, None] * np.linalg.pinv(rows * scale)).reshape(-1, SAMPLES, 6)
    simulation, machine = case.need_simulation("errors of the pose"), case.need_machine("errors of the pose")[0]
    assert simulation.disturbances is not None
    errors = pose_covariance(simulation.disturbances, machine.home.vector, states.coordinates, 0.0)
    white = simulation.force_noise_N**2 * SAMPLES / (motion.duration * case.recording.rate_Hz)
    covariance = sum(a @ (errors + white * np.eye(SAMPLES)) @ a.T for a in np.moveaxis(answer, 2, 0))
    form, body = physical_form(model), body_parameters(case.body(0))
    values = np.array([body.get(name, 0.0) for name in model.names])
    std = np.sqrt(np.diag(form.of(values, np.asarray(covariance))[1]))
    return {p.name: float(s) for p, s in zip(form.parameters, std, strict=True)}


def _command(*words: str) -> tuple[float, str]:
    began = time.perf_counter()
    hexcite = Path(sys.executable).parent / "hexcite"
    done = subprocess.run([str(hexcite), *words], capture_output=True, text=True, check=True)
    return time.perf_counter() - began, done.stdout


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        print_table("Errors of the pose", ("figure", "measured", "wanted"), pose_error_rows(Path(name), _command))
