"""Setups 1b, 2x and R of the paper's Figure 1 on one machine, with one motion and one payload.

    python tests/bench/setups.py            # the table
    python tests/bench/setups.py PLAN       # with the motion of a plan of the case hexapod

The same hexapod makes the same motion with six force sensors in bars that carry the end-effector (1b), in its struts,
at the drives (2x), and with a force/torque sensor at its platform (R). Noise of a sample is 1 N in every force, and
0.15 N m in the moments of the force/torque sensor: 1 N at the radius of the bars. Model 6, without error terms: errors
of structure and pose, in which the setups differ most, are not part of this.
"""

import sys
from functools import reduce
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

import hexcite as hx
from cases.schema import Case, load_case
from cases.sensors import SensorFrame, Transducer, together
from identification.machines.casadi_batch import over_samples
from identification.model.blocks import RIGID
from identification.model.model import identification_model
from identification.model.parameters import body_parameters, physical_form
from identification.motion.motion import sample
from tests.bench.tables import print_table

Array = NDArray[np.float64]

NAMES = ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")
RATE = 200.0  # [1/s] of instants that stand for all samples
LEVER = 0.15  # [m] at which noise of moments is 1 N


def setups() -> dict[str, Case]:
    """The three cases."""
    bars = load_case("hexapod")
    wrist = SensorFrame(transducer=Transducer(sense="sensor_on_load"))
    of_wrist = bars.model_copy(update={"setup": "R", "sensor_frame": wrist})
    return {"1b, bars": bars, "2x, struts": load_case("strut_sensors"), "R, force/torque": of_wrist}


def rows(plan: hx.Plan, payload: int = 1) -> list[list[str]]:
    """Deviations of the payload (two runs, with and without it), and of the external force in one sample.

    Args:
        plan: of the case hexapod, whose motion all make.
        payload: number of weights that are mounted.
    """
    motion = sample(plan.motion, RATE)
    columns = {name: _deviations(case, motion.coordinates, motion.rates, motion.accelerations, plan.duration, payload)
               for name, case in setups().items()}  # fmt: skip
    units = {"m": (1e3, "g")} | dict.fromkeys(("xC", "yC", "zC"), (1e6, "um"))
    units |= dict.fromkeys(("IC11", "IC22", "IC33"), (1e6, "kg mm^2"))
    units |= {"force": (1.0, "N"), "moment": (1.0, "N m")}
    labels = {"force": "external force, one sample", "moment": "external moment, one sample"}
    found = []
    for name in (*NAMES, *labels):
        scale, unit = units[name]
        found.append([f"{labels.get(name, name)} [{unit}]", *(f"{scale * c[name]:.3g}" for c in columns.values())])
    return found


def _deviations(
    case: Case, pose: Array, rates: Array, accelerations: Array, duration: float, payload: int
) -> dict[str, float]:
    assert case.payloads is not None
    model = identification_model(case, RIGID)
    noise = np.r_[np.ones(3), np.full(3, LEVER if case.sensor_frame.has_moments else 1.0)]
    matrices = over_samples(model.coordinate_regressor, pose, rates, accelerations)[0]
    whitened = matrices / noise[:, None]
    information = np.einsum("nij,nik->jk", whitened, whitened) * duration * case.recording.rate_Hz / len(pose)
    covariance = np.linalg.inv(information)
    form, body = physical_form(model), body_parameters(reduce(together, case.payloads.weights[:payload]))
    known = np.array([body.get(name, 0.0) for name in model.names])  # of the payload alone: struts cancel
    std = np.sqrt(np.diag(form.of(known, 2.0 * covariance)[1]))
    found = dict(zip((p.name for p in form.parameters), std, strict=True))
    left = noise[:, None] ** 2 * np.eye(6) + matrices @ covariance @ matrices.transpose(0, 2, 1)
    roots = np.linalg.cholesky(left)
    turned = [model.wrenches(roots[:, :, k], pose) for k in range(6)]
    variance = np.mean(np.sum(np.square(turned), axis=0), axis=0)
    return found | {"force": float(np.sqrt(variance[:3].mean())), "moment": float(np.sqrt(variance[3:].mean()))}


def main() -> None:
    """Prints the table."""
    if len(sys.argv) > 1:
        plan = hx.Plan.load(sys.argv[1])
    else:
        plan = hx.plan(load_case("hexapod"), hx.PointToPoint(), duration=12.0, model=RIGID, starts=1)
    print_table(
        f"One motion of {plan.duration:g} s, one payload, three setups", ("standard deviation", *setups()), rows(plan)
    )


if __name__ == "__main__":
    main()
