"""What a run promises of the parameters: their covariance by noise, and what the machine is off its case by.

The tolerances that a case states are carried through a planned run as `identification.findings` carries them through a
recorded one, by the same derivatives of the forces: of least squares, or with the sizes estimated beside the parameters
where that lowers a deviation by what is worth it.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from cases.base.phrases import NOTHING, Phrase, enumerated, phrase
from cases.base.units import Array
from cases.bounds import Bounds
from cases.schema import Case
from cases.tolerances import BOUNDS, KINDS, kind_of
from identification.machines.machine import Kinematics
from identification.machines.of_case import machine_of
from identification.model.blocks import Parameter
from identification.model.model import Model, expected_forces
from identification.model.parameters import physical_form
from identification.motion.motion import Trajectory
from identification.texts import CAUSE, legible, std_text
from planner.known import Known
from planner.noise import ExpectedNoise

NOISE = "noise"  # part of a budget
RATE, FEWEST, MOST = 100.0, 600, 3000  # samples of a motion a second [1/s], at least, and at most
SHIFT = 2e-3  # [s] for the derivative of the forces by time: what a run behind its filter shows of them
ROUNDING = 1e-12  # of the largest square of an effect, or of a variance
HARDLY = 0.8  # of a deviation that stays however long a run is: then it is said
LONG = 1e6  # times as much information of the same motion: what noise then leaves is nothing


@dataclass(frozen=True, slots=True)
class Prediction:
    """Covariance of the linear parameters by a run, by its causes."""

    model: Model
    values: Array  # u for which it is, shape (u,)
    noise: Array  # covariance of u by noise of the run, and by what that makes of estimated sizes, shape (u, u)
    # of u by one standard deviation of each size that a tolerance is one of, by its key, shapes (u, k); all runs of a
    # machine have these in common
    biases: Mapping[str, Array] = field(default_factory=dict)
    lasting: Mapping[str, Array] = field(default_factory=dict)  # the same of an endless run of the same motion

    @property
    def covariance(self) -> Array:
        """As of a result: by noise alone, shape (u, u)."""
        return self.noise

    @property
    def covariance_robust(self) -> Array:
        """As of a result: with the tolerances, shape (u, u)."""
        return np.asarray(sum((bias @ bias.T for bias in self.biases.values()), self.noise))

    def with_bounds(self, bounds: Bounds | None) -> "Prediction":
        """That of an estimate with bounds of the body as a prior, as `identify` uses them; itself without any use."""
        if bounds is None:
            return self
        from identification.estimation.bounded import bounded  # plans of cases without bounds do without

        estimate = bounded(self.model, self.values, self.noise, self.covariance_robust, bounds, judged=False)
        if estimate is None:
            return self
        endless = self.noise / LONG
        stays = np.asarray(sum((bias @ bias.T for bias in self.lasting.values()), endless))
        last = bounded(self.model, self.values, endless, stays, bounds, judged=False)
        lasting = dict(self.lasting)
        if last is not None:
            lasting = {key: last.kept @ bias for key, bias in lasting.items()} | {BOUNDS: last.biases}
        return replace(
            self,
            noise=estimate.kept @ self.noise @ estimate.kept.T,
            biases={key: estimate.kept @ bias for key, bias in self.biases.items()} | {BOUNDS: estimate.biases},
            lasting=lasting,
        )

    def beside(self, known: Known) -> "tuple[Prediction, Prediction]":
        """What is known without the run, and with it: its generalised mean with earlier results.

        What the machine is off its case by, all have in common: it is counted once.
        """
        from identification.results.pooling import mean_of

        before, after = mean_of([known]), mean_of([known, self])
        return (
            replace(self, values=known.values, noise=before.random, biases=before.biases),
            replace(self, values=known.values, noise=after.random, biases=after.biases),
        )

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of each physical parameter [SI]."""
        return self._deviations(np.diag(self._physical(self.noise)) + sum(self._variances(self.biases).values()))

    @property
    def least(self) -> dict[str, float]:
        """Standard deviations that stay however often the motion is repeated in a run [SI]; zero by noise alone."""
        none = np.zeros(len(physical_form(self.model).parameters))
        return self._deviations(none + sum(self._variances(self.lasting).values()))

    @property
    def budget(self) -> dict[str, dict[str, float]]:
        """Of each physical parameter the parts of its deviation by their causes [SI], whose squares add up."""
        kinds = {NOISE: np.diag(self._physical(self.noise))} | self._variances(self.biases)
        total = np.sum(list(kinds.values()), axis=0)
        kinds = {kind: np.where(variance > ROUNDING * total, variance, 0.0) for kind, variance in kinds.items()}
        parts = {kind: self._deviations(variance) for kind, variance in kinds.items()}
        return {name: {kind: of[name] for kind, of in parts.items()} for name in self.std}

    def _physical(self, covariance: Array) -> Array:
        return physical_form(self.model).of(self.values, covariance)[1]

    def _variances(self, biases: Mapping[str, Array]) -> dict[str, Array]:
        """Variances of the physical parameters by kinds of tolerances."""
        variances_by_cause: dict[str, Array] = {}
        for key, bias in biases.items():
            variances_by_cause[kind_of(key)] = variances_by_cause.get(kind_of(key), 0.0) + np.diag(
                self._physical(bias @ bias.T)
            )
        return variances_by_cause

    def _deviations(self, variances: Array) -> dict[str, float]:
        names = [p.name for p in physical_form(self.model).parameters]
        return {name: float(v) for name, v in zip(names, np.sqrt(variances.clip(0.0)), strict=True)}


