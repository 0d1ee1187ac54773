"""The estimators that a user can name, each as a function of one type, and what they are made for.

Selections and consistency wrap an estimator, so that each combination that makes sense is a composition.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cases.errors import IdentificationError
from cases.schema import Case
from cases.units import Array
from identification.estimation.biases import OFFSET_NAMES, Biases
from identification.estimation.channel_weights import full_weights, per_channel
from identification.estimation.compressed import gauss_markov
from identification.estimation.fit import EACH, Fit, Regression, StatedNoise
from identification.estimation.nonlinear import estimate_selected, nonlinear
from identification.estimation.priors import Prior, with_priors
from identification.estimation.robust import consistent, huber
from identification.finding import Kind, note, warning
from identification.model import Model
from identification.parameters import Selection, physical_form, select

THINNEST = 1e-3  # [m] rms distance of a body's mass from any plane: thinner than any tool or workpiece
PER_UNIT = (0, 0, 0, 1, 1, 1)  # channels of a force/torque sensor: forces, moments
UNLIKELY = 1e-3  # chance of so inconsistent an estimate below which it is reported
WHITENED = ("gauss-markov", "consistent", "nonlinear")  # which take forces whose noise is white in all channels
WEIGHTS = ("equal", "per_channel", "per_unit", "stated")
CONFLICT = 3.0  # standard deviations between data and a prior from which it is reported


@dataclass(frozen=True, slots=True)
class FitProblem:
    """Properties of a problem that a regression does not state."""

    model: Model  # model that the first columns of the regressors belong to
    pooled: bool  # all channels have the same noise, as identical sensors do; else each its own
    alike: tuple[int, ...] = EACH  # where they are not pooled, channels with the same number have the same noise
    # noise that the case states and that W follows from; forces and regressors are then multiplied with its `whitening`
    # before they are estimated from, after which all channels are alike
    noise: StatedNoise | None = None

    @classmethod
    def of(cls, model: Model, case: Case, how: "Method") -> "FitProblem":
        """The problem with the noise of the channels by the method's weights, or else by the case's.

        Raises:
            IdentificationError: weights from stated noise where none is stated, or with an estimator of their own.
        """
        weights = how.weights or case.sensors.weights
        if weights == "stated":
            if how.name not in WHITENED:
                raise IdentificationError(
                    f"the weights stated go with the estimators {', '.join(WHITENED)}; {how.name} finds its own"
                )
            return cls(model, True, noise=StatedNoise.of(model, case.sensors))
        return cls(model, weights == "equal", alike=PER_UNIT if weights == "per_unit" else EACH)


@dataclass(frozen=True, slots=True)
class Method:
    """How parameters are estimated."""

    name: str  # name of the estimator
    known: Mapping[str, float]  # exact values by linear or physical name [SI]
    dropped: tuple[str, ...]  # linear parameters without a column
    priors: tuple[Prior, ...]
    # `equal`, `per_channel`, `per_unit` or `stated`, see `cases.sensors`; None for those of the case
    weights: str | None = None
    # offsets from another result, which are among the known values; their uncertainty is propagated
    biases: Biases | None = None

    @property
    def plain(self) -> bool:
        """Whether it is Gauss-Markov with all parameters free and nothing known beforehand."""
        return self.name == "gauss-markov" and not (self.known or self.dropped or self.priors)

    @property
    def without_biases(self) -> "Method":
        """The same with the offsets of the forces free."""
        offsets = {} if self.biases is None else self.biases.known
        return replace(self, known={n: v for n, v in self.known.items() if n not in offsets}, biases=None)

    def selection(self, model: Model) -> Selection:
        """What of a model is estimated, where the problem is linear; for the non-linear form all of it.

        Raises:
            IdentificationError: names that the model does not have, or known values that are not linear.
        """
        return select(model, {} if self.name == "nonlinear" else self.known, self.dropped)

    def estimate(self, regression: Regression, problem: FitProblem) -> Fit:
        """The estimate of all parameters of a problem.

        Raises:
            IdentificationError: a combination that is not defined, names that the model does not have, or as the
                estimator does.
        """
        selected = bool(self.known or self.dropped)
        if self.priors:
            if self.name != "gauss-markov" or selected:
                raise IdentificationError(
                    "priors go with the estimator gauss-markov and all parameters free; leave the other choice out, "
                    "or give what is known exactly as a prior with a small standard deviation"
                )
            return _with_priors(regression, problem, self.priors)
        if self.name == "nonlinear":
            if self.dropped:
                raise IdentificationError(
                    "the estimator nonlinear knows values of physical parameters, no dropped columns; fix them to 0"
                )
            return _nonlinear(regression, problem, self.known)
        estimator = ESTIMATORS[self.name]
        if selected:
            selection = self.selection(problem.model)
            fit = estimate_selected(regression, selection, lambda free: estimator(free, problem))
        else:
            fit = estimator(regression, problem)
        return _consistent(regression, fit) if self.name == "consistent" else fit


def gauss_markov_of(regression: Regression, problem: FitProblem) -> Fit:
    """(24) with W = 1, or from the variance of each channel."""
    return gauss_markov(regression, np.ones(6)) if problem.pooled else per_channel(regression, problem.alike)


def robust_of(regression: Regression, problem: FitProblem) -> Fit:
    """Huber's M-estimate: gross errors of the forces count less."""
    fit, factors = huber(regression, problem.pooled, problem.alike)
    share = ", ".join(f"{100 * r:.0f}" for r in np.mean(factors < 1.0, axis=0))
    sentence = f"robust: {share} % of the samples of channels 1 to 6 count less (18 % where noise is Gaussian)"
    return replace(fit, findings=(note(Kind.ESTIMATOR, sentence), *fit.findings))


