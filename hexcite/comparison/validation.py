"""Known weights mounted one after the other and identified by each method (section 8, Table 7)."""

import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from cases.base.atomic import atomic_folder
from cases.base.errors import Code, HexciteError
from cases.base.folder_kinds import VALIDATION
from cases.base.output_places import check_folder
from cases.base.text_formats import json_text
from cases.base.units import as_html
from cases.schema import Case
from cases.sensors import Disturbances
from hexcite._run import require_controller
from hexcite.comparison.comparison import Comparison, recommend
from hexcite.comparison.entries import Conditions, Entry
from hexcite.comparison.trials import (
    METHODS,
    USUAL,
    Remark,
    Trial,
    ValidationSettings,
    executed,
    measured_trials,
    mounted_weights,
    require_methods,
    require_platform,
    trials,
)
from identification.results.result import Result

OFF = 3.0  # reported standard deviations; more is a systematic error


@dataclass(frozen=True, slots=True, repr=False)
class Validation:
    """Known weights as each method identifies them; saved for people and programs, not read back: only plans are."""

    case: Case  # machine and weights
    machine: str  # machine that was identified, in words
    trials: tuple[Trial, ...]
    simulated: bool | None  # whether the machine was; None where its runs do not say
    failed: Mapping[str, str] = field(default_factory=dict)  # methods that could not be carried out, and why
    executed: Mapping[str, str] = field(default_factory=dict)  # controller of each method, with remarks on its run
    controller: str | None = None  # controller that ran the programs; None for results of runs
    made: Mapping[str, bytes] = field(default_factory=dict)  # files of plans and programs by their place in the folder

    @property
    def comparison(self) -> Comparison:
        """The methods without payload, side by side."""
        return recommend([[entry_of_trial(self.case, trial)] for trial in self.trials if not trial.weights])

    @property
    def sentences(self) -> tuple[str, ...]:
        """Which method to prefer, and how many results are as close to a simulated machine's truth as they report."""
        errors = [abs(error) for trial in self.trials for error in trial.errors.values()]
        of, known = ("of what was added", "what is known of the weights") if self.measured else ("", "the truth")
        return (
            *(() if self.measured else self.comparison.sentences),
            f"mass, centre of gravity and inertia {of}".rstrip()
            + f": {sum(e <= OFF for e in errors)} of {len(errors)} are within {OFF:g} reported standard deviations of "
            f"{known}, the worst is off by {max(errors):.1f}",
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the evaluations: of all results that were given, or of the methods without payload."""
        if not self.measured:
            return self.comparison.warnings
        return tuple(f"{trial.load_words}: {warning}" for trial in self.trials for warning in trial.result.warnings)

    @property
    def measured(self) -> bool:
        """Whether results of runs were given, and nothing was carried out."""
        return self.controller is None

    def to_json(self) -> dict[str, Any]:
        """Entries of `validation.json`."""
        advice = self.comparison
        return {
            "case": self.case.name,
            "case_hash": self.case.hash,
            "machine": self.machine,
            "simulated": self.simulated,
            "controller": self.controller,
            "not_run": dict(self.failed),
            "rows": [trial.to_json() for trial in self.trials],
            "recommendation": {"best": advice.best, "ratios": advice.ratios, "sentences": self.sentences},
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
        """Which method to prefer, and how far results are from the truth."""
        return "\n".join([f"Validation of {self.case.name}", *self.sentences])

    _repr_html_ = as_html


def entry_of_trial(case: Case, trial: Trial) -> Entry:
    """A trial as an entry of a comparison, by the name of its method."""
    record = trial.result.record
    family = METHODS[trial.method].family if trial.method in METHODS else trial.method
    return Entry(
        trial.method, "identified", Conditions(case), record.model, family, trial.duration, record.samples, {},
        trial.result.parameters, record.s0, {}, trial.result.warnings, record.white_noise, residual=record.s0_N,
    )  # fmt: skip


def validate(
    case: Case,
    methods: Sequence[str] = tuple(METHODS),
    mounted: Sequence[int] | None = None,
    settings: ValidationSettings = USUAL,
    *,
    folder: Path | str | None = None,
    progress: Remark = lambda remark: None,
) -> Validation:
    """Carries out the payload experiment on the case's simulated machine, with the disturbances that the case states.

    >>> validation = hx.validate(hx.load_case("hexapod"), ["ptp"], [0, 1], hx.ValidationSettings(starts=1))
    >>> [(trial.method, trial.load_words) for trial in validation.trials]
    [('ptp', '0 kg'), ('ptp', '20 kg')]

    Args:
        case: case with payloads and a simulated machine.
        mounted: numbers of weights, from 0 on; by default none, and each up to all.
        folder: folder for plans and programs, in which an existing plan is not made again; a temporary one unless
            given.
        progress: shows the present step in words.

    Raises:
        HexciteError: no method could be carried out, an unknown method or controller, or a case without simulation.
    """
    require_methods(methods)
    require_platform(case)
    mounted = mounted_weights(case, mounted)
    case.need_machine("a validation")
    require_controller(settings.on)
    disturbances = case.need_simulation("a validation").disturbances
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
                progress(f"{method} {trial.load_words}")
        if not found:
            raise HexciteError(
                problem="; ".join(f"{method}: {reason}" for method, reason in failed.items()), code=Code.INFEASIBLE
            )
        plans = {
            str(file.relative_to(work)): file.read_bytes()
            for name in ("plans", "programs")
            for file in sorted((work / name).rglob("*"))
            if file.is_file()
        }
    machine = _simulated(case, disturbances, settings)
    return Validation(case, machine, tuple(found), True, failed, controllers, settings.on, plans)


def validate_results(results: Sequence[Result], weights: Sequence[int] | None = None) -> Validation:
    """What a real machine says of known weights: results of runs with numbers of them on it, against theory.

    >>> validation = hx.validate_results([hx.Result.load("empty-result"), hx.Result.load("loaded-result")])
    >>> "7 of 7 are within 3 reported standard deviations" in validation.sentences[-1]
    True

    Args:
        results: one a number of weights of the case's `[payloads]`, which are mounted in the order stated there.
        weights: how many were mounted, ascending from 0; by default 0, 1, 2 and so on.

    Raises:
        HexciteError: fewer than two results, another count than of `weights`, results of other cases or models.
        IdentificationError: two are of one recording, or what was added is nearer to another number of weights.
    """
    if len(results) < 2:
        raise HexciteError(
            problem="one result says nothing of weights",
            remedy="name the one without weights first, then those with weights",
            code=Code.MISSING,
        )
    case = results[0].case
    if others := [result for result in results if result.record.case != case.name]:
        raise HexciteError(
            place=others[0].source,
            problem=f"is of case {others[0].record.case}, {results[0].source} of {case.name}",
            remedy="identify all runs with the case of their machine",
            code=Code.OTHER_SOURCE,
        )
    mounted = mounted_weights(case, tuple(range(len(results))) if weights is None else weights)
    trials = tuple(measured_trials(results, mounted))
    kinds = {None if result.record.run is None else result.record.run.simulated for result in results}
    simulated = kinds.pop() if len(kinds) == 1 else None
    machine = {
        True: "a simulated machine",
        False: "a real machine",
        None: "a machine of which the runs do not say more",
    }
    return Validation(case, machine[simulated], trials, simulated)


def _simulated(case: Case, disturbances: Disturbances | None, settings: ValidationSettings) -> str:
    machine = f"a simulated machine ({case.need_simulation('a validation').source})"
    if disturbances is not None:
        machine += (
            f", with a structural mode at {disturbances.mode_Hz:g} Hz that falls with the load, ripple of the "
            f"struts and force errors that depend on the pose ({disturbances.source})"
        )
    return f"{machine}; programs executed on {settings.on}"
