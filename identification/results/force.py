"""The measurement model in use: external force and moment from sensor forces, (1) and (10)-(15), and another run.

With f^ = A u the forces that the model expects without contact (18), (1) reads f_Ext = -J^-T (f_q - f^), in {P}.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from cases.base.atomic import atomic_file
from cases.base.errors import Code, IdentificationError
from cases.base.options import default_of, documented
from cases.base.output_places import check_file
from cases.base.units import Array, as_html
from cases.recording_format import CLOCK, WRENCH
from cases.schema import Case
from identification.finding import Finding, Kind, changed_cases, sentences, warning
from identification.findings.drift import WARM_UP
from identification.findings.noise_level import channel_words
from identification.model.parameters import offset_columns
from identification.options import Frame
from identification.recording.recording import Recording
from identification.results.expected_residuals import used_samples
from identification.results.frames import place_of
from identification.results.result import Result
from identification.texts import aligned, budget_cells, std_text

UNITS = ("N", "N", "N", "N m", "N m", "N m")  # of `WRENCH`


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
    variances: Mapping[str, Array] = MappingProxyType({})  # of the components by their causes, shapes (n, 6)
    not_counted: Sequence[str] = ()  # kinds of tolerances that deviations do not count, for the case states none

    @property
    def std(self) -> Array:
        """Standard deviation of each component, shape (n, 6) [N, N m]."""
        return np.asarray(np.sqrt(sum(self.variances.values(), np.zeros_like(self.wrench))))

    @property
    def expanded(self) -> Array:
        """Expanded uncertainty U (k = 2), shape (n, 6) [N, N m]."""
        return 2.0 * self.std

    @property
    def typical_expanded(self) -> Array:
        """Root mean square of U (k = 2) over the recording, of each component, shape (6,) [N, N m]."""
        return np.asarray(np.sqrt(np.mean(self.expanded**2, axis=0)))

    @property
    def budget(self) -> dict[str, dict[str, float]]:
        """Of each component the parts of its deviation by their causes, root mean squares over the recording [SI]."""
        parts = {kind: np.sqrt(variance.mean(axis=0)) for kind, variance in self.variances.items()}
        return {name: {kind: float(part[k]) for kind, part in parts.items()} for k, name in enumerate(WRENCH)}

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

        Standard deviations stand behind them. Times are those of the recorder's own clock, to nanoseconds: other
        channels of the recording stand at them.

        Raises:
            FileProblem: it is there, or cannot be written.
        """
        import pyarrow as pa
        import pyarrow.csv as pacsv

        place = Path(file)
        check_file(place, [".csv"], overwrite=overwrite)
        table: dict[str, Any] = {CLOCK: self.t if self.origin is None else on_clock(self.t, self.origin)}
        table |= {name: np.ascontiguousarray(self.wrench[:, k]) for k, name in enumerate(WRENCH)}
        table |= {f"std_{name}": np.ascontiguousarray(self.std[:, k]) for k, name in enumerate(WRENCH)}
        with atomic_file(place) as part, part.open("wb") as out:
            comments = [f.sentence for f in self.findings if f.kind is Kind.CASE]
            if not self.frame.startswith("{P}"):
                comments.append(f"force and moment in the frame: {self.frame}")
            out.writelines(f"# {comment}\n".encode() for comment in comments)
            pacsv.write_csv(pa.table(table), out, pacsv.WriteOptions(quoting_style="none"))

    def __repr__(self) -> str:
        """How long it is, and rms and peak of each component."""
        size = f"{len(self.t)} samples from {self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self.t) else "no samples"
        lines = [f"External force and moment, frame {self.frame}: {size}"]
        lines += aligned(("component", "rms", "peak", "+-", "U (k=2)", "unit"), *self.rows)
        if self.not_counted:
            lines.append(f"+- counts no tolerances of {', '.join(self.not_counted)}: see [tolerances]")
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    def __str__(self) -> str:
        """The same, and the parts of the deviations by their causes."""
        budget = aligned(*budget_cells(dict(zip(WRENCH, UNITS, strict=True)), self.budget))
        return "\n".join([repr(self), *budget])

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Cells for people, of each component: name, rms, peak, deviation and U as root mean squares, unit."""
        columns = zip(WRENCH, self.rms, self.peak, self.typical_expanded, UNITS, strict=True)
        return [
            (name.rpartition("_")[0], f"{r:.4g}", f"{p:.4g}", std_text(float(u) / 2.0), std_text(float(u)), unit)
            for name, r, p, u, unit in columns
        ]

    def _repr_html_(self) -> str:
        return as_html(self)


def on_clock(t: Array, origin: Fraction) -> list[str]:
    """Times since `origin`, shape (n,) [s], as decimals of the clock that said `origin` then."""
    start = round(origin * 10**9)
    stamps = [start + int(ns) for ns in np.rint(t * 1e9)]
    return [f"{'-' * (ns < 0)}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d}" for ns in stamps]


@documented()
def force(recording: Recording, result: Result, whole: bool = True, frame: Frame = default_of(Frame)) -> ExternalForce:
    """External force and moment over a recording; of a moving run behind the filter of the case.

    Deviations count noise at each instant, what the result's deviations count, and how the tolerances of the case act
    on the forces of this motion; see `ExternalForce.budget`.

    >>> external = hx.force(hx.Recording.load("loaded"), hx.Result.load("empty-result"))
    >>> external.rms.round(1).tolist()  # of a weight of 20 kg that the result does not know [N, N m]
    [48.7, 58.1, 190.9, 5.6, 4.1, 0.4]

    Args:
        result: identified parameters of the same machine; their delay is compensated.
        whole: whether all samples are evaluated; else only the excitation.
        OPTIONS

    Raises:
        HexciteError: no such frame.
        CaseError: the case does not state where it is.
        FileProblem: parameters of another case.
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    place = place_of(result.case_as_told, frame, at_home=False)
    samples = used_samples(recording, result, whole)
    if samples.motion is None and not place.fixed:
        problem = "the frame of the sensors stands, and its case does not say how in {B}"
        raise IdentificationError(
            place=recording.source, problem=problem, remedy="choose frame sensor", code=Code.NOT_SUPPORTED
        )
    residuals = samples.residuals
    variance = np.diag(result.covariance_robust)[offset_columns(result.model)]
    findings = samples.findings
    findings += (
        *shifted_all_along(residuals, variance, samples.case),
        *changed_cases(recording.remarks + result.remarks),
    )
    into = samples.into(place)
    wrenches = np.einsum("nij,nj->ni", into, residuals)
    return ExternalForce(
        samples.t, wrenches, residuals, findings, samples.origin, samples.case.name, recording.source, result.source,
        place.words, samples.variances(place, into, wrenches), result.not_counted,
    )  # fmt: skip


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

    >>> verification = hx.verify(hx.Recording.load("empty"), hx.Result.load("empty-result"))
    >>> bool((verification.force_3s_N < 10.0).all())
    True

    Raises:
        FileProblem: parameters of another case.
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    over_run = force(recording, result, whole=False)
    spread, mean = 3 * over_run.wrench.std(axis=0), over_run.wrench.mean(axis=0)
    rms = np.asarray((over_run.residuals**2).mean(axis=0) ** 0.5)
    source = str(recording.paths[0]) if recording.paths else recording.source
    return Verification(source, len(over_run.t), spread[:3], spread[3:], mean[:3], mean[3:], rms)
