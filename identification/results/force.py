"""The measurement model in use: external force and moment from sensor forces, (1) and (10)-(15), tare, and another run.

With f^ = A u the forces that the model expects without contact (18), (1) reads f_Ext = -J^-T (f_q - f^), in {P}.
"""

from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.errors import Code, IdentificationError
from cases.base.files import atomic_file, check_file
from cases.base.units import Array, as_html
from cases.recording_format import CLOCK, WRENCH
from cases.schema import Case
from identification.finding import Finding, Kind, changed_cases, note, sentences, warning
from identification.findings.drift import WARM_UP
from identification.findings.noise_level import channel_words
from identification.findings.off_case import without
from identification.model.parameters import offset_columns
from identification.recording.recording import Recording
from identification.results.estimate import entries_of_parameters, physical_values
from identification.results.frames import FrameName, place_of
from identification.results.result import Result
from identification.samples.moving_window import NOISY, moving_run, on_one_clock
from identification.samples.sample_checks import unmeasured
from identification.samples.standstills import standstills, variance_of_mean
from identification.signals import white_noise


class ExternalForce(NamedTuple):
    """External force and moment on the load, about the origin of a frame and along its axes."""

    t: Array  # time, shape (n,) [s]; numbers of the standstills where there is no clock
    wrench: Array  # shape (n, 6) [N, N m]
    residuals: Array  # residuals of the sensors, measured less expected, shape (n, 6) [N, or N and N m]
    findings: tuple[Finding, ...] = ()  # what was not measured and is left out, and offsets that have drifted
    origin: Fraction | None = None  # what the recorder's own clock said at t = 0 [s]; None of standstills
    case: str = ""  # name of the machine
    recording: str = ""  # where the run is from
    parameters: str = ""  # the result whose parameters were used
    frame: str = "{P}"  # what it is about and along, for people

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that people should act on."""
        return sentences(self.findings, "warning")

    @property
    def rms(self) -> Array:
        """Root mean square of each component, shape (6,) [N, N m]."""
        return np.asarray(np.sqrt(np.mean(self.wrench**2, axis=0)))

    @property
    def peak(self) -> Array:
        """Largest magnitude of each component, shape (6,) [N, N m]."""
        return np.asarray(np.abs(self.wrench).max(axis=0))

    def save(self, file: Path | str, overwrite: bool = False) -> None:
        """Writes a CSV file of time and components, after a comment for each change of the case since.

        A comment says the frame, where that is not {P}.

        Times are those of the recorder's own clock, to nanoseconds: other channels of the recording stand at them.

        Raises:
            FileProblem: it is there, or cannot be written.
        """
        import pyarrow as pa
        import pyarrow.csv as pacsv

        place = Path(file)
        check_file(place, [".csv"], overwrite=overwrite)
        table: dict[str, Any] = {CLOCK: self.t if self.origin is None else on_clock(self.t, self.origin)}
        table |= {name: np.ascontiguousarray(self.wrench[:, k]) for k, name in enumerate(WRENCH)}
        with atomic_file(place) as part, part.open("wb") as out:
            comments = [f.sentence for f in self.findings if f.kind is Kind.CASE]
            if not self.frame.startswith("{P}"):
                comments.append(f"force and moment in the frame: {self.frame}")
            out.writelines(f"# {comment}\n".encode() for comment in comments)
            pacsv.write_csv(pa.table(table), out, pacsv.WriteOptions(quoting_style="none"))

    def __repr__(self) -> str:
        """How long it is, and rms and peak of each component."""
        components = zip(WRENCH, self.rms, self.peak, strict=True)
        size = f"{len(self.t)} samples from {self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self.t) else "no samples"
        lines = [f"External force and moment, frame {self.frame}: {size}"]
        lines += [f"{name}: rms {rms:.4g}, peak {peak:.4g}" for name, rms, peak in components]
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        return as_html(self)


def on_clock(t: Array, origin: Fraction) -> list[str]:
    """Times since `origin`, shape (n,) [s], as decimals of the clock that said `origin` then."""
    start = round(origin * 10**9)
    stamps = [start + int(ns) for ns in np.rint(t * 1e9)]
    return [f"{'-' * (ns < 0)}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d}" for ns in stamps]


def force(recording: Recording, result: Result, whole: bool = True, frame: FrameName = "sensor") -> ExternalForce:
    """External force and moment over a recording; of a moving run behind the filter of the case.

    Args:
        result: identified parameters of the same machine; their delay is compensated.
        whole: whether all samples are evaluated; else only the excitation.
        frame: "sensor", about the origin of {P} and along its axes; "flange" or "tool" of the robot, about and along
            its; "base", along the axes of {B} at each instant, about the origin of {P}.

    Raises:
        HexciteError: no such frame.
        CaseError: the case does not state where it is.
        FileProblem: parameters of another case.
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    model, place = result.model, place_of(result.case_as_told, frame, at_home=False)
    recording, case = without(on_one_clock(recording, result.case), result.case, result.sizes)
    findings, poses = unmeasured(recording), None
    if recording.t is None or case.setup == "1a":
        still = standstills(recording, case, model)
        t, forces, matrices = still.t, still.recorded, still.matrices
        if still.standing is not None:
            poses = still.standing.load.pose
        elif not place.fixed:
            problem = "the frame of the sensors stands, and its case does not say how in {B}"
            raise IdentificationError(
                place=recording.source, problem=problem, remedy="choose frame sensor", code=Code.NOT_SUPPORTED
            )
    else:
        run = moving_run(recording, case, model, whole)
        findings += run.window
        t, forces, matrices = run.t, run.forces, run.regressors(result.delay)
        poses = None if model.struts is None and place.fixed else run.kinematics(result.delay).pose
    residuals = forces - matrices @ result.values
    variance = np.diag(result.covariance_robust)[offset_columns(model)]
    findings += (*shifted_all_along(residuals, variance, case), *changed_cases(recording.remarks + result.remarks))
    origin = None if recording.t is None or case.setup == "1a" else recording.origin
    turns = None if poses is None or place.fixed else Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    wrenches = place.wrenches(-model.wrenches(residuals, poses), turns)
    told = case.name, recording.source, result.source, place.words
    return ExternalForce(t, wrenches, residuals, findings, origin, *told)


