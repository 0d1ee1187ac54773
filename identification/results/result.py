"""The result of an identification as users hold it: parameters by name, saved and loaded as a folder."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from cases.base.atomic import atomic_folder
from cases.base.doors import checks
from cases.base.errors import Code, FileProblem, HexciteError
from cases.base.file_reading import read_json
from cases.base.folder_kinds import RESULT
from cases.base.output_places import check_folder
from cases.base.phrases import phrase
from cases.base.provenance import sha256_of
from cases.base.text_formats import json_text
from cases.base.units import Array, as_html
from cases.basis import CONTENT, case_of, content_of, require_unchanged, result_basis
from cases.schema import Case
from identification.estimation.fit import Value
from identification.estimation.nearest_body import NearestBody, nearest_body
from identification.finding import Finding, Kind, note, sentences, warning
from identification.findings.fit_checks import impossible, is_impossible
from identification.findings.off_case import edited
from identification.findings.told import LeftOpen
from identification.model.model import Model, identification_model
from identification.options import FrameName
from identification.results.estimate import SCHEMA_VERSION, Estimate, ResultEntries, of_version_0_2, physical_values
from identification.results.frames import Body, Mounting, body_alone, mounting_of, place_of, turning_at_home
from identification.results.result_rows import physical_rows, pooled_rows, scatter_rows, tared_rows, treatment_rows
from identification.signals import Residuals
from identification.texts import (
    aligned,
    budget_cells,
    carries_rods,
    parameter_lines,
    value_cells,
)

PROMINENT = ("m", "xC", "yC", "zC")  # shown first
AGAIN = phrase("identify_again", "identify again")
ALIKE = 1e-9  # of numbers that are computed anew: another computer rounds otherwise


@dataclass(frozen=True, repr=False)
class Result:
    """Identified parameters; two are equal where they say the same.

    >>> result = hx.Result.load("empty-result")
    >>> result["m"]
    Value(value=31.82..., std=0.0069..., std_robust=0.0066..., unit='kg')
    >>> result["m"].reported == max(result["m"].std, result["m"].std_robust)
    True

    Args:
        record: entries of result.json.
        case: case of the recording.
        estimate: estimate with everything that is not saved; None where it was loaded.
        file: file that it was loaded from.
        remarks: what has changed in the case since, where it was loaded nevertheless.
    """

    case: Case = field(compare=False)
    record: ResultEntries
    estimate: Estimate | None = field(default=None, compare=False)
    file: Path | None = field(default=None, compare=False)
    remarks: tuple[str, ...] = field(default=(), compare=False)

    def __hash__(self) -> int:
        return hash((self.record.case_hash, self.record.values))

    def __reduce__(self) -> tuple[Any, ...]:
        """What goes to another process: all that `save` keeps, without the residuals."""
        return type(self), (self.case, self.record, None, self.file, self.remarks)

    def __getitem__(self, name: str) -> Value:
        """A physical parameter [SI]: `result["m"].value`, `.std` by (28), `.std_robust`, `.unit`."""
        return self.parameters[name]

    @property
    def parameters(self) -> Mapping[str, Value]:
        """Physical parameters by name [SI]."""
        return self.record.parameters

    @cached_property
    def residuals(self) -> Residuals | None:
        """Residuals of the recorded forces; None where it was loaded."""
        estimate = self.estimate
        return None if estimate is None else estimate.samples.series(estimate.at, estimate.fit.values)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What speaks against it, and what is good to know."""
        return self.record.findings

    def _quantity(self, name: str) -> Any:
        """What a finding says in numbers; None where none has it."""
        return next((finding.quantity[name] for finding in self.findings if name in finding.quantity), None)

    @property
    def budget(self) -> Mapping[str, Mapping[str, float]]:
        """Of each parameter the parts of its deviation by their causes [SI]; their squares add up to that of the
        reported one. Empty where the case states no tolerances.
        """
        return self._quantity("budget") or {}

    @property
    def sizes(self) -> Mapping[str, Array]:
        """By how much the machine is off its case, as its run tells: by keys of `[tolerances]`, shapes (k,) [SI].

        Empty where the parameters were estimated without them.
        """
        return {key: np.array(values, dtype=float) for key, values in (self._quantity("told_sizes") or {}).items()}

    @cached_property
    def left_open(self) -> LeftOpen | None:
        """What its run leaves open of `sizes`; None where it told none."""
        entries = self._quantity("told_left_open")
        return None if entries is None else LeftOpen.from_json(entries)

    @cached_property
    def case_as_told(self) -> Case:
        """The case of the machine off by `sizes`: with it parameters were estimated, and forces are computed."""
        return edited(self.case, self.sizes)

    @cached_property
    def body(self) -> Body:
        """The load in {P}, without offsets and all else that is the sensor's.

        Raises:
            IdentificationError: it has offsets alone, or its body is not a load.
        """
        model, places = body_alone(self.model, self.source)
        square = np.ix_(places, places)
        biases = {key: bias[places] for key, bias in self.biases.items()}
        sensor = place_of(self.case_as_told, "sensor")
        return Body(sensor, model, self.values[places], self.covariance[square], self.covariance_robust[square], biases)

    def mounting_of_body(self, body: Model, along_base: bool = False) -> Mounting:
        """What is not known of the place of the sensor, with its share in the errors of a body.

        That is its place on its flange and, where the load is seen along the axes of {B}, how the machine turns it at
        home: zeros of joints, encoders, and joints of a hexapod.
        """
        places = [self.model.names.index(name) for name in body.names]
        counted = self.biases.keys()
        turning = turning_at_home(self.case_as_told, self.model, self.values, counted) if along_base else {}
        return mounting_of(self.case, counted, self.left_open, places, turning)

    def in_frame(self, frame: FrameName) -> Body:
        """The load in the frame of the sensor, of the robot's flange or tool, or along the axes of {B} at home.

            result.in_frame("flange").parameters["xC"].value

        Deviations count how uncertain the sensor's place on the flange is, where the case states that.

        Raises:
            HexciteError: no such frame.
            CaseError: the case does not state where it is.
            IdentificationError: the result has no body.
        """
        place = place_of(self.case_as_told, frame)
        return self.body.seen_from(place, self.mounting_of_body(self.body.model, not place.fixed))

    @property
    def not_counted(self) -> list[str]:
        """Kinds of tolerances that no deviation counts, for the case states none."""
        return self._quantity("not_counted") or []

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that a user should act on."""
        return sentences(self.findings, "warning")

    @property
    def notes(self) -> tuple[str, ...]:
        """Further sentences on the evaluation."""
        return sentences(self.findings, "note")

    @property
    def source(self) -> str:
        """Its name in messages: its file, or the recording that it is from."""
        return str(self.record.recording if self.file is None else self.file)

    @property
    def fingerprint(self) -> str:
        """SHA-256 of its file; where it was not loaded, of what `save` writes into it."""
        if self.file is not None:
            return sha256_of(self.file)
        return hashlib.sha256(json_text(self.record.to_json()).encode()).hexdigest()

    @property
    def model(self) -> Model:
        """The model of the parameters.

        Raises:
            FileProblem: they belong to another case, or no model of it has that number.
        """
        name = self.record.case
        if self.case.name != name:
            problem = f"parameters of case {name}, not {self.case.name}"
            raise FileProblem(
                place=self.source, problem=problem, remedy=f"identify them for {self.case.name}", code=Code.OTHER_SOURCE
            )
        try:
            return identification_model(self.case_as_told, self.record.model)
        except HexciteError as error:
            raise FileProblem(place=self.source, problem=error.message, remedy=AGAIN, code=Code.DAMAGED) from error

    @property
    def values(self) -> Array:
        """The linear parameters u, shape (u,) [SI]."""
        return np.array(self.record.values, dtype=float)

    @property
    def covariance(self) -> Array:
        """Covariance of u by (28), shape (u, u)."""
        return np.array(self.record.covariance, dtype=float)

    @property
    def covariance_robust(self) -> Array:
        """Covariance of u that allows for noise with memory, shape (u, u)."""
        return np.array(self.record.covariance_robust, dtype=float)

    @cached_property
    def physical(self) -> NearestBody | None:
        """The nearest body that can exist and keeps `[bounds]` of the case; the estimate itself where it does.

        Bounds are not asked where a payload was mounted. None where the model has no body, or where none keeps what was
        given.
        """
        if self.record.physical is not None:
            return self.record.physical
        bounds = None if self.mounted else self.case.bounds
        return nearest_body(self.model, self.values, self.covariance, self.covariance_robust, bounds)

    @property
    def biases(self) -> Mapping[str, Array]:
        """Of u by one standard deviation of each size that a tolerance of the case is one of, shape (u, k), by its key.

        They are part of `covariance_robust`; other runs of the same machine have the same sizes.
        """
        return {key: np.array(rows, dtype=float) for key, rows in (self.record.tolerance_biases or {}).items()}

    @property
    def mounted(self) -> float:
        """Mass of the payload that was mounted for a run of hexcite [kg]; 0 where its recording says nothing."""
        return 0.0 if self.record.run is None else self.record.run.mounted

    @property
    def delay(self) -> float:
        """Delay of the forces [s]; 0 where none was estimated."""
        return 0.0 if self.record.delay_s is None else self.record.delay_s.value

    @property
    def recordings(self) -> frozenset[str]:
        """SHA-256 of the files that it was made of; empty where it does not say."""
        return frozenset(entry["sha256"] for entry in self.record.inputs)

    def write(self, folder: Path) -> None:
        """Writes result.json into a folder that is there."""
        entries = self.record.to_json()
        (folder / "result.json").write_text(json_text(entries | {CONTENT: content_of(entries)}), encoding="utf-8")

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with the same file; residuals are not saved.

        Raises:
            FileProblem: the folder holds something else, or cannot be written.
        """
        check_folder(Path(folder), RESULT, overwrite=overwrite)
        with atomic_folder(Path(folder), RESULT, overwrite) as part:
            self.write(part)

    @classmethod
    @checks
    def load(cls, folder: Path | str, case: Case | None = None, stale: bool = False) -> "Result":
        """The result of a folder.

        Args:
            folder: folder that `save` or `hexcite identify` wrote.
            case: instead of the one that the folder names.
            stale: read it although its case has changed since.

        Raises:
            FileProblem: missing, damaged, changed by hand or of another version; or its case has changed since.
        """
        file, record = _read(Path(folder))
        case_of_result = case_of(file, record.to_json(), AGAIN) if case is None else case
        _require_agreement(cls(case_of_result, record, file=file))
        remarks = require_unchanged(file, record.to_json(), result_basis(case_of_result), case_of_result, stale, AGAIN)
        return cls(case_of_result, record, file=file, remarks=remarks)

    def beside_physical(self) -> "Result":
        """The same with the nearest body that can exist as an entry, and a sentence, where that is not the estimate."""
        nearest = self.physical
        if nearest is None:
            if "m" not in self.record.names:
                return self
            remedy = "correct [bounds], or what was fixed or left out"
            bounds_finding = warning(
                Kind.MODEL, f"no body that can exist has what was given and keeps [bounds]; {remedy}"
            )
            return replace(self, record=self.record.replaced(findings=(*self.findings, bounds_finding)))
        if not nearest.moved:
            return self
        words = f"{nearest.words}: exports of the load take that one"
        bounds = any(name.startswith("bounds.") for name in nearest.broken)
        if nearest.impossible:
            bounds_finding = impossible(words)
        else:
            doubted = bounds and nearest.p_at_most < UNLIKELY
            bounds_finding = warning(Kind.CASE, words) if doubted else note(Kind.MODEL, words)
        # the fit said it before the deviations grew by what its residuals follow
        others = tuple(finding for finding in self.findings if not is_impossible(finding))
        return replace(self, record=self.record.replaced(physical=nearest, findings=(*others, bounds_finding)))

    def chosen_among(self, choice: Mapping[str, Any]) -> "Result":
        """The same with all models of its run, entries of `ModelChoice`, which it keeps and its page shows."""
        return replace(self, record=self.record.replaced(models=choice))

    def __repr__(self) -> str:
        """A few lines: model, warnings, residuals, the body."""
        about, *rest = self._summary()
        return "\n".join([about, *self._warned(), *rest])

    def _warned(self) -> list[str]:
        """A line for each warning."""
        return [f"warning: {warning}" for warning in self.warnings]

    def _summary(self) -> list[str]:
        """The lines of `repr` without warnings."""
        record, parameters = self.record, self.parameters
        equal = record.weights == "equal"
        unit, recorded = (" N", "") if equal else ("", f", recorded forces less the model {record.s0_N:.3g} N rms")
        residuals = f"s0 {record.s0:.3g}{unit} (27), white noise {record.white_noise:.3g}{unit}{recorded}"
        samples = "averaged standstills" if record.delay_s is None else "samples"
        lines = [f"Result for {self.case.name}: model {record.model}, {record.samples} {samples}"]
        lines.append(f"weights {record.weights}, {residuals}")
        lines.append(f"{len(parameters)} parameters, rank {record.rank}, condition {record.condition:.3g}")
        for name in [name for name in PROMINENT if name in parameters] or list(parameters)[:4]:
            words, value, deviation, *_, unit = value_cells(name, parameters[name], carries_rods(parameters))
            lines.append(f"{words} = {value} +- {deviation} {unit}")
        return lines

    def __str__(self) -> str:
        """The warnings, a table of all parameters, the notes, and a few lines on model, residuals and body."""
        which = (
            "+- is the larger of std (28), right for white noise, and of std robust, which allows for noise that is not"
        )
        if missing := self.not_counted:
            why = "the case states none, see [tolerances]" if missing == self.case.not_counted else "see the notes"
            which += f";\n  they count no tolerances of {', '.join(missing)}: {why}"
        lag = self.record.delay_s
        lines = [] if lag is None else [f"forces lag the motion by {lag.value * 1e3:.3f} +- {lag.std * 1e3:.3f} ms"]
        table = [
            *parameter_lines(self.parameters),
            which,
            *aligned(*budget_cells({n: p.unit for n, p in self.parameters.items()}, self.budget)),
            *lines,
            *self._pooled(),
            *aligned(*physical_rows(self.parameters, self.record.physical)),
            *self._treated(),
            *self._tared(),
            *self.notes,
        ]
        return "\n".join([*self._warned(), *table, *self._summary()])

    def _treated(self) -> list[str]:
        """A table of the parameters with another treatment of the data beside the default."""
        return [] if self.record.treatment is None else aligned(*treatment_rows(self.record.treatment))

    def _pooled(self) -> list[str]:
        """Tables of the runs that it is the mean of, and of how far they scatter."""
        pooled = self.record.pooled
        return [] if pooled is None else [*aligned(*pooled_rows(pooled)), *aligned(*scatter_rows(pooled))]

    def _tared(self) -> list[str]:
        """A table of the offsets before and after a tare."""
        return [] if not self.record.tared else aligned(*tared_rows(self.record.tared))

    _repr_html_ = as_html


