"""Two results of the same thing: their difference, and whether it is within what both are uncertain by."""

from typing import NamedTuple

import numpy as np

from cases.base.units import Array
from cases.tolerances import BOUNDS
from identification.estimation.fit import COVERAGE_FACTOR
from identification.model.parameters import physical_form
from identification.results.payload import in_common
from identification.results.result import Result


class Difference(NamedTuple):
    """Of a parameter, the later result less the earlier one [SI]."""

    value: float
    expanded: float  # U (k = 2) of the difference, in which tolerances that both are off by alike cancel

    @property
    def en(self) -> float | None:
        """E_n of ISO 13528, |difference| over its U; None where neither varies."""
        return abs(self.value) / self.expanded if self.expanded > 0.0 else None


def differences(before: Result, after: Result) -> dict[str, Difference]:
    """Differences of physical parameters that both results have, by name.

    Both are off by the same tolerances of their machine, and by the same bounds where both are of the same body: what
    these do to the difference is what they do to one less what they do to the other.
    """
    one, other = _Physical.of(before), _Physical.of(after)
    keys = in_common(before, after)
    same = (r.record.computed_from or {} for r in (before, after))
    bounds = [{key: v for key, v in of.items() if key.startswith("bounds")} for of in same]
    if BOUNDS in before.biases and BOUNDS in after.biases and bounds[0] == bounds[1]:
        keys = keys | {BOUNDS}
    compared = {}
    for name in one.names:
        if name not in other.names:
            continue
        j, k = one.names.index(name), other.names.index(name)
        white = one.slope[j] @ before.covariance @ one.slope[j] + other.slope[k] @ after.covariance @ other.slope[k]
        robust = sum(
            float(of.slope[i] @ result.covariance_robust @ of.slope[i])
            for of, i, result in ((one, j, before), (other, k, after))
        )
        for key in keys:
            there, here = one.slope[j] @ before.biases[key], other.slope[k] @ after.biases[key]
            if there.shape == here.shape:
                robust -= 2.0 * float(there @ here)
        variance = max(float(white), robust, 0.0)
        value = float(other.values[k] - one.values[j])
        compared[name] = Difference(value, COVERAGE_FACTOR * float(np.sqrt(variance)))
    return compared


class _Physical(NamedTuple):
    """Physical parameters of a result with their slopes by u."""

    names: list[str]
    values: Array
    slope: Array

    @classmethod
    def of(cls, result: Result) -> "_Physical":
        form = physical_form(result.model)
        values, slope = (v.full() for v in form.map(result.values))
        return cls([p.name for p in form.parameters], values[:, 0], slope)
