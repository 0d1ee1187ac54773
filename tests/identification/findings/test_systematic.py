"""What residuals follow is named with its size, and deviations hold the truth, on plants that share no code with it."""

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from cases.base.errors import HexciteError
from identification.finding import Kind
from identification.identify import estimate_parameters
from identification.results.estimate import Estimate
from tests.damaged.kinds import DAMAGES, Damage, damages_of
from tests.damaged.runs import SOUND, STATED, Change, Machine, Moves, Noise, Waves, machine, recorded
from tests.helpers import few, one_line, tells

OF = {damage.name: damage for damage in DAMAGES}


def found(
    of: Machine, change: Change = SOUND, seed: int = 1, noise: Noise = STATED, model: int | None = None
) -> Estimate:
    way = (Moves if seed % 2 else Waves)(of, seed, 6.0)
    estimate = estimate_parameters(recorded(of, way, seed, noise, change), of.case, model)
    for finding in estimate.findings:
        if finding.sentence:
            one_line(ValueError(finding.sentence))
    return estimate


def worst(estimate: Estimate, truth: dict[str, float]) -> float:
    """Largest error in reported deviations."""
    return max(abs(p.value - truth[k]) / p.reported for k, p in estimate.physical.items() if k in truth)


def number(sentences: Sequence[str], before: str, behind: str) -> float:
    """A number between words of one of the sentences, whose deviation stands behind it."""
    pattern = re.compile(re.escape(before) + r".*?(-?[\d.]+) ± [\d.]+ " + re.escape(behind))
    (said,) = (match for match in map(pattern.search, sentences) if match)
    return float(said.group(1))


NAMED = [
    ("hexapod", "gain of channel 1", 2.0, "gain of f1_N", "% too high", 2.0),
    ("hexapod", "gravity leans", 1.0, "gravity that leans by", "deg", 1.0),
    ("ur10_wrist", "zero of the last joint but one", 0.4, "zero of joint wrist_2", "deg", -0.4),
    ("five_axis_table", "sensor off along x", 5.0, "sensor frame that is", "mm further along its x", 5.0),
    ("ur10_wrist", "gain of channel 5", 2.0, "gain of my_Nm", "% too high", 2.0),
    ("ur10_wrist", "clock scale", 1e4, "time stamps that are", "% too far apart", 1.0),
    ("hexapod", "bars' lower angle", 3.0, "half-angle of the bars' lower ring", "deg larger", 3.0),
    ("five_axis_table", "clocks that drift apart", 1e3, "drift apart by", "ms over the run", 5.3),
]


@pytest.mark.first(1)
@pytest.mark.parametrize(("name", "damage", "size", "before", "behind", "value"), few(*NAMED, kept=3))
def test_what_residuals_follow_is_named_with_its_size_and_deviations_hold_the_truth(
    name: str, damage: str, size: float, before: str, behind: str, value: float
) -> None:
    of = machine(name)
    change = OF[damage].change(of, size)
    estimate = found(of, change)
    assert number(estimate.warnings, before, behind) == pytest.approx(value, rel=0.2)
    assert worst(estimate, change.truth or of.truth) < 4.5


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("name", "damage", "size", "words"),
    few(
        ("ur10_wrist", "hose spring", 5.0, "position along"),
        ("ur10_wrist", "constant pull in {B}, along x", 5.0, "constant force along x of the base"),
        ("hexapod", "friction of a cable along x", 5.0, "speed along x"),
        ("ur10_wrist", "payload lost half way", 5.0, "a load that changes at once"),
        ("five_axis_table", "channel 2 late", 5.0, "fy_N follow its own rate"),
        kept=2,
    ),
)
def test_what_has_no_single_size_is_named_by_what_it_follows(name: str, damage: str, size: float, words: str) -> None:
    of = machine(name)
    estimate = found(of, OF[damage].change(of, size))
    assert any(words in warning for warning in estimate.warnings), estimate.warnings
    assert worst(estimate, of.truth) < 4.5


@pytest.mark.slow
def test_a_mode_far_above_the_motion_is_estimated_as_the_response_that_it_is() -> None:
    """Below its frequency it sharpens forces: a part of their second derivative, which a run tells."""
    of = machine("ur10_wrist")
    estimate = found(of, OF["mode of the frame, damping 0.05"].change(of, 40.0))
    assert any(tells(finding.sentence, "sharpened", "ms^2", "compensated") for finding in estimate.findings)
    assert worst(estimate, of.truth) < 4.5


