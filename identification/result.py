"""What an identification says: parameters in both forms with standard deviations, and how well the model fits."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from cases.schema import Case
from identification.estimation.biases import AccelerometerBias
from identification.estimation.estimators import Method
from identification.estimation.fit import Fit
from identification.finding import Finding, Severity, quantities, sentences
from identification.model import ERROR_TERMS, Model, identification_model
from identification.noise.sources import Attenuation, NoiseSources, attenuation_of
from identification.parameters import physical_form
from identification.samples import USUAL, Conditioning, Samples

Array = NDArray[np.float64]

SCHEMA_VERSION = 1


class Delay(NamedTuple):
    """How much later than the motion the forces were recorded, and its standard deviation [s]."""

    value: float
    std: float


class Evaluation(NamedTuple):
    """What was evaluated."""

    evaluated: Samples
    residuals: Array  # recorded forces less the model, shape (n, 6) [N, or N and N m]
    delay: Delay | None  # delay of the forces, where it was estimated
    noise: NoiseSources | None  # what s0 consists of, where the case states noise
    accelerometer: AccelerometerBias | None  # its biases, where standstills have its readings
    conditioning: Conditioning
    findings: tuple[Finding, ...]  # all that is to be told


class Value(NamedTuple):
    """An estimated parameter: SI value, standard deviation by (28), autocorrelation-robust one, and unit."""

    value: float
    std: float
    std_robust: float
    unit: str

    @property
    def reported(self) -> float:
        """The larger of the two standard deviations, which is what people are shown."""
        return max(self.std, self.std_robust)

    def interval(self, freedom: float, level: float = 0.95) -> tuple[float, float]:
        """Confidence interval from the reported standard deviation: what is printed, and what coverage rates."""
        half = float(stdtrit(freedom, 0.5 + level / 2)) * self.reported
        return self.value - half, self.value + half


@dataclass(frozen=True, slots=True)
class Estimate:
    """The result of an identification."""

    case: str  # name of the case
    case_hash: str  # its fingerprint
    source: str  # the recording
    model: int  # number in Table 2
    names: tuple[str, ...]  # names of the linear parameters u
    values: Array  # u, shape (u,)
    covariance: Array  # covariance of u by (28), shape (u, u)
    covariance_robust: Array  # covariance of u, autocorrelation-robust, shape (u, u)
    physical: dict[str, Value]  # physical parameters by name
    # (27); dimensionless with per-channel weights, else [N]. Of a moving run: of the noise in the pass band, as white
    # noise of the recorded forces
    s0: float
    s0_N: float  # rms residual of the recorded forces, over the channels in newtons [N]
    residual_rms: Array  # residuals' rms of each channel, shape (6,) [N, or N and N m]
    samples: int  # used
    freedom: float  # degrees of freedom of the residuals
    rank: int  # rank of the scaled regressor
    condition: float  # condition of the scaled regressor (26)
    weights: str  # `equal`, `per_channel`, `per_unit` or `stated`
    w: Array  # diagonal of W for one sample, shape (6,); ones where only ratios were given [1/N^2, 1/(N m)^2]
    delay: Delay | None  # delay of the forces, where it was estimated
    how: Method
    terms: tuple[str, ...]  # forms of the error compensation other than the model's
    findings: tuple[Finding, ...]  # what speaks against it, and what is good to know
    residuals: Array  # f - A u at the evaluated samples, behind the filter where there is one, shape (n, 6), not saved
    noise_sources: NoiseSources | None  # what s0 consists of, where the case states noise
    # attenuation of physical parameters by name, where the case states noise of the struts
    attenuation: dict[str, Attenuation] | None
    accelerometer: AccelerometerBias | None  # its biases, where standstills have its readings
    evaluated: Samples  # the samples that it was made from, not saved
    conditioning: Conditioning = USUAL

    @property
    def warnings(self) -> tuple[str, ...]:
        """What people should act on."""
        return sentences(self.findings, Severity.WARNING)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is good to know."""
        return sentences(self.findings, Severity.NOTE)

    @property
    def told(self) -> dict[str, Any]:
        """What programs are told beside the figures, by their keys in result files."""
        return quantities(self.findings)

    def to_json(self) -> dict[str, Any]:
        """Everything but the residuals, SI units."""
        return {
            "schema_version": SCHEMA_VERSION,
            "case": self.case,
            "case_hash": self.case_hash,
            "recording": self.source,
            "model": self.model,
            "error_terms": list(self.terms),
            "estimator": self.how.name,
            "known": dict(self.how.known),
            "dropped": list(self.how.dropped),
            "biases": None if self.how.biases is None else self.how.biases.to_json(),
            "accelerometer": None if self.accelerometer is None else self.accelerometer.to_json(),
            "priors": {p.name: {"value": p.value, "std": p.std} for p in self.how.priors},
            "s0": self.s0,
            "s0_N": self.s0_N,
            "residual_rms": self.residual_rms.tolist(),
            "samples": self.samples,
            "degrees_of_freedom": self.freedom,
            "rank": self.rank,
            "condition": self.condition,
            "weights": self.weights,
            "w_diagonal": self.w.tolist(),
            "noise_sources": None if self.noise_sources is None else self.noise_sources.to_json(),
            "attenuation": None
            if self.attenuation is None
            else {name: value._asdict() for name, value in self.attenuation.items()},
            "delay_s": None if self.delay is None else {"value": self.delay.value, "std": self.delay.std},
            "parameters": {name: value._asdict() for name, value in self.physical.items()},
            "intervals_95": {name: list(value.interval(self.freedom)) for name, value in self.physical.items()},
            "linear": {"names": list(self.names), "values": self.values.tolist()},
            "covariance": self.covariance.tolist(),
            "covariance_robust": self.covariance_robust.tolist(),
            "notes": list(self.notes),
            "warnings": list(self.warnings),
            **self.told,
        }


