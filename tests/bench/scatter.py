"""What standard deviations ought to be: the scatter of estimates over machines that err with the pose in other ways."""

from pathlib import Path

import numpy as np

from cases.loading import load_case
from identification.identify import identify
from planner.runs.running import carried_out
from planner.validation.experiment import METHODS, Excitation

MACHINES = 12
SHOWN = {"m": "kg", "zC": "m", "IC33": "kg m^2", "k0": "N/m", "sensor offsets": "N"}
OFFSETS = tuple(f"f_q0_{k}" for k in range(1, 7))


def scatter_rows(programs: Path) -> list[list[str]]:
    """Scatter and reported deviations (root mean squares) of the hand-made and the point-to-point motion, without load.

    Args:
        programs: folder of a validation on the virtual controller.
    """
    rows = []
    for method in ("D9M", "ptp"):
        values, reported = _estimates(programs / f"{method}.mpf", method)
        for name, unit in SHOWN.items():
            names = OFFSETS if name == "sensor offsets" else (name,)
            scatter = np.sqrt(np.mean([np.var(values[n], ddof=1) for n in names]))
            said = np.sqrt(np.mean([np.square(reported[n]) for n in names]))
            told = f"{scatter:.3g} / {said:.3g} {unit}"
            rows.append([f"  {method}, {MACHINES} machines: scatter / reported std of {name}", told, "1 to 1"])
    return rows


def _estimates(program: Path, method: str) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    case = load_case("hexapod")
    found = case.need_simulation("the scatter").disturbances
    assert found is not None
    _, _, run = carried_out(program, case, "virtual")
    values: dict[str, list[float]] = {}
    reported: dict[str, list[float]] = {}
    for k in range(MACHINES):
        machine = found.model_copy(update={"pose_error_seed": 100 + k})
        excitation = Excitation(
            case, method, METHODS[method], run.excitation, run.execution, run.trigger, np.zeros((0, 6)), 1000 + k
        )
        for name, value in identify(excitation.recorded(0, machine)[0], case).physical.items():
            values.setdefault(name, []).append(value.value)
            reported.setdefault(name, []).append(value.reported)
    return values, reported
