"""Options of an evaluation; nothing heavy is imported, for `hexcite --help` shows them."""

from dataclasses import dataclass
from typing import Annotated

from cases.base.options import Option

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