ESTIMATORS: dict[str, Callable[[Regression, FitProblem], Fit]] = {
    "gauss-markov": gauss_markov_of,
    "robust": robust_of,
    "full": lambda regression, problem: full_weights(regression)[0],  # (24) with W from the channels' full covariance
    "consistent": gauss_markov_of,  # then the nearest parameters that a body of positive density has
    "nonlinear": gauss_markov_of,  # (18) in physical parameters, by Gauss-Newton, which needs no estimator of u
}


def method(
    name: str = "gauss-markov",
    known: Mapping[str, float] | None = None,
    dropped: Sequence[str] = (),
    priors: Sequence[Prior] = (),
    weights: str | None = None,
    biases: Biases | None = None,
) -> Method:
    """A method by the name of its estimator.

    Raises:
        IdentificationError: no such estimator or weights, with those that there are; biases given otherwise too.
    """
    if weights is not None and weights not in WEIGHTS:
        raise IdentificationError(f"weights {weights!r} are unknown; choose {', '.join(WEIGHTS)}")
    if name not in ESTIMATORS:
        raise IdentificationError(f"estimator {name!r} is unknown; choose {', '.join(ESTIMATORS)}")
    known = dict(known or {})
    if biases is not None:
        twice = [n for n in OFFSET_NAMES if n in known or n in dropped]
        if name != "gauss-markov" or priors or twice:
            other = f"{twice[0]} given otherwise" if twice else "priors" if priors else f"the estimator {name}"
            raise IdentificationError(f"--biases {biases.source}", f"does not go with {other}; leave one of them out")
        known |= biases.known
    return Method(name, known, tuple(dropped), tuple(priors), weights, biases)


def _consistent(regression: Regression, free: Fit) -> Fit:
    fit, rise, p_value = consistent(regression, free, THINNEST)
    sentence = "consistent: the estimate is that of a real body, the constraint did not bind"
    if rise:
        sentence = f"consistent: the constraint bound and raised chi^2 by {rise:.3g} s0^2; chance does so in at most "
        sentence += f"{100 * p_value:.2g} % of runs"
    findings = (*fit.findings, note(Kind.ESTIMATOR, sentence))
    if rise and p_value < UNLIKELY:
        far = "no real body is near what the data say; model or data are wrong"
        findings = (*findings, warning(Kind.ESTIMATOR, far))
    return replace(fit, findings=findings)


def _nonlinear(regression: Regression, problem: FitProblem, known: Mapping[str, float]) -> Fit:
    physical = [p.name for p in physical_form(problem.model).parameters]
    linear = [name for name in known if name in problem.model.names and name not in physical]
    if linear:
        raise IdentificationError(
            f"the estimator nonlinear knows physical parameters, not {', '.join(linear)}; fix {', '.join(physical)}"
        )
    return nonlinear(regression, problem.model, _weights(regression, problem), known)


def _weights(regression: Regression, problem: FitProblem) -> Array:
    """Diagonal of W for one sample, shape (6,), by Gauss-Markov where channels differ."""
    return np.ones(6) if problem.pooled else gauss_markov_of(regression, problem).weights


def _with_priors(regression: Regression, problem: FitProblem, priors: Sequence[Prior]) -> Fit:
    fit, effects = with_priors(regression, problem.model, _weights(regression, problem), priors)
    findings = []
    for effect in effects:
        sentence = f"prior {effect.prior.name} = {effect.prior.value:.6g} +- {effect.prior.std:.2g}: the data hold "
        sentence += f"{100 * effect.data_share:.0f} % of what is known about it"
        if effect.data_share > 0.0:
            sentence += f", it moved the estimate by {effect.moved:+.2g} of their standard deviations"
        findings.append(note(Kind.ESTIMATOR, sentence))
        if abs(effect.conflict) > CONFLICT:
            sentence = f"prior {effect.prior.name} disagrees with the data by {abs(effect.conflict):.1f} standard "
            findings.append(warning(Kind.ESTIMATOR, f"{sentence}deviations; doubt one of them"))
    return replace(fit, findings=tuple(findings))
