"""Figures of identification: an hour at 1 kHz, forward kinematics, coloured noise, contacts, the real sensor."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording, read
from identification.simulate import simulate_recording
from tests.bench.coverage import coloured_coverage
from tests.bench.hour import hour_figures
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

STATIC = Path(__file__).parents[3] / "shared/data/ft_wrist_ntnu/0-calibration_fts-accel.csv"
Rows = list[list[str]]


def identification_figures(folder: Path) -> Rows:
    """All of them; long recordings are written to `folder`."""
    return [*_kinematics(), *_coloured(), *_contacts(), *_wrist(), *hour_figures(folder)]


def _kinematics() -> Rows:
    case = load_case("hexapod")
    hexapod = Hexapod.of(case)
    struts = hexapod.strut_lengths(Harmonic(seed=1).at(np.linspace(0.0, 3.0, 20_000)).coordinates)
    times = []
    for _ in range(5):
        began = time.perf_counter()
        hexapod.poses(struts)
        times.append(time.perf_counter() - began)
    return [["forward kinematics of 20 000 samples", f"{min(times):.2f} s", "0.1 s"]]


def _coloured() -> Rows:
    case = load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=4.0))
    found = coloured_coverage(case, execution, np.array([[0.2, 3.8]]), seeds=200)
    return [
        ["coverage, noise of a 20 Hz filter, 200 seeds: robust std", f"{found.robust:.1f} %", "91 to 98 %"],
        ["  their width over the true spread, median", f"{found.width:.2f}", "at most 1.5"],
        ["  the same: std (28), which noise with memory misleads", f"{found.white:.1f} %", "fails"],
    ]


def _contacts() -> Rows:
    case = load_case("hexapod")
    executions = [PoseExecution(Hexapod.of(case), Harmonic(seed=s, duration=3.0)) for s in range(3)]
    frame = case.sensor_frame.structure
    alarms, late = 0, []
    for seed in range(50):
        run = simulate_recording(case, executions[seed % 3], np.array([[0.2, 2.8]]), seed)
        assert run.t is not None
        alarms += any("contact" in w for w in estimate_parameters(run, case).warnings)
        draw = np.random.default_rng(seed)
        push, start = draw.normal(size=3), float(draw.uniform(0.4, 2.4))
        extra = np.linalg.solve(frame, np.r_[20.0 * push / np.linalg.norm(push), 0.0, 0.0, 0.0])
        on = (run.t >= start) & (run.t < start + 0.2)
        touched = replace(run, forces=run.forces - on[:, None] * extra)
        told = [w for w in estimate_parameters(touched, case).warnings if "contact from" in w]
        late.append(abs(float(told[0].split("contact from ")[1].split()[0]) - start) if told else np.inf)
    return [
        ["contacts of 20 N, 0.2 s: worst error of their begin, 50 runs", f"{1e3 * max(late):.0f} ms", "50 ms"],
        ["  false alarms in 50 clean runs", f"{alarms}", "0"],
    ]


def _wrist() -> Rows:
    if not STATIC.is_file():
        return [["real force/torque sensor", "the recording is not there", ""]]
    case = load_case("ft_wrist")
    run = read(STATIC, case)
    assert run.rotations is not None
    halves = (slice(0, 12), slice(12, 24))
    half = [replace(run, forces=run.forces[k], rotations=run.rotations[k], specific_forces=None) for k in halves]
    estimate, whole = estimate_parameters(half[0], case), estimate_parameters(run, case)
    left = half[1].forces - _static_regressor(half[1], case.gravity) @ estimate.fit.values
    rms = np.sqrt(np.mean(left**2, axis=0))
    mass = whole.physical["m"]
    return [
        *_moving_wrist(),
        ["real sensor: mass (published 0.932 kg)", f"{mass.value:.4f} +- {mass.reported:.4f} kg", ""],
        ["  12 poses predict the other 12, rms", f"{rms[:3].max():.3f} N, {1e3 * rms[3:].max():.1f} mN m", "0.15, 5"],
    ]


def _moving_wrist() -> Rows:
    """The same sensor in motion: offsets free; the delay at several cut-offs."""
    case = load_case("ft_wrist")
    run = read([STATIC.with_name(f"1-baseline_{n}.csv") for n in ("accel", "wrench", "orientations")], case)
    free = estimate_parameters(run, case).physical["m"]
    delays = []
    for cutoff in (5.0, 10.0, 20.0, 40.0):
        form = case.recording.model_copy(update={"filter_cutoff_Hz": cutoff})
        delay = estimate_parameters(run, case.model_copy(update={"recording": form})).delay
        assert delay is not None
        delays.append(1e3 * delay.value)
    return [
        ["real sensor in motion: mass, offsets free", f"{free.value:.4f} +- {free.reported:.4f} kg", "covers 0.932"],
        ["  delay, cut-offs of 5 to 40 Hz", f"{min(delays):.2f} to {max(delays):.2f} ms", "within 1 ms"],
    ]


def _static_regressor(run: Recording, gravity: np.ndarray) -> np.ndarray:
    """A load at rest, from F = m g and T = c x F: the pull of the load on the sensor."""
    assert run.rotations is not None
    pull = run.rotations.transpose(0, 2, 1) @ gravity
    matrices = np.zeros((len(pull), 6, 10))
    matrices[:, :3, 0], matrices[:, :, 4:] = pull, np.eye(6)
    matrices[:, 3:, 1:4] = -np.cross(pull[:, None, :], np.eye(3)[None]).transpose(0, 2, 1)
    return matrices
