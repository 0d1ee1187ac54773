"""What is known beforehand, and how well: Gaussian priors on linear or physical parameters."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.estimation.selection import require_names
from identification.model import Model
from identification.parameters import PhysicalForm, physical_form

Array = NDArray[np.float64]


class Prior(NamedTuple):
    """A parameter, linear or physical, its value and standard deviation beforehand [SI]."""

    name: str
    value: float
    std: float


@dataclass(frozen=True, slots=True)
class PseudoMeasurements:
    """Priors as further rows of (23): h(u) = value + error of standard deviation std.

    Args:
        priors: at most one for each name.
        model: whose parameters they are about.
        form: its physical form.
    """

    priors: tuple[Prior, ...]
    model: Model
    form: PhysicalForm

    @classmethod
    def of(cls, priors: Sequence[Prior], model: Model) -> "PseudoMeasurements":
        """Checks the priors.

        Raises:
            IdentificationError: a name that the model does not have, with those that it has; two priors on one name; a
                prior that is not finite or has no uncertainty.
        """
        form = physical_form(model)
        names = [p.name for p in priors]
        require_names(names, list(dict.fromkeys([*model.names, *(p.name for p in form.parameters)])))
        for k, prior in enumerate(priors):
            if prior.name in names[:k]:
                raise IdentificationError(f"two priors on {prior.name}; combine them into one")
            if not (np.isfinite(prior.value) and np.isfinite(prior.std) and prior.std > 0.0):
                raise IdentificationError(
                    f"prior {prior.name} = {prior.value:g} +- {prior.std:g} needs finite numbers and a standard "
                    "deviation above 0; what is known exactly is fixed by a selection"
                )
        return cls(tuple(priors), model, form)

    @property
    def values(self) -> Array:
        """Shape (priors,) [SI]."""
        return np.array([p.value for p in self.priors])

    @property
    def std(self) -> Array:
        """Shape (priors,) [SI]."""
        return np.array([p.std for p in self.priors])

    @property
    def linear(self) -> NDArray[np.bool_]:
        """Which of them are on a component of u, shape (priors,)."""
        return np.array([p.name in self.model.names for p in self.priors], dtype=bool)

    def at(self, u: Array) -> tuple[Array, Array]:
        """H(u), shape (priors,), and dh/du, shape (priors, u); components of u beyond the model have no prior."""
        count = len(self.model.names)
        physical, jacobian = (value.full() for value in self.form.map(u[:count]))
        names = [p.name for p in self.form.parameters]
        values, rows = np.empty(len(self.priors)), np.zeros((len(self.priors), len(u)))
        for k, prior in enumerate(self.priors):
            if prior.name in self.model.names:
                index = self.model.names.index(prior.name)
                values[k], rows[k, index] = u[index], 1.0
            else:
                index = names.index(prior.name)
                values[k], rows[k, :count] = physical[index, 0], jacobian[index]
        return values, rows
