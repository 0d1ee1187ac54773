"""What an identification reports: parameters in both forms with standard deviations, and how well the model fits."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AliasPath,
    BaseModel,
    BeforeValidator,
    Field,
    NonNegativeFloat,
    PlainSerializer,
    PositiveInt,
)

from cases.base.provenance import provenance
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.estimators import Method
from identification.estimation.fit import Fit, Value
from identification.estimation.nearest_body import NearestBody
from identification.finding import SEVERITIES, Finding, sentences
from identification.model.model import Model
from identification.model.parameters import physical_form
from identification.motion.motion import Trajectory
from identification.recording.record import RunOrigin
from identification.samples.samples import Fitted, Samples


@dataclass(frozen=True, slots=True)
class Estimate:
    """The result of an identification: a fit without its regression, which is large, and what was found about it."""

    case: Case
    source: str  # the recording
    method: Method
    # u alone, without nuisances; `residuals`, not saved, are those behind the filter; `weights` are ones where only
    # ratios count
    fit: Fit
    samples: Samples  # samples that were evaluated
    residuals: Array  # recorded forces less the model, shape (n, 6) [N, or N and N m]
    s0: float  # (27), of the recorded forces; dimensionless where weights are given, else [N]
    delay: Value | None  # delay of the forces [s], where it was estimated
    physical: dict[str, Value]  # physical parameters by name
    findings: tuple[Finding, ...]  # what speaks against it, and what is good to know
    # of u by one standard deviation of each size that a tolerance of the case is one of, shape (u, k), by its key
    biases: Mapping[str, Array] = field(default_factory=dict)
    planned: tuple[Trajectory, float] | None = None  # motion of its plan, and when that begins [s], where it is known

    @property
    def model(self) -> Model:
        """The model that was identified."""
        return self.samples.model

    @property
    def at(self) -> float:
        """The delay, 0 where nothing moves [s]."""
        return 0.0 if self.delay is None else self.delay.value

    @property
    def residual_rms(self) -> Array:
        """Residuals' rms of each channel, shape (6,) [N, or N and N m]."""
        return np.asarray(np.sqrt(np.mean(self.residuals**2, axis=0)))

    @property
    def s0_N(self) -> float:
        """Rms residual of the recorded forces, over the channels in newtons [N]."""
        newtons = slice(0, 3 if self.case.sensor_frame.has_moments else 6)
        return float(np.sqrt(np.mean(self.residuals[:, newtons] ** 2)))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that people should act on."""
        return sentences(self.findings, "warning")

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that are good to know."""
        return sentences(self.findings, "note")

    @property
    def quantities(self) -> dict[str, Any]:
        """Entries of the findings for programs, by their keys in result files."""
        return {key: value for finding in self.findings for key, value in finding.quantity.items()}


def physical_values(model: Model, u: Array, covariance: Array, robust: Array) -> dict[str, Value]:
    """Physical parameters by name, of u, shape (u,), with its covariance by (28) and the robust one, shapes (u, u)."""
    form = physical_form(model)
    values, white = form.of(u, covariance)
    std, std_robust = (np.sqrt(np.diag(c).clip(0.0)) for c in (white, form.of(u, robust)[1]))
    return {
        p.name: Value(float(v), float(s), float(r), p.unit)
        for p, v, s, r in zip(form.parameters, values, std, std_robust, strict=True)
    }


def estimate_of(
    fitted: Fitted,
    source: str,
    case: Case,
    findings: tuple[Finding, ...],
    biases: Mapping[str, Array] | None = None,
) -> Estimate:
    """The estimate of a fit; columns of the fit beyond the model's parameters are nuisances, which it leaves out."""
    fit, model = fitted.fit, fitted.samples.model
    parameters = slice(len(model.parameters))
    u, white, robust = (
        fit.values[parameters],
        fit.covariance[parameters, parameters],
        fit.covariance_robust[parameters, parameters],
    )
    fit = replace(fit, values=u, covariance=white, covariance_robust=robust)
    physical = physical_values(model, u, white, robust)
    of_u = {key: bias[parameters] for key, bias in (biases or {}).items()}
    return Estimate(
        case, source, fitted.method, fit, fitted.samples, fitted.residuals, _s0(fitted), fitted.delay, physical,
        findings, of_u,
    )  # fmt: skip