STRETCHES = 10  # of a recording, in each of which a channel reads too much
DRIFTED = 3.0  # standard deviations by which it does


def shifted_all_along(residuals: Array, variance: Array, case: Case) -> list[Finding]:
    """A warning where a channel reads more, or less, than a result expects in every part of a recording.

    By residuals, measured less expected, in the order of time, shape (n, 6) [N, or N and N m], and the variance of the
    result's offsets, shape (6,).
    """
    if len(residuals) < STRETCHES:
        return []
    means = np.array([part.mean(axis=0) for part in np.array_split(residuals, STRETCHES)])
    std = np.sqrt(variance + means.var(axis=0, ddof=1))
    one_way = np.abs(np.sign(means).sum(axis=0)) == STRETCHES
    least = np.where(one_way, np.abs(means).min(axis=0), 0.0) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(least))
    if not least[worst] > DRIFTED:
        return []
    channel, unit = channel_words(case, worst)
    sentence = f"{channel} reads {means[:, worst].mean():+.2g} {unit} more than the result expects all along: its "
    return [warning(Kind.OFFSETS, f"{sentence}offset has drifted, or something presses all along; {WARM_UP}")]


def drifted_since(change: Array, std: Array, case: Case, source: str) -> list[Finding]:
    """A note where a tare finds other offsets than a result, `source`.

    By the change of the offsets, shape (6,) [N, or N and N m], and its standard deviation.
    """
    sure = np.abs(change) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(sure))
    if not sure[worst] > DRIFTED:
        return []
    channel, unit = channel_words(case, worst)
    sentence = f"the offset of {channel} has drifted by {change[worst]:+.2g} {unit} ({sure[worst]:.0f} standard "
    return [note(Kind.OFFSETS, f"{sentence}deviations) since {source}: what was computed with that is off by it")]


STILL = 1e-4  # [m or rad] that drives may move in a standstill, beside the noise of their encoders


