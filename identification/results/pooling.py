"""One estimate of several runs of the same thing, and whether their scatter is what their deviations promise.

Each run has noise of its own; what the machine is off its case by, all have in common: u_i = u + e_i + B_i p, cov e_i =
R_i, p ~ (0, 1). The mean weighs runs by R_i^-1, as least squares of all samples together would, so that u is off by the
mean of B_i p, counted once. Runs are compared by chi^2 of u_i in their whole covariance, R_i and B_i B_j^T.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple, Protocol

import numpy as np
from scipy.linalg import block_diag
from scipy.special import chdtrc

from cases.base.errors import Code, FileProblem, HexciteError, option
from cases.base.phrases import Phrase, phrase
from cases.base.provenance import provenance
from cases.base.units import Array
from cases.basis import differing
from identification.estimation.covariances import Free, larger_of
from identification.estimation.fit import Value
from identification.finding import Finding, Kind, note, warning
from identification.model.model import Model
from identification.model.parameters import physical_form
from identification.results.budgets import budget_rows
from identification.results.estimate import ResultEntries, entries_of_parameters, physical_values, rows_of
from identification.results.result import Result
from identification.texts import parameter_words

UNLIKELY = 0.01  # chance of a scatter by noise, below which deviations grow by it


def pool(results: Sequence[Result]) -> Result:
    """One result of several runs of the same machine with the same load: their generalised mean.

    >>> first = hx.Result.load("empty-result")
    >>> second = hx.identify(hx.run("run.mpf", hx.load_case("hexapod"), seed=5))
    >>> both = hx.pool([first, second])
    >>> [f"{result['m'].value:.3f} +- {result['m'].reported:.3f} kg" for result in (first, second, both)]
    ['31.826 +- 0.007 kg', '31.834 +- 0.007 kg', '31.830 +- 0.005 kg']

    Tolerances of the case, which all runs have in common, are counted once: more runs do not average them out. Where
    runs scatter more than their deviations promise, deviations grow by that; `record.pooled` and the findings say so,
    and which run differs from the others.

    Raises:
        HexciteError: fewer than two results.
        FileProblem: two differ in machine, model, what was known or load, or are of the same recording.
    """
    if len(results) < 2:
        raise HexciteError(
            place="pool",
            problem=phrase("one_result", "{count} result", count=len(results)),
            remedy=phrase("two_results", "name two results or more of the same machine and load"),
            code=Code.TOO_FEW,
        )
    require_alike(results)
    first = results[0]
    runs = _Runs.of(results)
    mean, all_agree = runs.mean(), runs.agreement(range(len(results)))
    growth = all_agree.ratio if all_agree.chance < UNLIKELY else 1.0
    u, random, white = mean.values, growth**2 * mean.random, growth**2 * mean.white
    robust = random + sum((b @ b.T for b in mean.biases.values()), np.zeros_like(random))
    model = first.model
    physical = physical_values(model, u, white, robust)
    names = [result.source for result in results]
    scatter = _scatter_by_parameter(model, u, runs)
    others = runs.without_each() if len(results) > 2 else ()
    findings = [*_agreement_findings(names, all_agree, others, scatter), *_of_runs(results)]
    findings += _budget(first, model, u, white, random, mean.biases)
    pooled = {
        "results": [
            {"result": r.source, "recording": r.record.recording, "chi2_share": share}
            for r, share in zip(results, all_agree.shares, strict=True)
        ],
        **all_agree.to_json(),
        "deviations_multiplied_by": growth,
        "parameters": scatter,
        "without": [a.to_json() for a in others],
    }
    entries = first.record.replaced(
        **_entries_of_runs([result.record for result in results]),
        **entries_of_parameters(physical, u, white, robust),
        **({"tolerance_biases": rows_of(mean.biases)} if mean.biases else {}),
        findings=tuple(findings),
        pooled=pooled,
    )
    of_one_run = {"run", "standstills", "models", "treatment", "tared", "tared_with", "plan_hash", "physical"}
    of_one_run |= set() if all(result.record.channel_noise for result in results) else {"channel_noise"}
    of_mean = {name: getattr(entries, name) for name in entries.model_fields_set - of_one_run}
    remarks = tuple(dict.fromkeys(x for r in results for x in r.remarks))
    return Result(first.case, type(entries)(**of_mean), remarks=remarks).beside_physical()


def _entries_of_runs(records: Sequence[ResultEntries]) -> dict[str, Any]:
    """Entries of all runs together: sums of what is counted, means of noise and residuals by numbers of samples."""
    weights = np.array([record.samples for record in records], dtype=float)

    def together(values: Sequence[float]) -> float:
        return float(np.sqrt(np.average(np.square(values), weights=weights)))

    return {
        "recording": ", ".join(record.recording for record in records),
        "inputs": tuple(entry for record in records for entry in record.inputs),
        "versions": provenance(())["versions"],
        "measuring_s": sum(record.measuring_s or 0.0 for record in records),
        "delay_s": _mean_delay(records),
        "s0": together([record.s0 for record in records]),
        "white_noise": together([record.white_noise for record in records]),
        "s0_N": together([record.s0_N for record in records]),
        "residual_rms": tuple(
            together(column) for column in zip(*(record.residual_rms for record in records), strict=True)
        ),
        **_noise_of_channels(records, weights),
        "samples": sum(record.samples for record in records),
        "degrees_of_freedom": sum(record.degrees_of_freedom for record in records),
        "condition": max(record.condition for record in records),
    }


def require_alike(results: Sequence[Result]) -> None:
    """Refuses results that no mean can be of.

    Raises:
        FileProblem: two differ in machine, model, what was known or load, or are of the same recording.
    """
    first, *rest = results
    for result in results:
        if result.record.priors:
            raise FileProblem(
                place=result.source,
                problem=phrase(
                    "counts_prior",
                    "counts a prior of {name}, which a mean would count again",
                    name=next(iter(result.record.priors)),
                ),
                remedy=phrase("without_prior", "identify without {prior}", prior=option("priors", "prior")),
                code=Code.CONTRADICTION,
            )
    for one, other in combinations(results, 2):
        if one.recordings & other.recordings:
            raise FileProblem(
                place=other.source,
                problem=phrase("same_recording", "is of the same recording as {other}", other=one.source),
                remedy=phrase("each_once", "name each run once"),
                code=Code.OTHER_SOURCE,
            )
    for result in rest:
        _require_like(result, first)


NONE = phrase("none_stated", "none")
NOT_STATED = phrase("not_stated", "not stated")


def _differs(what: str, here: object, source: str, there: object) -> Phrase:
    """That something of a result is another than that of the first one."""
    return phrase(
        "differs_from_first", "{what} is {here}, that of {source} {there}", what=what, here=here, source=source,
        there=there,
    )  # fmt: skip


def _require_like(result: Result, first: Result) -> None:
    """Raises FileProblem where a result differs from the first in machine, options, load or kind of run."""
    again = phrase("identify_both_alike", "identify both with the same case and options")
    record, base = result.record, first.record
    if record.case != base.case:
        raise FileProblem(
            place=result.source,
            problem=phrase(
                "results_of_two_cases",
                "is of case {case}, {other} of {other_case}",
                case=record.case,
                other=first.source,
                other_case=base.case,
            ),
            remedy=again,
            code=Code.OTHER_SOURCE,
        )
    then, now = base.computed_from or {}, record.computed_from or {}
    for key in differing(then, now):
        there, here = (NOT_STATED if of.get(key) is None else of[key] for of in (then, now))
        raise FileProblem(
            place=result.source,
            problem=_differs(key, here, first.source, there),
            remedy=again,
            code=Code.OTHER_SOURCE,
        )
    for what in ("model", "known", "dropped", "weights"):
        there, here = getattr(base, what), getattr(record, what)
        if (there or None) != (here or None):
            with_model = phrase("also_with", "{again}, and with {option}", again=again, option=option("model"))
            remedy = with_model if what == "model" else again
            raise FileProblem(
                place=result.source,
                problem=_differs(what, here or NONE, first.source, there or NONE),
                remedy=remedy,
                code=Code.OTHER_SOURCE,
            )
    if result.mounted != first.mounted:
        raise FileProblem(
            place=result.source,
            problem=phrase(
                "other_payload",
                "a payload of {mounted} kg was mounted, {first} kg with {source}",
                mounted=f"{result.mounted:.4g}",
                first=f"{first.mounted:.4g}",
                source=first.source,
            ),
            remedy=phrase("same_load", "pool runs of the same load; hexcite payload compares two loads"),
            code=Code.OTHER_SOURCE,
        )
    if (base.delay_s is None) != (record.delay_s is None):
        kinds = ["standstills" if of.delay_s is None else "a motion" for of in (record, base)]
        raise FileProblem(
            place=result.source,
            problem=phrase(
                "other_kind",
                "is of {kind}, {source} of {other}",
                kind=kinds[0],
                source=first.source,
                other=kinds[1],
            ),
            remedy=phrase("one_kind", "pool runs of one kind"),
            code=Code.OTHER_SOURCE,
        )


class Estimated(Protocol):
    """What a mean needs of a run, whether it was identified or is planned."""

    @property
    def values(self) -> Array:
        """u, shape (u,)."""

    @property
    def covariance(self) -> Array:
        """Covariance of u by (28), shape (u, u)."""

    @property
    def covariance_robust(self) -> Array:
        """Covariance of u with all that deviations count, shape (u, u)."""

    @property
    def biases(self) -> Mapping[str, Array]:
        """Part of that by what all runs have in common, as of a result."""


class Mean(NamedTuple):
    """A generalised mean of u."""

    values: Array  # shape (u,)
    random: Array  # covariance by what is each run's own, shape (u, u)
    white: Array  # the same, by (28) of each run
    biases: Mapping[str, Array]  # as of a result


class Agreement(NamedTuple):
    """How far runs scatter."""

    chi2: float
    freedom: int
    shares: tuple[float, ...]  # of each run in chi^2

    @property
    def chance(self) -> float:
        """Probability of so much by noise."""
        return float(chdtrc(self.freedom, self.chi2))

    @property
    def ratio(self) -> float:
        """Scatter over what deviations promise."""
        return float(np.sqrt(self.chi2 / self.freedom))

    def to_json(self) -> dict[str, Any]:
        """Entries of a result."""
        return {"chi2": self.chi2, "degrees_of_freedom": self.freedom, "p": self.chance, "scatter": self.ratio}


@dataclass(frozen=True, slots=True)
class _Runs:
    """Values of runs in coordinates x in which all of them are free: u = first + lift x."""

    first: Array  # u of the first, shape (u,)
    lift: Array  # shape (u, x)
    values: tuple[Array, ...]  # x of each, shape (x,)
    random: tuple[Array, ...]  # covariance by its own noise, shape (x, x)
    white: tuple[Array, ...]
    biases: tuple[Mapping[str, Array], ...]  # shapes (x, k)

    @classmethod
    def of(cls, results: Sequence[Estimated]) -> "_Runs":
        first = results[0].values
        lift, down = Free.of(sum((result.covariance for result in results), np.zeros((len(first),) * 2)))
        values_of_runs, white, biases = [], [], []
        for result in results:
            common = sum((b @ b.T for b in result.biases.values()), np.zeros_like(result.covariance))
            least = down @ result.covariance @ down.T
            values_of_runs.append(larger_of(least, down @ (result.covariance_robust - common) @ down.T))
            white.append(least)
            biases.append({key: down @ bias for key, bias in result.biases.items()})
        x = tuple(down @ (result.values - first) for result in results)
        return cls(first, lift, x, tuple(values_of_runs), tuple(white), tuple(biases))

    def mean(self) -> Mean:
        """The mean of all runs, weighted by their own noise."""
        inverse = [np.linalg.inv(random) for random in self.random]
        covariance = np.linalg.inv(sum(inverse))
        weights = [covariance @ i for i in inverse]
        x = sum(w @ v for w, v in zip(weights, self.values, strict=True))
        white = sum(w @ c @ w.T for w, c in zip(weights, self.white, strict=True))
        keys = dict.fromkeys(key for biases in self.biases for key in biases)
        common = {
            key: self.lift @ sum(w @ b[key] for w, b in zip(weights, self.biases, strict=True) if key in b)
            for key in keys
        }
        lift = self.lift
        return Mean(self.first + lift @ x, lift @ covariance @ lift.T, lift @ white @ lift.T, common)

    def agreement(self, which: Sequence[int], rows: Array | None = None) -> Agreement:
        """How far runs scatter, by all of x or by rows of it, shape (r, x)."""
        rows = np.eye(len(self.values[0])) if rows is None else rows
        keys = dict.fromkeys(key for k in which for key in self.biases[k])
        whole = block_diag(*(rows @ self.random[k] @ rows.T for k in which))
        for key in keys:
            width = next(self.biases[k][key].shape[1] for k in which if key in self.biases[k])
            none = np.zeros((len(self.values[0]), width))
            stacked = np.vstack([rows @ self.biases[k].get(key, none) for k in which])
            whole = whole + stacked @ stacked.T
        inverse, values = np.linalg.inv(whole), np.concatenate([rows @ self.values[k] for k in which])
        design = np.tile(np.eye(len(rows)), (len(which), 1))
        x = np.linalg.solve(design.T @ inverse @ design, design.T @ inverse @ values)
        off = values - design @ x
        each = (off * (inverse @ off)).reshape(len(which), -1).sum(axis=1)
        chi2 = max(float(each.sum()), 0.0)
        return Agreement(chi2, (len(which) - 1) * len(rows), tuple((each / max(chi2, 1e-300)).tolist()))

    def without_each(self) -> tuple[Agreement, ...]:
        """How far the others scatter, of each run."""
        every = range(len(self.values))
        return tuple(self.agreement([k for k in every if k != omitted]) for omitted in every)


def mean_of(runs: Sequence[Estimated]) -> Mean:
    """The generalised mean of runs of the same machine with the same load, of which some may be planned."""
    return _Runs.of(runs).mean()


def _scatter_by_parameter(model: Model, u: Array, runs: _Runs) -> dict[str, dict[str, float]]:
    """Of each physical parameter how far runs scatter; parameters that are given are left out."""
    form = physical_form(model)
    slope = form.map(u)[1].full() @ runs.lift
    every, scatter = range(len(runs.values)), dict[str, dict[str, float]]()
    for parameter, row in zip(form.parameters, slope, strict=True):
        if not row @ runs.random[0] @ row > 0.0:
            continue
        of = runs.agreement(every, row[None])
        scatter[parameter.name] = {"scatter": of.ratio, "p": of.chance}
    return scatter


def _agreement_findings(
    names: Sequence[str], whole: Agreement, others: Sequence[Agreement], scatter: Mapping[str, Mapping[str, float]]
) -> list[Finding]:
    """Whether runs agree, and which one does not."""
    figures = f"chi-square {whole.chi2:.3g} for {whole.freedom} degrees of freedom, p = {whole.chance:.2g}"
    if whole.chance >= UNLIKELY:
        return [
            note(Kind.MODEL, f"{len(names)} runs agree: they scatter {whole.ratio:.2g} times as promised ({figures})")
        ]
    worst = max(scatter, key=lambda name: scatter[name]["scatter"])
    sentence = (
        f"{len(names)} runs scatter {whole.ratio:.2g} times as their deviations promise ({figures}), most in "
        f"{parameter_words(worst)}; deviations are multiplied by it"
    )
    if not others:
        sentence += ". Which of two is wrong a third run would say"
    else:
        odd = max(range(len(others)), key=lambda k: others[k].chance)
        chance = chdtrc(whole.freedom - others[odd].freedom, max(whole.chi2 - others[odd].chi2, 0.0)) * len(names)
        if others[odd].chance >= UNLIKELY and chance < UNLIKELY:
            sentence += f". {names[odd]} differs from the others, which agree (p = {others[odd].chance:.2g}): look for "
            sentence += "what was different, or pool without it"
        else:
            sentence += ". No single run is the cause: load, temperature or clamping changed between them"
    return [warning(Kind.MODEL, sentence, counted=True)]


def _of_runs(results: Sequence[Result]) -> list[Finding]:
    """Warnings of the runs, each with its run."""
    return [
        Finding(f.kind, f.severity, f"{result.source}: {f.sentence}", f.place, {}, f.counted)
        for result in results
        for f in result.findings
        if f.severity == "warning"
    ]


def _budget(
    first: Result, model: Model, u: Array, white: Array, random: Array, biases: Mapping[str, Array]
) -> list[Finding]:
    """What the deviations do not count, and their parts."""
    findings = [note(Kind.NOISE, "", not_counted=list(first.not_counted))] if first.not_counted else []
    if not biases:
        return findings
    return [*findings, note(Kind.NOISE, "", budget=budget_rows(model, u, white, random, biases))]


def _noise_of_channels(records: Sequence[Any], weights: Array) -> dict[str, Any]:
    """Noise of each channel by the residuals of all runs, weighted by their samples; none where a run has none.

    Earlier results lack what their run left behind the filter: then the mean does.
    """
    entries = [record.channel_noise for record in records]
    if not all(entries):
        return {}
    keys = [key for key in ("measured", "evaluated") if all(key in of for of in entries)]
    squares = {key: np.average(np.square([of[key] for of in entries]), axis=0, weights=weights) for key in keys}
    if any("by_drives" in of for of in entries):  # a run that does not say it has no noise above the stated one
        by_drives = [of.get("by_drives", np.zeros(len(of["measured"]))) for of in entries]
        squares["by_drives"] = np.average(np.square(by_drives), axis=0, weights=weights)
    noise = {key: np.sqrt(square).tolist() for key, square in squares.items()}
    return {"channel_noise": {"stated": entries[0].get("stated"), **noise}}


def _mean_delay(records: Sequence[Any]) -> Value | None:
    """The mean of delays, weighted by their variances."""
    delays = [record.delay_s for record in records if record.delay_s is not None]
    if not delays:
        return None
    if any(delay.reported <= 0.0 for delay in delays):  # given, or not estimated: alike
        return Value(float(np.mean([delay.value for delay in delays])), 0.0, 0.0, "s")
    weights = np.array([delay.reported**-2 for delay in delays])
    std = float(weights.sum() ** -0.5)
    return Value(float(weights @ [delay.value for delay in delays] / weights.sum()), std, std, "s")
