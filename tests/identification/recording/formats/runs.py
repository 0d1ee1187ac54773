"""A short run of the hexapod with known numbers, and how files of any format write it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cases.recording_format import BAR_FORCES, STRUTS, RecordingFormat
from cases.schema import Case, load_case

HEXAPOD = load_case("hexapod")
COUNT = 40
NAMES = ["t_s", *STRUTS, *BAR_FORCES]


@dataclass(frozen=True)
class Truth:
    """Time [s], struts [m] and forces [N] of a run, rounded so that files can hold them exactly."""

    count: int = COUNT
    seed: int = 0
    step: float = 1e-3
    t: np.ndarray = field(init=False)
    struts: np.ndarray = field(init=False)
    forces: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        draw = np.random.default_rng(self.seed)
        object.__setattr__(self, "t", np.arange(self.count) * self.step)
        object.__setattr__(self, "struts", np.round(draw.uniform(0.9, 1.1, (self.count, 6)), 6))
        object.__setattr__(self, "forces", np.round(draw.normal(0.0, 50.0, (self.count, 6)), 3))

    def numbers(self, tick: float = 1.0, length: float = 1e-3) -> np.ndarray:
        """Rows of time, struts and forces, in units of `tick` [s] and `length` [m]."""
        return np.column_stack([self.t / tick, self.struts / length, self.forces])


def number(value: float, decimal: str = ".") -> str:
    return f"{value:.9g}".replace(".", decimal)


def rows(numbers: np.ndarray, delimiter: str = ",", decimal: str = ".") -> list[str]:
    lines = ["\t".join(["%.9g"] * len(row)) % tuple(row) for row in np.asarray(numbers).tolist()]  # some are long
    return [line.replace(".", decimal).replace("\t", delimiter) for line in lines]


def csv(numbers: np.ndarray, names: Sequence[str] = NAMES, delimiter: str = ",", decimal: str = ".") -> str:
    return "\n".join([delimiter.join(names), *rows(numbers, delimiter, decimal)]) + "\n"


def written(folder: Path, text: str | bytes, name: str = "run.csv") -> Path:
    file = folder / name
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return file


def case_with(case: Case = HEXAPOD, **recording: object) -> Case:
    """The case with other settings in [recording], checked as in a case file."""
    settings = case.recording.model_dump(exclude_none=True) | recording
    return case.model_copy(update={"recording": RecordingFormat.model_validate(settings)})
