"""All models of one run side by side (Table 3), compared by what they predict of samples that are left out.

Deviations do not choose a model: one that lacks an effect has fewer parameters, smaller deviations, and wrong values.
Nor does s0 alone, which falls with every parameter. Here each contiguous block of samples, or of poses, is predicted
from the others (cross-validation); the model that predicts best is taken, or the smallest that is as good within one
standard error over the blocks (Hastie, Tibshirani & Friedman 2009, section 7.10).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from threadpoolctl import threadpool_limits

from cases.base.errors import Code, HexciteError, IdentificationError
from cases.base.options import default_of, documented
from cases.base.units import Array, as_html
from cases.schema import Case
from identification.estimation.estimators import Method
from identification.estimation.fit import Value, column_scale, triangle
from identification.fitting import FittedRun, fitted_run, refined
from identification.identify import default_model, standing_of
from identification.model.model import Model
from identification.options import POSES, AverageStandstills
from identification.recording.recording import Recording
from identification.results.estimate import estimate_of
from identification.results.identifiability import models_of
from identification.samples.clocks import on_one_clock
from identification.samples.making import evaluated_samples
from identification.samples.samples import GAUSS_MARKOV, Fitted, fit_samples
from identification.texts import aligned, legible, parameter_words, std_text, value_text

BLOCKS = 10  # contiguous, each predicted from the others
SMALL = 1e-12  # of the largest singular value, below which a block's neighbours do not determine a combination


@dataclass(frozen=True, slots=True)
class ModelRow:
    """One model of a run."""

    model: int  # its number
    count: int  # number of its parameters
    reason: str | None = None  # why it was not identified; None where it was
    s0: float = float("nan")  # (27), as of a result
    # rms of what it leaves of forces that it was not fitted to, behind the evaluation's filter; as s0 [N or 1]
    predicted: float = float("nan")
    worse: float = 0.0  # by how many standard errors over the blocks it predicts worse than the best
    parameters: Mapping[str, Value] | None = None  # physical parameters by name

    def to_json(self) -> dict[str, Any]:
        """Its entries."""
        values = None if self.parameters is None else {n: v._asdict() for n, v in self.parameters.items()}
        numbers = {"s0": self.s0, "predicted": self.predicted, "worse_by_standard_errors": self.worse}
        entries = {"reason": self.reason} if self.reason is not None else numbers
        return {"model": self.model, "count": self.count, **entries, "parameters": values}


@dataclass(frozen=True, slots=True, repr=False)
class ModelChoice:
    """All models of a run, and the one to prefer.

    >>> choice = hx.identify_models(hx.Recording.load("empty"))
    >>> choice.best, [row.model for row in choice.rows if row.predicted < 1.5]
    (9, [8, 9, 10])
    """

    rows: tuple[ModelRow, ...]
    best: int  # number of the model to prefer
    blocks: int  # number of blocks that were left out, one after the other
    of: str  # what a block holds

    @property
    def sentences(self) -> tuple[str, ...]:
        """Which model is preferred, and why."""
        rows = {row.model: row for row in self.rows if row.reason is None}
        preferred, others = rows[self.best], [row for number, row in rows.items() if number != self.best]
        way = f"{self.blocks} blocks of {self.of} were left out and predicted from the others"
        first = f"model {self.best}: it predicts them to {preferred.predicted:.3g}"
        better = [row for row in others if row.predicted < preferred.predicted]
        if better:
            most = min(better, key=lambda row: row.predicted)
            first += f"; model {most.model} with {most.count} parameters is not better beyond the scatter "
            first += f"({most.predicted:.3g})"
        else:
            first += ", the best of all"
        worse = sorted((r for r in others if r.predicted >= preferred.predicted), key=lambda row: row.predicted)
        clear = [r for r in worse if r.predicted > 1.01 * preferred.predicted]
        if clear:
            first += "; " + ", ".join(f"model {r.model} to {r.predicted:.3g}" for r in clear[:3])
        refused = (f"model {r.model} is not identified: {r.reason}" for r in self.rows if r.reason is not None)
        return way, first, *refused

    def to_json(self) -> dict[str, Any]:
        """Its entries for programs."""
        return {
            "best": self.best,
            "blocks": self.blocks,
            "of": self.of,
            "models": [row.to_json() for row in self.rows],
            "sentences": list(self.sentences),
        }

    def __repr__(self) -> str:
        """The models, each with s0 and prediction, and the one to prefer."""
        return "\n".join([*aligned(*figures_of(self.to_json())), *self.sentences])

    def __str__(self) -> str:
        """The same as Table 3, with the parameters of each."""
        return "\n".join([*aligned(*table_3(self.to_json())), "", repr(self)])

    _repr_html_ = as_html


def figures_of(entries: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """A row a model, the head first: parameters, s0, prediction, by how many standard errors worse."""
    rows: list[tuple[str, ...]] = [
        ("model", "parameters", "s0 (27)", "predicted, left out", "standard errors worse than best")
    ]
    for m in entries["models"]:
        name = f"{m['model']}{' (preferred)' if m['model'] == entries['best'] else ''}"
        if m["parameters"] is None:
            rows.append((name, str(m["count"]), "-", "-", "not identified"))
        else:
            cells = f"{m['s0']:.3g}", f"{m['predicted']:.3g}", f"{m['worse_by_standard_errors']:.2g}"
            rows.append((name, str(m["count"]), *cells))
    return rows


def table_3(entries: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Table 3: a row a parameter, the head first, and of each model that was identified value and deviation.

    Factors of each sensor (K1, K3, K4) are left out.
    """
    models = [m for m in entries["models"] if m["parameters"] is not None]
    names = dict.fromkeys(n for m in models for n in m["parameters"] if not n.startswith("K"))
    rows = [("parameter", *(f"model {m['model']}" for m in models))]
    for name in names:
        values = [m["parameters"].get(name) for m in models]
        scale, unit = legible(next(v["unit"] for v in values if v is not None))
        cells = []
        for v in values:
            std = 0.0 if v is None else max(v["std"], v["std_robust"]) * scale
            cells.append("-" if v is None else f"{value_text(v['value'] * scale, std)} ± {std_text(std)}")
        rows.append((f"{parameter_words(name)} [{unit}]", *cells))
    return rows