def said(of: Machine, damage: Damage, size: float) -> float:
    """How far a recording is from sound, as it is said: 0 for nothing, infinity where it is refused.

    Noise beyond what is stated is said by a note where +- counts it, for noise with memory looks the same.
    """
    try:
        estimate = found(of, damage.change(of, size))
    except HexciteError:
        return np.inf
    told = estimate.warnings or any("noise_excess" in finding.quantity for finding in estimate.findings)
    return estimate.physical["m"].reported if told else 0.0


KINDS = [(name, damage.name) for name in ("hexapod", "ur10_wrist") for damage in damages_of(machine(name))]
FIRST = [("hexapod", "bars' lower angle"), ("ur10_wrist", "hose spring"), ("hexapod", "gain of channel 3")]


@pytest.mark.repeats
@pytest.mark.parametrize(("name", "damage"), few(*FIRST, *(kind for kind in KINDS if kind not in FIRST)))
def test_worse_damage_never_says_less(name: str, damage: str) -> None:
    of = machine(name)
    each = [said(of, OF[damage], size) for size in OF[damage].sizes]
    assert all(after > 0.0 or before == 0.0 for before, after in pairwise(each)), each
    assert each[-1] > 0.0 or (name, damage) not in FIRST


SOUNDS = {
    "white": Noise(),
    "remembers 50 ms": Noise(0.5, 0.05, 0.8),
    "remembers 0.3 s": Noise(0.7, 0.3, 0.6),
    "hum": Noise(1.0, hum=2.0),
    "in steps": Noise(1.0, step=1.0),
}


@pytest.mark.first(1)
@pytest.mark.parametrize("noise", few(*SOUNDS, kept=2))
@pytest.mark.parametrize("name", ["hexapod", "ur10_wrist", "five_axis_table"])
def test_a_sound_run_is_not_accused(name: str, noise: str) -> None:
    of = machine(name)
    estimate = found(of, seed=2, noise=SOUNDS[noise])
    assert estimate.warnings == ()
    assert worst(estimate, of.truth) < 4.5


@pytest.mark.slow
def test_a_model_that_is_too_small_is_named_with_what_it_lacks() -> None:
    estimate = found(machine("hexapod"), model=6)
    assert any(tells(w, "model 9 has beside model 6", "k0, k1, k2, k3", "choose model 9") for w in estimate.warnings)


def test_noise_of_drives_is_told_with_the_bias_that_it_makes_and_the_remedy() -> None:
    of = machine("hexapod")
    damage = OF["noise of the drives"]
    estimate = found(of, damage.change(of, 50.0))
    (finding,) = (f for f in estimate.findings if "drive_noise" in f.quantity)
    assert tells(finding.sentence, "noise of the struts", "um", "biases", "Lower recording.filter_cutoff_Hz = 40")
    mass = estimate.physical["m"]
    bias = finding.quantity["drive_noise"]["bias"][0]
    assert mass.value - of.truth["m"] == pytest.approx(bias, rel=0.4)
    assert worst(estimate, of.truth) < 4.5


@pytest.mark.repeats
def test_noise_of_drives_never_pulls_a_parameter_by_more_than_all_of_it() -> None:
    """A small slow machine whose run hardly shows the inertia: noise of 0.03 um is about all there is to see of it."""
    of = machine("hexapod_32000")
    estimate = estimate_parameters(recorded(of, Moves(of, 52077, 4.0, 0.8), 52077, STATED), of.case)
    assert estimate.warnings == ()
    for name in ("IC11", "IC13", "IC23", "IC33"):
        inertia = estimate.physical[name]
        assert abs(inertia.value - of.truth[name]) < 3.0 * inertia.reported
        assert inertia.reported < 1.5 * inertia.std


def test_time_stamps_that_no_clock_makes_are_told_with_what_to_state() -> None:
    of = machine("hexapod")
    estimate = found(of, OF["clock scale"].change(of, 1000.0))
    (warning,) = (f.sentence for f in estimate.findings if "odd_clock" in f.quantity)
    assert tells(warning, "2.002 ms", "+0.1 %", "2 ms", "recording.clock.period_ms = 2")
    assert worst(estimate, of.truth) < 4.5
    assert not any("odd_clock" in f.quantity for f in found(of, OF["clock scale"].change(of, 100.0)).findings)


@pytest.mark.slow
def test_a_sensor_that_warms_up_is_told_with_the_change() -> None:
    of = machine("ur10_wrist")
    estimate = found(of, OF["warm-up of all channels"].change(of, 5.0))
    (finding,) = (f for f in estimate.findings if f.kind is Kind.OFFSETS)
    assert tells(finding.sentence, "drifts by", "as of a sensor that warms up", "hexcite tare")
    assert worst(estimate, of.truth) < 4.5
