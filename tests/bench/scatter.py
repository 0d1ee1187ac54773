"""What standard deviations ought to be: the scatter of estimates over machines that err with the pose in other ways."""

from pathlib import Path

import numpy as np

from cases.schema import load_case
from hexcite._run import carried_out
from hexcite.comparison.trials import Excitation
from identification.identify import estimate_parameters
from postprocessors.program import read_program

MACHINES = 12  # of so many a scatter is uncertain by a fifth, of twenty parameters the extremes by more
METHODS_SHOWN = ("D9M", "D9N", "ptp", "spline")


def scatter_rows(programs: Path) -> list[list[str]]:
    """Scatter over root mean square of the reported deviations: of all parameters, without load, and by (28) alone.

    Args:
        programs: folder of a validation on the virtual controller.
    """
    rows = []
    for method in METHODS_SHOWN:
        found = _estimates(programs / f"{method}.mpf", method)
        scatter = np.std(found[:, :, 0], axis=0, ddof=1)
        for words, column, wanted in (("reported", 1, "about 1"), ("(28)", 2, "misled")):
            ratio = scatter / np.sqrt(np.mean(found[:, :, column] ** 2, axis=0))
            told = f"{np.exp(np.mean(np.log(ratio))):.2f} ({ratio.min():.2f} to {ratio.max():.2f})"
            rows.append([f"  {method}, {MACHINES} machines: scatter over std, {words}", told, wanted])
    return rows


def _estimates(program: Path, method: str) -> np.ndarray:
    """Values, reported deviations and those by (28), shape (machines, parameters, 3)."""
    case = load_case("hexapod")
    found = case.need_simulation("the scatter").disturbances
    assert found is not None
    run = carried_out(read_program(program, case), case, "virtual")
    rows = []
    for k in range(MACHINES):
        machine = found.model_copy(update={"pose_error_seed": 100 + k})
        excitation = Excitation(case, method, run.excitation, run.execution, run.trigger, np.zeros((0, 6)), 1000 + k)
        physical = estimate_parameters(excitation.recorded(0, machine), case).physical
        rows.append([(v.value, v.reported, v.std) for v in physical.values()])
    return np.array(rows)