class Promise(NamedTuple):
    """What is promised of the physical parameters, of several predictions the worst of each."""

    std: dict[str, float]  # standard deviations [SI]
    budget: dict[str, dict[str, float]]  # their parts by causes; empty where no tolerance is stated
    least: dict[str, float]  # deviations that stay however long the run is; empty as above

    @classmethod
    def of(cls, predictions: Sequence[Prediction]) -> "Promise":
        """The largest deviation of each parameter, with its parts."""
        runs = [(one.std, one.budget, one.least) for one in predictions]
        worst = {name: max(runs, key=lambda run: run[0][name]) for name in runs[0][0]}
        std = {name: run[0][name] for name, run in worst.items()}
        if not any(one.biases for one in predictions):
            return cls(std, {}, {})
        return cls(std, {n: run[1][n] for n, run in worst.items()}, {n: run[2][n] for n, run in worst.items()})

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        entries: dict[str, Any] = {"predicted_std": self.std}
        return entries | ({"predicted_budget": self.budget, "predicted_least": self.least} if self.budget else {})

    def not_counted(self, case: Case, standing: bool) -> list[str]:
        """Kinds of tolerances that a machine has and no deviation counts; a clock does not matter to standstills."""
        counted = [*next(iter(self.budget.values()), {}), *(["clock"] if standing else [])]
        return [kind for kind in dict.fromkeys(KINDS[key] for key in case.tolerable) if kind not in counted]

    def lasting_words(self, parameters: Sequence[Parameter], wanted: Collection[str], longer: str) -> Phrase:
        """What a longer run cannot lower and why, such as `more seconds lower m from .. to .. at most: ..`.

        Empty where it would lower all that matters.

        Args:
            parameters: physical parameters with their units.
            wanted: names of those that matter; all where there are none.
            longer: what would make the run longer, with its verb.
        """
        share = {name: self.least.get(name, 0.0) / std for name, std in self.std.items() if std > 0.0}
        stuck = [p for p in parameters if share.get(p.name, 0.0) > HARDLY and (not wanted or p.name in wanted)]
        if not stuck:
            return NOTHING
        first = stuck[0]
        scale, unit = legible(first.unit)
        now, least = (std_text(of[first.name] * scale) for of in (self.std, self.least))
        parts = {kind: part**2 for kind, part in self.budget[first.name].items() if kind != NOISE}
        kind = max(parts, key=lambda one: parts[one])
        percent = 100.0 * parts[kind] / self.std[first.name] ** 2
        rest = [p.name for p in stuck[1:]]
        gain = phrase("from_to_at_most", "from {now} to {least} {unit} at most", now=now, least=least, unit=unit)
        if now == least:
            gain = phrase("by_nothing", "by nothing, it stays at {now} {unit}", now=now, unit=unit)
        whole = phrase(
            "lasting",
            "{longer} {name} {gain}: tolerances of {kind} are {percent} % of its variance",
            longer=longer,
            name=first.name,
            gain=gain,
            kind=phrase(CAUSE, kind, name=kind),
            percent=f"{percent:.0f}",
        )
        others = ", ".join(rest)
        return phrase("and_likewise", "{whole}; likewise {others}", whole=whole, others=others) if rest else whole


