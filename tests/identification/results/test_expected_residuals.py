"""Parameters in use on a machine off its case: forces and tared offsets are off by what their deviations say."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cases.base.units import DEG, MM
from cases.schema import Case
from identification.findings.left_out import LeftOut
from identification.findings.tolerances import UNITS
from identification.identify import identify
from identification.recording.recording import Recording
from identification.results.expected_errors import effects_in, errors_of
from identification.results.expected_residuals import used_samples
from identification.results.force import force
from identification.results.frames import place_of
from identification.results.taring import tare
from tests.bench.forces_in_use import Machined, Still, figures, force_errors, tare_errors
from tests.bench.silent import way_of
from tests.damaged.runs import SOUND, Change, Moves, Noise, machine, recorded
from tests.helpers import few
from tests.identification.findings.test_tolerances import bar, edited, gain, gravity, joint, sensor, zero

FAINT = Noise(0.05, encoder=0.0)
HELD = np.array([40.0, -25.0, 30.0, 3.0, -2.0, 1.5])  # what sensors hold against a force from outside [N, N m]


def turned(case: Case, run: Recording) -> tuple[Case, Recording]:
    """The sensor turned about its z axis, which is that of its table of angles where it stands straight."""
    return edited(case, "machine", "chain", "sensor", "rpy_deg", 2, by=0.05), run


def straight(case: Case) -> Case:
    """The case with its sensor's angles written out."""
    data = case.model_dump(mode="json", exclude_unset=True)
    if case.chain is not None:
        data["machine"]["chain"]["sensor"] |= {"rpy_deg": [0.0, 0.0, 0.0]}
    return Case.model_validate(data)


def tolerant(case: Case, key: str) -> Case:
    """The case with one tolerance, too small for a run to tell its size."""
    data = case.model_dump(mode="json", exclude_unset=True)
    return Case.model_validate(data | {"tolerances": {key: 1e-6}})


@cache
def quiet(name: str):
    """A machine, a run, a further one with a force from outside, and a standstill; hardly any noise."""
    of = machine(name)
    pulled = Change(pull=lambda now: np.broadcast_to(HELD, (len(now.q), 6)))
    runs = [recorded(of, Moves(of, seed, 4.0), seed, FAINT, change) for seed, change in ((1, SOUND), (2, pulled))]
    half = of.limits[0]
    still = recorded(of, Still(of.home + 0.4 * half * np.cos(np.arange(len(half))), 0.4), 3, FAINT)
    return of, (*runs, still)


CHANGES = [
    ("hexapod", "joints_mm", 18 + 11, joint("platform", 3, 2), 0.1 * MM),
    ("ur10_wrist", "joint_zeros_deg", 4, zero, 0.02 * DEG),
    ("ur10_wrist", "sensor_deg", 2, turned, 0.05 * DEG),
    ("hexapod", "gain_percent", 2, gain, 2e-3),
    ("hexapod", "bars_mm", 6, bar("lower", 2, 0), 0.1 * MM),
    ("ur10_wrist", "sensor_mm", 2, sensor, 0.5 * MM),
    ("hexapod", "gravity_percent", 0, gravity, 1e-3),
]


@pytest.mark.first(1)
@pytest.mark.parametrize(("name", "key", "column", "change", "size"), few(*CHANGES, kept=4))
@pytest.mark.repeats
def test_forces_and_tared_offsets_change_with_the_case_as_their_factors_say(name, key, column, change, size) -> None:
    """A force from outside acts: gains, bars and axes act on that too."""
    of, (run, other, still) = quiet(name)
    case = straight(of.case)
    results, forces, offsets = [], {"sensor": [], "base": []}, []
    for wrong in (True, False):
        found = []
        for recording in (run, other, still):
            right_case, right_run = change(case, recording)
            as_said = (case, recording) if wrong else (right_case, right_run)
            found.append((tolerant(as_said[0], key), replace(as_said[1], case=tolerant(as_said[0], key))))
        estimated = identify(found[0][1], found[0][0], model=6 if name != "hexapod" else None)
        results.append(estimated)
        for frame, of_frame in forces.items():
            of_frame.append(force(found[1][1], estimated, frame=frame).wrench)
        tared = tare(found[2][1], estimated)
        offsets.append(tared.values[[tared.model.names.index(f"f_q0_{k}") for k in range(1, 7)]])
    result = results[0]
    scale = size / (1e-6 * UNITS[key.rpartition("_")[2]])
    used = used_samples(replace(other, case=result.case), result, True)
    for frame, (wrong_force, right_force) in forces.items():
        place = place_of(result.case, frame, at_home=False)
        into = np.broadcast_to(used.into(place), (len(used.t), 6, 6))
        factor = used.errors(slice(None), place, into, wrong_force).by_tolerance[key][:, :, column]
        found, expected = wrong_force - right_force, scale * factor
        for half in (slice(0, 3), slice(3, 6)):
            most = np.abs(found[:, half]).max()
            if most > 5e-3:
                np.testing.assert_allclose(expected[:, half], found[:, half], atol=0.03 * most + 1e-3)
    still_motion = used_samples(replace(still, case=result.case, t=None), result, True).motion.at(np.array([5]))
    left_out = LeftOut.in_use(result.model, still_motion, result.values, np.zeros((1, 6)), result.case)
    matrices = left_out.matrices.copy()
    own = [result.model.names.index(f"f_q0_{k}") for k in range(1, 7)]
    matrices[:, :, own] = 0.0
    factor = errors_of(result, matrices, effects_in(left_out, result)).by_tolerance[key][0, :, column]
    between = offsets[0] - offsets[1]
    np.testing.assert_allclose(scale * factor, between, atol=max(0.05 * np.abs(between).max(), 5e-4))


@pytest.mark.parametrize("name", few("chain_91001", "hexapod_91002", kept=1))
def test_a_tare_near_the_run_cancels_what_tolerances_do_to_its_offsets(name: str) -> None:
    """At home, in the middle of the run, offsets are as good as those of the run, or better."""
    of = Machined.drawn(name, 91_001, "white")
    result = identify(of.run(way_of(of.of, 91_001, 4.0), 1), of.case)
    far, near = (tare(of.run(Still(of.of.home + share * of.of.limits[0]), 5), result) for share in (0.9, 0.0))
    names = [n for n in result.parameters if n.startswith("f_q0")]
    assert np.mean([far[n].reported / near[n].reported for n in names]) > 1.05
    for tared in (far, near):
        for name in names:
            parts = sum(v**2 for v in tared.budget[name].values())
            assert parts == pytest.approx(tared[name].reported ** 2, rel=0.1)


@pytest.mark.slow
def test_errors_in_use_are_as_large_as_reported() -> None:
    offsets, forces = [], []
    for seed, name in enumerate(["hexapod", "ur10_wrist", "hexapod_91002", "chain_91003"] * 2, 500):
        of = Machined.drawn(name, seed, "white")
        result = identify(of.run(way_of(of.of, seed, 5.0), seed), of.case)
        offsets.append(tare_errors(of, result, seed)[0])
        forces += [force_errors(of, result, seed, frame) for frame in ("sensor", "base")]
    for errors in (offsets, forces):
        size = np.concatenate([e.ravel() for e in errors])
        assert 0.7 < np.sqrt(np.mean(size**2)) < 1.3, figures(errors)
