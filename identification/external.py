"""The measurement model in use: external force and moment from sensor forces, (1) and (10)-(15), tare, and payloads.

With f^ = A u the forces that the model expects without contact (18), (1) reads f_Ext = -J^-T (f_q - f^), in {P}. A
payload is the rigid body that was added from one identification to another.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from cases.basis import KEPT
from cases.errors import IdentificationError
from cases.recording_format import WRENCH
from cases.units import Array, as_html
from identification.estimation.biases import drifted_since, shifted_all_along
from identification.finding import FINDINGS, Finding, Kind, Severity, sentences, warning
from identification.model import Model
from identification.outcome import Result
from identification.parameters import FIRST_MOMENT, INERTIA, MASS, Block, offset_columns
from identification.recording import Recording
from identification.result import Value, physical_values
from identification.runs.preparation import moving_run, on_one_clock
from identification.runs.sample_checks import unmeasured
from identification.runs.standstills import standstills


class ExternalForce(NamedTuple):
    """External force and moment on the platform, about the origin of {P} and along its axes."""

    t: Array  # time, shape (n,) [s]; numbers of the standstills where there is no clock
    wrench: Array  # shape (n, 6) [N, N m]
    residuals: Array  # residuals of the sensors, measured less expected, shape (n, 6) [N, or N and N m]
    findings: tuple[Finding, ...] = ()  # what was not measured and is left out, and offsets that have drifted

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that people should act on."""
        return sentences(self.findings, Severity.WARNING)

    @property
    def rms(self) -> Array:
        """Root mean square of each component, shape (6,) [N, N m]."""
        return np.asarray(np.sqrt(np.mean(self.wrench**2, axis=0)))

    @property
    def peak(self) -> Array:
        """Largest magnitude of each component, shape (6,) [N, N m]."""
        return np.asarray(np.abs(self.wrench).max(axis=0))

    def __repr__(self) -> str:
        """How long it is, and rms and peak of each component."""
        components = zip(WRENCH, self.rms, self.peak, strict=True)
        size = f"{len(self.t)} samples from {self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self.t) else "no samples"
        lines = [f"External force and moment in {{P}}: {size}"]
        lines += [f"{name}: rms {rms:.4g}, peak {peak:.4g}" for name, rms, peak in components]
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        return as_html(self)


def force(recording: Recording, result: Result, whole: bool = True) -> ExternalForce:
    """External force and moment over a recording, in {P}; of a moving run behind the filter of the case.

    Args:
        result: identified parameters of the same machine; their delay is compensated.
        whole: whether all samples are evaluated; else only the excitation.

    Raises:
        FileProblem: parameters of another case.
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    model, case = result.model, result.case
    recording = on_one_clock(recording, case)
    checks = unmeasured(recording)
    findings = checks.findings
    if recording.t is None or case.setup == "1a":
        still = standstills(recording, case, model, checks)
        t, forces, matrices, poses = still.t, still.recorded, still.matrices, None
        if model.struts is not None and recording.struts is not None:
            poses = model.struts.hexapod.coordinates(recording.struts[~checks.bad])
    else:
        run = moving_run(recording, case, model, whole, checks)
        findings += run.window
        t, forces, matrices = run.t, run.forces, run.regressors(result.delay)
        poses = None if model.struts is None else run.kinematics(result.delay).pose
    residuals = forces - matrices @ result.values
    variance = np.diag(result.covariance_robust)[offset_columns(model)]
    findings += tuple(shifted_all_along(residuals, variance, case))
    return ExternalForce(t, -model.wrenches(residuals, poses), residuals, findings)


STILL = 1e-4  # [m or rad] that drives may move in a standstill: encoder noise and drift, not motion


def tare(recording: Recording, result: Result) -> Result:
    """The result with sensor offsets f_q0 (11) identified anew from a standstill without contact; all else stays.

    Offsets and the rest no longer vary together. Notes say which offsets have drifted since the result.

    Raises:
        IdentificationError: the machine moves, or there are fewer than two samples.
        FileProblem: parameters of another case.
    """
    model, case = result.model, result.case
    recording = on_one_clock(recording, case)
    checks = unmeasured(recording)
    count = int(np.sum(~checks.bad))
    if count < 2:
        raise IdentificationError(recording.source, f"{count} sample; a tare needs a standstill of two or more")
    travel = 0.0 if recording.struts is None else float(np.ptp(recording.struts[~checks.bad], axis=0).max())
    if travel > STILL:
        drives, unit = case.drive_words
        raise IdentificationError(
            recording.source,
            f"{drives} move by {travel * 1e3:.3g} {unit}, at most {STILL * 1e3:g} {unit} in a "
            "standstill; cut the motion off",
        )
    still = standstills(recording, case, model, checks)
    residuals = still.recorded - still.matrices @ result.values
    change, variance = residuals.mean(axis=0), residuals.var(axis=0, ddof=1) / count
    offsets = offset_columns(model)
    values, covariance, robust = result.values.copy(), result.covariance.copy(), result.covariance_robust.copy()
    drift = drifted_since(change, np.sqrt(variance + np.diag(robust)[offsets]), case, result.source)
    values[offsets] += change
    for square in (covariance, robust):
        square[offsets, :] = square[:, offsets] = 0.0
        square[offsets, offsets] = variance
    physical, freedom = physical_values(model, values, covariance, robust), result.record["degrees_of_freedom"]
    record = dict(result.record) | {
        "parameters": {name: value._asdict() for name, value in physical.items()},
        "intervals_95": {name: list(value.interval(freedom)) for name, value in physical.items()},
        "linear": {"names": model.names, "values": values.tolist()},
        "covariance": covariance.tolist(),
        "covariance_robust": robust.tolist(),
        "notes": [*result.notes, *sentences(drift, Severity.NOTE)],
        "findings": FINDINGS.dump_python((*result.findings, *drift), mode="json"),
        "tared_with": recording.source,
    }
    return Result(case, record)


LEVEL = 1e-3  # share of gravity along an axis from which on the payload's place along it is uncertain
UNLIKELY = 1e-3  # chance of so large a misfit of a weight by noise


class Payload(NamedTuple):
    """The payload between two results."""

    parameters: dict[str, Value]  # mass, centre of gravity in {P} and inertia about it (where both results have it)
    findings: tuple[Finding, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that people should act on."""
        return sentences(self.findings, Severity.WARNING)


