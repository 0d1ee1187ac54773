"""Sensor offsets identified anew from a standstill without contact, with deviations that follow from both runs."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, IdentificationError
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.standing_mean import StandingMean, standing_mean
from identification.finding import Finding, Kind, changed_cases, note
from identification.findings.left_out import LeftOut
from identification.findings.noise_level import channel_words
from identification.findings.off_case import without
from identification.model.parameters import offset_columns
from identification.recording.recording import Recording
from identification.results.budgets import budget_rows
from identification.results.estimate import entries_of_parameters, physical_values, rows_of
from identification.results.expected_errors import effects_in, errors_of, random_of
from identification.results.result import Result
from identification.samples.clocks import on_one_clock
from identification.samples.moving_window import NOISY
from identification.samples.samples import Standstills
from identification.samples.standstills import standstills
from identification.signals import white_noise

DRIFTED = 3.0  # standard deviations by which an offset is another one


def drifted_since(change: Array, std: Array, case: Case, source: str) -> list[Finding]:
    """A note where a tare finds other offsets than a result, `source`.

    By the change of the offsets, shape (6,) [N, or N and N m], and its standard deviation.
    """
    sure = np.abs(change) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(sure))
    if not sure[worst] > DRIFTED:
        return []
    channel, unit = channel_words(case, worst)
    sentence = f"the offset of {channel} has drifted by {change[worst]:+.2g} {unit} ({sure[worst]:.0f} standard "
    return [note(Kind.OFFSETS, f"{sentence}deviations) since {source}: what was computed with that is off by it")]


STILL = 1e-4  # [m or rad] that drives may move in a standstill, beside the noise of their encoders
FEW = 10  # samples of a standstill that show how tolerances act at its pose, and whether noise remembers


def tare(recording: Recording, result: Result) -> Result:
    """The result with sensor offsets f_q0 (11) identified anew from a standstill without contact; all else stays.

    >>> result = hx.Result.load("empty-result")
    >>> tared = hx.tare(hx.read("still.csv", hx.load_case("hexapod")), result)
    >>> sorted(tared.record.tared["f1_N"])
    ['after', 'before', 'change_std', 'unit']
    >>> tared["m"] == result["m"]
    True

    Offsets are off by noise of the standstill, and by what all else is off at its pose: by noise of its run, and by
    tolerances of the case, whose effects on the forces there and on the parameters cancel where the pose is like those
    of that run. `record.tared` holds the offset of each channel before and after; a note says which has drifted.

    Raises:
        IdentificationError: the machine moves, or there are fewer than two samples.
        FileProblem: parameters of another case.
    """
    model = result.model
    recording, case = without(on_one_clock(recording, result.case), result.case, result.sizes)
    count = int(np.sum(~recording.bad))
    if count < 2:
        raise IdentificationError(
            place=recording.source,
            problem=phrase("one_sample", "{count} sample", count=count),
            remedy=phrase("tare_needs", "a tare needs a standstill of two or more"),
            code=Code.TOO_FEW,
        )
    _require_still(recording, case)
    still = standstills(recording, case, model)
    residuals = still.recorded - still.matrices @ result.values
    change, offsets = residuals.mean(axis=0), offset_columns(model)
    values = result.values
    values[offsets] += change
    scatter = standing_mean(residuals) if count >= FEW else StandingMean.of_white_noise(residuals)
    moved = _with_new_offsets(result, still, case, (scatter.white, scatter.covariance))
    std = moved.change_std
    drift = drifted_since(change, std, case, result.source)
    physical, stale = physical_values(model, values, moved.white, moved.robust), recording.remarks + result.remarks
    findings = [_finding_after(finding, moved, values, result) for finding in result.findings]
    record = result.record.replaced(
        **entries_of_parameters(physical, values, moved.white, moved.robust),
        findings=(*findings, *drift, *_short_for_its_noise(scatter), *changed_cases(stale)),
        tared_with=str(recording.paths[0]) if recording.paths else recording.source,
        tared={
            channel_words(case, k)[0]: {
                "before": float(result.values[place]),
                "after": float(values[place]),
                "change_std": float(std[k]),
                "unit": channel_words(case, k)[1],
            }
            for k, place in enumerate(offsets)
        },
        **({"tolerance_biases": rows_of(moved.biases)} if moved.biases else {}),
        **({"stale": stale} if stale else {}),
    )
    nearest = Result(result.case, record.replaced(physical=None)).physical
    # the same body; what is correlated with it moves by other amounts
    body = nearest if nearest is not None and nearest.moved else None
    return Result(result.case, record.replaced(physical=body))


def _require_still(recording: Recording, case: Case) -> None:
    """Raises IdentificationError where drives move by more than they do in a standstill."""
    travel = 0.0 if recording.drives is None else float(np.ptp(recording.drives[~recording.bad], axis=0).max())
    noise = 0.0 if recording.drives is None else float(white_noise(recording.drives).max())
    if travel > STILL + NOISY * noise:
        drives, unit = case.drive_words
        most = (STILL + NOISY * noise) * 1e3
        raise IdentificationError(
            place=recording.source,
            problem=phrase(
                "moves_in_tare",
                "{drives} move by {travel} {unit}, at most {most} {unit_2} in a standstill",
                drives=drives,
                travel=f"{travel * 1000.0:.3g}",
                unit=unit,
                most=f"{most:.3g}",
                unit_2=unit,
            ),
            remedy=phrase("cut_motion", "cut the motion off"),
            code=Code.MISFIT,
        )


class _Moved(NamedTuple):
    """What u with new offsets is off by."""

    white: Array  # covariance by (28) and the white noise of the standstill, shape (u, u)
    random: Array  # covariance by all but tolerances, shape (u, u)
    biases: Mapping[str, Array]  # as of a result
    scores: Array | None  # as `LeftOpen.of_values`; None where no sizes were told
    change_std: Array  # of the change of each offset where none has drifted, shape (6,)

    @property
    def robust(self) -> Array:
        """Covariance by all that counts, shape (u, u)."""
        return np.asarray(self.random + sum((b @ b.T for b in self.biases.values()), np.zeros_like(self.random)))


def _with_new_offsets(result: Result, still: Standstills, case: Case, scatter: tuple[Array, Array]) -> _Moved:
    """Errors of u where offsets make a standstill read what it reads.

    Args:
        result: parameters before.
        still: the standstill.
        case: case of the machine as its run told it.
        scatter: covariance of the means of the channels by white noise, and with memory, shapes (6, 6).
    """
    offsets, matrix = offset_columns(result.model), still.matrices.mean(axis=0)
    others = matrix.copy()
    others[:, offsets] = 0.0
    effects: dict[str, Array] = {}
    if still.standing is not None:
        rows = np.unique(np.linspace(0, len(still.t) - 1, FEW).astype(int))
        motion = still.standing.at(rows)
        in_use = LeftOut.in_use(result.model, motion, result.values, np.zeros((len(rows), 6)), case)
        effects = {key: of.mean(axis=0) for key, of in effects_in(in_use, result).items()}
    errors, open_ = errors_of(result, others, effects), result.left_open
    by_scores, by_values = -errors.of_values, np.eye(len(result.values))
    by_scores[offsets], by_values[offsets] = errors.scores, -others
    covariances = []
    for robust, covariance in enumerate((result.covariance, random_of(result))):
        noise = np.zeros((0, 0)) if open_ is None else open_.noise_of(bool(robust))
        plain = covariance - errors.of_values @ noise @ errors.of_values.T
        new = by_scores @ noise @ by_scores.T + by_values @ plain @ by_values.T
        new[np.ix_(offsets, offsets)] += scatter[robust]
        covariances.append((new + new.T) / 2.0)
    biases = {}
    for key, before in result.biases.items():
        biases[key] = before.copy()
        biases[key][offsets] = errors.by_tolerance[key]
    change = sum(errors_of(result, matrix, effects).variances.values(), np.diag(scatter[1]))
    return _Moved(covariances[0], covariances[1], biases, None if open_ is None else -by_scores, np.sqrt(change))


def _short_for_its_noise(scatter: StandingMean) -> list[Finding]:
    """A note where much of the variance of the means is of noise of which a standstill shows little."""
    if not scatter.short:
        return []
    sentence = phrase(
        "slow_noise_standing",
        "the standstill is short for what its noise remembers: {share} % of the variance of its means is of noise that "
        "lasts for a quarter of it or longer; +- of the offsets is so much larger, and still too small where noise "
        "lasts longer than the standstill; record several times as long, or find what drifts",
        share=f"{100.0 * scatter.slow:.0f}",
    )
    return [note(Kind.NOISE, sentence, slow_noise=scatter.slow)]


def _finding_after(finding: Finding, moved: _Moved, values: Array, result: Result) -> Finding:
    """A finding of the result before, with what new offsets change in its entries."""
    entries = dict(finding.quantity)
    if "told_left_open" in entries and result.left_open is not None and moved.scores is not None:
        entries["told_left_open"] = result.left_open._replace(of_values=moved.scores).to_json()
    if "budget" in entries:
        rows = budget_rows(result.model, values, moved.white, moved.random, moved.biases)
        offsets = {result.model.names[k] for k in offset_columns(result.model)}
        entries["budget"] = {
            name: dict.fromkeys(parts, 0.0) | rows[name] if name in offsets else parts
            for name, parts in entries["budget"].items()
        }
    return replace(finding, quantity=entries)
