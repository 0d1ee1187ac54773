"""What is said of a run that something speaks against: its cause with the remedy, or what was tried and what it left.

A cause is said only after its remedy was tried: the whole run is evaluated as it would be with it.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cases.base.errors import HexciteError, Remedy
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.findings.causes.hypothesis import (
    RECORDED,
    SENSED,
    Family,
    Trial,
    case_of,
    channels_of,
    drives_of,
    pace_of,
)
from identification.findings.causes.instants import instants_of
from identification.findings.causes.remedies import keys_to_write, remedy
from identification.findings.causes.search import MODERATE, NEAR, Search, Tried, search
from identification.machines.hexapod import Hexapod
from identification.machines.of_case import machine_of
from identification.model.model import Model, identification_model
from identification.recording.recording import Recording
from identification.samples.sample_checks import scan

MOST_NAMED = 3  # explanations that a sentence names
CONFIRMED = 2.0  # times the residuals at some instants that those of the whole run may have
PIECE = 20_000  # rows whose orientation is computed at a time

Evaluate = Callable[[Recording, Case], Fit]
"""The fit to a run with another case."""


@dataclass(frozen=True, slots=True)
class Answer:
    """A sentence about the cause of a run's residuals."""

    named: bool  # whether the cause is known; else the sentence says what was tried
    sentence: str
    # whether residuals are so large that there is a mistake; smaller ones a machine makes itself, by its structure
    large: bool = True
    remedies: tuple[Remedy, ...] = ()  # keys of the case for each explanation that keys alone mend


def answer(recording: Recording, case: Case, model: Model, evaluate: Evaluate, fit: Fit | None = None) -> Answer | None:
    """The cause of a run's residuals, or what was tried; None where nothing needs or has an explanation.

    Args:
        recording: a run that something speaks against, as it was read.
        case: the case that it was read with.
        model: model that its forces are compared with.
        evaluate: fits a run as this one is fitted; raises HexciteError where it cannot.
        fit: the fit to it, where there is one: samples in contact are not in its residuals.
    """
    clean = recording
    with suppress(HexciteError):
        _, clean = scan(recording, case)
    found = search(clean, case, model, fit)
    if found is None or found.sound:
        return None
    confirmed = [entry for entry in found.explanations if _confirmed(entry, recording, case, model, evaluate)]
    if confirmed:
        trials = [entry.trial for entry in confirmed[:MOST_NAMED]]
        return Answer(True, _cause(confirmed, found, case), remedies=tuple(r for t in trials for r in _keys(t, case)))
    if not found.families:
        return None
    large = found.recorded is None or found.recorded.residuals > MODERATE
    return Answer(False, _tried(found, case), large)


def mended(trial: Trial, recording: Recording, case: Case) -> tuple[Recording, Case]:
    """The run and the case as they are where the remedies of a trial are followed."""
    for hypothesis in trial:
        if hypothesis.recorded is not None:
            recording = hypothesis.recorded(recording, case) or recording
    read = tuple(hypothesis for hypothesis in trial if hypothesis.place == "recording")
    forces = recording.forces @ channels_of(read, RECORDED).T
    struts, t = recording.struts, recording.t
    if struts is not None:
        struts = drives_of(read, struts.shape[1]).of(struts)
    if t is not None and pace_of(read) != 1.0:
        t = t * pace_of(read)
    edited = case_of(trial, case)
    run = replace(recording, forces=forces, struts=struts, t=t)
    if any(hypothesis.in_base for hypothesis in trial):
        # the controller turned the wrench as if the sensor were as the case says
        turns = _rotations(run, case_of(tuple(h for h in trial if h.family is not Family.SENSOR), case))
        forces = np.einsum("nji,nbj->nbi", turns, forces.reshape(-1, 2, 3)).reshape(-1, 6)
    return replace(run, forces=forces @ channels_of(read, SENSED).T), edited


def _rotations(recording: Recording, case: Case) -> Array:
    """R at every row of a recording, shape (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    if recording.struts is None:
        assert recording.rotations is not None
        return recording.rotations
    machine = machine_of(case)
    parts = (recording.struts[k : k + PIECE] for k in range(0, len(recording.struts), PIECE))
    still = (
        (
            part,
            machine.poses(part)
            if isinstance(machine, Hexapod)
            else machine.kinematics(part, 0.0 * part, 0.0 * part).pose,
        )
        for part in parts
    )
    return np.concatenate([Rotation.from_euler("xyz", pose[:, 3:]).as_matrix() for _, pose in still])


def _confirmed(entry: Tried, recording: Recording, case: Case, model: Model, evaluate: Evaluate) -> bool:
    """Whether the whole run, evaluated with the remedies, leaves no more than some instants did."""
    run, edited = mended(entry.trial, recording, case)
    try:
        fit, instants = evaluate(run, edited), instants_of(run, edited, identification_model(edited, model.number))
    except HexciteError:
        return False
    if instants is None:
        return False
    left = float(np.sqrt(np.mean((fit.residuals / instants.noise) ** 2)))
    return left <= max(CONFIRMED * entry.residuals, NEAR)


def words_of(trial: Trial) -> str:
    """What is wrong where a trial is right."""
    return ", and ".join(hypothesis.words for hypothesis in trial)


def remedy_of(trial: Trial, case: Case) -> str:
    """What to write into the case, or to do, where a trial is right."""
    keyed = tuple(hypothesis for hypothesis in trial if not hypothesis.remedy)
    keys = keys_to_write(case, case_of(keyed, case))
    return ", and ".join([*([keys] if keys else []), *(h.remedy for h in trial if h.remedy)])


def _keys(trial: Trial, case: Case) -> tuple[Remedy, ...]:
    """The keys that mend a trial; none where something beside them is to be done."""
    return () if any(h.remedy for h in trial) else remedy(words_of(trial), case, case_of(trial, case))


def _cause(confirmed: list[Tried], found: Search, case: Case) -> str:
    named = confirmed[:MOST_NAMED]
    left = named[0].left()
    before = None if found.recorded is None else found.recorded.left()
    words = " or ".join(words_of(entry.trial) for entry in named)
    if before is None or found.recorded is None or not np.isfinite(found.recorded.residuals):
        smaller = "small"
    else:
        smaller = f"{found.recorded.residuals / max(named[0].residuals, 1e-9):.3g} times smaller"
    noise = f"{left.newtons:.2g} N, where noise makes {left.noise:.2g} N"
    remedies = " or ".join(dict.fromkeys(remedy_of(entry.trial, case) for entry in named))
    return f"{words}: then residuals are {smaller} ({noise}); {remedies}"


def _tried(found: Search, case: Case) -> str:
    """What was tried without success."""
    drives = case.drive_words[0]
    families = ", ".join(family.format(drives=drives) for family in found.families)
    left = ""
    if found.recorded is not None and np.isfinite(found.recorded.residuals):
        before = found.recorded.left()
        left = f" residuals of {before.newtons:.2g} N, where noise makes {before.noise:.2g} N"
    least = ""
    if found.best is not None and found.best.trial:
        least = f"; least is left, {found.best.left().newtons:.2g} N, if {words_of(found.best.trial)}"
    alone = " alone, nor two of them," if found.pairs else ""
    return f"none of these{alone} explains{left or ' the run'}: {families}{least}"
