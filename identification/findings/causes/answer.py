"""What is said of a run that something speaks against: its cause with the remedy, or what was tried and what it left.

A cause is said only after its remedy was tried: the whole run is evaluated as it would be with it.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cases.base.errors import HexciteError, Remedy
from cases.base.phrases import Phrase, enumerated, phrase, said
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.findings.causes.deviations import Certainty, Evaluate, certain, deviations_of, sized
from identification.findings.causes.explanations import MODERATE, NEAR, Tried
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
from identification.findings.causes.remedies import Deviations, Path, Places, keys_to_write, numbers_of, remedy
from identification.findings.causes.search import Search, search
from identification.findings.causes.steps import Following, Step
from identification.findings.causes.tables_of_files import as_one_table, places_in_tables
from identification.machines.hexapod import Hexapod
from identification.machines.of_case import machine_of
from identification.model.model import Model, identification_model
from identification.recording.formats.reading import tables_of_columns
from identification.recording.recording import Recording
from identification.samples.sample_checks import scan
from identification.samples.samples import Fitted

MOST_NAMED = 3  # explanations that a sentence names
CONFIRMED = 2.0  # times the residuals at some instants that those of the whole run may have
PIECE = 20_000  # rows whose orientation is computed at a time


@dataclass(frozen=True, slots=True)
class Answer:
    """A sentence about the cause of a run's residuals."""

    named: bool  # whether the cause is known; else the sentence says what was tried
    sentence: Phrase
    # whether residuals are so large that there is a mistake; smaller ones a machine makes itself, by its structure
    large: bool = True
    remedies: tuple[Remedy, ...] = ()  # keys of the case for each explanation that keys alone mend


@dataclass(frozen=True, slots=True)
class Cause:
    """An explanation that the whole run confirms."""

    entry: Tried
    trial: Trial  # with sizes as the whole run shows them
    certainty: Certainty | None  # of these sizes; None where it has none, or where they are not known

    @property
    def words(self) -> Phrase:
        """What is wrong, sizes with their standard deviations."""
        return words_of(self.trial)

    @property
    def loose(self) -> str:
        """Why its sizes are not to be written into the case; empty where they may be."""
        return "" if self.certainty is None else self.certainty.loose


def answer(recording: Recording, case: Case, model: Model, evaluate: Evaluate, fit: Fit | None = None) -> Answer | None:
    """The cause of a run's residuals, or what was tried; None where nothing needs or has an explanation.

    Args:
        recording: a run that something speaks against, as it was read.
        case: the case that it was read with.
        model: model that its forces are compared with.
        evaluate: fits a run as this one is fitted; raises HexciteError where it cannot.
        fit: the fit to it, where there is one: samples in contact are not in its residuals.
    """
    tables = dict[str, int]()
    with suppress(HexciteError):  # files that are no longer there
        tables = tables_of_columns(recording.paths, case)
    case = as_one_table(case, tables)

    def places(path: Path) -> list[Path]:
        return places_in_tables(path, tables)

    clean = recording
    with suppress(HexciteError):
        clean = scan(recording, case).recording
    following = Following()
    explanation = search(clean, case, model, fit, following)
    if explanation is None or explanation.sound:
        return None
    if explanation.explanations:
        following.at(Step.WHOLE)
    causes = causes_of(explanation, recording, case, model, evaluate)
    if causes:
        return Answer(
            True,
            _named(causes, explanation, case, places),
            remedies=tuple(r for c in causes for r in _keys(c, case, places)),
        )
    if not explanation.families:
        return None
    large = explanation.recorded is None or explanation.recorded.residuals > MODERATE
    return Answer(False, _tried(explanation, case), large)


def causes_of(found: Search, recording: Recording, case: Case, model: Model, evaluate: Evaluate) -> list[Cause]:
    """The explanations of a search that the whole run confirms, the best first, with sizes as it shows them.

    Args:
        found: the search.
        recording: as of `answer`, and so the others.
        case: the case.
        model: the model.
        evaluate: the fit.
    """
    causes: list[Cause] = []
    for entry in found.explanations:
        fitted = _confirmed(entry, recording, case, model, evaluate)
        if fitted is not None and len(causes) < MOST_NAMED:
            sizes = certain(entry.trial, fitted, lambda trial: mended(trial, recording, case), evaluate)
            causes.append(Cause(entry, *sizes))
    return causes


def mended(trial: Trial, recording: Recording, case: Case) -> tuple[Recording, Case]:
    """The run and the case as they are where the remedies of a trial are followed."""
    for hypothesis in trial:
        if hypothesis.recorded is not None:
            recording = hypothesis.recorded(recording, case) or recording
    read = tuple(hypothesis for hypothesis in trial if hypothesis.place == "recording")
    forces = recording.forces @ channels_of(read, RECORDED).T
    struts, t = recording.drives, recording.t
    if struts is not None:
        struts = drives_of(read, struts.shape[1]).of(struts)
    if t is not None and pace_of(read) != 1.0:
        t = t * pace_of(read)
    edited = case_of(trial, case)
    run = replace(recording, forces=forces, drives=struts, t=t)
    if any(hypothesis.in_base for hypothesis in trial):
        # the controller turned the wrench as if the sensor were as the case says
        turns = _rotations(run, case_of(tuple(h for h in trial if h.family is not Family.SENSOR), case))
        forces = np.einsum("nji,nbj->nbi", turns, forces.reshape(-1, 2, 3)).reshape(-1, 6)
    return replace(run, forces=forces @ channels_of(read, SENSED).T), edited