@documented()
def identify_models(
    recording: Recording,
    case: Case | None = None,
    *,
    how: Method | Callable[[Model], Method] = GAUSS_MARKOV,
    average_standstills: AverageStandstills = default_of(AverageStandstills),
    poses: Annotated[Array | None, POSES] = None,
) -> ModelChoice:
    """All models that a run can carry, with s0 and parameters each (Table 3), and the one that predicts best.

    Findings are not looked for: `identify` the model that is preferred.

    >>> choice = hx.identify_models(hx.Recording.load("empty"))
    >>> choice.best
    9
    >>> {row.model: round(row.s0) for row in choice.rows}
    {0: 17, 1: 16, 2: 17, 3: 15, 4: 15, 5: 15, 6: 4, 7: 4, 8: 1, 9: 1, 10: 1}

    Args:
        recording: the run.
        case: case of the machine; the recording's own unless given.
        how: what is known beforehand, and how channels are weighted; or what gives it for a model.
        OPTIONS

    Raises:
        IdentificationError: the run determines the parameters of no model.
        RecordingError: the run cannot be evaluated.
        CaseError: the case lacks what the evaluation needs.
    """
    case = recording.machine_case(case)
    run, _ = standing_of(on_one_clock(recording, case), case, poses, average_standstills)
    models, unit = carried(run, case), "poses" if run.t is None or case.setup == "1a" else "samples"
    with threadpool_limits(limits=1, user_api="blas"):
        fits = _fits(run, case, models, how)
        fitted = {number: fit for number, fit in fits.items() if isinstance(fit, Fitted)}
        if not fitted:
            first = next(fit for fit in fits.values() if isinstance(fit, HexciteError))
            raise IdentificationError(
                place=recording.source,
                problem=f"no model can be identified; the largest: {first.said.problem}",
                remedy=first.said.remedy,
                code=Code.NO_EXCITATION,
            )
        if len(next(iter(fitted.values())).regression.forces) < 2:
            raise IdentificationError(
                place=recording.source,
                problem="has one sample: models are compared by how they predict samples from others",
                remedy="record more standstills, or identify with one model",
                code=Code.TOO_FEW,
            )
        weights = fitted[max(fitted, key=lambda n: len(models[n].names))].w
        root = np.asarray(np.linalg.cholesky(weights).T)
        errors = {number: left_out(fit, root) for number, fit in fitted.items()}
    best = min(errors, key=lambda n: float(errors[n].mean()))
    worse = {number: _standard_errors(error - errors[best]) for number, error in errors.items()}
    preferred = min((n for n in errors if worse[n] <= 1.0), key=lambda n: (len(models[n].names), errors[n].mean()))
    rows = []
    for number, model in models.items():
        fit = fits[number]
        if not isinstance(fit, Fitted):
            rows.append(ModelRow(number, len(model.names), fit.problem))
            continue
        estimate = estimate_of(fit, recording.source, case, ())
        rms = float(np.sqrt(errors[number].mean() / 6.0))
        rows.append(ModelRow(number, len(model.names), None, estimate.s0, rms, worse[number], estimate.physical))
    return ModelChoice(tuple(rows), preferred, len(errors[best]), unit)


