"""What a run could not have shown is told with the size that it could have, and the bias that it would make."""

import numpy as np
import pytest

from cases.tolerances import Tolerances
from identification.findings.systematic import SHOWN
from identification.identify import estimate_parameters
from identification.results.estimate import Estimate
from tests.damaged.kinds import DAMAGES
from tests.damaged.runs import SOUND, STATED, Change, Machine, Waves, machine, recorded
from tests.helpers import few, tells

OF = {damage.name: damage for damage in DAMAGES}
PREDICTED = [
    ("ur10_wrist", "gain of channel 3", 0.5, "a gain of fz_N", 5e-3),
    ("ur10_wrist", "sensor off along z", 1.0, "further along its z", 1e-3),
    ("hexapod", "stroke of all struts", 0.05, "a scale of all struts", 5e-4),
    ("hexapod", "clock scale", 100.0, "time stamps", 1e-4),
    ("ur10_wrist", "gain of channel 1", 0.5, "a gain of fx_N", 5e-3),
]


def found(of: Machine, change: Change = SOUND) -> Estimate:
    return estimate_parameters(recorded(of, Waves(of, 2, 5.0), 1, STATED, change), of.case)


def test_a_clock_whose_tolerance_is_stated_is_counted_and_not_unseen() -> None:
    """With the tolerance of stamps stated, deviations hold what the run leaves open of them."""
    of = machine("hexapod")
    sound = found(of)
    entry = next(e for f in sound.findings for e in f.quantity.get("not_shown", ()) if e["key"] == "clock")
    tolerant = of.case.model_copy(update={"tolerances": Tolerances(clock_ppm=1e6 * entry["size"])})
    allowed = estimate_parameters(recorded(of, Waves(of, 2, 5.0), 1, STATED), tolerant)
    k = allowed.model.names.index(entry["parameter"])
    before, after = (np.sqrt(each.fit.covariance_robust[k, k]) for each in (sound, allowed))
    assert before < 0.1 * abs(entry["bias"]) / SHOWN
    assert after > 0.5 * abs(entry["bias"]) / SHOWN


@pytest.mark.first(1)
@pytest.mark.parametrize(("name", "damage", "size", "words", "in_si"), few(*PREDICTED, kept=2))
def test_what_is_not_shown_biases_the_parameter_by_as_much_as_is_told(
    name: str, damage: str, size: float, words: str, in_si: float
) -> None:
    of = machine(name)
    sound, damaged = found(of), found(of, OF[damage].change(of, size))
    (entries,) = (f.quantity["not_shown"] for f in sound.findings if "not_shown" in f.quantity)
    assert [e["deviations"] for e in entries] == sorted((e["deviations"] for e in entries), reverse=True)
    assert entries[-1]["deviations"] > 1.0
    (entry,) = (e for e in entries if words in e["as_with"])
    assert in_si < entry["size"]
    (told,) = (f.sentence for f in sound.findings if "not_shown" in f.quantity)
    assert tells(
        told, entries[0]["as_with"], f"({entries[0]['parameter']})", f"{entries[0]['deviations']:.3g} deviations"
    )
    assert damaged.warnings == sound.warnings == ()
    k = sound.model.names.index(entry["parameter"])
    bias = damaged.fit.values[k] - sound.fit.values[k]
    assert bias == pytest.approx(entry["bias"] * in_si / entry["size"], rel=0.05)


def test_what_noise_alone_may_be_widens_deviations_with_a_word() -> None:
    of = machine("hexapod")
    estimate = found(of, OF["clock scale"].change(of, 27_000.0))
    (told,) = (finding for finding in estimate.findings if "suspected" in finding.quantity)
    entry, mass = told.quantity["suspected"], estimate.physical["m"]
    assert entry["key"] == "clock"
    assert 1e-7 < entry["chance"] < 5e-4
    assert 2.0 < entry["growth"] < 1.1 * mass.std_robust / mass.std  # the odd clock counts too
    assert tells(told.sentence, "time stamps", "that of m is", f"{entry['growth']:.2g} times")
    assert abs(mass.value - of.truth["m"]) < 3.0 * mass.std_robust


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("name", "source", "target", "share"), few(("ur10_wrist", 2, 3, 2e-4), ("hexapod", 0, 4, 1e-3), kept=1)
)
def test_cross_talk_that_a_run_hides_is_told_channel_by_channel(
    name: str, source: int, target: int, share: float
) -> None:
    of = machine(name)
    channels = of.case.sensor_frame.channels
    offset = of.truth[f"f_q0_{source + 1}"]
    crossed = Change(forces=lambda now, own, _: own + share * np.outer(own[:, source] - offset, np.eye(6)[target]))
    sound, damaged = found(of), found(of, crossed)
    (entries,) = (f.quantity["not_shown"] for f in sound.findings if "not_shown" in f.quantity)
    couplings = [e for e in entries if e["key"] == "coupling"]
    (entry,) = (e for e in couplings if tells(e["as_with"], f"{channels[target]} reads", f"load on {channels[source]}"))
    assert share < entry["size"]
    k = sound.model.names.index(entry["parameter"])
    bias = damaged.fit.values[k] - sound.fit.values[k]
    assert bias == pytest.approx(entry["bias"] * share / entry["size"], rel=0.05)