def payload_on_table(before: Result, after: Result) -> Payload:
    """The payload that was put on a frame that does not move, from the offsets without and with it (setup 1a).

    Its weight pulls along gravity alone: the component of the centre of gravity along gravity stays unknown, and so do
    all of xC, yC, zC that have a share in it; the warnings name them.

    Both models are of offsets only.

    Raises:
        IdentificationError: the difference in mass is not significant.
    """
    body = replace(after.model, blocks=(MASS, FIRST_MOMENT))
    still = np.zeros((1, 6))
    matrix = body.matrices(np.zeros((1, 3)), np.eye(3)[None], still, still)[0]
    white = np.diag(before.covariance + after.covariance)
    robust = np.diag(before.covariance_robust + after.covariance_robust)
    variance = np.maximum(np.maximum(white, robust), np.finfo(float).tiny)
    root = 1.0 / np.sqrt(variance)
    along = np.abs(body.gravity) > LEVEL * np.linalg.norm(body.gravity)
    # The unknown direction stays free, so that the others do not take over its share.
    spread = np.linalg.pinv(matrix * root[:, None], rcond=1e-9) * root
    u = spread @ (after.values - before.values)
    of_u = (spread * variance) @ spread.T
    std = float(np.sqrt(of_u[0, 0]))
    if not abs(u[0]) > 3.0 * std:
        raise _no_payload(before, after, float(u[0]), std)
    residuals = (after.values - before.values - matrix @ u) * root
    findings = _about(before, after, float(u[0]))
    if float(residuals @ residuals) > float(chdtri(3, UNLIKELY)):
        sentence = "the change of the forces is not a weight alone: something pushes, or a sensor has drifted"
        findings.append(warning(Kind.MODEL, sentence))
    names = [n for n, a in zip(("xC", "yC", "zC"), along, strict=True) if a]
    sentence = f"{', '.join(names)} not determined: gravity acts along it, and the frame does not move; weigh the "
    findings.append(warning(Kind.MODEL, f"{sentence}payload in another orientation"))
    physical = physical_values(body, u, of_u, of_u)
    return Payload({name: value for name, value in physical.items() if name not in names}, tuple(findings))


def require_two(before: Result, after: Result) -> None:
    """Refuses one recording as both.

    Raises:
        IdentificationError: both results are of the same files.
    """
    if before.source == after.source:
        raise IdentificationError(after.source, "is named twice; name the result without the payload, then with it")
    if before.recordings and before.recordings == after.recordings:
        raise IdentificationError(
            after.source,
            f"is of the same recording as {before.source}; name the result of a run without the "
            "payload, then of one with it",
        )


def _no_payload(before: Result, after: Result, mass: float, std: float) -> IdentificationError:
    return IdentificationError(
        after.source,
        f"mass differs from {before.source} by {mass:.4g} +- {std:.2g} kg, not by a payload; name the "
        "results without and with payload, in this order",
    )


def _about(before: Result, after: Result, mass: float) -> list[Finding]:
    findings = []
    if before.model.number != after.model.number:
        numbers = f"{before.model.number} and {after.model.number}"
        findings.append(warning(Kind.MODEL, f"models {numbers} differ: masses of different models do not compare"))
    if before.record.get(KEPT) != after.record.get(KEPT):
        findings.append(warning(Kind.CASE, "the case was changed between the two identifications"))
    if mass < 0.0:
        sentence = "the mass became smaller: this is what was taken off, as a negative payload"
        findings.append(warning(Kind.MODEL, sentence))
    return findings


def payload_between(before: Result, after: Result) -> Payload:
    """The body that has to be added to `before` to get `after`; the two runs are independent.

    Mass, first moments and inertia about the origin of {P} of rigid bodies add, so their differences are those of the
    payload, and covariances add. What two different models blame on mass differs (section 5): then a warning says so.

    Raises:
        IdentificationError: the difference in mass is not significant, so that there is no centre of gravity.
    """
    model_before, model_after = before.model, after.model
    shared: tuple[Block, ...] = (MASS, FIRST_MOMENT)
    if INERTIA in model_before.blocks and INERTIA in model_after.blocks:
        shared = (*shared, INERTIA)
    body = Model(model_after.number, shared, model_after.structure, model_after.gravity)
    old = [model_before.names.index(name) for name in body.names]
    new = [model_after.names.index(name) for name in body.names]
    difference = after.values[new] - before.values[old]
    covariance = after.covariance[np.ix_(new, new)] + before.covariance[np.ix_(old, old)]
    robust = after.covariance_robust[np.ix_(new, new)] + before.covariance_robust[np.ix_(old, old)]
    std = float(np.sqrt(max(covariance[0, 0], robust[0, 0])))
    if not abs(difference[0]) > 3.0 * std:
        raise _no_payload(before, after, float(difference[0]), std)
    findings = _about(before, after, float(difference[0]))
    return Payload(physical_values(body, difference, covariance, robust), tuple(findings))
