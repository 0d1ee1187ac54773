"""Requests: settings of a plan as a user states them, refused before any work where they cannot be met."""

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from enum import StrEnum
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, NoReturn

from cases.base.errors import Code, HexciteError, choice, option
from cases.base.options import default_of
from cases.base.phrases import Phrase, phrase
from cases.sensors import payload_words
from identification.estimation.criteria import Criterion
from identification.texts import legible
from planner.families.settings import (
    FAMILIES,
    FamilySettings,
    PointToPoint,
    family_class,
    require_plannable_without,
)
from planner.known import Known
from planner.options import (
    DURATION,
    Candidates,
    Count,
    Payload,
    PayloadFrom,
    PoseMethodName,
    SampleSeed,
    Seconds,
    Seed,
    SolverName,
    Starts,
    Without,
    Workers,
)
from planner.options import Criterion as CriterionName

OWNERS = {setting.name: name for name, kind in FAMILIES.items() for setting in fields(kind)}
"""Settings of one family alone, and its name."""
LONGEST = 600.0  # [s] longest excitation; the method is for production breaks
LONGEST_SEARCH = 1e5  # [s]


def require_seed(seed: int) -> None:
    """Raises HexciteError where a seed is negative."""
    if seed < 0:
        raise HexciteError(problem=f"seed {seed} is negative", remedy="choose 0 or more", code=Code.OUT_OF_RANGE)


def require_starts(starts: int | None) -> None:
    """Raises HexciteError where a number of starts cannot be."""
    if starts is not None and not 1 <= starts <= 1000:
        raise HexciteError(
            problem=f"{starts} starts", remedy=f"choose {option('starts')} 1 to 1000", code=Code.OUT_OF_RANGE
        )


def require_workers(workers: int | None) -> None:
    """Raises HexciteError where a number of processes cannot be."""
    if workers is not None and not 1 <= workers <= 1000:
        raise HexciteError(
            problem=f"{workers} workers",
            remedy=f"choose {option('workers')} 1 to 1000, by default one a core",
            code=Code.OUT_OF_RANGE,
        )


class Solver(StrEnum):
    """What solves the non-linear program of a start; see `planner.search.solvers`."""

    IPOPT = "ipopt"
    SQP = "sqp"
    ACTIVE_SET = "active-set"

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        """Refuses what is not one of them."""
        raise HexciteError(problem=f"solver {value!r} is unknown", remedy=choice(str(value), cls), code=Code.UNKNOWN)


