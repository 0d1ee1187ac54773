"""Estimates beside the truth that a simulated machine knows."""

from typing import Any

import numpy as np

from cases.schema import Case
from identification.model import identification_model
from identification.parameters import linear_parameters, physical_form
from identification.result import Estimate


def truth_rows(case: Case, estimate: Estimate) -> list[dict[str, Any]]:
    """Truth, estimate, standard deviation and error of each physical parameter, SI units.

    The standard deviation is the larger of (28) and the autocorrelation-robust one.

    Raises:
        CaseError: the case describes no simulated machine.
    """
    model = identification_model(case, estimate.model)
    u = linear_parameters(model, case.need_simulation("the comparison with the truth").parameters)
    truth, _ = physical_form(model).of(u, np.zeros((len(u), len(u))))
    return [
        {
            "name": name,
            "unit": value.unit,
            "truth": float(true),
            "estimate": value.value,
            "std": value.reported,
            "error": value.value - float(true),
        }
        for true, (name, value) in zip(truth, estimate.physical.items(), strict=True)
    ]