def carried(run: Recording, case: Case) -> dict[int, Model]:
    """The models that a run, whose standstills are averaged already, can be evaluated by, by number."""
    moves, has_positions, usual = (
        run.t is not None and case.setup != "1a",
        run.drives is not None,
        default_model(run, case),
    )
    models = models_of(case)
    if not moves:
        return {n: m for n, m in models.items() if not m.needs_motion and (has_positions or not m.needs_position)}
    return {n: m for n, m in models.items() if has_positions or n == usual or not m.needs_position}


def _fits(
    run: Recording, case: Case, models: Mapping[int, Model], how: Method | Callable[[Model], Method]
) -> dict[int, Fitted | HexciteError]:
    """The fit of each model to the same samples, or why there is none.

    Contact is looked for with the largest model: to a smaller one all that it lacks may look like a push.
    """
    fits: dict[int, Fitted | HexciteError] = {}
    first: FittedRun | None = None
    for number, model in sorted(models.items(), key=lambda item: -len(item[1].names)):
        try:
            method = how if isinstance(how, Method) else how(model)
            if first is None:
                first = fitted_run(run, case, model, method)
                fits[number] = first.fitted
                continue
            samples = evaluated_samples(first.clean, case, model)
            samples = samples.without(~np.isin(samples.t, first.fitted.samples.t))
            delay = None if first.fitted.samples.wide is None else first.fitted.delay
            fits[number] = refined(fit_samples(samples, method, case.sensors, fixed_delay=delay))
        except HexciteError as error:  # also of a known value that this model does not have
            fits[number] = error
    return {number: fits[number] for number in models}


def left_out(fitted: Fitted, root: Array) -> Array:
    """Mean over samples of the squared errors, summed over channels, of each block predicted from the others.

    Args:
        fitted: fit whose regression is divided into contiguous blocks.
        root: root of W, shape (6, 6).
    """
    regression, selection = fitted.regression, fitted.method.selection(fitted.samples.model)
    unknowns = len(selection.offset)
    columns = regression.regressors
    right = regression.forces - columns[:, :, :unknowns] @ selection.offset
    columns = np.dstack([columns[:, :, :unknowns] @ selection.basis, columns[:, :, unknowns:]])
    blocks = np.array_split(np.arange(len(right)), min(BLOCKS, len(right)))
    rows = [
        np.dstack([root @ columns[b], (right[b] @ root.T)[:, :, None]]).reshape(-1, columns.shape[2] + 1)
        for b in blocks
    ]
    tops = [triangle(block) for block in rows]
    errors = []
    for k, block in enumerate(rows):
        others = np.vstack([top for j, top in enumerate(tops) if j != k])
        scale = column_scale(others[:, :-1])
        values = scale * np.linalg.lstsq(others[:, :-1] * scale, others[:, -1], rcond=SMALL)[0]
        misses = block[:, -1] - block[:, :-1] @ values
        errors.append(float(np.sum(misses**2)) / (len(misses) / 6))
    return np.array(errors)


def _standard_errors(differences: Array) -> float:
    """By how many standard errors the mean of some differences between blocks is above zero."""
    mean, error = float(differences.mean()), float(differences.std(ddof=1) / np.sqrt(len(differences)))
    return 0.0 if mean <= 0.0 else mean / error if error > 0.0 else float("inf")
