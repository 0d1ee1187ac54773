"""What a plan is worth and how it was found, as it stands in `plan.json`: of a motion, and of a set of poses."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from identification.limit import LimitReport
from planner.bounds.kept import Bound
from planner.search.solving import Failed


class Rival(NamedTuple):
    """What a motion of another family reached in seconds."""

    family: str
    d_efficiency: float


class Tried(NamedTuple):
    """One start of a search."""

    seed: int  # of the start
    refined: bool  # whether all limits were constrained wherever they come close; else it was explored only
    start_logdet: float | None  # log det F where it began; None where F was singular
    logdet: float  # log det F where it ended
    criterion_value: float  # value of the criterion asked for, to be maximised
    solver: str  # the solver's status
    converged: bool  # whether its last stage converged
    iterations: int  # iterations of all stages
    seconds: float  # spent


class Search(NamedTuple):
    """How a motion was found."""

    starts: tuple[Tried, ...]  # those that led somewhere, the best first
    failed: tuple[Failed, ...]  # the others, with the reason
    interrupted: bool  # whether Ctrl-C ended the search early
    seconds: float  # spent on it [s]
    rival: Rival | None  # what another family reached in seconds


@dataclass(frozen=True, slots=True)
class Worth:
    """What a planned motion is worth."""

    settings: Mapping[str, Any]  # settings of the family, as found
    search: Search
    score: float  # the criterion of Table 4, to be maximised, in reference scaling
    logdet: float  # log det of the mean information, reference scaling, W = 1
    condition: float  # mu_1 / mu_u, reference scaling
    bound: Bound
    tight: Bound | None  # what no motion from rest to rest with limited jerk can exceed, where that is known
    noise: tuple[float, ...]  # standard deviation of a sample of each channel behind the predictions [N, or N and N m]
    shaken: bool  # whether noise of the accelerations is part of it
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
        return self.tight.efficiency(self.logdet) if self.tight is not None else None

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        search = self.search
        return {
            "interrupted": search.interrupted,
            "settings": dict(self.settings),
            "solve_s": search.seconds,
            "starts": [start._asdict() for start in search.starts],
            "failed_starts": [{"seed": f.seed, "reason": f.reason} for f in search.failed],
            "criterion_value": self.score,
            "logdet": self.logdet,
            "condition": self.condition,
            "d_efficiency": self.d_efficiency,
            "d_efficiency_tight": self.d_efficiency_tight,
            "bound": self.bound.to_json(),
            "bound_tight": self.tight.to_json() if self.tight is not None else None,
            "weaknesses": list(self.weaknesses),
            "rival": None if search.rival is None else search.rival._asdict(),
            "vibration": self.vibration,
            "notes": list(self.notes),
            "assumed_noise_of_channels": list(self.noise),
            "noise_of_accelerations": self.shaken,
            "weights": self.weights,
        }

    @classmethod
    def of_json(cls, data: Mapping[str, Any], parameters: int) -> "Worth":
        """From `plan.json`; raises KeyError, TypeError or ValueError where an entry is missing or damaged."""
        tight, rival = data["bound_tight"], data["rival"]
        return cls(
            settings=dict(data["settings"]),
            search=Search(
                tuple(Tried(**start) for start in data["starts"]),
                tuple(Failed(**failed) for failed in data["failed_starts"]),
                bool(data["interrupted"]),
                float(data["solve_s"]),
                None if rival is None else Rival(**rival),
            ),
            score=float(data["criterion_value"]),
            logdet=float(data["logdet"]),
            condition=float(data["condition"]),
            bound=Bound.of_json(data["bound"], parameters),
            tight=None if tight is None else Bound.of_json(tight, parameters),
            noise=tuple(float(v) for v in data["assumed_noise_of_channels"]),
            shaken=bool(data["noise_of_accelerations"]),
            weights=str(data["weights"]),
            weaknesses=tuple(str(w) for w in data["weaknesses"]),
            notes=tuple(str(w) for w in data["notes"]),
            vibration=data.get("vibration"),
        )


@dataclass(frozen=True, slots=True)
class PoseWorth:
    """What a set of poses is worth."""

    settings: Mapping[str, Any]  # where the candidates come from, and for how long is measured
    remark: str  # how the choice ended
    candidates: int  # number of valid poses to choose from
    travel: float  # time of the moves [s]
    travel_unordered: float  # the same in the order of choice [s]
    value: float  # value of the criterion of Table 4, to be maximised: mean information, reference scaling
    condition: float  # mu_1 / mu_u, reference scaling
    efficiency: float  # lower bound of the D-efficiency against every design over the candidates; certified
    efficiency_space: float  # D-efficiency against the design over the whole pose space; an estimate
    fewest: int  # poses that Algorithm 1 keeps of these before rank is lost
    std_of_all: Mapping[str, float]  # predicted standard deviations from all candidates [SI]
    select_seconds: float  # time spent on choosing [s]
    solve_seconds: float  # time spent on everything [s]

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json`."""
        return {
            "remark": self.remark,
            "candidates": self.candidates,
            "settings": dict(self.settings),
            "travel_s": self.travel,
            "travel_in_order_of_choice_s": self.travel_unordered,
            "criterion_value": self.value,
            "condition": self.condition,
            "efficiency": self.efficiency,
            "efficiency_space": self.efficiency_space,
            "efficiency_method": "D; efficiency: lower bound against the approximate design over the candidates; "
            "efficiency_space: estimate against the design over the whole pose space",
            "fewest_poses": self.fewest,
            "predicted_std_of_all_candidates": dict(self.std_of_all),
            "select_s": self.select_seconds,
            "solve_s": self.solve_seconds,
        }

    @classmethod
    def of_json(cls, data: Mapping[str, Any]) -> "PoseWorth":
        """From `plan.json`; errors as `Worth.of_json`."""
        return cls(
            settings=dict(data["settings"]),
            remark=str(data["remark"]),
            candidates=int(data["candidates"]),
            travel=float(data["travel_s"]),
            travel_unordered=float(data["travel_in_order_of_choice_s"]),
            value=float(data["criterion_value"]),
            condition=float(data["condition"]),
            efficiency=float(data["efficiency"]),
            efficiency_space=float(data["efficiency_space"]),
            fewest=int(data["fewest_poses"]),
            std_of_all={str(k): float(v) for k, v in data["predicted_std_of_all_candidates"].items()},
            select_seconds=float(data["select_s"]),
            solve_seconds=float(data["solve_s"]),
        )


BINDING = 0.99  # share of a limit from which it shapes the motion


def bound_by(limits: LimitReport) -> list[str]:
    """The limits that shape a motion."""
    return [c.name for c in limits.checks if c.binding and c.ratio > BINDING]
