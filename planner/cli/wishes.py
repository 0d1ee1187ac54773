"""What a user asks of an identification, as typed, and the method that it means."""

from pathlib import Path
from typing import NamedTuple

from cases.schema import Case
from identification.estimation.estimators import Method, method
from identification.estimation.priors import Prior
from identification.estimation.selection import symmetric_platform
from identification.model import Model
from identification.parameters import physical_form
from identification.saved import biases_of
from planner.cli.quantities import read_uncertain, read_values


class Typed(NamedTuple):
    """What a user asks of an identification, as typed.

    Args:
        estimator: its name.
        fix: known values.
        drop: names to leave out.
        symmetric: whether the platform is symmetric.
        prior: uncertain values.
        weights: instead of the case's.
        biases: result whose offsets are taken.
        stale: go on although the case has changed since the biases were identified.
    """

    estimator: str = "gauss-markov"
    fix: tuple[str, ...] = ()
    drop: tuple[str, ...] = ()
    symmetric: bool = False
    prior: tuple[str, ...] = ()
    weights: str | None = None
    biases: Path | None = None
    stale: bool = False


def method_of(wish: Typed, model: Model, case: Case) -> Method:
    """The method that a user asks for.

    Raises:
        HexciteError: a value that is not understood, a name that the model does not have, an unknown estimator, a
            result that is none or belongs to another case.
    """
    units = {p.name: p.unit for p in (*model.parameters, *physical_form(model).parameters)}
    known = read_values(wish.fix, units, "--fix")
    if wish.symmetric:
        known = symmetric_platform(model) | known
    priors = [Prior(*values) for values in read_uncertain(wish.prior, units, "--prior")]
    biases = None if wish.biases is None else biases_of(wish.biases, case, wish.stale)
    return method(wish.estimator, known, wish.drop, priors, wish.weights, biases)