def estimate_of(
    model: Model,
    fit: Fit,
    source: str,
    case: Case,
    evaluation: Evaluation,
    how: Method,
) -> Estimate:
    """Puts a fit into words; columns of the fit beyond the model's parameters are nuisances and left out."""
    unknowns = len(model.parameters)
    linear, covariance = fit.values[:unknowns], fit.covariance[:unknowns, :unknowns]
    form = physical_form(model)
    values, physical_covariance = form.of(linear, covariance)
    covariance_robust = fit.covariance_robust[:unknowns, :unknowns]
    _, robust_covariance = form.of(linear, covariance_robust)
    standard = identification_model(case, model.number).names == model.names
    terms = () if standard else tuple(n for n, b in ERROR_TERMS.items() if b in model.blocks)
    std, robust = (np.sqrt(np.maximum(np.diag(c), 0.0)) for c in (physical_covariance, robust_covariance))
    physical = {
        p.name: Value(float(v), float(s), float(r), p.unit)
        for p, v, s, r in zip(form.parameters, values, std, robust, strict=True)
    }
    noise = evaluation.noise
    attenuation = None
    if noise is not None and noise.bias is not None:
        reported = np.array([value.reported for value in physical.values()])
        attenuation = attenuation_of(form, linear, noise.bias, reported)
    newtons = slice(0, 3 if case.sensor_frame.has_moments else 6)
    return Estimate(
        case=case.name,
        case_hash=case.hash,
        source=source,
        model=model.number,
        names=tuple(model.names),
        values=linear,
        covariance=covariance,
        covariance_robust=covariance_robust,
        physical=physical,
        s0=fit.s0,
        s0_N=float(np.sqrt(np.mean(evaluation.residuals[:, newtons] ** 2))),
        residual_rms=np.sqrt(np.mean(evaluation.residuals**2, axis=0)),
        samples=evaluation.evaluated.samples,
        freedom=fit.freedom,
        rank=fit.rank,
        condition=fit.condition,
        weights=how.weights or case.sensors.weights,
        w=fit.weights,
        delay=evaluation.delay,
        how=how,
        terms=terms,
        findings=evaluation.findings,
        residuals=fit.residuals,
        noise_sources=noise,
        attenuation=attenuation,
        accelerometer=evaluation.accelerometer,
        evaluated=evaluation.evaluated,
        conditioning=evaluation.conditioning,
    )
