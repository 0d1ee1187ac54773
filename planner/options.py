"""Options of plans, each declared once: name, type, default, unit and meaning.

Arguments of `hx.plan`, `hx.plan_poses`, `hx.bound` and `hx.retime`, requests, settings of families, options of the
commands and the grid of a study are made from what stands here. What is refused stands in `planner.request` and
`planner.families.settings`. Nothing heavy is imported, for `hexcite --help` shows these texts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, TypedDict

from cases.base.errors import option
from cases.base.options import Option
from cases.base.phrases import Phrase, phrase

DURATION = 12.0  # [s] unless another is asked for
LONGEST_WANTED = 60.0  # [s] longest motion that is tried for a target unless another is asked for


Duration = Annotated[
    float | None,
    Option(
        f"Whole duration in s, by default {DURATION:g}; a multiple of {option('period')} where that is given. With "
        f"{option('target')} the longest that is tried, by default {LONGEST_WANTED:g}.",
        unit="s",
    ),
]
Criterion = Annotated[
    str,
    Option(
        "What to optimise, Table 4: A average variance, D volume of the confidence ellipsoid, K condition, N "
        "noise amplification.",
        "D",
    ),
]
Workers = Annotated[int | None, Option("Processes on this computer; by default one a core.")]
Model = Annotated[int | None, Option("Identification model, 0 to 9; by default the largest of the machine.")]
Payload = Annotated[
    int,
    Option(
        "How many of the case's payloads are mounted.",
        0,
        written="A number, or a range such as 0-5.",
        read_as=str,
    ),
]
PayloadFrom = Annotated[
    int | None,
    Option("Fewest payloads of a range: the largest deviation of the range counts; by default just as many."),
]
Starts = Annotated[
    int | None, Option("Number of random starts, of that many choices at most; by default as many as pay.")
]
Seconds = Annotated[
    float | None,
    Option("How long to search in s, then to keep the best; by default as long as it pays.", unit="s"),
]
Seed = Annotated[int, Option("Seed of the random starts.", 0)]
SolverName = Annotated[
    str | None,
    Option(
        "What optimises a start: ipopt (interior point), sqp, or active-set (quasi-Newton); by default active-set "
        "where few unknowns are explored (fourier), ipopt else."
    ),
]
Count = Annotated[int | None, Option("Poses; by default 30.")]
PoseMethodName = Annotated[str, Option("backward (Algorithm 1), backward-change, refine, or all.", "refine")]
Candidates = Annotated[int | None, Option("Quasi-random candidates; by default the grid of the case, of a chain 2048.")]
SampleSeed = Annotated[int, Option("Seed of the sample.", 0)]
TimeLimit = Annotated[
    float,  # of processor time, so that answers do not depend on what else a computer does; usual: 1 to 20 s
    Option("Stop after this many seconds of computing; the answer is an estimate then.", 120.0, unit="s"),
]
Pace = Annotated[
    str,
    Option(
        "ruckig: moves as a controller times them, other paths slower inside every limit; toppra: as fast as all "
        "limits but jerk allow.",
        "ruckig",
        flag="with",
    ),
]
PaceWithout = Annotated[
    str | None,
    Option(
        "jerk, where the machine bears steps of acceleration: toppra, which cannot limit it, wants it where the case "
        "does."
    ),
]
Without = Annotated[
    str | None,
    Option(
        "jerk, which linuxcnc and urscript do not limit: moves with steps of acceleration, if the machine bears them."
    ),
]


class PlanOptions(TypedDict, total=False):
    """What may be asked of a motion, beside its family and its duration."""

    criterion: Criterion
    target: Annotated[
        Mapping[str, float],  # [SI]
        Option(
            "Standard deviations to reach, by parameter: plans the shortest motion whose predicted deviations reach "
            "all.",
            {},
            written="Written m=5g, xC=0.02mm; repeatable.",
            read_as=list[str],
        ),
    ]
    known: Annotated[
        Sequence[object],  # of `Result`
        Option(
            f"Earlier results of the machine with the same load: deviations and {option('target')} then hold for them "
            "and the run together.",
            (),
            written="Result folder; repeatable.",
            read_as=list[Path],
        ),
    ]
    model: Model
    payload: Payload
    payload_from: PayloadFrom
    starts: Starts
    seconds: Seconds
    seed: Seed
    solver: SolverName
    workers: Workers


class PoseOptions(TypedDict, total=False):
    """What may be asked of poses."""

    criterion: Criterion
    count: Count
    method: PoseMethodName
    model: Annotated[int | None, Option("Identification model, 0 to 5; by default the largest of the machine.")]
    candidates: Candidates
    seed: SampleSeed
    known: Annotated[
        Sequence[object],  # of `Result`
        Option(
            "Results of earlier standstills of the machine: deviations then hold for all of them.",
            (),
            written="Result folder; repeatable.",
            read_as=list[Path],
        ),
    ]
    without: Without


@dataclass(frozen=True, slots=True)
class FourierOptions:
    """Settings of a Fourier series."""

    name: ClassVar[str] = "fourier"
    words: ClassVar[str] = "Fourier series"

    order: Annotated[int, Option("harmonics, 1 to 7; 1 is ellipses, with half a period for each way in and out.")] = 5
    period: Annotated[
        float | None,
        Option(f"period in s; by default about 2, to fit {option('duration')}, a whole number of them.", unit="s"),
    ] = None
    free_order: Annotated[bool, Option("search the best order, 2 to 7.")] = False
    free_period: Annotated[
        bool, Option(f"optimise the period too; as many whole ones as fit into {option('duration')}.")
    ] = False
    centred: Annotated[bool, Option("keep x0 in the middle of the motion box, as in the paper.")] = False
    equal_start: Annotated[bool, Option("begin with all coefficients alike, to study solvers, as in the paper.")] = (
        False
    )


@dataclass(frozen=True, slots=True)
class MoveOptions:
    """Settings of point-to-point moves."""

    name: ClassVar[str] = "ptp"
    words: ClassVar[str] = "moves"

    moves: Annotated[
        int | None, Option("point-to-point moves, 8 to 64; by default the best of a few numbers, by trying.")
    ] = None
    controller: Annotated[
        str | None,
        Option(
            "plan with the time law of linuxcnc, virtual, sinumerik, twincat, setpoints, urscript or ros2; "
            "by default as the case says, else with limited jerk.",
            flag="for",
        ),
    ] = None
    without: Without = None


@dataclass(frozen=True, slots=True)
class SplineOptions:
    """Settings of a spline."""

    name: ClassVar[str] = "spline"
    words: ClassVar[str] = "spline"

    knots: Annotated[int | None, Option("intervals, 20 to 150; by default ten a second, 150 at most.")] = None


@dataclass(frozen=True, slots=True)
class ManualOptions:
    """Settings of a hand-made motion."""

    name: ClassVar[str] = "manual"
    words: ClassVar[str] = "manual motion"

    sequence: Annotated[
        Path | str | None,
        Option(
            "TOML file of steps or CSV of poses; by default the case's manual.toml, else each coordinate in turn, then "
            "all at once.",
            read_as=Path,
        ),
    ] = None


OF_FAMILIES: Mapping[str, type[FourierOptions | MoveOptions | SplineOptions | ManualOptions]] = {
    kind.name: kind for kind in (FourierOptions, MoveOptions, SplineOptions, ManualOptions)
}
"""Declarations of the settings that one family alone has, by its name."""
FAMILY_WORDS = {name: kind.words for name, kind in OF_FAMILIES.items()} | {"poses": "poses"}
"""What families are called in texts for people, by their names in files and on the command line."""
FAMILY = "family"
"""Code of a family in words."""


def family_phrase(name: str) -> Phrase:
    """A family in words, whose value is its name."""
    return phrase(FAMILY, FAMILY_WORDS[name], name=name)
