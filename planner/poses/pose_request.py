"""Which poses to plan: settings as a user states them, refused before any work where they cannot be met."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar

from cases.errors import HexciteError
from planner.poses.pose_criteria import POSE_CRITERIA

USUAL = 30  # poses of the paper's reduced sets


class PoseMethod(StrEnum):
    """How poses are chosen."""

    BACKWARD = "backward"
    BACKWARD_CHANGE = "backward-change"
    REFINE = "refine"
    ALL = "all"
    GIVEN = "given"


METHODS = {
    PoseMethod.BACKWARD: "Algorithm 1: removes the pose without which the criterion is best",
    PoseMethod.BACKWARD_CHANGE: "Algorithm 1 in its other reading: removes the pose that changes the criterion least",
    PoseMethod.REFINE: "Algorithm 1, then moves the poses freely in the workspace",
    PoseMethod.ALL: "every candidate",
    PoseMethod.GIVEN: "poses of one's own",
}


@dataclass(frozen=True, slots=True)
class PoseRequest:
    """What to plan."""

    criterion: str = "D"  # letter of Table 4
    count: int | None = None  # poses; None: 30
    method: str = PoseMethod.REFINE  # one of METHODS
    model: int = 5  # number in Table 2, 0 to 5
    candidates: int | None = None  # quasi-random candidates; None: the grid of the case
    seed: int = 0  # of these
    # standard deviation of an averaged force [N]; None: the sensors' noise, averaged as white noise
    noise: float | None = None

    name: ClassVar[str] = "poses"
    """In place of a family."""

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json` that say what was asked for, beside criterion and model."""
        entries = {"count": self.count, "candidates": self.candidates, "noise": self.noise}
        return {"method": str(self.method), "seed": self.seed, "asked": entries}

    @classmethod
    def of_json(cls, data: Mapping[str, Any]) -> "PoseRequest":
        """From `plan.json`; raises KeyError, TypeError, ValueError or HexciteError where an entry is damaged."""
        seed = data["seed"] if "seed" in data else data["settings"]["seed"]
        return cls(
            str(data["criterion"]), method=str(data["method"]), model=int(data["model"]), seed=int(seed),
            **data.get("asked", {}),
        )  # fmt: skip

    def __post_init__(self) -> None:
        if self.criterion not in POSE_CRITERIA:
            raise HexciteError(f"criterion {self.criterion!r} is unknown; choose {', '.join(POSE_CRITERIA)}")
        if self.method not in set(PoseMethod):
            raise HexciteError(f"method {self.method!r} is unknown; choose {', '.join(PoseMethod)}")
        if self.method in (PoseMethod.ALL, PoseMethod.GIVEN) and self.count is not None:
            raise HexciteError(f"method {self.method} measures every pose; leave --count out, or choose another method")
        if self.noise is not None and not 0.0 < self.noise < float("inf"):
            raise HexciteError(f"noise {self.noise:g} N is not positive; give the scatter of an averaged force")
        if self.seed < 0:
            raise HexciteError(f"seed {self.seed} is negative; choose 0 or more")

    def wanted(self, available: int, parameters: int) -> int:
        """Poses to choose from `available` ones for a model with `parameters`.

        Raises:
            HexciteError: more than there are, or fewer than can determine the model.
        """
        if self.method in (PoseMethod.ALL, PoseMethod.GIVEN):
            return available
        fewest = -(-parameters // 6)
        count = self.count if self.count is not None else min(USUAL, available)
        if count < fewest:
            raise HexciteError(
                f"{count} poses give {6 * max(count, 0)} forces for {parameters} parameters of model {self.model}; ask "
                f"for {fewest} or more, about {USUAL} for useful standard deviations"
            )
        if count > available:
            raise HexciteError(
                f"{count} poses are asked for, only {available} candidates are valid; ask for fewer, take smaller "
                "steps in [poses], or sample more with --candidates"
            )
        return count