def tare(recording: Recording, result: Result) -> Result:
    """The result with sensor offsets f_q0 (11) identified anew from a standstill without contact; all else stays.

    The uncertainty of all else at the pose of the standstill is part of that of the offsets. `record.tared` holds the
    offset of each channel before and after; a note says which has drifted since the result.

    Raises:
        IdentificationError: the machine moves, or there are fewer than two samples.
        FileProblem: parameters of another case.
    """
    model = result.model
    recording, case = without(on_one_clock(recording, result.case), result.case, result.sizes)
    count = int(np.sum(~recording.bad))
    if count < 2:
        raise IdentificationError(
            place=recording.source,
            problem=f"{count} sample",
            remedy="a tare needs a standstill of two or more",
            code=Code.TOO_FEW,
        )
    travel = 0.0 if recording.struts is None else float(np.ptp(recording.struts[~recording.bad], axis=0).max())
    noise = 0.0 if recording.struts is None else float(white_noise(recording.struts).max())
    if travel > STILL + NOISY * noise:
        drives, unit = case.drive_words
        raise IdentificationError(
            place=recording.source,
            problem=f"{drives} move by {travel * 1e3:.3g} {unit}, at most "
            f"{(STILL + NOISY * noise) * 1e3:.3g} {unit} in a "
            "standstill",
            remedy="cut the motion off",
            code=Code.MISFIT,
        )
    still = standstills(recording, case, model)
    residuals = still.recorded - still.matrices @ result.values
    change = residuals.mean(axis=0)
    variance = np.maximum(residuals.var(axis=0, ddof=1) / count, variance_of_mean(residuals))
    offsets = offset_columns(model)
    values, covariance, robust = result.values.copy(), result.covariance.copy(), result.covariance_robust.copy()
    std, before = np.sqrt(variance + np.diag(robust)[offsets]), values[offsets].copy()
    drift = drifted_since(change, std, case, result.source)
    values[offsets] += change
    others = still.matrices.mean(axis=0)
    others[:, offsets] = 0.0
    for square in (covariance, robust):
        together, own = -others @ square, others @ square @ others.T + np.diag(variance)
        together[:, offsets] = own
        square[offsets, :], square[:, offsets] = together, together.T
    physical, stale = physical_values(model, values, covariance, robust), recording.remarks + result.remarks
    parameters = entries_of_parameters(physical, values, covariance, robust)
    record = result.record.replaced(
        **parameters,
        findings=(*result.findings, *drift, *changed_cases(stale)),
        tared_with=str(recording.paths[0]) if recording.paths else recording.source,
        tared={
            channel_words(case, k)[0]: {
                "before": float(before[k]),
                "after": float(values[offsets][k]),
                "change_std": float(std[k]),
                "unit": channel_words(case, k)[1],
            }
            for k in range(len(std))
        },
        **({"stale": stale} if stale else {}),
    )
    tared = Result(case, record.replaced(physical=None))
    moved = tared.physical  # the same body; what is correlated with it moves by other amounts
    return Result(case, record.replaced(physical=moved if moved is not None and moved.moved else None))


class Verification(NamedTuple):
    """How well parameters predict a run that they are not from: forces that nothing outside should have caused."""

    recording: str  # where the run is from
    samples: int
    force_3s_N: Array  # three standard deviations of the residual force, shape (3,)
    moment_3s_Nm: Array  # of the residual moment, shape (3,)
    mean_force_N: Array  # shape (3,)
    mean_moment_Nm: Array  # shape (3,)
    channel_rms: Array  # rms of each sensor's residuals, shape (6,) [N, or N and N m]

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        return {name: v.tolist() if isinstance(v, np.ndarray) else v for name, v in self._asdict().items()}

    def __repr__(self) -> str:
        """One line: residual force and moment."""
        force, moment = (", ".join(f"{v:.3g}" for v in values) for values in (self.force_3s_N, self.moment_3s_Nm))
        return f"verified on {self.recording}: residual force +- {force} N (3 s), residual moment +- {moment} N m (3 s)"

    def _repr_html_(self) -> str:
        return as_html(self)


def verify(recording: Recording, result: Result) -> Verification:
    """How well parameters predict a second run of the same machine, whose excitation nothing touches.

        result = hx.identify(hx.Recording.load("first"))
        print(hx.verify(hx.Recording.load("second"), result))

    Raises:
        FileProblem: parameters of another case.
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    over_run = force(recording, result, whole=False)
    spread, mean = 3 * over_run.wrench.std(axis=0), over_run.wrench.mean(axis=0)
    rms = np.asarray((over_run.residuals**2).mean(axis=0) ** 0.5)
    source = str(recording.paths[0]) if recording.paths else recording.source
    return Verification(source, len(over_run.t), spread[:3], spread[3:], mean[:3], mean[3:], rms)