def _s0(fitted: Fitted) -> float:
    """The value of (27) for the recorded forces, with the degrees of freedom of the estimated parameters.

    Where only some of the samples of a run are evaluated, their mean square stands for that of all.
    """
    samples, residuals = fitted.samples, fitted.residuals * np.reshape(fitted.samples.scale, (-1, 1))
    forces = residuals.shape[1] * samples.recorded_count
    freedom = forces - len(fitted.method.selection(samples.model).names)
    power = float(np.mean(np.einsum("nk,kl,nl->n", residuals, fitted.w, residuals)))
    return float(np.sqrt(power * samples.recorded_count / freedom))


SCHEMA_VERSION = 1


def _in_seconds(entry: Any) -> Any:
    return {"std_robust": entry.get("std"), "unit": "s"} | entry if isinstance(entry, dict) else entry


Numbers = tuple[float, ...]
Entries = Mapping[str, Any]  # an object of a JSON file
Physical = Annotated[Value, PlainSerializer(Value._asdict)]
Delay = Annotated[
    Value,
    BeforeValidator(_in_seconds),
    PlainSerializer(lambda delay: {"value": delay.value, "std": delay.std}),
]
Input = Annotated[Mapping[Literal["file", "sha256"], str], Field(min_length=2)]


class ResultEntries(BaseModel, strict=True, frozen=True, allow_inf_nan=False, populate_by_name=True):
    """Entries of `result.json`; those with a default may be absent."""

    # what it was made of
    case: str
    case_hash: str
    case_file: str | None = None
    recording: str
    inputs: tuple[Input, ...]
    versions: Mapping[str, str]
    computed_from: Entries | None = None  # values of the case by dotted key
    measuring_s: NonNegativeFloat | None = None
    plan_hash: str | None = None
    run: RunOrigin | None = None
    recorded_at: str | None = None  # date of the first of the files that were read
    # of each channel as white noise by its residuals, `measured` and `stated`, and rms of these, `evaluated` behind the
    # filter
    channel_noise: Entries | None = None
    standstills: Entries | None = None
    models: Entries | None = None  # all models of the run, see `ModelChoice`, where this one was chosen among them
    treatment: Entries | None = None  # another treatment of the data, and what it changes beside the default
    pooled: Entries | None = None  # the results that it is the mean of, and how far they scatter, see `pool`
    tared_with: str | None = None
    tared: Mapping[str, Entries] | None = None  # of each channel its offset `before` and `after`, with `change_std`
    stale: tuple[str, ...] = ()

    # parameters in both forms [SI], and what was known of them
    model: int
    known: Entries | None = None
    dropped: tuple[str, ...] = ()
    priors: Entries | None = None
    parameters: Mapping[str, Physical]
    names: tuple[str, ...] = Field(validation_alias=AliasPath("linear", "names"))
    values: Numbers = Field(validation_alias=AliasPath("linear", "values"))
    covariance: tuple[Numbers, ...]  # covariance of the linear ones by (28)
    covariance_robust: tuple[Numbers, ...]
    # of the linear ones by one standard deviation of each size that a tolerance is one of, by its key of [tolerances];
    # all runs of a machine have these in common
    tolerance_biases: Mapping[str, tuple[Numbers, ...]] | None = None
    physical: NearestBody | None = None  # nearest body that can exist, where that is not the estimate
    delay_s: Delay | None

    # how well the model fits
    weights: str
    s0: NonNegativeFloat  # (27)
    white_noise: NonNegativeFloat
    s0_N: NonNegativeFloat
    residual_rms: Annotated[tuple[NonNegativeFloat, ...], Field(min_length=6, max_length=6)]
    samples: PositiveInt
    degrees_of_freedom: float
    rank: PositiveInt
    condition: NonNegativeFloat
    findings: tuple[Finding, ...]

    def replaced(self, **changes: Any) -> Self:
        """The same with other entries."""
        return type(self)(**{name: getattr(self, name) for name in self.model_fields_set} | changes)

    def to_json(self) -> dict[str, Any]:
        """The object of the file: intervals, `notes`, `warnings` and what findings say in numbers stand beside them."""
        entries = self.model_dump(mode="json", exclude_unset=True)
        entries["linear"] = {key: entries.pop(key) for key in ("names", "values")}
        intervals = {name: list(p.interval(self.degrees_of_freedom)) for name, p in self.parameters.items()}
        expanded = {name: p.expanded for name, p in self.parameters.items()}
        texts = {f"{severity}s": list(sentences(self.findings, severity)) for severity in SEVERITIES}
        quantities = {key: value for finding in entries["findings"] for key, value in finding["quantity"].items()}
        return {
            "schema_version": SCHEMA_VERSION,
            **entries,
            "intervals_95": intervals,
            "expanded_k2": expanded,
            **texts,
            **quantities,
        }


