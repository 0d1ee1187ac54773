"""Table 3 of the paper in simulation: what each static model makes of a machine whose k2 and k3 are not zero."""

import numpy as np

from cases.base.errors import IdentificationError
from cases.schema import Case
from identification.estimation.criteria import pose_regressors
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters
from identification.recording.recording import Recording
from identification.results.estimate import Estimate
from planner.poses.planned_poses import grid_candidates

TRUE_STATIC_MODEL = 5
MODELS = (0, 1, 2, 3, 4, 5)
SHOWN = ("m", "xC", "yC", "zC", "f_q0_1", "f_q0_2", "f_q0_3", "f_q0_4", "f_q0_5", "f_q0_6", "k0", "k1", "k2", "k3")


def standing_run(case: Case, noise: float, seed: int) -> Recording:
    """Averaged standstills at the 480 poses of the case's simulated machine.

    Args:
        case: with a simulated machine.
        noise: of an averaged force [N].
        seed: of it.
    """
    poses = grid_candidates(case)
    model = identification_model(case, TRUE_STATIC_MODEL)
    truth = linear_parameters(model, case.need_simulation("table 3").parameters)
    forces = pose_regressors(model, poses) @ truth
    forces = forces + np.random.default_rng(seed).normal(0.0, noise, forces.shape)
    return Recording("480 poses", None, Hexapod.of(case).strut_lengths(poses), None, forces, None)


def table_3(case: Case, noise: float = 1.0, seed: int = 0) -> dict[int, Estimate | str]:
    """Estimates by model, or the reason why there is none."""
    recording = standing_run(case, noise, seed)
    found: dict[int, Estimate | str] = {}
    for number in MODELS:
        try:
            found[number] = estimate_parameters(recording, case, number)
        except IdentificationError as error:
            found[number] = str(error)
    return found


def rows_of(case: Case, found: dict[int, Estimate | str]) -> list[list[str]]:
    """Rows for printing: truth, then each model; lengths in mm."""
    model = identification_model(case, TRUE_STATIC_MODEL)
    truth = dict(zip(model.names, linear_parameters(model, case.need_simulation("table 3").parameters), strict=True))
    truth |= {f"{c}C": truth[f"m{c}C"] / truth["m"] for c in "xyz"}
    rows = [["s0 in N", "-", *(f"{e.s0:.2f}" if isinstance(e, Estimate) else "refused" for e in found.values())]]
    for name in SHOWN:
        scale = 1e3 if name.endswith("C") else 1.0
        row = [name, f"{truth[name] * scale:.2f}"]
        for estimate in found.values():
            value = estimate.physical.get(name) if isinstance(estimate, Estimate) else None
            row.append("-" if value is None else f"{value.value * scale:.2f} ± {value.std * scale:.2f}")
        rows.append(row)
    return rows


COLUMNS = ("parameter", "true", *(f"model {k}" for k in MODELS))
