"""A result that was saved, as other commands use it: parameters to predict forces with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.basis import KEPT, Artefact, recording_basis, result_basis
from cases.errors import FileProblem
from cases.files import DAMAGED, read_json
from cases.schema import Case
from identification.estimation.biases import OFFSET_NAMES, AccelerometerBias, Biases
from identification.model import Model, identification_model
from identification.parameters import physical_form
from identification.result import SCHEMA_VERSION, physical_values

Array = NDArray[np.float64]

ALIKE = 1e-9  # of parameters that are computed anew: another computer rounds otherwise
_OF_A_RECORDING = ("recording.", "sensors.")  # keys that say how a run was read, not what offsets mean


@dataclass(frozen=True, slots=True)
class SavedResult:
    """Identified parameters."""

    source: str  # the file
    case_name: str  # name of the case they belong to
    model: int  # number in Table 2
    values: Array  # u, shape (u,)
    covariance: Array  # covariance of u by (28), shape (u, u)
    covariance_robust: Array  # covariance of u, autocorrelation-robust, shape (u, u)
    terms: tuple[str, ...]  # forms of the error compensation other than the model's
    delay: float  # delay of the forces [s]; 0 where none was estimated
    accelerometer: AccelerometerBias | None = None  # its biases, where standstills told them
    recordings: frozenset[str] = frozenset()  # SHA-256 of the files that it was made of; empty where it does not say
    about: Mapping[str, Any] = field(default_factory=dict)  # all of result.json

    @property
    def artefact(self) -> Artefact:
        """What it says of its case."""
        return Artefact(Path(self.source), self.about, "identify again")

    def remarks(self, case: Case, stale: bool) -> tuple[str, ...]:
        """What to write into everything that is made of it, where the case has changed since and `stale` is set.

        Raises:
            FileProblem: the case has changed and `stale` is not set, or a number was changed by hand.
        """
        self.require_own_parameters(case)
        return self.artefact.require_unchanged(result_basis(case), case, stale)

    def model_of(self, case: Case) -> Model:
        """The model of the parameters, for a case of the same machine.

        Raises:
            FileProblem: the parameters belong to another case.
        """
        if case.name != self.case_name:
            raise FileProblem(
                self.source, f"parameters of case {self.case_name}, not {case.name}", f"identify them for {case.name}"
            )
        return identification_model(case, self.model, self.terms)

    def require_own_parameters(self, case: Case) -> None:
        """Computes the physical parameters anew from the linear ones, so that nobody reads the wrong one of two.

        Raises:
            FileProblem: they were changed by hand, or belong to another case.
        """
        model = self.model_of(case)
        form, keys = physical_form(model), ("value", "std")
        try:
            names, told = list(self.about["linear"]["names"]), self.about["parameters"]
            physical = {p.name for p in form.parameters}
            if names != model.names or len(self.values) != len(names) or not physical <= set(told):
                message = f"its parameters are not those of model {self.model}"
                raise FileProblem(self.source, message, "identify again")
            told = np.array([[float(told[p.name][key]) for key in keys] for p in form.parameters])
        except DAMAGED as error:
            raise FileProblem(self.source, f"entry {error} is missing or damaged", "identify again") from error
        values, covariance = form.of(self.values, self.covariance)
        found = np.column_stack([values, np.sqrt(np.diag(covariance).clip(0.0))])
        alike = np.abs(told - found) <= ALIKE * np.abs(found).max(axis=1, keepdims=True)
        for row, column in np.argwhere(~alike):
            entry = f"{keys[column]} of {form.parameters[row].name}"
            words = f"{entry} is {told[row, column]:.6g}, but {found[row, column]:.6g} by the linear parameters"
            raise FileProblem(self.source, f"{words}: changed by hand", "identify again")


def load_result(path: Path) -> SavedResult:
    """Reads `result.json`, or the folder that holds it.

    Raises:
        FileProblem: missing, damaged or of another version.
    """
    file = path / "result.json" if path.is_dir() else path
    return solution_of(read_json(file, "hexcite identify"), str(file))


def solution_of(data: Mapping[str, Any], file: str) -> SavedResult:
    """What `result.json` says of the parameters; errors as `load_result`."""
    if data.get("schema_version") != SCHEMA_VERSION:
        raise FileProblem(
            file, f"schema_version {data.get('schema_version')!r}, expected {SCHEMA_VERSION}", "identify again"
        )
    try:
        delay, bias = data["delay_s"], data.get("accelerometer")
        result = SavedResult(
            source=file,
            case_name=str(data["case"]),
            model=int(data["model"]),
            values=np.array(data["linear"]["values"], dtype=float),
            covariance=np.array(data["covariance"], dtype=float),
            covariance_robust=np.array(data.get("covariance_robust", data["covariance"]), dtype=float),
            terms=tuple(str(t) for t in data.get("error_terms", ())),
            delay=0.0 if delay is None else float(delay["value"]),
            accelerometer=None if bias is None else _accelerometer(bias),
            recordings=frozenset(str(i["sha256"]) for i in data.get("inputs", ())),
            about=data,
        )
    except DAMAGED as error:
        raise FileProblem(file, f"entry {error} is missing or damaged", "identify again") from error
    count = len(result.values)
    arrays = (result.values, result.covariance, result.covariance_robust)
    whole = result.values.ndim == 1 and all(a.shape == (count, count) for a in arrays[1:])
    if not whole or not all(np.isfinite(a).all() for a in arrays):
        raise FileProblem(file, "values and covariance do not belong together", "identify again")
    return result


def _accelerometer(data: Any) -> AccelerometerBias:
    """From JSON; raises KeyError, TypeError or ValueError where it is damaged."""
    values, covariance = (np.array(data[k], dtype=float) for k in ("bias_m_s2", "covariance_m2_s4"))
    turn, rms = np.array(data["turn_rad"], dtype=float), float(data["rms_m_s2"])
    if values.shape != (3,) or covariance.shape != (3, 3) or not np.isfinite([*values, *covariance.ravel()]).all():
        raise ValueError("accelerometer")
    return AccelerometerBias(values, covariance, turn, rms)


def biases_of(path: Path, case: Case, stale: bool = False) -> Biases:
    """Offsets of forces and accelerometer from a result of the same machine, for a run that is to take them as known.

    How that result's recording was read and filtered may differ; machine, sensor frame and gravity may not.

    Args:
        stale: go on although the machine has changed since.

    Raises:
        FileProblem: no such result, one of another case, or the machine has changed and `stale` is not set.
    """
    result = load_result(path)
    now, then = recording_basis(case), result.about.get(KEPT)
    about = dict(result.about)
    if isinstance(then, Mapping):
        about[KEPT] = {key: value for key, value in then.items() if key in now or not key.startswith(_OF_A_RECORDING)}
    remarks = Artefact(Path(result.source), about, "identify the standstills again").require_unchanged(now, case, stale)
    result.require_own_parameters(case)
    names = result.model_of(case).names
    offsets = [names.index(name) for name in OFFSET_NAMES]
    white, robust = (c[np.ix_(offsets, offsets)] for c in (result.covariance, result.covariance_robust))
    std = np.sqrt(np.diag(white))
    larger = np.maximum(std, np.sqrt(np.diag(robust)))
    growth = larger / np.where(std > 0.0, std, 1.0)
    covariance = white * np.outer(growth, growth)
    return Biases(str(path), result.values[offsets], covariance, result.accelerometer, remarks)


def with_tare(
    result: SavedResult, case: Case, values: Array, covariance: Array, source: str, notes: Sequence[str] = ()
) -> dict[str, Any]:
    """What `result.json` holds with other linear values: physical parameters and deviations follow from them.

    Args:
        result: result that is changed.
        values: new u, shape (u,).
        covariance: covariance of u, shape (u, u).
        source: the recording that they come from.
        notes: what else there is to say.
    """
    data = dict(result.about)
    robust_covariance = result.covariance_robust.copy()
    offsets = [k for k, name in enumerate(data["linear"]["names"]) if name.startswith("f_q0")]
    robust_covariance[offsets, :] = robust_covariance[:, offsets] = 0.0
    robust_covariance[offsets, offsets] = np.diag(covariance)[offsets]
    physical = physical_values(result.model_of(case), values, covariance, robust_covariance)
    freedom = float(data.get("degrees_of_freedom", np.inf))
    return data | {
        "parameters": {name: value._asdict() for name, value in physical.items()},
        "intervals_95": {name: list(value.interval(freedom)) for name, value in physical.items()},
        "linear": {"names": data["linear"]["names"], "values": values.tolist()},
        "covariance": covariance.tolist(),
        "covariance_robust": robust_covariance.tolist(),
        "notes": [*data.get("notes", ()), *notes],
        "tared_with": source,
    }