@dataclass(frozen=True, slots=True)
class Request:
    """What to plan: options as `planner.options` declares them, with nothing left open but what the search decides."""

    family: FamilySettings = field(default_factory=PointToPoint)  # family of motions, with its settings
    duration: float = DURATION  # duration of the excitation [s]
    criterion: Criterion = default_of(CriterionName)  # its letter will do
    model: int = 9  # number in Table 2
    payload: Payload = default_of(Payload)
    payload_from: PayloadFrom = default_of(PayloadFrom)
    starts: Starts = default_of(Starts)
    seed: Seed = default_of(Seed)
    solver: Solver | None = default_of(SolverName)  # its name will do
    workers: Workers = field(default=default_of(Workers), compare=False)
    seconds: Seconds = default_of(Seconds)
    # predicted standard deviations to reach, by physical parameter [SI]: where there are any, the shortest motion that
    # reaches them is planned, and `duration` is the longest that it may have until it is
    target: Mapping[str, float] = field(default_factory=dict, hash=False)
    known: Known | None = field(default=None, compare=False)  # what earlier results say

    def __post_init__(self) -> None:
        object.__setattr__(self, "criterion", Criterion(self.criterion))
        object.__setattr__(self, "solver", None if self.solver is None else Solver(self.solver))
        if not abs(self.duration) <= LONGEST:
            raise HexciteError(
                problem=phrase(
                    "duration_too_long",
                    "duration {duration} s is not at most {longest} s",
                    duration=f"{self.duration:g}",
                    longest=f"{LONGEST:g}",
                ),
                remedy=phrase("choose_12", "choose about 12 s"),
                code=Code.OUT_OF_RANGE,
            )
        self.family.check(self.duration)
        require_starts(self.starts)
        require_seed(self.seed)
        require_workers(self.workers)
        if self.seconds is not None and not 0.0 < self.seconds <= LONGEST_SEARCH:
            raise HexciteError(
                problem=phrase(
                    "no_search_time", "{seconds} s is not a time to search for", seconds=f"{self.seconds:g}"
                ),
                remedy=phrase(
                    "choose_up_to",
                    "choose {seconds} up to {longest}",
                    seconds=option("seconds"),
                    longest=f"{LONGEST_SEARCH:g}",
                ),
                code=Code.OUT_OF_RANGE,
            )
        if self.seconds is not None and self.starts is not None:
            raise HexciteError(
                problem=f"{option('starts')} and {option('seconds')} both say when a search ends",
                remedy="leave out one of them",
                code=Code.CONTRADICTION,
            )
        if self.payload_from is not None and not 0 <= self.payload_from <= self.payload:
            raise HexciteError(
                problem=f"payloads {self.payload_from}-{self.payload} are not a range",
                remedy=f"give the fewest first, as 0-{self.payload}",
                code=Code.OUT_OF_RANGE,
            )
        if self.known is not None:
            self.known.require_model(self.model)
            if len(self.payloads) > 1:
                raise HexciteError(
                    problem=f"what is known is of one load, {self.mounted} are planned for",
                    remedy=f"give one {option('payload')}",
                    code=Code.CONTRADICTION,
                )

    @property
    def payloads(self) -> range:
        """Numbers of payloads that may be mounted."""
        return range(self.payload if self.payload_from is None else self.payload_from, self.payload + 1)

    @property
    def mounted(self) -> Phrase:
        """The mounted payloads in words."""
        most = payload_words(self.payload)
        least = self.payloads[0]
        return most if least == self.payload else phrase("to_payloads", "{least} to {most}", least=least, most=most)

    @property
    def name(self) -> str:
        """Name of the family."""
        return self.family.name

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json` that say what was asked for, beside criterion and model."""
        entries: dict[str, Any] = {
            "duration_s": self.duration,
            "starts": self.starts,
            "seconds": self.seconds,
            "solver": self.solver,
        }
        entries |= {"target": dict(self.target)} if self.target else {}
        settings = {name: str(v) if isinstance(v, Path) else v for name, v in asdict(self.family).items()}
        return {"seed": self.seed, "asked": entries | {"family": settings}}

    @classmethod
    def of_json(cls, data: Mapping[str, Any]) -> "Request":
        """From `plan.json`; raises KeyError, TypeError, ValueError or HexciteError where an entry is damaged."""
        asked, fewest, kind = data["asked"], data["payload_from"], family_class(str(data["family"]))
        settings = {setting.name for setting in fields(kind)}  # other versions may have more
        return cls(
            kind(**{name: value for name, value in asked["family"].items() if name in settings}),
            float(asked["duration_s"]),
            Criterion(data["criterion"]),
            int(data["model"]),
            int(data["payload"]),
            None if fewest == data["payload"] else int(fewest),
            asked["starts"],
            int(data["seed"]),
            None if (solver := asked.get("solver")) is None else Solver(solver),  # older plans have none, nor the next
            seconds=asked.get("seconds"),
            target={str(name): float(value) for name, value in asked.get("target", {}).items()},
        )


_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_VALUE = re.compile(
    rf"(?P<name>\w+)=(?P<value>{_NUMBER})(?:(?:\+-|±)(?P<std>{_NUMBER}))?\s*(?P<unit>[^\W\d_][\w/^ ]*)?"
)


class TypedValue(NamedTuple):
    """A value such as m=0.05kg or m=33+-0.5kg."""

    name: str  # name of the parameter
    value: float  # [SI]
    std: float | None  # standard deviation [SI]; None where none is given


def read_value(text: str, units: Mapping[str, str], option: str, example: str, model: int) -> TypedValue:
    """The value that a text states.

    Args:
        units: SI unit of each parameter that may be named.
        option: option that it was given with, for messages.
        model: number of the model that has these parameters, for messages.

    Raises:
        HexciteError: not understood, an unknown name, a missing or unknown unit.
    """
    match = _VALUE.fullmatch(text.strip())
    if match is None:
        raise HexciteError(
            place=f"{option} {text}",
            problem=phrase("target_not_understood", "is not understood"),
            remedy=phrase("write_so", "write {option} {example}", option=option, example=example),
            code=Code.WRONG_KIND,
        )
    name, unit = match["name"], (match["unit"] or "").replace("^", "").replace(" ", "")
    if name not in units:
        raise HexciteError(
            place=f"{option} {text}",
            problem=phrase("not_a_parameter", "{name} is not a parameter of model {model}", name=name, model=model),
            remedy=choice(name, units, "choose from"),
            code=Code.UNKNOWN,
        )
    factor, for_people = legible(units[name])
    scales = {
        re.sub(r"[ ^]", "", unit_name): scale for unit_name, scale in ((units[name], 1.0), (for_people, 1.0 / factor))
    }
    scales |= {"g": 1e-3} if units[name] == "kg" else {}
    if unit not in scales:
        problem = f"unit {match['unit']} does not fit {name}" if unit else "has no unit"
        raise HexciteError(
            place=f"{option} {text}", problem=problem, remedy=f"give {' or '.join(scales)}", code=Code.WRONG_KIND
        )
    std = None if match["std"] is None else float(match["std"]) * scales[unit]
    return TypedValue(name, float(match["value"]) * scales[unit], std)


USUAL = 30  # poses of the paper's reduced sets


PoseMethod = Literal["backward", "backward-change", "refine", "all", "given"]
METHODS: dict[PoseMethod, str] = {
    "backward": "Algorithm 1: removes the pose without which the criterion is best",
    "backward-change": "Algorithm 1 in its other reading: removes the pose that changes the criterion least",
    "refine": "Algorithm 1, then moves the poses freely in the workspace",
    "all": "every candidate",
    "given": "poses of one's own",
}


@dataclass(frozen=True, slots=True)
class PoseRequest:
    """Which poses to plan: options as `planner.options` declares them."""

    criterion: Criterion = default_of(CriterionName)  # its letter will do
    count: Count = default_of(Count)
    method: PoseMethod = default_of(PoseMethodName)
    model: int = 5  # number in Table 2, 0 to 5
    candidates: Candidates = default_of(Candidates)
    seed: SampleSeed = default_of(SampleSeed)
    without: Without = default_of(Without)  # of the moves between poses
    known: Known | None = field(default=None, compare=False)  # what earlier results say
    name: ClassVar[str] = "poses"  # in place of that of a family

    def to_json(self) -> dict[str, Any]:
        """Entries of `plan.json` that say what was asked for, beside criterion and model."""
        entries = {"count": self.count, "candidates": self.candidates, "without": self.without}
        return {"method": self.method, "seed": self.seed, "asked": entries}

    @classmethod
    def of_json(cls, data: Mapping[str, Any]) -> "PoseRequest":
        """From `plan.json`; raises KeyError, TypeError, ValueError or HexciteError where an entry is damaged."""
        asked, model, seed = data["asked"], int(data["model"]), int(data["seed"])
        criterion, without = Criterion(data["criterion"]), asked.get("without")  # which older plans do not have
        return cls(criterion, asked["count"], data["method"], model, asked["candidates"], seed, without)

    def __post_init__(self) -> None:
        object.__setattr__(self, "criterion", Criterion(self.criterion))
        if self.method not in METHODS:
            choice = ", ".join(method for method in METHODS if method != "given")  # which comes with the poses
            raise HexciteError(
                problem=f"method {self.method!r} is unknown", remedy=f"choose {choice}", code=Code.UNKNOWN
            )
        if self.method in ("all", "given") and self.count is not None:
            raise HexciteError(
                problem=f"method {self.method} measures every pose",
                remedy=f"leave {option('count')} out, or choose another method",
                code=Code.CONTRADICTION,
            )
        require_plannable_without(self.without)
        require_seed(self.seed)
        if self.known is not None:
            self.known.require_model(self.model)

    def wanted(self, available: int, parameters: int) -> int:
        """Number of poses to choose from `available` ones for a model with `parameters`.

        Raises:
            HexciteError: more than there are, or fewer than can determine the model.
        """
        if self.method in ("all", "given"):
            return available
        fewest = -(-parameters // 6)
        count = self.count if self.count is not None else min(USUAL, available)
        if count < fewest:
            raise HexciteError(
                problem=phrase(
                    "poses_too_few",
                    "{count} poses give {forces} forces for {parameters} parameters of model {model}",
                    count=count,
                    forces=6 * max(count, 0),
                    parameters=parameters,
                    model=self.model,
                ),
                remedy=phrase(
                    "ask_for",
                    "ask for {fewest} or more, about {usual} for useful standard deviations",
                    fewest=fewest,
                    usual=USUAL,
                ),
                code=Code.TOO_FEW,
            )
        if count > available:
            raise HexciteError(
                problem=phrase(
                    "few_candidates",
                    "{count} poses are asked for, only {available} candidates are valid",
                    count=count,
                    available=available,
                ),
                remedy=phrase(
                    "fewer_or_more",
                    "ask for fewer, take smaller steps in [poses], or sample more with {candidates}",
                    candidates=option("candidates"),
                ),
                code=Code.OUT_OF_RANGE,
            )
        return count
