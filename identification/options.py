"""Options of evaluations, each declared once; nothing heavy is imported, for `hexcite --help` shows them.

Arguments of `hx.identify`, `hx.identify_models` and `hx.force`, fields of `Method` and `Treatment`, and options of
`hexcite identify`, `force`, `payload` and `pool` are made from what stands here. An option whose type is heavy is
declared without it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from cases.base.options import Option

FrameName = Literal["sensor", "flange", "tool", "base"]
FRAMES: tuple[FrameName, ...] = get_args(FrameName)

Frame = Annotated[
    FrameName,
    Option(
        "Frame of force and moment: sensor, about the origin of {P} and along its axes; flange or tool (TCP) of the "
        "robot, about and along its; base, along the axes of {B} at each instant, about the origin of {P}.",
        "sensor",
        read_as=str,
    ),
]
LoadFrame = Annotated[
    str | None,
    Option(
        "State the load in the frame of the sensor, the robot's flange or tool (TCP), or along the axes of the base."
    ),
]
MODEL = Option(
    "Identification model, 0 to 9, or 10 (3 with inertia); by default what the run can carry.",
    written="all: every model (Table 3), and that one is kept which predicts best what is left out.",
)
AverageStandstills = Annotated[
    bool, Option("Average the run's standstills, wherever they are.", False, flag="standstills")
]
POSES = Option(
    "Poses whose standstills the run holds and which are averaged; a run of hexcite knows its own.",
    written="Their plan.",
    in_python="Shape (n, k) [m or rad].",
)
PLAN = Option(
    "The plan of the run: what was different from it is reported.",
    written="By default the one that the run names, or that lies beside the recording.",
    in_python="Or plans of which one may be that of the run.",
)
Weights = Annotated[
    str | None,
    Option(
        "W: equal, per_channel or per_unit (from the residuals), full (from their covariance between channels), "
        "stated (from the noise of forces and accelerations in the case, through the model), huber (per_channel, "
        "and gross errors count less); by default the case's."
    ),
]
Known = Annotated[
    Mapping[str, float],
    Option(
        "Exact values by linear or physical name.",
        {},
        flag="fix",
        written="m=93.1kg, xC=0mm; repeatable.",
        read_as=list[str],
        in_python="In SI.",
    ),
]
Dropped = Annotated[
    tuple[str, ...],
    Option(
        "Linear parameters to leave out, as if they were zero.",
        (),
        flag="drop",
        written="k3; repeatable.",
        read_as=list[str],
    ),
]
PRIORS = Option("Uncertain values.", (), flag="prior", written="m=33+-0.5kg; repeatable.", read_as=list[str])
BESIDE = "Shown beside the default."


@dataclass(frozen=True, slots=True)
class TreatmentOptions:
    """How a moving run is treated."""

    accelerated: Annotated[
        float | None,
        Option(
            "Evaluate samples from this share of the run's largest translational or rotational acceleration on alone: "
            "0.3.",
            written=BESIDE,
        ),
    ] = None
    period: Annotated[
        float | None,
        Option("Replace the motion by a Fourier series (34)-(36) of this period in s.", unit="s", written=BESIDE),
    ] = None
    harmonics: Annotated[int, Option("Harmonics of that series.")] = 7
    cutoff: Annotated[
        float | None,
        Option(
            "Low-pass in Hz in place of the case's; infinite: the widest there is.",
            unit="Hz",
            written=f"Write none for infinite. {BESIDE}",
            read_as=str,
        ),
    ] = None
