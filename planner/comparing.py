"""Plans, runs and results side by side: what each cost and tells, what belongs together, and which one to prefer."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cases.errors import FileProblem, HexciteError, IdentificationError
from cases.files import read_json
from cases.loading import load_case
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.evaluation import moving_run, standstills
from identification.hexapod import Hexapod
from identification.identify import default_model
from identification.model import Model, identification_model
from identification.motion import Joined, Measurement, sample
from identification.rates import on_one_clock
from identification.recording import Recording, files_of, read_recording
from identification.reference import reference_scaling
from identification.saved import load_result
from planner.fingerprints import plan_hash
from planner.noise import expected_noise
from planner.plan import load_plan
from planner.planning import SAMPLES_PER_SECOND, predicted_std
from planner.poses.regressors import pose_regressors
from planner.problem import mean_information

Array = NDArray[np.float64]

SAME_PATH = 2e-3  # [m] a run that strays less from a plan, and the plan from it, is a run of that plan
PATH_RATE = 500.0  # [1/s]
NO_DIFFERENCE = 1.05  # ratio of standard deviations below which the shorter one is as good


class Level(IntEnum):
    """How far an excitation has come."""

    PLANNED = 1
    EXECUTED = 2
    IDENTIFIED = 3


class Told(NamedTuple):
    """A parameter: value (None before it was identified), and standard deviation, reported or predicted [SI]."""

    value: float | None
    std: float
    unit: str


@dataclass(frozen=True, slots=True)
class Entry:
    """One thing that is compared.

    Args:
        name: as the user named it.
        level: plan, run or result.
        case: of it.
        model: number in Table 2.
        family: of the plan, or what the recording says.
        duration: measuring time [s]; None where nothing tells.
        samples: of forces that count.
        criteria: A, D, K, N and condition of the mean information in the reference scaling; empty where it is unknown.
        parameters: by name.
        s0: of an identified one [N].
        notes: figures of the execution, by name.
        path: positions on the way, shape (n, 3) [m]; None where it is unknown.
        hashes: fingerprints of the recordings that it is or was made of.
        plan: fingerprint of the plan that it is or followed; None where nothing says.
    """

    name: str
    level: Level
    case: Case
    model: int
    family: str
    duration: float | None
    samples: int
    criteria: Mapping[str, float]
    parameters: Mapping[str, Told]
    s0: float | None
    notes: Mapping[str, float]
    path: Array | None
    hashes: frozenset[str]
    plan: str | None = None

    def to_json(self) -> dict[str, Any]:
        """One row of the answer."""
        return {
            "name": self.name,
            "level": self.level.name.lower(),
            "model": self.model,
            "family": self.family,
            "duration_s": self.duration,
            "samples": self.samples,
            "criteria": dict(self.criteria),
            "s0_N": self.s0,
            "parameters": {n: t._asdict() for n, t in self.parameters.items()},
            "execution": dict(self.notes),
        }


def read_entry(path: Path) -> Entry:
    """Reads a plan, recording or result folder.

    Raises:
        FileProblem: it is none of these.
        HexciteError: it cannot be used; the message says why.
    """
    readers = {"plan.json": _plan, "recording.json": _run, "result.json": _result}
    for file, reader in readers.items():
        if (path / file).is_file():
            return reader(path)
    raise FileProblem(f"{path}: holds no plan, run or result; name folders that plan, poses, run or identify wrote")


def _plan(path: Path) -> Entry:
    saved = load_plan(path)
    model = identification_model(saved.case, int(saved.data["model"]))
    scaling = reference_scaling(saved.case, model)
    if saved.data["family"] == "poses" and isinstance(saved.motion, Joined):
        poses = np.array([p.pose for p in saved.motion.parts if isinstance(p, Measurement)])
        matrix = (pose_regressors(model, poses) * scaling).reshape(-1, len(scaling))
        information, samples = matrix.T @ matrix / len(poses), len(poses)
    else:
        information = mean_information(model, scaling, saved.motion)
        samples = round(saved.motion.duration * SAMPLES_PER_SECOND)
    units = _units(model)
    told = {n: Told(None, float(s), units[n]) for n, s in saved.data["predicted_std"].items()}
    return Entry(
        str(path), Level.PLANNED, saved.case, model.number, str(saved.data["family"]), saved.motion.duration, samples,
        _criteria(information, model), told, None, {}, sample(saved.motion, PATH_RATE).pose[:, :3], frozenset(),
        plan_hash(path),
    )  # fmt: skip


def _units(model: Model) -> dict[str, str]:
    from identification.parameters import physical_form

    return {p.name: p.unit for p in physical_form(model).parameters}


def _criteria(information: Array, model: Model) -> dict[str, float]:
    mu = singular_values(information, model.names)
    return {letter: c.of(mu) for letter, c in CRITERIA.items()} | {"condition": float(mu[0] / mu[-1])}


def _run(path: Path) -> Entry:
    about = read_json(path / "recording.json", "hexcite run")
    case = load_case(str(about.get("case_file")))
    recording = on_one_clock(read_recording(path, case), case)
    model = identification_model(case, default_model(recording))
    scaling = reference_scaling(case, model)
    matrices, way, samples = _matrices(recording, case, model)
    information = _seen(matrices, None, scaling)
    duration = about.get("executed_s")
    noise = expected_noise(case, model)
    seconds = samples / SAMPLES_PER_SECOND
    weighted = _seen(matrices, noise.whitening, scaling)
    scattered = None if noise.scatter is None else _seen(matrices, noise.scatter, scaling)
    units = _units(model)
    expected = predicted_std(case, model, scaling, weighted, seconds, noise.sensors, 0, scattered)
    figures = ("planned_s", "executed_s", "d_efficiency_planned", "d_efficiency", "path_error_mm")
    return Entry(
        str(path), Level.EXECUTED, case, model.number, str(about.get("controller", "recorded")),
        None if duration is None else float(duration), samples, _criteria(information, model),
        {n: Told(None, s, units[n]) for n, s in expected.items()}, None,
        {n: float(about[n]) for n in figures if about.get(n) is not None}, way, _fingerprints(path),
        about.get("plan_hash"),
    )  # fmt: skip


def _seen(matrices: Array, root: Array | None, scaling: Array) -> Array:
    """Mean of H A^T R^T R A H, shape (u, u)."""
    rows = ((matrices if root is None else root @ matrices) * scaling).reshape(-1, len(scaling))
    return np.asarray(rows.T @ rows / len(matrices))


def _matrices(recording: Recording, case: Case, model: Model) -> tuple[Array, Array | None, int]:
    """Regressors that are evaluated, the way of the platform, and the number of samples that they stand for."""
    if recording.t is None:
        return standstills(recording, case, model).regressors, None, len(recording.forces)
    run = moving_run(recording, case, model)
    struts = run.filter.apply(run.recording.struts)[run.rows] if run.recording.struts is not None else None
    way = None if struts is None else Hexapod.of(case).poses(struts)[:, :3]
    return run.regressors(0.0), way, run.samples


def _fingerprints(path: Path) -> frozenset[str]:
    found = set()
    for file in files_of([path]):
        with file.open("rb") as stream:
            found.add(hashlib.file_digest(stream, "sha256").hexdigest())
    return frozenset(found)


def _result(path: Path) -> Entry:
    saved = load_result(path)
    data = read_json(path / "result.json", "hexcite identify")
    case = load_case(saved.case_name)
    model = identification_model(case, saved.model)
    samples, s0 = int(data["samples"]), float(data["s0"])
    criteria: dict[str, float] = {}
    if data["weights"] == "equal" and saved.covariance.shape[0] == len(model.names):
        try:  # (28) turned round: the information that the run held of these parameters
            mean = s0**2 * np.linalg.inv(saved.covariance) / samples
            scaling = reference_scaling(case, model)
            criteria = _criteria(mean * np.outer(scaling, scaling), model)
        except (np.linalg.LinAlgError, IdentificationError):
            criteria = {}
    told = {
        n: Told(float(p["value"]), max(float(p["std"]), float(p["std_robust"])), str(p["unit"]))
        for n, p in data["parameters"].items()
    }
    hashes = frozenset(str(i["sha256"]) for i in data.get("inputs", []))
    return Entry(
        str(path), Level.IDENTIFIED, case, saved.model, str(data.get("estimator", "")), None, samples, criteria, told,
        float(data["s0_N"]), {}, None, hashes, data.get("plan_hash"),
    )  # fmt: skip


def groups(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Entries that belong together: a result with the run it was made of (by hash), a run with the plan it followed.

    A run follows the plan whose fingerprint it carries; where it carries none of these, one from whose path neither
    strays. A result without its run belongs to the plan of that run. A result takes the measuring time of its run.
    """
    found = [[e] for e in entries if e.level is Level.PLANNED]
    for run in (e for e in entries if e.level is Level.EXECUTED):
        plans = [g for g in found if len(g) == 1 and g[0].level is Level.PLANNED]
        named = [g for g in plans if run.plan is not None and run.plan == g[0].plan]
        home = next((g for g in named or plans if named or _follows(run, g[0])), None)
        if home is None:
            found.append([run])
        else:
            home.append(run)
    for result in (e for e in entries if e.level is Level.IDENTIFIED):
        home = next((g for g in found if any(e.hashes & result.hashes for e in g)), None)
        alone = [g for g in found if len(g) == 1 and result.plan is not None and g[0].plan == result.plan]
        if home is None and alone and alone[0][0].level is Level.PLANNED:
            alone[0].append(result)
        elif home is None:
            found.append([result])
        else:
            run = next(e for e in home if e.hashes & result.hashes)
            home.append(replace(result, duration=run.duration))
    return found


