"""Periodic runs as Fourier series against the low-pass, with encoders of several resolutions."""

import numpy as np

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.model import identification_model
from identification.parameters import linear_parameters, physical_form
from identification.samples import Conditioning
from tests.helpers import simulated
from tests.identification.repeating import Repeating, recorded

SEEDS = 6
STEPS_UM = (0.1, 10.0, 50.0)


def conditioning_rows() -> list[list[str]]:
    """Errors of the low-pass over those of the series, as geometric means over the parameters of model 9."""
    case = load_case("hexapod")
    model = identification_model(case, 9)
    truth = physical_form(model).of(linear_parameters(model, case.simulation.parameters), np.eye(20))[0]
    rows = []
    for step in STEPS_UM:
        coarse = simulated(case, encoder_resolution_um=step)
        errors = np.empty((2, SEEDS, len(truth)))
        for seed in range(SEEDS):
            run = recorded(coarse, Repeating(seed=seed), seed)
            for k, how in enumerate((Conditioning(), Conditioning(True))):
                found = estimate_parameters(run, coarse, conditioning=how)
                errors[k, seed] = [v.value for v in found.physical.values()] - truth
        usual, series = np.sqrt(np.mean(errors**2, axis=1))
        ratio = f"{np.exp(np.mean(np.log(usual / series))):.3g}"
        rows.append(
            [f"error of the low-pass over that of --period auto, encoder steps of {step:g} um", ratio, "1 or more"]
        )
    return rows
