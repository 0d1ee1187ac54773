"""Several runs of the same thing: their mean, what does not average out, and whether they agree."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import FileProblem, HexciteError
from cases.tolerances import Tolerances
from identification.estimation.covariances import larger_of
from identification.estimation.estimators import Method
from identification.results.result import Result
from tests.damaged.runs import SOUND, STATED, Moves, machine, recorded
from tests.helpers import tells

GAIN = 0.2  # percent, of each channel


@cache
def of_run(seed: int, gain: float = 1.0) -> Result:
    """A hexapod with gains off by their tolerance, the same in every run; `gain` is an error of one run."""
    of = machine("hexapod")
    case = of.case.model_copy(update={"tolerances": Tolerances.model_validate({"gain_percent": GAIN})})
    gains = 1.0 + np.random.default_rng(5).normal(0.0, GAIN / 100.0, 6)
    run = recorded(of, Moves(of, seed, 4.0), seed, STATED, SOUND)
    return hx.identify(replace(run, forces=run.forces * gains * gain, source=f"run_{seed}"), case)


@pytest.mark.repeats
def test_what_runs_have_in_common_does_not_average_out_and_their_noise_does() -> None:
    runs = [of_run(seed) for seed in (1, 2, 3, 4)]
    pooled, truth = hx.pool(runs), machine("hexapod").truth
    for name, value in pooled.parameters.items():
        if name in truth:
            assert abs(value.value - truth[name]) < 3.5 * value.reported
    one, all_of = runs[0].budget["m"], pooled.budget["m"]
    assert all_of["gains"] == pytest.approx(one["gains"], rel=0.2)
    noise = [np.hypot(b["noise"], b["noise with memory"]) for b in (all_of, one)]
    assert noise[0] < 0.7 * noise[1]
    assert sum(part**2 for part in all_of.values()) == pytest.approx(pooled["m"].reported ** 2, rel=1e-6)
    assert pooled.record.pooled["p"] > 0.01
    assert any(tells(text, "4 runs agree") for text in pooled.notes)


@pytest.mark.repeats
def test_a_pool_of_pools_is_the_pool_of_all() -> None:
    a, b, c, d = (of_run(seed) for seed in (1, 2, 3, 4))
    both, at_once = hx.pool([hx.pool([a, b]), hx.pool([c, d])]), hx.pool([a, b, c, d])
    scale = np.sqrt(np.diag(at_once.covariance_robust))
    np.testing.assert_allclose((both.values - at_once.values) / scale, 0.0, atol=0.2)
    np.testing.assert_allclose(np.sqrt(np.diag(both.covariance_robust)) / scale, 1.0, rtol=0.1)


def test_a_pool_knows_the_noise_of_the_channels() -> None:
    """It is that of the machine, so that verdicts judge it, and force and exported chains count it."""
    runs = [of_run(seed) for seed in (1, 2)]
    pooled, noise = hx.pool(runs), machine("hexapod").noise
    np.testing.assert_allclose(pooled.record.channel_noise["measured"], noise, rtol=0.15)
    evaluated = [run.record.channel_noise["evaluated"] for run in runs]
    assert np.all(np.min(evaluated, axis=0) <= pooled.record.channel_noise["evaluated"])
    assert np.all(np.max(evaluated, axis=0) >= pooled.record.channel_noise["evaluated"])
    assert any(check.code == "noise" for check in hx.accept(pooled).checks)


def test_a_run_that_differs_is_named_and_deviations_allow_for_it() -> None:
    runs = [of_run(1), of_run(2), of_run(3, 1.01), of_run(4)]
    pooled, sound = hx.pool(runs), hx.pool([of_run(seed) for seed in (1, 2, 4)])
    assert pooled.record.pooled["p"] < 1e-3
    assert any(tells(text, "run_3 differs from the others") for text in pooled.warnings)
    assert pooled["m"].std > 1.5 * sound["m"].std
    two = hx.pool([of_run(1), of_run(3, 1.01)])
    assert any(tells(text, "a third run") for text in two.warnings)


def test_it_is_a_result_that_others_take(tmp_path: Path) -> None:
    pooled = hx.pool([of_run(1), of_run(2)])
    pooled.save(tmp_path / "pooled")
    again = hx.Result.load(tmp_path / "pooled", pooled.case)
    assert again == pooled
    np.testing.assert_array_equal(again.biases["gain_percent"], pooled.biases["gain_percent"])
    hx.export(again, "json", tmp_path / "model.json", force=True)
    hx.report(again, tmp_path / "page.html")
    assert "how far they scatter" in (tmp_path / "page.html").read_text()


def test_what_no_mean_can_be_of_is_refused_with_what_differs() -> None:
    run, other = of_run(1), of_run(2)
    with pytest.raises(HexciteError, match="two results"):
        hx.pool([run])
    same = {"inputs": ({"file": "a.csv", "sha256": "0" * 64},)}
    differing = [
        ({"model": 6}, "model is 6"),
        ({"known": {"k3": 0.0}}, "known is"),
        ({"run": {"payload": {"weights": 1, "mass_kg": 2.0}}}, "payload of 2 kg was mounted"),
        ({"delay_s": None}, "standstills"),
        ({"case": "mill"}, "of case mill"),
        ({"computed_from": {**other.record.computed_from, "setup": "2x"}}, "setup is 2x"),
        ({"priors": {"m": {"value": 1.0, "std": 1.0}}}, "prior of m"),
    ]
    for change, words in differing:
        with pytest.raises(FileProblem, match=words):
            hx.pool([run, replace(other, record=other.record.replaced(**change))])
    with pytest.raises(FileProblem, match="same recording"):
        hx.pool([replace(r, record=r.record.replaced(**same)) for r in (run, other)])


@pytest.mark.repeats
def test_a_known_value_stays_known() -> None:
    of = machine("hexapod")
    runs = [
        hx.identify(recorded(of, Moves(of, seed, 4.0), seed, STATED, SOUND), of.case, how=Method({"xC": 0.001}))
        for seed in (1, 2)
    ]
    pooled = hx.pool(runs)
    assert pooled["xC"].value == pytest.approx(0.001, rel=1e-9)
    assert pooled["m"].std < runs[0]["m"].std


def test_the_larger_of_two_covariances_is_nowhere_below_either() -> None:
    draw = np.random.default_rng(0)
    a, b = (m @ m.T for m in draw.normal(size=(2, 5, 5)))
    larger = larger_of(a, b)
    for least in (a, b):
        assert np.linalg.eigvalsh(larger - least).min() > -1e-9
    assert np.linalg.det(larger) < np.linalg.det(a + b)
