"""The information limit of a case: what no motion inside its limits can exceed; computed once, then read from a cache.

A file of the cache belongs to a case, a model and the code that computes: the files below are hashed, so that bounds of
another version are never read. `HEXCITE_CACHE=off` in the environment reads and writes none.

It is that of the D-optimal approximate design over the motion box of pose, rates and accelerations, see
`planner.bounds.design` and its proof in `planner.bounds.certificate`.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from math import isfinite
from pathlib import Path
from time import process_time

import numpy as np
from platformdirs import user_cache_path
from pydantic import TypeAdapter, ValidationError

from cases.base.atomic import write_text
from cases.base.errors import Code, FileProblem, HexciteError, option
from cases.base.options import default_of, documented
from cases.base.seldom import seldom
from cases.base.text_formats import json_text
from cases.base.units import as_html
from cases.basis import bound_hash
from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.model.model import Model, full_model, identification_model
from planner.bounds.design import optimal_design, searched_design
from planner.bounds.features import box_features
from planner.options import Model as ModelNumber
from planner.options import TimeLimit
from planner.search.feasibility import require_identifiable

PROVEN = "multiplicative and exchange steps; dmax proven by branch and bound over angles and rates, corners of the rest"
ESTIMATE = "multiplicative and exchange steps; dmax by branch and bound, an estimate: a longer time limit may prove it"
SEARCHED = "multiplicative and exchange steps; dmax by climbing from many states of the box, an estimate"
COMPUTING = (
    "planner/bounds", "identification/model", "identification/machines", "identification/estimation/criteria.*",
)  # fmt: skip
"""Modules on which a bound depends, beside the case, from the folder of the packages."""
SEARCHED_GAP = 5e-3  # the same where dmax is searched for: half a percent of an efficiency
SWITCH = "HEXCITE_CACHE"  # variable of the environment
GAP = 1e-3  # of dmax / u - 1: log det F* is then known to u GAP = 0.02, an efficiency to 0.1 %


@dataclass(frozen=True, slots=True, repr=False)
class Bound:
    """An upper bound of log det of the mean information, in reference scaling."""

    logdet: float  # the bound, log det F + u log(dmax / u)
    dmax: float  # largest directional derivative over the box: proven, or the largest that was found
    parameters: int  # u
    method: str  # how the design and dmax were found
    certified: bool  # whether the bound is proven; otherwise it is an estimate
    design_logdet: float  # log det F of the design that was found; the best lies between it and the bound

    def efficiency(self, logdet: float) -> float:
        """D-efficiency of a motion with this log det of its mean information, between 0 and 1 inside the limits."""
        return float(np.exp((logdet - self.logdet) / self.parameters))

    def raised(self, logdet: float) -> "Bound":
        """The bound, of which a motion inside the limits with this log det of its information is a witness.

        An estimate may lie below what a motion has; then it is not a bound, and the motion is.
        """
        if logdet <= self.logdet:
            return self
        known = self.certified and logdet - self.logdet <= GAP * self.parameters  # the rounding of its search
        return replace(self, logdet=logdet, certified=known, method=f"{self.method}; raised to a motion that has more")

    def __repr__(self) -> str:
        """A few lines: how it was found, the best design, and the bound."""
        return (
            f"{self.method}\nlog det of the mean information of {self.parameters} parameters in reference scaling:\n"
            f"the best design that was found has {self.design_logdet:.4f}\n"
            f"no motion exceeds {self.logdet:.4f} ({self.label})"
        )

    _repr_html_ = as_html

    @property
    def label(self) -> str:
        """The kind of the bound, in words for people."""
        return "certified" if self.certified else "an estimate"


@lru_cache(maxsize=1)
def code_hash() -> str:
    """Hash of the code that computes a bound: its modules as they lie on the disk, and the libraries that solve."""
    home, content = Path(__file__).parents[2], hashlib.sha256()
    for place in COMPUTING:
        for file in sorted(home.glob(place if place.endswith(".*") else f"{place}/*")):
            if file.is_file():
                content.update(file.name.encode() + file.read_bytes())
    for library in ("casadi", "numpy", "scipy"):
        content.update(version(library).encode())
    return content.hexdigest()[:16]


def information_limit(
    case: Case,
    model: Model,
    time_limit: TimeLimit = default_of(TimeLimit),
    renew: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Bound:
    """The bound of a case and model, from the cache if it was computed before.

    Args:
        renew: whether to compute an estimate that is known again.
        time_limit: as in `bound`.
        progress: as in `bound`.
    """
    if os.environ.get(SWITCH, "").lower() == "off":
        return compute_bound(case, model, time_limit, progress)
    name = f"{bound_hash(case)}-model{model.number}-box-equal-{code_hash()}.json"  # equal: W = 1
    file = user_cache_path("hexcite") / "bounds" / name
    with suppress(OSError, ValidationError):
        bound = TypeAdapter(Bound).validate_json(file.read_bytes(), strict=True)
        fits = bound.parameters == len(model.parameters) and np.isfinite([bound.logdet, bound.design_logdet]).all()
        if fits and 0.0 < bound.dmax < np.inf and (bound.certified or not renew):
            return bound
    result = compute_bound(case, model, time_limit, progress)
    with suppress(FileProblem):  # without a writable cache it is computed anew each time
        write_text(file, json_text(asdict(result)))
    return result


@documented()
def bound(
    case: Case,
    model: ModelNumber = default_of(ModelNumber),
    *,
    time_limit: TimeLimit = default_of(TimeLimit),
    progress: Callable[[str], None] = lambda _: None,
) -> Bound:
    """Upper bound of the information of a motion inside the limits of a case, with its certificate.

    >>> hx.bound(hx.load_case("five_axis_table"), model=0)
    multiplicative and exchange steps; dmax by climbing from many states of the box, an estimate
    log det of the mean information of 10 parameters in reference scaling:
    the best design that was found has 3.32...
    no motion exceeds 3.35... (an estimate)

    A proven one is read from the cache if it was computed before; an estimate is computed again.

    Args:
        case: machine and limits.
        OPTIONS
        progress: called with a line about the state of the computation, at most once a second.

    Raises:
        HexciteError: no duration, an unknown model, a case without machine or limits, or a machine whose motions do not
            determine all parameters.
    """
    if not (isfinite(time_limit) and time_limit > 0.0):
        raise HexciteError(
            problem=f"{option('time_limit')} {time_limit:g} s is not a duration",
            remedy="give seconds above 0, such as 120",
            code=Code.OUT_OF_RANGE,
        )
    case.need_motion("the information limit")
    effective_model = identification_model(case, full_model(case) if model is None else model)
    require_identifiable(case, effective_model)
    return information_limit(case, effective_model, time_limit, True, seldom(progress))


def compute_bound(
    case: Case,
    model: Model,
    time_limit: TimeLimit = default_of(TimeLimit),
    progress: Callable[[str], None] = lambda _: None,
) -> Bound:
    """Computes the bound; arguments as in `bound`."""
    scaling, deadline = reference_scaling(case, model), process_time() + time_limit
    if model.struts is not None or not (model.machine is None or model.machine.of_pose):
        design, method = searched_design(case, model, scaling, SEARCHED_GAP, deadline, progress), SEARCHED
    else:
        design = optimal_design(box_features(case, model, scaling), GAP, deadline, progress)
        method = PROVEN if design.certified else ESTIMATE
    return Bound(design.bound(len(scaling)), design.dmax, len(scaling), method, design.certified, design.logdet)