UNLIKELY = 1e-3  # chance of a distance from bounds, below which they or the run are doubted


def case_of_result(path: Path) -> Case:
    """The case that a saved result names.

    Raises:
        FileProblem: no such result, or it names no case.
        CaseError: its case cannot be read.
    """
    file, record = _read(path)
    return case_of(file, record.to_json(), AGAIN)


def _read(path: Path) -> tuple[Path, ResultEntries]:
    """`result.json`, or that of the folder that holds it, and its entries."""
    file = path / "result.json" if path.is_dir() else path
    data = read_json(file, "hexcite identify")
    version = data.get("schema_version")
    if version != SCHEMA_VERSION:
        raise FileProblem(
            place=file,
            problem=f"schema_version {version!r}, expected {SCHEMA_VERSION}",
            remedy=AGAIN,
            code=Code.VERSION,
        )
    if data.pop(CONTENT, None) not in (None, content_of(data)):  # version 0.2 stated none
        raise FileProblem(
            place=file, problem=phrase("result_changed", "was changed by hand"), remedy=AGAIN, code=Code.CHANGED
        )
    try:
        return file, ResultEntries.model_validate_json(json_text(of_version_0_2(data)))
    except ValidationError as error:
        place = ".".join(map(str, error.errors()[0]["loc"]))
        raise FileProblem(
            place=file, problem=f"entry {place} is missing or damaged", remedy=AGAIN, code=Code.DAMAGED
        ) from error