def _follows(run: Entry, plan: Entry) -> bool:
    if run.path is None or plan.path is None or run.level is plan.level:
        return False
    there, back = cKDTree(plan.path).query(run.path)[0], cKDTree(run.path).query(plan.path)[0]
    return bool(max(there.max(), back.max()) < SAME_PATH * 5 and np.mean(there) < SAME_PATH)


class Recommendation(NamedTuple):
    """Which one to prefer.

    Args:
        best: its name; None where nothing can be compared.
        per_second: the best per second of measuring time; None where times are unknown.
        level: what the figures are: planned, executed or identified.
        ratios: geometric mean of the standard deviations of each, over the best one's.
        sentences: why.
    """

    best: str | None
    per_second: str | None
    level: str
    ratios: Mapping[str, float]
    sentences: tuple[str, ...]


def recommend(found: Sequence[Sequence[Entry]]) -> Recommendation:
    """Recommends the excitation with the smallest standard deviations, by the best evidence that all of them have."""
    if len(found) < 2:
        return Recommendation(None, None, "", {}, ("there is nothing to choose from: name two excitations or more",))
    common = [level for level in sorted(Level, reverse=True) if all(any(e.level is level for e in g) for g in found)]
    remarks = []
    if common:
        chosen = [next(e for e in g if e.level is common[0]) for g in found]
        level = common[0].name.lower()
    else:
        chosen = [max(g, key=lambda e: e.level) for g in found]
        level = "mixed"
        remarks.append("predictions stand beside identified values: predictions know nothing of the machine's errors")
    names = [n for n in chosen[0].parameters if all(n in e.parameters for e in chosen)]
    if not names:
        return Recommendation(None, None, level, {}, ("they have no parameter in common",))
    for entry in chosen:
        missing = sorted({n for e in chosen for n in e.parameters} - set(entry.parameters))
        if missing:
            remarks.append(f"{entry.name} does not determine {', '.join(missing)}: not compared")
    sizes = np.array([_size(e, names) for e in chosen])
    order = np.argsort(sizes, kind="stable")
    best, second = chosen[order[0]], chosen[order[1]]
    ratio = float(np.exp(sizes[order[1]] - sizes[order[0]]))
    times = [e.duration for e in chosen]
    if ratio < NO_DIFFERENCE and best.duration and second.duration and second.duration < best.duration:
        best, second = second, best
        why = f"standard deviations of {second.name} are as small within {100 * (ratio - 1):.0f} %, but it takes longer"
    else:
        why = f"its {level} standard deviations are smallest: {second.name}'s are {ratio:.2f} times as large"
    why += f" (geometric mean over {len(names)} parameters)"
    sentences = [f"{best.name}: {why}{_times(best, second)}", *remarks]
    fastest = None
    if all(times):
        rates = sizes + 0.5 * np.log([float(t or 1.0) for t in times])
        fastest = chosen[int(np.argmin(rates))].name
        if fastest != best.name:
            sentences.append(f"per second of measuring time {fastest} tells most")
    ratios = {e.name: float(np.exp(s - sizes.min())) for e, s in zip(chosen, sizes, strict=True)}
    return Recommendation(best.name, fastest, level, ratios, tuple(sentences))


def _size(entry: Entry, names: Iterable[str]) -> float:
    deviations = [entry.parameters[n].std for n in names]
    if not all(d > 0.0 for d in deviations):
        raise HexciteError(f"{entry.name}: a parameter was given, not identified; compare without --fix")
    return float(np.mean(np.log(deviations)))


def _times(best: Entry, second: Entry) -> str:
    if best.duration is None or second.duration is None:
        return ""
    return f", in {best.duration:.1f} s against {second.duration:.1f} s"