LOOSE = 0.5  # of a variance that is noise, from which on further runs lower it
MOST_NAMED = 3  # parameters of which a sentence says by how much a run lowers their deviations


@dataclass(frozen=True, slots=True)
class Gain:
    """What a run adds to what earlier results say."""

    results: tuple[str, ...]  # their names
    before: dict[str, float]  # standard deviations by them [SI]
    after: Promise  # with the run
    warnings: tuple[str, ...] = ()  # that the earlier results do not agree

    @classmethod
    def of(cls, run: Prediction, known: Known) -> "Gain":
        """That of a run for the load as it is known."""
        before, after = run.beside(known)
        return cls(known.results, before.std, Promise.of([after]), known.warnings)

    @property
    def loose(self) -> tuple[str, ...]:
        """Parameters whose deviations further runs will lower: noise is most of their variance."""
        budget, std = self.after.budget, self.after.std
        return tuple(name for name in budget if budget[name][NOISE] ** 2 > LOOSE * std[name] ** 2)

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        return asdict(self) | {"after": self.after._asdict(), "loose": list(self.loose)}

    @property
    def words(self) -> tuple[str, ...]:
        """What the run lowers most, what stays loose after it, and that the earlier results do not agree."""
        std, named = self.after.std, ", ".join(self.results)
        most = sorted(std, key=lambda name: std[name] / self.before[name])[:MOST_NAMED]
        to = "{name} to {percent} %"
        parts = (phrase("falls_to", to, name=n, percent=f"{100.0 * std[n] / self.before[n]:.0f}") for n in most)
        known = "known by {named}: with this run deviations fall, most {falls} of what they are"
        sentences = [phrase("known_by", known, named=named, falls=enumerated("comma", [*parts]))]
        if self.loose:
            still = "still loose, for noise is most of their variance: {loose}"
            sentences.append(phrase("still_loose", still, loose=", ".join(self.loose)))
        elif self.after.budget:
            nothing = "nothing is loose after it: tolerances are most of every variance"
            sentences.append(phrase("nothing_loose", nothing))
        return (*sentences, *self.warnings)


class Tolerated(NamedTuple):
    """What tolerances add to a prediction; fields are those of `Prediction`."""

    noise: Array  # covariance of u by what noise makes of sizes that are estimated beside it, shape (u, u)
    biases: dict[str, Array]
    lasting: dict[str, Array]


def tolerated_in_motion(
    case: Case, model: Model, values: Array, motion: Trajectory, noise: Array, expected: ExpectedNoise
) -> Tolerated:
    """What the tolerances of a case do to the estimate of a run of a motion, whose delay is estimated too.

    Args:
        model: without weights.
        values: u, shape (u,).
        noise: covariance of u by noise, shape (u, u).
        expected: noise of a sample, with the weights of the estimate.
    """
    count = int(np.clip(RATE * motion.duration, FEWEST, MOST))
    t = (np.arange(count) + 0.5) * motion.duration / count

    def forces(at: Array) -> Array:
        return expected_forces(model, _load(case, motion, at)[0], values)

    ends = np.clip(t - SHIFT, 0.0, None), np.clip(t + SHIFT, None, motion.duration)
    late = (forces(ends[0]) - forces(ends[1])) / (ends[1] - ends[0])[:, None]
    load, drives = _load(case, motion, t)
    each = case.recording.rate_Hz * motion.duration / count / expected.sensors**2
    return _tolerated(case, model, values, _Sampled(t, load, drives, late), noise, expected, each)


def tolerated_at_poses(
    case: Case, model: Model, values: Array, poses: Array, noise: Array, expected: ExpectedNoise, averaged: float
) -> Tolerated:
    """What the tolerances of a case do to the estimate of averaged standstills.

    Args:
        poses: shape (n, k) [m or rad].
        averaged: standard deviation of an averaged force [N]; the others are as above.
    """
    machine = machine_of(case)
    places = machine.drives(poses)
    drives = places, np.zeros_like(places), np.zeros_like(places)
    load = machine.kinematics(*drives, poses if machine.of_pose else None)
    t = np.arange(1.0, len(poses) + 1)
    return _tolerated(case, model, values, _Sampled(t, load, drives), noise, expected, averaged**-2)


