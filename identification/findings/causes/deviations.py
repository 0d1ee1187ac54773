"""Sizes of hypotheses found anew on the whole run, with standard deviations, and what they would make uncertain.

Least squares over the instants of a search find a size; here its effect on the forces, and so on the parameters, is
taken from a fit of the whole run with a size a little larger. What residuals still show of the effect corrects the
size, and the noise that they show is its deviation (`alternatives.sizes_of`). A size that is written into the case
counts as known from then on. Where its deviation moves a parameter by more than that parameter's own deviation, the
case would give wrong numbers: such a size is to be measured otherwise.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from cases.base.errors import HexciteError
from cases.base.phrases import NOTHING, Phrase, phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.alternatives import sizes_of
from identification.findings.causes.hypothesis import Hypothesis, Size, Trial, pace_of
from identification.findings.remains import remainder_of
from identification.model.parameters import physical_form
from identification.recording.recording import Recording
from identification.samples.samples import Fitted
from identification.texts import legible, std_text

LOOSE = 1.0  # deviations of a parameter by which the deviation of a size may move it, to be written into the case


class Evaluate(Protocol):
    """Fits a run with another case."""

    def __call__(self, run: Recording, case: Case, robust: bool = True) -> Fitted:
        """The fit; `robust`: whether its deviations are looked at, which allow for noise with memory then."""


Mended = Callable[[Trial], tuple[Recording, Case]]
"""The run and the case as they are where a trial is right."""


@dataclass(frozen=True, slots=True)
class Certainty:
    """How surely the sizes of a trial are known."""

    covariance: Array  # of the sizes that were found, in the order of the trial, shape (k, k)
    # what their deviations would make of a parameter, where that is too much; empty where it is not
    loose: Phrase = NOTHING


@dataclass(frozen=True, slots=True)
class _Place:
    """One of the sizes of a trial."""

    hypothesis: int  # number of the hypothesis in the trial
    value: int  # number of the size's value
    nudge: float


def sized(trial: Trial) -> bool:
    """Whether a trial has sizes that a run can show."""
    return bool(_places(trial))


def _places(trial: Trial) -> list[_Place]:
    return [_Place(i, k, s.nudges[k]) for i, h in enumerate(trial) if (s := h.size) is not None for k in s.free]


def certain(trial: Trial, fitted: Fitted, mended: Mended, evaluate: Evaluate) -> tuple[Trial, Certainty | None]:
    """A trial whose sizes are those that the whole run shows, with deviations in its words, and their certainty.

    The trial as it is, and None, where it has no size, or where the run does not show how its forces follow from it.

    Args:
        trial: the trial.
        fitted: the fit to the whole run with it.
        mended: run and case of a trial.
        evaluate: fits the whole run.
    """
    if not sized(trial):
        return trial, None
    places = _places(trial)
    effects = [_effect(trial, place, fitted, mended, evaluate) for place in places]
    columns = [effect[0] for effect in effects if effect is not None]
    if len(columns) < len(places):
        return trial, None
    sizes = sizes_of(np.stack(columns, axis=2), remainder_of(fitted))
    if sizes is None:
        return trial, None
    covariance = sizes.noise.covariance
    answer = np.stack([effect[1] for effect in effects if effect is not None], axis=1)
    better = _moved(trial, places, sizes.values)
    with suppress(HexciteError):
        again = evaluate(*_as_filtered(better, trial, mended))
        if again.fit.residuals.shape == fitted.fit.residuals.shape and _left(again, fitted) < _left(fitted, fitted):
            trial, fitted = better, again
    return _stated(trial, places, covariance), Certainty(covariance, _loose(fitted, answer, covariance))


def deviations_of(values: Callable[[Trial], Sequence[Array]], trial: Trial, certainty: Certainty) -> list[Array]:
    """Standard deviations of values that follow from the sizes of a trial, shapes as theirs."""
    places, slopes = _places(trial), []
    for place in places:
        low, high = (values(_moved(trial, [place], np.array([sign * place.nudge]))) for sign in (-1.0, 1.0))
        slopes.append([(b - a) / (2.0 * place.nudge) for a, b in zip(low, high, strict=True)])
    each = [np.stack(of_value, axis=-1) for of_value in zip(*slopes, strict=True)]
    return [np.sqrt(np.einsum("...i,ij,...j->...", slope, certainty.covariance, slope)) for slope in each]


def _effect(
    trial: Trial, place: _Place, fitted: Fitted, mended: Mended, evaluate: Evaluate
) -> tuple[Array, Array] | None:
    """Effect of a unit of a size on the forces, shape (n, 6), and on the values of the fit; None where not known."""
    try:
        other = evaluate(*_as_filtered(_moved(trial, [place], np.array([place.nudge])), trial, mended), robust=False)
    except HexciteError:
        return None
    if other.fit.residuals.shape != fitted.fit.residuals.shape or len(other.fit.values) != len(fitted.fit.values):
        return None
    change = fitted.fit.residuals - other.fit.residuals, other.fit.values - fitted.fit.values
    return change[0] / place.nudge, change[1] / place.nudge


def _as_filtered(trial: Trial, base: Trial, mended: Mended) -> tuple[Recording, Case]:
    """Run and case of a trial, with a filter that reaches over as many samples as with another trial.

    At another pace of the clock the same cut-off would pass more or less of the noise: the pace at which it passes
    least would seem to fit best.
    """
    run, case = mended(trial)
    ratio, cutoff = pace_of(trial) / pace_of(base), case.recording.filter_cutoff_Hz
    if ratio == 1.0 or cutoff is None:
        return run, case
    form = case.recording.model_copy(update={"filter_cutoff_Hz": cutoff / ratio})
    return run, case.model_copy(update={"recording": form})


def _moved(trial: Trial, places: Sequence[_Place], steps: Array) -> Trial:
    """A trial with sizes changed by steps, shape (k,)."""
    moved = list(trial)
    for place, step in zip(places, steps, strict=True):
        hypothesis = moved[place.hypothesis]
        assert hypothesis.size is not None
        values = hypothesis.size.values.copy()
        values[place.value] += step
        moved[place.hypothesis] = _of_size(hypothesis, hypothesis.size._replace(values=values))
    return tuple(moved)


def _of_size(hypothesis: Hypothesis, size: Size, stds: Sequence[float] | None = None) -> Hypothesis:
    other = size.make(size.values, stds)
    return hypothesis if other is None else replace(other, size=size)


def _stated(trial: Trial, places: Sequence[_Place], covariance: Array) -> Trial:
    """A trial whose words state the deviations of its sizes."""
    hypotheses = list(trial)
    for i, hypothesis in enumerate(trial):
        if (size := hypothesis.size) is None:
            continue
        columns = [k for k, place in enumerate(places) if place.hypothesis == i]
        slopes = []
        for k in columns:
            step = np.zeros(len(size.values))
            step[places[k].value] = 0.01 * places[k].nudge
            slopes.append((size.stated(size.values + step) - size.stated(size.values - step)) / (2.0 * step.max()))
        slope = np.stack(slopes, axis=1)
        stds = np.sqrt(np.einsum("ji,ik,jk->j", slope, covariance[np.ix_(columns, columns)], slope))
        hypotheses[i] = _of_size(hypothesis, size, [float(std) for std in stds])
    return tuple(hypotheses)


def _left(fitted: Fitted, by: Fitted) -> float:
    """Squares of the residuals of a fit, weighted as another fit weights them."""
    return float(np.einsum("ni,ij,nj->", fitted.fit.residuals, by.w, fitted.fit.residuals))


def _loose(fitted: Fitted, answer: Array, covariance: Array) -> Phrase:
    """What the deviations of sizes make of the parameter that they move most, beside its own deviation."""
    model = fitted.samples.model
    parameters, fit, form = slice(len(model.names)), fitted.fit, physical_form(model)
    moved = answer[parameters] @ covariance @ answer[parameters].T
    of_sizes = np.sqrt(np.maximum(np.diag(form.of(fit.values[parameters], moved)[1]), 0.0))
    by_noise = [
        np.diag(form.of(fit.values[parameters], c[parameters, parameters])[1])
        for c in (fit.covariance, fit.covariance_robust)
    ]
    reported = np.sqrt(np.maximum(*by_noise))
    some = reported > 0.0
    ratios = np.where(some, of_sizes / np.where(some, reported, 1.0), 0.0)
    worst = int(np.argmax(ratios))
    if not ratios[worst] > LOOSE:
        return NOTHING
    parameter = form.parameters[worst]
    factor, unit = legible(parameter.unit)
    return phrase(
        "would_be_off",
        "{name} would be off by {off} {unit} where {reported} {unit} would be reported",
        name=parameter.name,
        off=std_text(factor * of_sizes[worst]),
        reported=std_text(factor * reported[worst]),
        unit=unit,
    )
