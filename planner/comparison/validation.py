"""Known weights mounted one after the other and identified by each method (section 8, Table 7)."""

import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from cases.controller import ControllerName
from cases.errors import HexciteError
from cases.files import VALIDATION, atomic_folder, check_folder, json_text
from cases.schema import Case
from cases.sensors import Disturbances
from cases.units import as_html
from planner.comparison.claims import Claim, claims_of
from planner.comparison.methods import METHODS, USUAL, Remark, ValidationSettings, executed, require_methods
from planner.comparison.trials import Trial, mounted_weights, recorded_trials, require_weights, trials
from planner.execution import require_controller


@dataclass(frozen=True, slots=True, repr=False)
class Validation:
    """Known weights as each method identifies them; saved for people and programs, not read back: only plans are."""

    case: Case  # machine and weights
    machine: str  # machine that was identified, in words
    trials: tuple[Trial, ...]
    claims: tuple[Claim, ...]  # claims that follow from the trials
    failed: Mapping[str, str]  # methods that could not be carried out, and why
    executed: Mapping[str, str]  # controller of each method that was simulated
    controller: str | None  # controller that ran the programs; None for recordings of a machine
    # disturbances of the simulated machine; None for recordings of a machine and for an ideal structure
    disturbances: Disturbances | None
    made: Mapping[str, bytes]  # files of plans and programs by their place in the folder

    def to_json(self) -> dict[str, Any]:
        """Entries of `validation.json`."""
        return {
            "case": self.case.name,
            "case_hash": self.case.hash,
            "machine": self.machine,
            "simulated": self.controller is not None,
            "controller": self.controller,
            "disturbances": None if self.disturbances is None else self.disturbances.model_dump(),
            "not_run": dict(self.failed),
            "rows": [trial.to_json() for trial in self.trials],
            "findings": [claim._asdict() for claim in self.claims],
            "recommendation": {"sentences": [claim.sentence() for claim in self.claims if claim.holds]},
            "executed": dict(self.executed),
        }

    def write(self, folder: Path) -> None:
        """Writes validation.json, plans and programs into an existing folder."""
        (folder / "validation.json").write_text(json_text(self.to_json()), encoding="utf-8")
        for name, content in self.made.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with the same files."""
        check_folder(Path(folder), VALIDATION, overwrite=overwrite)
        with atomic_folder(Path(folder), VALIDATION, overwrite) as part:
            self.write(part)

    def __repr__(self) -> str:
        """The claims, a line each."""
        return "\n".join([f"Validation of {self.case.name}", *(claim.sentence() for claim in self.claims)])

    _repr_html_ = as_html


def validate(
    case: Case,
    methods: Sequence[str] = tuple(METHODS),
    mounted: Sequence[int] | None = None,
    settings: ValidationSettings = USUAL,
    *,
    undisturbed: bool = False,
    folder: Path | str | None = None,
    progress: Remark = lambda remark: None,
) -> Validation:
    """Carries out the payload experiment on the case's simulated machine.

    Args:
        case: case with payloads and a simulated machine.
        mounted: numbers of weights, from 0 on; by default none, and each up to all.
        undisturbed: whether the simulated structure is an ideal one.
        folder: folder for plans and programs, in which an existing plan is not made again; a temporary one unless
            given.
        progress: shows the present step in words.

    Raises:
        HexciteError: no method could be carried out, an unknown method or controller, or a case without simulation.
    """
    require_methods(methods)
    mounted = mounted_weights(case, None if mounted is None else ",".join(map(str, mounted)))
    disturbances = _disturbances_of(case, settings, undisturbed)
    with ExitStack() as places, threadpool_limits(limits=1, user_api="blas"):
        work = Path(folder or places.enter_context(tempfile.TemporaryDirectory(prefix="hexcite-validation-")))
        found, controllers, failed = list[Trial](), dict[str, str](), dict[str, str]()
        for method in methods:
            try:
                excitation = executed(case, method, settings, work, progress)
            except HexciteError as error:  # the others go on
                failed[method] = error.typed.replace(f"{work}/", "")
                continue
            controllers[method] = excitation.controller
            progress(f"{method}: identifying")
            for trial in trials(excitation, mounted, disturbances):
                found.append(trial)
                progress(f"{method} {trial.load:.0f} kg")
        if not found:
            raise HexciteError("; ".join(f"{method}: {reason}" for method, reason in failed.items()))
        origin = {
            str(file.relative_to(work)): file.read_bytes()
            for name in ("plans", "programs")
            for file in sorted((work / name).rglob("*"))
            if file.is_file()
        }
    return Validation(
        case=case,
        machine=_simulated(case, disturbances, settings),
        trials=tuple(found),
        claims=tuple(claims_of(found)),
        failed=failed,
        executed=controllers,
        controller=settings.on,
        disturbances=disturbances,
        made=origin,
    )


def _disturbances_of(case: Case, settings: ValidationSettings, undisturbed: bool) -> Disturbances | None:
    """Disturbances of the simulated machine; raises HexciteError where it cannot be run."""
    case.need_machine("a validation")
    require_controller(settings.on)
    disturbances = case.need_simulation("a validation without recordings").disturbances
    if disturbances is None and not undisturbed:
        case.missing("simulation.disturbances", "a validation (or --undisturbed)")
    return None if undisturbed else disturbances


def validate_recordings(case: Case, recordings: Path | str, methods: Sequence[str] | None = None) -> Validation:
    """Evaluates the payload experiment from a real machine's recordings.

    Args:
        recordings: folder with a folder for each method, whose runs 0, 1, .. are named after the number of weights.
        methods: names of folders; None for all.

    Raises:
        HexciteError: runs are missing, or cannot be evaluated.
    """
    require_weights(case)
    recordings = Path(recordings)
    folders = sorted(p for p in recordings.iterdir() if p.is_dir()) if recordings.is_dir() else []
    if not folders:
        raise HexciteError(recordings, "holds no folder of runs; name the folder that holds one for each method")
    names = [folder.name for folder in folders]
    for name in (name for name in methods or () if name not in names):
        raise HexciteError(f"method {name!r}: {recordings} holds no folder of that name, but {', '.join(names)}")
    folders = [folder for folder in folders if methods is None or folder.name in methods]
    found = tuple(trial for folder in folders for trial in recorded_trials(case, folder))
    machine = f"recordings of a machine in {recordings}"
    return Validation(case, machine, found, tuple(claims_of(found)), {}, {}, None, None, {})


def _simulated(case: Case, disturbances: Disturbances | None, settings: ValidationSettings) -> str:
    machine = f"a simulated machine ({case.need_simulation('a validation').source})"
    if disturbances is not None:
        machine += (
            f", with a structural mode at {disturbances.mode_Hz:g} Hz that falls with the load, ripple of the "
            f"struts and force errors that depend on the pose ({disturbances.source})"
        )
    controller = "LinuxCNC" if settings.on == ControllerName.LINUXCNC else "the built-in virtual controller"
    machine += f"; programs executed on {controller}"
    if settings.on == ControllerName.LINUXCNC:
        machine += ", which limits no jerk: its steps of acceleration make the structure vibrate"
    return machine