class _Sampled(NamedTuple):
    """What moves at instants of a plan, or at its poses."""

    t: Array  # instants [s], of poses their numbers, shape (n,)
    load: Kinematics
    drives: tuple[Array, Array, Array]  # places, speeds and accelerations, each of shape (n, k)
    late: Array | None = None  # forces of a delay of 1 s, shape (n, 6) [N/s]; None where there is none to estimate


def _load(case: Case, motion: Trajectory, t: Array) -> tuple[Kinematics, tuple[Array, Array, Array]]:
    """Motion of the load's frame at instants, shape (n,) [s], and places, speeds and accelerations of the drives."""
    machine, at = machine_of(case), motion.at(t)
    drives = machine.drives(at.coordinates), at.rates, at.accelerations
    if machine.of_pose:
        speeds, accelerations = machine.further_drives(case, at.coordinates, at.rates, at.accelerations)[0]
        drives = drives[0], speeds, accelerations
    return machine.kinematics(*drives, at.coordinates if machine.of_pose else None), drives


def _tolerated(
    case: Case, model: Model, values: Array, at: _Sampled, noise: Array, expected: ExpectedNoise, share: float
) -> Tolerated:
    """What tolerances do to an estimate from samples.

    Args:
        share: samples that each of them stands for, over the variance of the sensors' noise [1/N^2].
    """
    # SciPy, which plans of cases without tolerances do without
    from identification.estimation.alternatives import Remainder
    from identification.findings.left_out import LeftOut, Names
    from identification.findings.told import joint_covariance, shown, worth_estimating
    from identification.findings.tolerances import shares_of
    from identification.samples.samples import MotionOfSamples

    bars, count, t, late = case.sensor_frame.bars, len(values), at.t, at.late
    of_samples = MotionOfSamples(np.ones(len(t), dtype=bool), at.load, at.drives, machine_of(case))
    ends = None if bars is None else (bars.lower.points, bars.upper.points)
    none = np.zeros(0, dtype=np.int64)
    left_out = LeftOut(model, of_samples, values, t, late is not None, 1.0, none, Names.of(case), bars=ends)
    root = np.eye(6) if expected.whitening is None else expected.whitening
    channels = root @ expected.channels @ root.T / expected.sensors**2
    columns = left_out.matrices if late is None else np.concatenate([left_out.matrices, late[:, :, None]], axis=2)
    rest = Remainder.of(
        columns, columns, np.zeros((len(t), 6)), root.T @ root, np.arange(len(t)), coloured=False, freedom=6.0 * len(t)
    )
    shares = shares_of(left_out, rest, np.eye(columns.shape[2]), case.tolerances)
    plain = {s.key: s.biases[:count] for s in shares if s.biases.shape[1]}
    nothing = Tolerated(np.zeros((count, count)), plain, plain)
    estimated_sizes = shown(shares, case)
    if not estimated_sizes or case.sensors.pose_field is not None:  # errors of the pose look like sizes, and hide them
        return nothing
    strength = share * _strength(np.concatenate([s.residuals for s in estimated_sizes], axis=2), channels)
    both = np.concatenate([s.biases[:count] for s in estimated_sizes], axis=1)
    stays = joint_covariance(strength)
    if not worth_estimating(np.diag(noise + both @ both.T), np.diag(noise + both @ stays @ both.T)):
        return nothing

    def with_sizes(stay: Array) -> dict[str, Array]:
        parts = np.split(both @ stay, np.cumsum([s.biases.shape[1] for s in estimated_sizes])[:-1], axis=1)
        return plain | {s.key: part for s, part in zip(estimated_sizes, parts, strict=True)}

    by_noise = both @ stays @ strength @ stays @ both.T
    return Tolerated(by_noise, with_sizes(stays), with_sizes(joint_covariance(LONG * strength)))


def _strength(residuals: Array, channels: Array) -> Array:
    """How well residuals show sizes: G^T N^-1 G, N what noise makes of their scores, shape (k, k).

    Args:
        residuals: what a fit leaves of their effects, weighted, shape (n, 6, k).
        channels: covariance of a weighted sample, shape (6, 6).
    """
    both = ((0, 1), (0, 1))
    values, vectors = np.linalg.eigh(np.tensordot(residuals, residuals, both))
    significant = values > ROUNDING * values[-1]
    through = np.sqrt(values[significant])
    scored = residuals @ (vectors[:, significant] / through)
    noise = np.tensordot(scored, channels @ scored, both)
    directions = (vectors[:, significant] * through).T
    return np.asarray(directions.T @ np.linalg.solve(noise, directions))
