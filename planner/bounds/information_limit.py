"""The information limit of a case: what no motion inside its limits can exceed; computed once, then read from a cache.

Two bounds. Over the motion box of pose, rates and accelerations: the D-optimal approximate design, see
`planner.bounds.design` and its proof in `planner.bounds.certificate`. Tighter: the best design that also has the
moments of a motion from rest to rest with limited jerk, see `planner.bounds.features`, `planner.bounds.tight` and the
proof in `planner.bounds.certificate`.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from math import isfinite
from pathlib import Path
from time import process_time

import numpy as np
from platformdirs import user_cache_path

from cases.basis import bound_hash
from cases.errors import CaseError, FileProblem, HexciteError
from cases.files import DAMAGED, json_text, read_json, write_text
from cases.schema import Case
from cases.units import as_html
from identification.criteria import reference_scaling
from identification.model import Model, full_model, identification_model
from planner.bounds.design import Design, optimal_design, searched_design
from planner.bounds.features import box_features
from planner.bounds.tight import tight_design
from planner.search.feasibility import require_identifiable

PROVEN = "multiplicative and exchange steps; dmax proven by branch and bound over angles and rates, corners of the rest"
ESTIMATE = "multiplicative and exchange steps; dmax by branch and bound that ran out of time, an estimate"
SEARCHED = "multiplicative and exchange steps; dmax by climbing from many states of the box, an estimate"
TIGHT = (
    "convex optimisation under moment constraints, with exchange; largest Lagrangian proven by branch and bound over "
    "angles, rates and accelerations"
)
TIGHT_ESTIMATE = (
    "convex optimisation under moment constraints, with exchange; largest Lagrangian by a search that ran out of time "
    "for its proof, an estimate"
)
VERSION = 2  # of the method: a new one does not read old cache files
SEARCHED_GAP = 5e-3  # the same where dmax is searched for: half a percent of an efficiency
GAP = 1e-3  # of dmax / u - 1: log det F* is then known to u GAP = 0.02, an efficiency to 0.1 %
TIGHT_GAP = 0.01  # of the Lagrangian's maximum, within which it counts as proven; the design found lies further below
TIGHT_AIM = 0.003  # the same, at which the proof ends before its time
TIME_LIMIT = 120.0  # [s] of processor time, so that answers do not depend on what else a computer does; usual: 1 to 20


@dataclass(frozen=True, slots=True, repr=False)
class Bound:
    """An upper bound of log det of the mean information, in reference scaling."""

    logdet: float  # the bound, log det F + u log(dmax / u)
    # largest directional derivative over the box, of the tighter bound largest Lagrangian: proven, or the largest that
    # was found
    dmax: float
    parameters: int  # u
    method: str  # how the design and dmax were found
    certified: bool  # whether the bound is proven; otherwise it is an estimate
    design_logdet: float  # log det F of the design that was found; the best lies between it and the bound
    # bound that is proven in any case; `logdet` where certified, looser otherwise. None where nothing is proven: for
    # machines whose coordinates are not a pose
    proven_logdet: float | None

    def efficiency(self, logdet: float) -> float:
        """D-efficiency of a motion with this log det of its mean information, between 0 and 1."""
        return float(np.exp((logdet - self.logdet) / self.parameters))

    def __repr__(self) -> str:
        """Two lines: the bound, and how it was found."""
        design = f"the best design that was found has {self.design_logdet:.4f}"
        return (
            f"Bound of log det, {self.label}: {self.logdet:.4f}, {self.parameters} parameters; {design}\n{self.method}"
        )

    _repr_html_ = as_html

    @property
    def label(self) -> str:
        """The kind of the bound, in words for people."""
        return "certified" if self.certified else "an estimate"


def information_limit(
    case: Case,
    model: Model,
    tight: bool = False,
    time_limit: float = TIME_LIMIT,
    renew: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Bound:
    """The bound of a case and model, from the cache if it was computed before.

    The tight one takes a minute or two, and more time makes it tighter: where it is not certified it is computed again,
    with `renew` in any case, and the better of the new and the known one goes into the cache.

    Arguments as in `bound`; over the box alone `renew` computes only an estimate again.

    Raises:
        HexciteError: there is no bound yet after the time limit, or the convex optimisation failed.
    """
    file, previous = _file(case, model, tight), known_bound(case, model, tight)
    if previous is not None and (previous.certified and not renew if tight else previous.certified or not renew):
        return previous
    result = compute_bound(case, model, tight, time_limit, progress)
    if tight and previous is not None:
        result = max(previous, result, key=lambda bound: (bound.certified, -bound.logdet))
    with suppress(FileProblem):  # without a writable cache it is computed anew each time
        write_text(file, json_text(asdict(result)))
    return result


def require_time(time_limit: float) -> None:
    """Raises HexciteError where a time limit is not a positive duration."""
    if not (isfinite(time_limit) and time_limit > 0.0):
        raise HexciteError(f"--time-limit {time_limit:g} s is not a duration; give seconds above 0, such as 120")


def bound(
    case: Case,
    model: int | None = None,
    tight: bool = False,
    *,
    time_limit: float = TIME_LIMIT,
    renew: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Bound:
    """Upper bound of the information of a motion inside the limits of a case, with its certificate.

    Args:
        case: machine and limits.
        model: number in Table 2; by default the largest that a motion can identify.
        tight: count on rest at both ends and limited jerk, which takes minutes; else on the motion box alone.
        time_limit: processor time after which the answer is an estimate [s].
        renew: compute a known bound again.
        progress: called with a line about the state of the computation now and then.

    Raises:
        HexciteError: no duration, an unknown model, a case without machine or limits, `tight` of sensors in struts, or
            a machine whose motions do not determine all parameters.
    """
    require_time(time_limit)
    case.need_motion("the information limit")
    effective_model = identification_model(case, full_model(case) if model is None else model)
    require_identifiable(case, effective_model)
    if tight:
        case.need_machine("the tight information limit")
        if effective_model.struts is not None:
            raise CaseError(
                f"case {case.name}",
                "sensor_frame.struts",
                "the tight information limit is for sensors in a frame of their own; use bound without --tight",
            )
    return information_limit(case, effective_model, tight, time_limit, renew, progress)


def _file(case: Case, model: Model, tight: bool) -> Path:
    folder, kind = user_cache_path("hexcite") / "bounds", "tight" if tight else "box"
    return folder / f"{bound_hash(case)}-model{model.number}-{kind}-equal-v{VERSION}.json"  # equal: W = 1


def known_bound(case: Case, model: Model, tight: bool) -> Bound | None:
    """The earlier answer of `information_limit`, or None; a damaged file of the cache is removed."""
    file = _file(case, model, tight)
    if not file.is_file():
        return None
    try:
        return _read(file, len(model.parameters))
    except (FileProblem, *DAMAGED):
        with suppress(OSError):  # a cache holds nothing that cannot be computed again
            file.unlink(missing_ok=True)
        return None


def _read(file: Path, size: int) -> Bound:
    """A bound from the cache; raises where it is not one of this model."""
    data = read_json(file, "hexcite bound")
    bound = Bound(**data)
    proven = [] if bound.proven_logdet is None else [bound.proven_logdet]
    numbers = [bound.logdet, bound.dmax, bound.design_logdet, *proven]
    fits = isinstance(bound.method, str) and isinstance(bound.certified, bool) and bound.parameters == size
    if not (fits and np.isfinite(numbers).all() and bound.dmax > 0.0):
        raise ValueError(f"{file}: holds no bound of {size} parameters")
    return bound


def compute_bound(
    case: Case,
    model: Model,
    tight: bool = False,
    time_limit: float = TIME_LIMIT,
    progress: Callable[[str], None] = lambda _: None,
) -> Bound:
    """Computes the bound; arguments and errors as in `information_limit`."""
    scaling, deadline = reference_scaling(case, model), process_time() + time_limit
    size = len(scaling)
    if tight:
        design = tight_design(case, box_features(case, model, scaling), TIGHT_GAP, deadline, progress, aim=TIGHT_AIM)
        return _bound(design, size, TIGHT if design.certified else TIGHT_ESTIMATE)
    if model.struts is not None or not (model.machine is None or model.machine.of_pose):
        design = searched_design(case, model, scaling, SEARCHED_GAP, deadline, progress)
        return replace(_bound(design, size, SEARCHED), proven_logdet=None)
    design = optimal_design(box_features(case, model, scaling), GAP, deadline, progress)
    if not np.isfinite(design.proven):
        raise HexciteError(
            "the information limit has no proof yet after the time limit; give it more with --time-limit"
        )
    return _bound(design, size, PROVEN if design.certified else ESTIMATE)


def _bound(design: Design, size: int, method: str) -> Bound:
    proven = design.logdet + size * float(np.log(design.proven / size))
    return Bound(design.bound(size), design.dmax, size, method, design.certified, design.attained, proven)
