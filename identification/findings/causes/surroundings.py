"""Hypotheses about what is around the machine: gravity, a compensated wrench, its axes, and the pace of the clock."""

from collections.abc import Iterator

import numpy as np

from cases.base.phrases import Phrase, phrase
from cases.base.units import Array
from cases.schema import Case
from identification.findings.causes.hypothesis import Edit, Family, Hypothesis
from identification.texts import number, with_deviation

DIRECTIONS = tuple(
    (axis, sign, word)
    for axis, (low, high) in enumerate((("-x", "+x"), ("-y", "+y"), ("-z", "+z")))
    for sign, word in ((-1.0, low), (1.0, high))
)


def leaning_of(case: Case, direction: Array) -> float:
    """Angle between a direction, shape (3,), and gravity as the case says it [deg]."""
    size = float(np.linalg.norm(case.gravity) * np.linalg.norm(direction))
    return float(np.degrees(np.arccos(np.clip(case.gravity @ direction / size, -1.0, 1.0))))


def of_gravity(
    case: Case, direction: Array, mistakes: float = 1.0, words: Phrase | None = None, std: float | None = None
) -> Hypothesis:
    """Gravity along another direction of {B}, of the size that the case says.

    Args:
        case: the case.
        direction: shape (3,).
        mistakes: that it counts for.
        words: what is wrong; None: the angle between both directions.
        std: standard deviation of that angle [deg]; None where it is not known.
    """
    size = float(np.linalg.norm(case.gravity))
    vector = np.asarray(direction) / np.linalg.norm(direction) * size
    entries = tuple(float(round(value, 4)) + 0.0 for value in vector)
    if words is None:
        away = number(leaning_of(case, vector), std, 3)
        words = phrase(
            "on_a_slope", "gravity points {away} deg away from gravity_m_s2: the machine stands on a slope", away=away
        )
    return Hypothesis(family=Family.GRAVITY, words=words, edit=_gravity(entries), place="case", mistakes=mistakes)


def _gravity(vector: tuple[float, ...]) -> Edit:
    return lambda case: case.model_copy(update={"gravity_m_s2": vector})


def of_surroundings(case: Case) -> Iterator[Hypothesis]:
    """Gravity along other axes of {B}: on a wall, under a ceiling."""
    for axis, sign, word in DIRECTIONS:
        vector = np.eye(3)[axis] * sign
        if vector @ case.gravity < 0.999 * np.linalg.norm(case.gravity):
            yield of_gravity(
                case, vector, words=phrase("gravity_along", "gravity points along {word} of {{B}}", word=word)
            )


RAW = phrase("record_raw", "record them raw, with every compensation of the tool or payload switched off")


def of_compensation() -> Hypothesis:
    """A wrench without the weight of what the sensor carries."""
    return Hypothesis(
        family=Family.COMPENSATED,
        words=phrase("compensated", "the forces are compensated: they lack the weight of what the sensor carries"),
        edit=_gravity((0.0, 0.0, 0.0)), place="case",
        remedy=RAW,
    )  # fmt: skip


def of_share(case: Case, share: float, mistakes: float, std: float | None = None) -> Hypothesis:
    """A wrench without a share of the weight: compensated for a load of another mass, at the same centre of gravity.

    Args:
        case: the case.
        share: as above.
        mistakes: that it counts for.
        std: standard deviation of the share [%]; None where it is not known.
    """
    gravity = tuple(float(f"{(1.0 - share) * value:.5g}") for value in case.gravity)
    sentence = "the forces are compensated: they lack {share} % of the weight of what the sensor carries"
    return Hypothesis(
        family=Family.COMPENSATED, edit=_gravity(gravity), place="case", mistakes=mistakes,
        words=phrase("compensated_in_part", sentence, share=number(100.0 * share, std, 3)),
        remedy=RAW,
    )  # fmt: skip


def of_axes() -> Hypothesis:
    """A wrench in the axes of the base."""
    return Hypothesis(
        family=Family.AXES, in_base=True,
        words=phrase("in_base", "the wrench is in the axes of the base, not of the sensor"),
        remedy=phrase("record_in_sensor", "record it raw, in the axes of the sensor itself"),
    )  # fmt: skip


def of_pace(step: float, pace: float, std: float | None = None) -> Hypothesis:
    """Seconds of the recording that are longer or shorter than true ones.

    Args:
        step: between two samples, as recorded [s].
        pace: true seconds in a second of the recording.
        std: standard deviation of the true step [ms]; None where it is not known.
    """

    period = float(f"{step * pace * 1e3:.6g}")

    def edit(case: Case) -> Case:
        clock = case.recording.clock.model_copy(update={"period_ms": period})
        return case.model_copy(update={"recording": case.recording.model_copy(update={"clock": clock})})

    apart = f"{period:.4g}" if std is None else with_deviation(1e3 * step * pace, std)
    step_of_file = f"{step * 1e3:.4g}"
    words = phrase("samples_apart", "samples are {apart} ms apart, not {stated} ms", apart=apart, stated=step_of_file)
    return Hypothesis(family=Family.CLOCK, words=words, pace=pace, edit=edit, mistakes=1.8)
