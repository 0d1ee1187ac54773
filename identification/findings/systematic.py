"""What the residuals of a fit follow, in words, and how much wider its deviations are for it.

Each thing that the model leaves out (`left_out`) is tested beside the others. The one that explains the residuals best
is taken in, and the rest is tested again, until nothing is left that noise does not make. Deviations grow by the biases
of all that is seen, each in the share by which it is likely: from what is merely suspicious on, so that no effect is
silently below a threshold.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cases.base.errors import printable
from cases.base.phrases import Phrase, enumerated, phrase, said
from cases.base.units import DEG, Array
from cases.schema import Case
from identification.estimation.alternatives import Alternative, Effect, Remainder, Unseen, effects_of, unseen
from identification.estimation.fit import inverse_root
from identification.finding import Finding, Kind, note, warning
from identification.findings.clock import OddClock
from identification.findings.drift import Drift, drift_of
from identification.findings.effects import alternatives_of, couplings_of
from identification.findings.left_out import LeftOut
from identification.findings.noise_level import channel_words
from identification.findings.remains import excerpt_of, free_basis, remainder_of
from identification.findings.structural_mode import Ringing, biased_by, by_other_sharpening, mode_of, sharpened
from identification.findings.told import Told
from identification.findings.tolerances import Share, shares_of, without_tolerances
from identification.model.parameters import offset_columns
from identification.samples.samples import Fitted, MotionOfSamples
from identification.texts import parameter_phrase, two_digits, with_deviation

CERTAIN = 1e-7  # chance below which an alternative is seen: some seventy are tried in each run
SUSPICIOUS = 5e-4  # chance from which on it counts in the deviations: one sound run in thirty has one
PRIOR = 0.01  # odds of each alternative beforehand
ROUNDS = 4  # alternatives that are taken in, at most


class Seen(NamedTuple):
    """An effect that noise does not make."""

    effect: Effect
    rivals: tuple[Effect, ...]  # others that explain nearly as much
    explained: Array  # rms of what it explains of the residuals of each channel, shape (6,) [N, or N and N m]


class Suspected(NamedTuple):
    """An effect that noise may make, but seldom does."""

    effect: Effect
    tried: int  # alternatives that were tried with it
    bias: Array  # covariance of the values of the fit by it and its rivals, in their shares, shape (v, v)


class Systematic(NamedTuple):
    """What a fit leaves that is not noise."""

    seen: tuple[Seen, ...]  # effects that are certain, each beside those before it
    suspected: Suspected | None  # the likeliest of those for which deviations allow beside them
    drift: Drift | None  # of offsets
    bias: Array  # covariance of the values of the fit by all that is seen or likely, shape (v, v)
    drives: Array | None  # bias of the values of the fit by noise of the drives, shape (v,), where that is measured
    residuals: Array  # of each channel, rms, shape (6,) [N, or N and N m]
    motion: MotionOfSamples
    tolerances: tuple[Share, ...]  # what each stated tolerance does to the values
    ringing: Ringing | None  # a structural mode that forces show
    hidden: tuple[Unseen, ...]  # how well the run shows each effect of one size; answers are of the fit's values


def systematic_of(
    fitted: Fitted, case: Case, odd: OddClock | None = None, told: Told | None = None
) -> Systematic | None:
    """What the residuals of a fit follow; None where nothing is known of the motion, or priors are part of the fit.

    Args:
        fitted: the fit.
        case: case with which it was evaluated.
        odd: a clock that may be wrong, for which deviations are to allow.
        told: sizes that were estimated beside the parameters, where they were.
    """
    whole, (fitted, part) = fitted, excerpt_of(fitted)
    samples = fitted.samples
    motion = None if fitted.method.priors else samples.motion(fitted.at)
    if motion is None:
        return None
    basis, residuals = free_basis(fitted), fitted.fit.residuals
    left_out = LeftOut.of(fitted, motion, case)
    rest = remainder_of(fitted, left_out.regressors(fitted.regression.names))
    half = rest.half
    tolerances = shares_of(left_out, rest, basis, case.tolerances)
    if told is not None:
        estimated = {share.key: share for share in told.remaining}
        tolerances = tuple(estimated.get(share.key, share) for share in tolerances)
    rest = without_tolerances(rest, tolerances)
    drift, bias = drift_of(whole), np.zeros((basis.shape[1],) * 2)
    if drift is not None:
        rest = rest.beside((drift.shape[part] * samples.scale)[:, None, None] * np.eye(6))
        bias += np.outer(drift.bias, drift.bias)
    mode = mode_of(whole)
    ringing = None
    if mode is not None:  # before all that follows derivatives of the forces, which would take it over
        column = left_out.weighted(sharpened(mode, left_out)[:, :, None])
        ringing = Ringing(mode, biased_by(column, rest, basis) + by_other_sharpening(mode, fitted))
        rest = rest.beside(column)
    alternatives = list(alternatives_of(left_out))
    if odd is not None:
        for clock in (alternative for alternative in alternatives if alternative.key == "clock"):
            wrong = half @ rest.without_fit(rest.root @ clock.columns)[1][: len(half), 0] * odd.share
            bias += np.outer(wrong, wrong)
    shown = _shown(alternatives, rest, basis)
    bias = basis @ (bias + shown.bias) @ basis.T
    if drift is not None:  # an offset is that of the whole run, and what it is before and after differs by the drift
        for k, place in enumerate(offset_columns(samples.model)):
            bias[place, place] += drift.drifts[k] * drift.change[k] ** 2
    attenuated = left_out.attenuation(fitted.w)
    drives = None
    if attenuated is not None:
        pull = basis.T @ np.r_[attenuated, np.zeros(fitted.regression.nuisance)]
        fit = inverse_root((rest.root @ fitted.regression.regressors @ basis).reshape(-1, basis.shape[1]))
        drives = -basis @ (fit @ (fit.T @ pull))  # by F of the fit, to which noise adds: it bounds what noise can pull
        bias += np.outer(drives, drives)
    if ringing is not None:
        bias += np.outer(ringing.bias, ringing.bias)
    rms = np.sqrt(np.mean(residuals**2, axis=0))
    coupled = any(seen.effect.alternative.key == "coupling" for seen in shown.seen)
    single = [] if coupled else couplings_of(left_out)
    hidden = [of._replace(answer=basis @ of.answer) for of in unseen([*shown.alternatives, *single], shown.rest)]
    return Systematic(shown.seen, shown.suspected, drift, bias, drives, rms, motion, tolerances, ringing, tuple(hidden))


class _Shown(NamedTuple):
    """What residuals follow, one effect beside the other."""

    seen: tuple[Seen, ...]
    suspected: Suspected | None
    bias: Array  # covariance of the free values of the fit by these and their rivals, in their shares, shape (f, f)
    rest: Remainder  # what they leave
    alternatives: tuple[Alternative, ...]  # those that are not among them


def _shown(alternatives: Sequence[Alternative], rest: Remainder, basis: Array) -> _Shown:
    """Effects that the rest shows for certain, each explained before the next, then one that it shows by likelihood."""
    candidates, bias, seen = list(alternatives), np.zeros((basis.shape[1],) * 2), list[Seen]()
    inverse = np.linalg.inv(rest.root).T
    for _ in range(ROUNDS):
        effects = effects_of(candidates, rest, SUSPICIOUS)
        if not effects:
            break
        likely = np.exp(np.array([effect.evidence - effects[0].evidence for effect in effects]))
        odds = PRIOR * sum(_odds(effect.chance) for effect in effects)
        shares = odds / (1.0 + odds) * likely / likely.sum()
        more = np.sum([share * effect.bias for effect, share in zip(effects, shares, strict=True)], axis=0)
        bias += more
        if effects[0].chance > CERTAIN:
            suspected = Suspected(effects[0], len(candidates), basis @ more @ basis.T)
            return _Shown(tuple(seen), suspected, bias, rest, tuple(candidates))
        explained = np.sqrt(np.mean((effects[0].explained @ inverse) ** 2, axis=0))
        seen.append(Seen(effects[0], tuple(effects[1:]), explained))
        explanation = effects[0].alternative
        rest = rest.beside(explanation.columns @ effects[0].supported)
        candidates = [alternative for alternative in candidates if alternative is not explanation]  # counted whole
    return _Shown(tuple(seen), None, bias, rest, tuple(candidates))


def _odds(chance: float) -> float:
    """Largest odds of an effect that would have a probability by chance (Sellke, Bayarri & Berger 2001)."""
    return float(1.0 / (-np.e * chance * np.log(chance))) if chance < 1.0 / np.e else 1.0


def allowed_for(fitted: Fitted, systematic: Systematic | None) -> Fitted:
    """The fit with deviations that allow for what its residuals show, and for the stated tolerances of the machine."""
    if systematic is None:
        return fitted
    fit = fitted.fit
    more = systematic.bias + sum(share.covariance for share in systematic.tolerances)
    return fitted._replace(fit=replace(fit, covariance_robust=fit.covariance_robust + more))


MUCH_NOISE = 0.05  # share of the residuals' squares, from which on an effect is one to act on whatever it does
HARM = 1.0  # deviations of a parameter, the same


def noisy_drives(case: Case, fitted: Fitted, systematic: Systematic | None) -> list[Finding]:
    """Noise of the drives that biases a parameter by more than its deviation."""
    if systematic is None or systematic.drives is None or systematic.motion.noise is None:
        return []
    fit, names = fitted.fit, fitted.samples.model.names
    variance = np.maximum(np.diag(fit.covariance), np.diag(fit.covariance_robust))[: len(names)]
    free = variance > 0.0
    ratios = np.where(free, systematic.drives[: len(names)] / np.sqrt(np.where(free, variance, 1.0)), 0.0)
    worst = int(np.argmax(np.abs(ratios)))
    if abs(ratios[worst]) < HARM:
        return []
    noise, machine = systematic.motion.noise, systematic.motion.machine
    turns = machine.turns if machine is not None else np.zeros(len(noise), dtype=bool)
    sizes = [
        f"{noise[kind].max() / unit:.2g} {word}"
        for kind, unit, word in ((~turns, 1e-6, "um"), (turns, DEG, "deg"))
        if noise[kind].any()
    ]
    sentence = phrase(
        "drive_noise",
        "noise of the {drives} ({sizes} from sample to sample) makes accelerations noisy, which biases {name} by about "
        "{bias} ({deviations} deviations; they allow for it). Lower recording.filter_cutoff_Hz = {cutoff}",
        drives=phrase(case.drive_words[0], case.drive_words[0]),
        sizes=enumerated("comma", sizes),
        name=names[worst],
        bias=f"{systematic.drives[worst]:+.2g}",
        deviations=f"{abs(ratios[worst]):.2g}",
        cutoff=f"{case.recording.filter_cutoff_Hz:g}",
    )
    bearable = bool(abs(ratios[worst]) <= BEARABLE)
    return [
        warning(Kind.NOISE, sentence, counted=bearable, drive_noise={"bias": systematic.drives[: len(names)].tolist()})
    ]


CODED = 5  # entries of what is not shown whose causes have their codes too, for tables in other languages
SHOWN = 5.0  # deviations of an effect's size, at which about half of all runs show it


def not_shown(fitted: Fitted, systematic: Systematic | None) -> list[Finding]:
    """Effects that this run shows so badly that they may bias a parameter by more than its deviation unseen.

    Of each the size that about half of all runs like this one would show, and the parameter that it would bias most, as
    an entry; a sentence tells of the worst.

    Args:
        fitted: the fit with deviations that allow for what its residuals show.
    """
    if systematic is None:
        return []
    fit, names = fitted.fit, fitted.samples.model.names
    variance = np.maximum(np.diag(fit.covariance), np.diag(fit.covariance_robust))[: len(names)]
    free, entries = variance > 0.0, list[dict[str, Any]]()
    for effect in systematic.hidden:
        size, of = SHOWN * effect.std, effect.alternative
        bias = size * effect.answer[: len(names)]
        ratios = np.where(free, np.abs(bias) / np.sqrt(np.where(free, variance, 1.0)), 0.0)
        worst = int(np.argmax(ratios))
        if ratios[worst] > HARM:
            cause = of.caused(f"{size / of.unit:.2g}")
            entry = {"key": of.key, "follows": of.follow, "as_with": cause, "size": size, "parameter": names[worst]}
            entries.append(entry | {"bias": float(bias[worst]), "deviations": float(ratios[worst])})
    if not entries:
        return []
    ordered = sorted(entries, key=lambda entry: -entry["deviations"])
    for told in ordered[:CODED]:
        told["phrase"] = said(told["as_with"]).to_json(printable)
    first, units = ordered[0], {p.name: p.unit for p in fitted.samples.model.parameters}
    amount = f"{first['bias']:+.2g} {units[first['parameter']]}"
    sentence = phrase(
        "not_shown",
        "half of all runs like this one would not show {cause}, which biases {parameter} by {amount} ({deviations} "
        "deviations)",
        cause=said(first["as_with"]),
        parameter=parameter_phrase(first["parameter"]),
        amount=amount,
        deviations=f"{first['deviations']:.3g}",
    )
    if len(ordered) > 1:
        sentence = phrase(
            "not_shown_more",
            "{sentence}; {count} more, smaller ones stand in not_shown of result.json",
            sentence=sentence,
            count=len(ordered) - 1,
        )
    return [note(Kind.MODEL, sentence, not_shown=ordered)]


def systematic_findings(case: Case, fitted: Fitted, systematic: Systematic | None) -> list[Finding]:
    """What the residuals follow, the largest first; a warning where it matters, else a note.

    Args:
        fitted: the fit before its deviations allow for it.
    """
    if systematic is None:
        return []
    names = fitted.samples.model.names
    if not systematic.seen:
        return _suspicion(fitted, systematic.suspected)
    first, growth = systematic.seen[0], _growth(fitted, systematic.bias)
    sentence = _follows(first, systematic, case)
    if len(systematic.seen) > 1:
        others = dict.fromkeys(effect.effect.alternative.follow for effect in systematic.seen[1:])
        sentence = phrase(
            "and_follows",
            "{sentence}; what is left follows {others}",
            sentence=sentence,
            others=enumerated("both", list(others)),
        )
    worst = int(np.argmax(growth))
    if growth[worst] > GROWN:
        sentence = phrase(
            "allowed_for",
            "{sentence}. Deviations allow for it: that of {name} is {times} times that of noise alone",
            sentence=sentence,
            name=names[worst],
            times=two_digits(growth[worst]),
        )
    quantity = [
        {
            "key": effect.effect.alternative.key,
            "follows": effect.effect.alternative.follow,
            "as_with": _cause(effect.effect),
            "size": float(effect.effect.sizes[0]) if len(effect.effect.sizes) == 1 else None,
            "std": float(effect.effect.stds[0]) if len(effect.effect.sizes) == 1 else None,
            "chance": effect.effect.chance,
            "share": effect.effect.share,
            "explained_rms": effect.explained.tolist(),
        }
        for effect in systematic.seen
    ]
    matters = first.effect.share > MUCH_NOISE or growth[worst] > np.sqrt(1.0 + HARM**2)
    if not matters:
        return [note(Kind.MODEL, sentence, systematic=quantity)]
    return [warning(Kind.MODEL, sentence, counted=bool(growth[worst] <= BEARABLE), systematic=quantity)]


def _growth(fitted: Fitted, bias: Array) -> Array:
    """How many times as large deviations with a bias of that covariance are as those of noise alone, shape (u,)."""
    fit, names = fitted.fit, fitted.samples.model.names
    white, robust, more = (np.diag(c)[: len(names)] for c in (fit.covariance, fit.covariance_robust, bias))
    free = white > 0.0
    before, after = np.maximum(white, robust), np.maximum(white, robust + more)
    return np.asarray(np.sqrt(np.where(free, after, 1.0) / np.where(free, before, 1.0)))


def _suspicion(fitted: Fitted, suspected: Suspected | None) -> list[Finding]:
    """For what that noise may make deviations allow, and how much wider they are for it."""
    if suspected is None:
        return []
    names, growth = fitted.samples.model.names, _growth(fitted, suspected.bias)
    worst = int(np.argmax(growth))
    if not growth[worst] > GROWN:
        return []
    effect = suspected.effect
    runs = 1.0 / (suspected.tried * effect.chance)
    sentence = phrase(
        "suspected",
        "residuals may follow {follow}, as with {cause} (one sound run in {runs} looks so, for {tried} such things are "
        "tried). Deviations allow for it: that of {name} is {times} times that of noise alone; a second run tells "
        "which it is",
        follow=said(effect.alternative.follow),
        cause=said(_cause(effect)),
        runs=f"{runs:.0f}",
        tried=suspected.tried,
        name=names[worst],
        times=two_digits(growth[worst]),
    )
    entry = {"key": effect.alternative.key, "chance": effect.chance, "tried": suspected.tried}
    return [note(Kind.MODEL, sentence, suspected=entry | {"growth": float(growth[worst])})]


BEARABLE = 3.0  # times a deviation by noise alone, up to which one that allows for an effect is as good as any
GROWN = 1.1  # times a deviation, from which on it is said


def _follows(seen: Seen, systematic: Systematic, case: Case) -> Phrase:
    """What residuals follow, in which channel, how much, and what would make it."""
    effect, alternative = seen.effect, seen.effect.alternative
    if alternative.each:
        follow, channel = alternative.each[effect.best]
    else:
        follow, channel = alternative.follow, -1
    if channel < 0:
        channel = int(np.argmax(seen.explained / np.maximum(systematic.residuals, np.finfo(float).tiny)))
    name, unit = channel_words(case, channel)
    causes = [_cause(effect), *(_cause(rival) for rival in seen.rivals[:1])]
    return phrase(
        "follows",
        "residuals of {name} follow {follow} ({part} of {whole} {unit} rms), as with {causes}",
        name=name,
        follow=follow,
        part=f"{seen.explained[channel]:.2g}",
        whole=f"{systematic.residuals[channel]:.2g}",
        unit=unit,
        causes=enumerated("comma_or", list(dict.fromkeys(causes))),
    )


def _cause(effect: Effect) -> Phrase:
    """Words for what makes an effect, with its size where it has one."""
    size, std = effect.sizes[0] / effect.alternative.unit, effect.stds[0] / effect.alternative.unit
    return effect.alternative.caused(with_deviation(float(size), float(std)))
