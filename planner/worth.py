"""What a plan is worth and how it was found, as it stands in `plan.json`: of a motion, and of a set of poses.

Fields have the names of the entries.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import TypeAdapter

from identification.limit import LimitReport
from planner.bounds.kept import Bound
from planner.search.solving import Failed


@dataclass(frozen=True, slots=True)
class Search:
    """How a motion was found."""

    # starts that led somewhere, the best first: seed; refined, whether all limits were constrained wherever they come
    # close, else it was explored only; start_logdet, log det F where it began, None where F was singular; logdet, where
    # it ended; criterion_value, to be maximised; solver, its status; converged, whether its last stage did; iterations
    # of all stages; seconds
    starts: tuple[dict[str, Any], ...]
    failed_starts: tuple[Failed, ...]  # the others, with the reason
    interrupted: bool  # whether Ctrl-C ended the search early
    solve_s: float  # spent on it [s]
    rival: dict[str, Any] | None  # what another family reached in seconds: family, d_efficiency


@dataclass(frozen=True, slots=True)
class Worth:
    """What a planned motion is worth."""

    settings: Mapping[str, Any]  # settings of the family, as found
    search: Search
    criterion_value: float  # the criterion of Table 4, to be maximised, in reference scaling
    logdet: float  # log det of the mean information, reference scaling, W = 1
    condition: float  # mu_1 / mu_u, reference scaling
    bound: Bound
    bound_tight: Bound | None  # what no motion from rest to rest with limited jerk can exceed, where that is known
    # standard deviation of a sample of each channel behind the predictions [N, or N and N m]
    assumed_noise_of_channels: tuple[float, ...]
    noise_of_accelerations: bool  # whether noise of the accelerations is part of it
    weights: str  # weights of the identification that predictions assume
    weaknesses: tuple[str, ...] = ()  # why another plan would carry more information
    notes: tuple[str, ...] = ()  # what the user should know before running it
    # what the time law costs on a machine with a structural mode, as `planner.vibration` tells it
    vibration: Mapping[str, Any] | None = None

    @property
    def d_efficiency(self) -> float:
        """D-efficiency against the box bound."""
        return self.bound.efficiency(self.logdet)

    @property
    def d_efficiency_tight(self) -> float | None:
        """D-efficiency against the bound of motions from rest to rest, where that is known."""
        return self.bound_tight.efficiency(self.logdet) if self.bound_tight is not None else None

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        entries = asdict(self)
        search: dict[str, Any] = entries.pop("search")
        efficiencies = {"d_efficiency": self.d_efficiency, "d_efficiency_tight": self.d_efficiency_tight}
        return search | entries | efficiencies

    @classmethod
    def of_json(cls, data: Mapping[str, Any], parameters: int) -> "Worth":
        """From `plan.json`; raises KeyError, TypeError or ValueError where an entry is missing or damaged."""
        bounds = {
            key: None if data[key] is None else Bound.of_json(data[key], parameters) for key in ("bound", "bound_tight")
        }
        return TypeAdapter(cls).validate_python({**data, **bounds, "search": data})


@dataclass(frozen=True, slots=True)
class PoseWorth:
    """What a set of poses is worth."""

    settings: Mapping[str, Any]  # where the candidates come from, and for how long is measured
    remark: str  # how the choice ended
    candidates: int  # number of valid poses to choose from
    travel_s: float  # time of the moves [s]
    travel_in_order_of_choice_s: float  # the same in the order of choice [s]
    criterion_value: float  # criterion of Table 4, to be maximised: mean information, reference scaling
    condition: float  # mu_1 / mu_u, reference scaling
    efficiency: float  # lower bound of the D-efficiency against every design over the candidates; certified
    efficiency_space: float  # D-efficiency against the design over the whole pose space; an estimate
    fewest_poses: int  # poses that Algorithm 1 keeps of these before rank is lost
    predicted_std_of_all_candidates: Mapping[str, float]  # predicted standard deviations from all candidates [SI]
    select_s: float  # time spent on choosing [s]
    solve_s: float  # time spent on everything [s]

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        method = (
            "D; efficiency: lower bound against the approximate design over the candidates; efficiency_space: estimate "
            "against the design over the whole pose space"
        )
        return asdict(self) | {"efficiency_method": method}

    @classmethod
    def of_json(cls, data: Mapping[str, Any]) -> "PoseWorth":
        """From `plan.json`; errors as `Worth.of_json`."""
        return TypeAdapter(cls).validate_python(data)


BINDING = 0.99  # share of a limit from which it shapes the motion


def bound_by(limits: LimitReport) -> list[str]:
    """The limits that shape a motion."""
    return [c.name for c in limits.checks if c.binding and c.ratio > BINDING]