def _rotations(recording: Recording, case: Case) -> Array:
    """R at every row of a recording, shape (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    if recording.drives is None:
        assert recording.rotations is not None
        return recording.rotations
    machine = machine_of(case)
    parts = (recording.drives[k : k + PIECE] for k in range(0, len(recording.drives), PIECE))
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


def _confirmed(entry: Tried, recording: Recording, case: Case, model: Model, evaluate: Evaluate) -> Fitted | None:
    """The fit to the whole run with the remedies; None where it leaves more than some instants did."""
    run, edited = mended(entry.trial, recording, case)
    try:
        fitted = evaluate(run, edited, robust=sized(entry.trial))  # deviations of sizes follow from it
        instants = instants_of(run, edited, identification_model(edited, model.number))
    except HexciteError:
        return None
    if instants is None:
        return None
    residual = float(np.sqrt(np.mean((fitted.fit.residuals / instants.noise) ** 2)))
    return fitted if residual <= max(CONFIRMED * entry.residuals, NEAR) else None


def words_of(trial: Trial) -> Phrase:
    """What is wrong where a trial is right."""
    return enumerated("and", [hypothesis.words for hypothesis in trial])


def _remedy_of(trial: Trial, case: Case, deviations: Deviations | None, places: Places) -> Phrase:
    """What to write into the case, or to do, where a trial is right."""
    keyed = tuple(hypothesis for hypothesis in trial if not hypothesis.remedy)
    keys = keys_to_write(case, case_of(keyed, case), deviations, places)
    return enumerated("and", [*([keys] if keys else []), *(h.remedy for h in trial if h.remedy)])


def _keys(cause: Cause, case: Case, places: Places) -> tuple[Remedy, ...]:
    """The keys that mend a cause; none where something beside them is to be done, or its sizes are not surely known."""
    trial = cause.trial
    if any(h.remedy for h in trial) or cause.loose:
        return ()
    return remedy(words_of(trial), case, case_of(trial, case), _deviations(cause, case), places)


def _deviations(cause: Cause, case: Case) -> Deviations | None:
    """Standard deviations of what the remedy of a cause writes; None where they are not known."""
    certainty = cause.certainty
    if certainty is None:
        return None
    return lambda places: deviations_of(lambda trial: numbers_of(case_of(trial, case), places), cause.trial, certainty)


def _what_to_do(cause: Cause, case: Case, places: Places) -> Phrase:
    """The remedy of a cause, or why its sizes are not to be written into the case."""
    if not cause.loose:
        return _remedy_of(cause.trial, case, _deviations(cause, case), places)
    words = "too loosely known to be written into the case ({why}): measure it at the machine and write that"
    return phrase("too_loose", words, why=said(cause.loose))


def _named(causes: list[Cause], found: Search, case: Case, places: Places) -> Phrase:
    named = [cause.entry for cause in causes]
    residual = named[0].residual_forces()
    before = None if found.recorded is None else found.recorded.residual_forces()
    words = enumerated("or", [cause.words for cause in causes])
    if before is None or found.recorded is None or not np.isfinite(found.recorded.residuals):
        smaller = phrase("small", "small")
    else:
        times = f"{found.recorded.residuals / max(named[0].residuals, 1e-9):.3g}"
        smaller = phrase("times_smaller", "{times} times smaller", times=times)
    return phrase(
        "cause",
        "{words}: then residuals are {smaller} ({newtons} N, where noise makes {noise} N); {remedies}",
        words=words,
        smaller=smaller,
        newtons=f"{residual.newtons:.2g}",
        noise=f"{residual.noise:.2g}",
        remedies=enumerated("or", list(dict.fromkeys(_what_to_do(cause, case, places) for cause in causes))),
    )


def _tried(found: Search, case: Case) -> Phrase:
    """What was tried without success."""
    drives = phrase(case.drive_words[0], case.drive_words[0])
    families = enumerated("comma", [phrase(f"family_{f.name.lower()}", f.value, drives=drives) for f in found.families])
    if found.recorded is not None and np.isfinite(found.recorded.residuals):
        before = found.recorded.residual_forces()
        phrase_of_residual = phrase(
            "residuals_of",
            "residuals of {newtons} N, where noise makes {noise} N",
            newtons=f"{before.newtons:.2g}",
            noise=f"{before.noise:.2g}",
        )
    else:
        phrase_of_residual = phrase("the_run", "the run")
    if found.pairs:
        nothing = phrase(
            "not_two",
            "none of these alone, nor two of them, explains {left}: {tried}",
            left=phrase_of_residual,
            tried=families,
        )
    else:
        nothing = phrase("not_one", "none of these explains {left}: {tried}", left=phrase_of_residual, tried=families)
    if found.best is None or not found.best.trial:
        return nothing
    return phrase(
        "least_left",
        "{nothing}; least is left, {newtons} N, if {words}",
        nothing=nothing,
        newtons=f"{found.best.residual_forces().newtons:.2g}",
        words=words_of(found.best.trial),
    )