def of_version_0_2(entries: dict[str, Any]) -> dict[str, Any]:
    """Entries of a file, also of version 0.2, whose `s0` is the white noise: of a run (27) follows where W = 1."""
    if "white_noise" in entries or "s0" not in entries:
        return entries
    upgraded = {**entries, "white_noise": entries["s0"]}
    with suppress(KeyError, TypeError, ValueError):  # what is damaged is said by field
        if entries["weights"] == "equal" and entries["delay_s"] is not None:
            mean = sum(float(rms) ** 2 for rms in entries["residual_rms"])
            upgraded["s0"] = float(np.sqrt(mean * entries["samples"] / (6 * entries["samples"] - entries["rank"])))
    return upgraded


def entries_of(estimate: Estimate, files: Sequence[Path] = (), **origin: Any) -> ResultEntries:
    """Entries of an estimate.

    Args:
        files: files that were read.
        origin: what else it was made of, by field of `ResultEntries`.
    """
    about = provenance(files)
    common: dict[str, Any] = {"tolerance_biases": rows_of(estimate.biases)} if estimate.biases else {}
    fit, method, model, case = estimate.fit, estimate.method, estimate.model, estimate.case
    return ResultEntries(
        case=case.name,
        case_hash=case.hash,
        recording=estimate.source,
        inputs=tuple(about["inputs"]),
        versions=about["versions"],
        model=model.number,
        known=method.known,
        dropped=tuple(method.dropped),
        priors={p.name: {"value": p.value, "std": p.std} for p in method.priors},
        **entries_of_parameters(estimate.physical, fit.values, fit.covariance, fit.covariance_robust),
        names=tuple(model.names),
        **common,
        delay_s=estimate.delay,
        weights=method.weights or case.sensors.weights,
        s0=estimate.s0,
        white_noise=fit.white_noise,
        s0_N=estimate.s0_N,
        residual_rms=tuple(estimate.residual_rms.tolist()),
        samples=estimate.samples.recorded_count,
        degrees_of_freedom=fit.freedom,
        rank=fit.rank,
        condition=fit.condition,
        findings=estimate.findings,
        **origin,
    )


def rows_of(biases: Mapping[str, Array]) -> dict[str, tuple[tuple[float, ...], ...]]:
    """Biases by tolerances as an entry."""
    return {key: tuple(map(tuple, bias.tolist())) for key, bias in biases.items() if bias.shape[1]}


def entries_of_parameters(physical: Mapping[str, Value], u: Array, covariance: Array, robust: Array) -> dict[str, Any]:
    """Entries on parameters: physical ones by name, and the linear ones u with both covariances."""
    return {
        "parameters": physical,
        "values": tuple(u.tolist()),
        "covariance": tuple(map(tuple, covariance.tolist())),
        "covariance_robust": tuple(map(tuple, robust.tolist())),
    }