def _require_agreement(result: Result) -> None:
    """Refuses physical parameters that do not follow from the linear ones: changed by hand, or of another model."""
    record, model = result.record, result.model
    lengths = {len(row) for square in (record.covariance, record.covariance_robust) for row in (square, *square)}
    other = FileProblem(
        place=result.source,
        problem=f"its parameters are not those of model {model.number}",
        remedy=AGAIN,
        code=Code.CHANGED,
    )
    if record.names != tuple(model.names) or lengths | {len(record.values)} != {len(model.names)}:
        raise other
    squares = result.covariance, result.covariance_robust
    physical = physical_values(model, result.values, *squares)
    if physical.keys() != record.parameters.keys():
        raise other
    for name, computed in physical.items():
        stated, size = record.parameters[name], max(abs(computed.value), computed.reported)
        if stated.unit != computed.unit or not np.allclose(stated[:3], computed[:3], rtol=0.0, atol=ALIKE * size):
            problem = f"{name} is {stated.value:.6g} {stated.unit}, by the linear parameters {computed.value:.6g} "
            raise FileProblem(
                place=result.source,
                problem=f"{problem}{computed.unit}: value or deviation changed by hand",
                remedy=AGAIN,
                code=Code.CHANGED,
            )
    for square in squares:
        scale = np.sqrt(np.outer(np.diag(square), np.diag(square)).clip(0.0))
        if np.any(np.abs(square - square.T) > ALIKE * scale):
            raise FileProblem(
                place=result.source,
                problem="a covariance is not symmetric: changed by hand",
                remedy=AGAIN,
                code=Code.CHANGED,
            )
