"""What a run itself tells of the sizes that its case tolerates: they are estimated beside the parameters, with priors.

Least squares leave the scores c = G d + n of how far the machine still is off the case, d, whose prior is normal with
the stated deviations (here each is 1), n noise as the residuals show it. The most probable sizes follow from both; the
run is then evaluated anew with the case of the machine as it is, until nothing moves. So parameters are those of the
joint estimate, its residuals and findings are those of the machine as it is, and what the run does not tell of a size
stays in the deviations: B C B^T, C the covariance of d with the run, in place of B B^T.

Where this lowers no deviation by a twentieth, and no size is off, the estimate by least squares alone is kept: it needs
no trust in what a case states.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from cases.base.phrases import NOTHING, Phrase, enumerated, phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.alternatives import noise_of
from identification.estimation.score_test import Noise
from identification.finding import Finding, Kind, note, warning
from identification.findings.contradiction import (
    UNLIKELY,
    Part,
    chance_of_all,
    chance_of_one,
    standing_out,
    times_stated,
)
from identification.findings.drift import drift_of
from identification.findings.left_out import LeftOut
from identification.findings.off_case import SHOWABLE, Size, remedies_of, remedy_of, sizes_named
from identification.findings.remains import excerpt_of, free_basis, remainder_of
from identification.findings.tolerances import Share, shares_of
from identification.samples.samples import Fitted
from identification.texts import two_digits, with_deviation

FAINT = 0.02  # of the noise of a score, as variance: below it nothing is told in a direction
WORTH = 0.95  # of a deviation by least squares alone, to which estimated sizes have to lower one
SETTLED = 0.1  # of a deviation, by which another round still moves a parameter
CLEAR = 3.0  # deviations by which a size differs from the case: it is said
TELLING = 0.5  # of what is tolerated, to which the run has to tell a size for its value to be given


class LeftOpen(NamedTuple):
    """What a run leaves open of sizes that it told, in units of their stated deviations.

    Sizes are off by (1 - K G) p - K n, and u by (B - B K G) p - B K n beside its own noise, where p are the sizes of
    the machine and n is what noise makes of the scores.
    """

    counts: Mapping[str, int]  # sizes that each tolerance is of, by its key, in their order
    gain: Array  # K, shape (k, scores)
    through: Array  # G, shape (scores, k)
    noise: Array  # covariance of n, by noise as residuals show it, shape (scores, scores)
    white: float  # variance of each of n by white noise
    of_values: Array  # B K, shape (u, scores)

    @property
    def remains(self) -> dict[str, Array]:
        """What stays of all sizes by one deviation of each size of a tolerance, shapes (k, sizes), by its key."""
        reduction = np.eye(len(self.gain)) - self.gain @ self.through
        ends = np.cumsum(list(self.counts.values()))
        return dict(zip(self.counts, np.split(reduction, ends[:-1], axis=1), strict=True))

    def noise_of(self, robust: bool) -> Array:
        """Covariance of n with memory or, where not `robust`, white, shape (scores, scores)."""
        return self.noise if robust else self.white * np.eye(len(self.noise))

    def of_keys(self, effects: Mapping[str, Array]) -> Array:
        """Effects of each size, shapes (.., sizes) by keys, side by side in the order of the sizes, shape (.., k)."""
        return np.concatenate([effects[key] for key in self.counts], axis=-1)

    def to_json(self) -> dict[str, Any]:
        """Entries of a result."""
        arrays = {name: v.tolist() for name, v in self._asdict().items() if isinstance(v, np.ndarray)}
        return {"counts": dict(self.counts), "white": self.white, **arrays}

    @classmethod
    def from_json(cls, entries: Mapping[str, Any]) -> "LeftOpen":
        """The value of these entries."""
        arrays = {name: np.array(entries[name], dtype=float) for name in ("gain", "through", "noise", "of_values")}
        return cls(dict(entries["counts"]), white=float(entries["white"]), **arrays)


class Together(NamedTuple):
    """Sizes of one machine by two runs that each told them: weighed by what each leaves open, their prior once."""

    first: Array  # weight of the sizes of the first run, shape (k, k)
    second: Array  # of the second
    remains: dict[str, Array]  # as of `LeftOpen`

    @classmethod
    def of(cls, one: LeftOpen, other: LeftOpen) -> "Together":
        """Of two runs with the same sizes."""
        each = [np.concatenate(list(of.remains.values()), axis=1) for of in (one, other)]
        inverse = [
            np.linalg.inv(0.5 * (reduction + reduction.T)) for reduction in each
        ]  # 1 - K G is the covariance with the run
        both = np.linalg.inv(inverse[0] + inverse[1] - np.eye(len(each[0])))
        first, second = (np.asarray(both @ i, dtype=float) for i in inverse)
        whole = first @ each[0] + second @ each[1] - both
        ends = np.cumsum(list(one.counts.values()))
        return cls(first, second, dict(zip(one.counts, np.split(whole, ends[:-1], axis=1), strict=True)))


class Told(NamedTuple):
    """Sizes by which a machine is off its case, in units of their stated deviations, as a run tells them."""

    shares: tuple[Share, ...]  # effects of the sizes on the fit by which they were found
    stated: Array  # deviations, shape (k,) [SI]
    sizes: Array  # estimates, shape (k,)
    step: Array  # by how much these differ from those with which the run was evaluated, shape (k,)
    covariance: Array  # of the sizes with the run, shape (k, k)
    reduction: Array  # how much of each size stays in that estimate, I - K G, shape (k, k)
    noise: Array  # what noise makes of the estimates, shape (k, k), and
    white: Array  # what scores make of them, K, shape (k, scores): white noise is the same in each of these
    through: Array  # what the sizes make of the scores, G, shape (scores, k)
    scores: Array  # of a machine with these sizes, shape (scores,)
    of_scores: Noise  # what noise makes of them, as residuals show it
    before: Array  # covariance of the values of the fit without tolerances, shape (v, v)

    @property
    def biases(self) -> Array:
        """Of the values of the fit by a unit of each size, shape (v, k)."""
        return np.concatenate([share.biases for share in self.shares], axis=1)

    @property
    def settled(self) -> bool:
        """Whether another round would move no parameter by what matters."""
        moved, total = self.biases @ self.step, self.before + self.biases @ self.covariance @ self.biases.T
        return bool(np.all(np.abs(moved) <= SETTLED * np.sqrt(np.diag(total))))

    @property
    def surprises(self) -> Array:
        """By how many deviations of what can be told of a size it is off, shape (k,)."""
        return np.asarray(self.sizes / np.sqrt(np.maximum(1.0 - np.diag(self.covariance), FAINT)))

    @property
    def chance(self) -> float:
        """Probability of what speaks most against the case, one size or all together, by noise and what is stated."""
        shown = self.scores, self.through, self.of_scores
        return min(chance_of_one(*shown), chance_of_all(*shown))

    def worth(self, parameters: int) -> bool:
        """Whether they lower the deviation of one of so many parameters, or one of them is off."""
        plain = np.diag(self.before + self.biases @ self.biases.T)[:parameters]
        joint = np.diag(self.before + self.biases @ self.covariance @ self.biases.T)[:parameters]
        return worth_estimating(plain, joint) or self.chance < UNLIKELY

    @property
    def by_key(self) -> dict[str, Array]:
        """Estimated sizes by keys of tolerances, shapes (k,) [SI]."""
        ends = np.cumsum([share.biases.shape[1] for share in self.shares])[:-1]
        parts = np.split(self.sizes * self.stated, ends)
        return {share.key: part for share, part in zip(self.shares, parts, strict=True) if len(part)}

    @property
    def remaining(self) -> tuple[Share, ...]:
        """What each tolerance does to values that are estimated with the sizes: none of it is left in residuals."""
        both, begin, blocks = self.biases @ self.reduction, 0, []
        for share in self.shares:
            end = begin + share.biases.shape[1]
            blocks.append(share._replace(biases=both[:, begin:end], residuals=share.residuals[:, :, :0]))
            begin = end
        return tuple(blocks)

    def left_open(self, fitted: Fitted) -> "LeftOpen":
        """What it leaves open of the sizes, beside the parameters of a fit."""
        parameters = slice(len(fitted.samples.model.names))
        return LeftOpen(
            {share.key: share.biases.shape[1] for share in self.shares},
            self.white,
            self.through,
            self.of_scores.covariance,
            fitted.fit.white_noise**2 / fitted.regression.filtered.stride,
            self.biases[parameters] @ self.white,
        )

    def allowed_for(self, fitted: Fitted) -> Fitted:
        """A fit with deviations that count the noise in the estimates of the sizes."""
        fit, through = fitted.fit, self.biases @ self.white
        white = fit.white_noise**2 / fitted.regression.filtered.stride * through @ through.T
        robust = self.biases @ self.noise @ self.biases.T
        return fitted._replace(
            fit=replace(fit, covariance=fit.covariance + white, covariance_robust=fit.covariance_robust + robust)
        )


def worth_estimating(plain: Array, joint: Array) -> bool:
    """Whether sizes that are estimated lower one of some variances of least squares alone by enough, shapes (u,)."""
    return bool(np.any(joint[plain > 0.0] < WORTH**2 * plain[plain > 0.0]))


def shown(shares: tuple[Share, ...], case: Case) -> tuple[Share, ...]:
    """Tolerances whose sizes a run can tell, and without which it can be evaluated anew."""
    # without a chain no key of the case turns the frame of a sensor
    return tuple(
        share
        for share in shares
        if share.key in SHOWABLE
        and share.biases.shape[1]
        and not (case.chain is None and share.key.startswith("sensor"))
    )


def joint_covariance(strength: Array) -> Array:
    """Covariance of sizes, whose prior variances are 1, by what a run with known noise shows of them, shape (k, k).

    Args:
        strength: squares of what its fit leaves of their effects, over the variance of the noise, shape (k, k).
    """
    values, vectors = np.linalg.eigh(strength)
    return np.asarray((vectors / (1.0 + np.where(values > FAINT, values, 0.0))) @ vectors.T)


def told_by(fitted: Fitted, case: Case, sizes: Array | None = None) -> Told | None:
    """What a run tells of the sizes that its case tolerates; None where it tells nothing, or that cannot be seen.

    Args:
        fitted: the fit of the run with the case of a machine that is off by the sizes.
        case: that case.
        sizes: these, in units of their stated deviations, shape (k,); None for none.
    """
    whole, (fitted, part) = fitted, excerpt_of(fitted)
    motion = None if fitted.method.priors or case.tolerances is None else fitted.samples.motion(fitted.at)
    if motion is None or case.tolerances is None:
        return None
    left_out, basis = LeftOut.of(fitted, motion, case), free_basis(fitted)
    rest = remainder_of(fitted, left_out.regressors(fitted.regression.names))
    drift = drift_of(whole)
    if drift is not None:
        rest = rest.beside((drift.shape[part] * fitted.samples.scale)[:, None, None] * np.eye(6))
    every = shares_of(left_out, rest, basis, case.tolerances)
    shares = shown(every, case)
    if not shares:
        return None
    residual_effects, both = np.concatenate([share.residuals for share in shares], axis=2), ((0, 1), (0, 1))
    values, vectors = np.linalg.eigh(np.tensordot(residual_effects, residual_effects, both))
    significant = values > FAINT * float(np.mean(rest.residuals**2))
    if not significant.any():
        return None
    strength = np.sqrt(values[significant])
    through = (vectors[:, significant] * strength).T  # G, of scores in an orthonormal basis
    scored = residual_effects @ (vectors[:, significant] / strength)
    scores = np.tensordot(scored, rest.residuals, both)
    noise = noise_of(scored, rest, rest.residuals - scored @ scores)
    now = np.zeros(residual_effects.shape[2]) if sizes is None else sizes
    factor = cho_factor(through @ through.T + noise.covariance)
    gain = cho_solve(factor, through).T
    news = scores + through @ now
    step = gain @ news - now
    stays = np.eye(len(now)) - gain @ through
    counts, stated = [share.biases.shape[1] for share in shares], dict(case.tolerances.stated())
    deviations = [stated[share.key] * sizes_named(case, share.key)[0].unit for share in shares]
    return Told(
        shares,
        np.repeat(deviations, counts),
        _moved(shares, np.repeat(deviations, counts), now, step),
        step,
        stays,
        stays,
        gain @ noise.covariance @ gain.T,
        gain,
        through,
        news,
        noise,
        np.maximum(fitted.fit.covariance, fitted.fit.covariance_robust),
    )


def _moved(shares: tuple[Share, ...], deviations: Array, now: Array, step: Array) -> Array:
    """Sizes after a step, in units of their deviations; turns of the sensor follow each other and do not add up."""
    after, end = now + step, 0
    for share in shares:
        begin, end = end, end + share.biases.shape[1]
        if share.key == "sensor_deg":
            first, second = (Rotation.from_rotvec(by[begin:end] * deviations[begin:end]) for by in (now, step))
            after[begin:end] = (first * second).as_rotvec() / deviations[begin:end]
    return after


def findings_of(told: Told, case: Case, fitted: Fitted) -> list[Finding]:
    """What a run tells of a machine that is off its case, in words and as entries.

    Args:
        told: what it tells.
        case: the case as it is stated.
        fitted: the fit of the run as it is, by its noise alone.
    """
    named = [size for share in told.shares for size in sizes_named(case, share.key)]
    stds, values, entries = np.sqrt(np.diag(told.covariance)), told.sizes, list[dict[str, Any]]()
    by_key, clear = told.by_key, list[tuple[Size, Phrase, Array]]()
    for k, size in enumerate(named):
        if stds[k] > TELLING:
            continue
        unit = told.stated[k] / size.unit
        amount = with_deviation(float(values[k] * unit), float(stds[k] * unit))
        sentence = size.words.filled(size=f"{amount} {size.symbol}")
        entries.append(
            {
                "key": size.key,
                "words": sentence,
                "value": float(values[k] * told.stated[k]),
                "std": float(stds[k] * told.stated[k]),
                "tolerance": float(told.stated[k]),
                "deviations": float(told.surprises[k]),
            }
        )
        if abs(values[k]) > CLEAR * stds[k]:
            clear.append((size, sentence, told.surprises[k]))
    exact = {key: sizes.tolist() for key, sizes in by_key.items()}
    left_open = told.left_open(fitted).to_json()
    findings = [note(Kind.CASE, "", told=entries, told_sizes=exact), note(Kind.CASE, "", told_left_open=left_open)]
    for key in dict.fromkeys(size.key for size, _, _ in clear):
        words = enumerated("semicolon", [sentence for size, sentence, _ in clear if size.key == key])
        first = next(size for size, _, _ in clear if size.key == key)
        sentence = phrase(
            "told_sizes",
            "the run tells that {words}: estimated and allowed for; {remedy}",
            words=words,
            remedy=remedy_of(case, first, {key: by_key[key]}),
        )
        told_of = note(Kind.CASE, sentence)
        findings.append(replace(told_of, remedies=remedies_of(words, case, first, {key: by_key[key]})))
    return findings + _contradictions(told, named)


def _contradictions(told: Told, named: list[Size]) -> list[Finding]:
    """What cannot be right at its tolerance: a part that stands out, or all that is stated together."""
    chance, count = told.chance, len(named)
    if chance >= UNLIKELY:
        return []
    entry: dict[str, Any] = {"chance": chance, "tried": count}
    parts = standing_out(told.scores, told.through, told.of_scores)
    if not parts:
        times = times_stated(told.scores, told.through, told.of_scores)
        sentence = phrase(
            "tolerances_too_small",
            "the case cannot be right at its tolerances: what the run shows of {keys} is about {times} times as large "
            "as stated (of machines that are as stated {rare} so much), and of {tried} sizes none stands out. State "
            "larger ones, or measure the machine",
            keys=enumerated("comma", [f"tolerances.{share.key}" for share in told.shares]),
            times=two_digits(times),
            rare=_rare(chance),
            tried=count,
        )
        return [warning(Kind.CASE, sentence, impossible=entry | {"times": times})]
    sentence = phrase(
        "part_off_tolerance",
        "the case cannot be right at its tolerances: {parts}; of machines that are as stated, with {tried} such "
        "sizes, {rare} so much. Measure that part, or state what is true of it",
        parts=enumerated("or", [_off(part, told, named[part.place]) for part in parts]),
        tried=count,
        rare=_rare(parts[0].chance),
    )
    first, *others = ({"key": named[part.place].key} | _figures(part, told) for part in parts)
    return [warning(Kind.CASE, sentence, impossible=entry | first | ({"or": others} if others else {}))]


def _off(part: Part, told: Told, size: Size) -> Phrase:
    """By how much a part is off, and what is stated of it."""
    unit = told.stated[part.place] / size.unit
    return phrase(
        "part_off",
        "{words}, where tolerances.{key} states {stated} ({deviations} deviations of both{larger})",
        words=size.words.filled(size=f"{with_deviation(part.size * unit, part.std * unit)} {size.symbol}"),
        key=size.key,
        stated=f"{unit:.3g}",
        deviations=f"{part.deviations:.2g}",
        larger=_larger(part.times),
    )


def _larger(times: float) -> Phrase:
    """That the other sizes were taken for larger than stated, where they were."""
    shown = f"{times:.2g}"
    if shown == "1":
        return NOTHING
    return phrase("others_larger", ", if all others are {times} times as large as stated", times=shown)


def _figures(part: Part, told: Told) -> dict[str, float]:
    """Entries of a part, sizes in SI."""
    tolerance = float(told.stated[part.place])
    return {
        "deviations": part.deviations,
        "chance": part.chance,
        "value": part.size * tolerance,
        "std": part.std * tolerance,
        "times": part.times,
    }


def _rare(chance: float) -> Phrase:
    """How many sound machines show something that has a chance."""
    if chance < RAREST:
        return phrase("shown_by_fewer", "fewer than one in {runs} shows", runs=f"{1.0 / RAREST:.0f}")
    return phrase("shown_by_one", "one in {runs} shows", runs=f"{1.0 / chance:.0f}")


RAREST = 1e-6  # chance below which its figure says nothing more to a reader
