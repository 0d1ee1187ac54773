"""Numbers as people read them, to the second digit of their standard deviation; parameters and solvers in words."""

from collections.abc import Collection
from enum import StrEnum
from math import floor, isfinite, log10
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from identification.estimation.fit import Value
    from identification.limit import LimitCheck

_BODY = {"m": "mass"} | {f"{axis}C": f"centre of gravity {axis}" for axis in "xyz"}
_BODY |= {f"IC{i}{j}": f"inertia {a}{b}" for i, a in enumerate("xyz", 1) for j, b in enumerate("xyz", 1)}
_WORDS = {
    "k0": "deformation: force by displacement",
    "k1": "deformation: moment by displacement",
    "k2": "deformation: force by tilt",
    "k3": "deformation: moment by tilt",
    "mu": "mass of a rod",
    "h": "first moment of a rod",
    "k": "inertia of rod and tube",
    "d": "first moment of a tube",
} | {f"f_q0_{k}": f"offset of channel {k}" for k in range(1, 7)}
_WORDS |= {f"K{n}_{k}{a}": f"deformation: channel {k} by {a}" for n in "134" for k in range(1, 7) for a in "xyz"}
MOST_TIMES = 10.0  # multiple of a limit up to which a share is shown
MOST_PLACES = 9  # decimals beyond which a fixed notation is not legible


def places(std: float) -> int | None:
    """Decimals that show `std` with two digits; None where it is not a scale (zero, not finite, tiny)."""
    if not isfinite(std) or std <= 0.0:
        return None
    digits = 1 - floor(log10(float(f"{std:.1e}")))  # rounded first: 0.0996 is shown as 0.10
    return None if digits > MOST_PLACES else max(digits, 0)


def value_text(value: float, std: float) -> str:
    """`value` with the digits that are significant for its standard deviation `std`, in the same unit."""
    decimals = places(std)
    return f"{value:.6g}" if decimals is None else f"{round(value, decimals) + 0.0:.{decimals}f}"


def std_text(std: float) -> str:
    """A standard deviation with two digits, without exponent where that is legible."""
    decimals = places(std)
    return f"{std:#.2g}" if decimals is None else f"{std:.{decimals}f}"


def with_deviation(value: float, std: float) -> str:
    """A value with its standard deviation, both rounded to two digits of the deviation."""
    return f"{value_text(value, std)} ± {std_text(std)}"


def legible(unit: str) -> tuple[float, str]:
    """Factor from an SI unit to the one for people, and that unit: mm for lengths, all else unchanged."""
    return (1e3, "mm") if unit == "m" else (1.0, unit)


def share_text(ratio: float, decimals: int = 2) -> str:
    """Share of a limit in %, with two decimals, as 99.99 is not 100; above ten times the limit in words."""
    return f"{100 * ratio:.{decimals}f} %" if ratio <= MOST_TIMES else "more than ten times"


def bounds_text(check: "LimitCheck") -> str:
    """The limit, or both where there are two."""
    if check.bounds is None:
        return f"{check.limit:.4g}"
    low, high = check.bounds
    return f"±{high:.4g}" if low == -high else f"{low:.4g} to {high:.4g}"


def carries_rods(names: Collection[str]) -> bool:
    """Whether these are parameters of sensors in struts that carry whole rods: the body is the platform with rods."""
    return "d" in names and "mu" not in names


def parameter_words(name: str, rods: bool = False) -> str:
    """A parameter in words with its letter in brackets, such as `mass (m)`; letters that have no words stay alone.

    Args:
        rods: whether parameters of the body are those of the platform with rods, see `carries_rods`.
    """
    words = _BODY.get(name, _WORDS.get(name))
    if words is None:
        return name
    return f"{words}, platform with rods ({name})" if rods and name in _BODY else f"{words} ({name})"


def value_cells(name: str, value: "Value", rods: bool = False) -> tuple[str, ...]:
    """A parameter for people: words, value, the larger standard deviation, that by (28), the robust one, unit."""
    scale, unit = legible(value.unit)
    if value.reported <= 1e-9 * abs(value.value):  # a given value deviates by rounding only
        return parameter_words(name, rods), f"{value.value * scale:.6g}", "given", "-", "-", unit
    deviations = (std_text(std * scale) for std in (value.reported, value.std, value.std_robust))
    return parameter_words(name, rods), value_text(value.value * scale, value.reported * scale), *deviations, unit


class SolverStatus(StrEnum):
    """How a run of IPOPT ended: its own return statuses as CasADi names them, in small letters, and ours."""

    CONVERGED = "solve succeeded"
    ACCEPTABLE = "solved to acceptable level"
    INFEASIBLE = "infeasible problem detected"
    TINY_STEPS = "search direction becomes too small"
    DIVERGING = "diverging iterates"
    STOPPED = "user requested stop"
    FEASIBLE = "feasible point found"
    ITERATION_LIMIT = "maximum iterations exceeded"
    RESTORATION_FAILED = "restoration failed"
    STEP_FAILED = "error in step computation"
    CPU_LIMIT = "maximum cputime exceeded"
    TIME_LIMIT = "maximum walltime exceeded"
    TOO_FEW_FREEDOMS = "not enough degrees of freedom"
    INVALID_PROBLEM = "invalid problem definition"
    INVALID_OPTION = "invalid option"
    INVALID_NUMBER = "invalid number detected"
    EXCEPTION = "unrecoverable exception"
    FOREIGN_EXCEPTION = "nonipopt exception thrown"
    NO_MEMORY = "insufficient memory"
    INTERNAL_ERROR = "internal error"
    SETTLED = "no more gained"
    NOT_RUN = ""
    UNKNOWN = "unknown"

    @classmethod
    def _missing_(cls, value: object) -> "SolverStatus":
        """The member of a status as IPOPT writes it, such as `Solve_Succeeded`."""
        plain = str(value).replace("_", " ").lower()
        return next((status for status in cls if status.value == plain), cls.UNKNOWN)

    @property
    def converged(self) -> bool:
        """Whether the solver converged, or gained so little that it was stopped."""
        return self in (SolverStatus.CONVERGED, SolverStatus.ACCEPTABLE, SolverStatus.FEASIBLE, SolverStatus.SETTLED)

    @property
    def words(self) -> str:
        """What people are shown: to stop at the iterations that a stage has is not a failure."""
        return _SHOWN.get(self, str(self))


_SHOWN = {
    SolverStatus.ITERATION_LIMIT: "at its iteration limit",
    SolverStatus.STOPPED: "stopped by the time limit or by Ctrl-C",
    SolverStatus.CONVERGED: "converged",
}
