"""Exported signal chains say how uncertain their wrench is, in the frame that was chosen."""

import ctypes
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import CaseError, HexciteError
from cases.schema import Case
from identification.estimation.fit import Value
from identification.identify import identify
from identification.results.chain_uncertainty import anywhere
from identification.results.force import force
from identification.results.frames import place_of
from identification.results.result import Result
from postprocessors.export.code import c_sources, linuxcnc_component, python_module, structured_text
from postprocessors.export.targets import preview
from tests.bench.tolerances import CHAIN
from tests.damaged.runs import STATED, Moves, machine, recorded
from tests.hexcite.command_line import call
from tests.postprocessors.export.calibrations import calibration
from tests.postprocessors.export.test_joints import module_of

ARM = "ur10_wrist"


@cache
def made() -> tuple[Result, object]:
    """A result of an arm that states tolerances, and another run of it."""
    of = machine(ARM)
    data = of.case.model_dump(mode="json", exclude_unset=True) | {"tolerances": CHAIN}
    case = Case.model_validate(data).found_at(ARM)
    run, other = (recorded(of, Moves(of, seed, 4.0), seed, STATED) for seed in (1, 2))
    return identify(replace(run, case=case), case), replace(other, case=case)


def test_what_a_chain_promises_is_what_forces_of_a_run_have_or_more(tmp_path: Path) -> None:
    """The run moves inside the box in which the largest is looked for."""
    result, other = made()
    module = module_of(result, tmp_path)
    promised, found = module.uncertainty(np.zeros(6)), force(other, result).expanded.max(axis=0)
    assert np.all(found < 1.1 * promised), (found, promised)
    assert np.all(promised < 6.0 * found), (found, promised)


def test_a_chain_promises_what_a_delay_that_is_off_makes_of_forces() -> None:
    """It is what forces of another program's plant change by in the time that the delay may be off, within limits."""
    result, _ = made()
    off = 1.0  # [s] so large that nothing else counts beside it
    late = result.record.replaced(delay_s=Value(result.delay, off, off, "s"))
    place = place_of(result.case_as_told, "sensor", at_home=False)
    promise = anywhere(replace(result, record=late), place)
    assert "delay" in promise.counts
    of, draw = machine(ARM), np.random.default_rng(1)
    most, rates = np.array(of.limits), np.zeros(6)
    for _ in range(200):
        state = most * draw.uniform(-1.0, 1.0, most.shape) / np.array([[1.0], [1.0], [2.0], [6.0]])
        steps = np.array([-1e-4, 1e-4])
        now = of.plant.motion(lambda t, s=state: of.home + np.vander(t, 4, increasing=True) @ s, steps)
        before, after = of.plant.forces(now, 0.0)
        rates = np.maximum(rates, np.abs(after - before) / 2e-4)
    ratios = promise.expanded / 2.0 / rates  # largest of 200 states each, drawn by others
    assert np.all((ratios > 0.6) & (ratios < 1.7)), ratios
    assert 0.8 < ratios.mean() < 1.25, ratios
    sure = result.record.replaced(delay_s=Value(result.delay, 0.0, 0.0, "s"))
    known = anywhere(replace(result, record=sure), place)
    assert "delay" not in known.counts
    assert np.all(known.expanded <= anywhere(result, place).expanded)


@pytest.mark.parametrize("frame", ["sensor", "flange", "base"])
def test_uncertainty_grows_with_the_force_by_gains(frame: str, tmp_path: Path) -> None:
    result, _ = made()
    promise = anywhere(result, place_of(result.case_as_told, frame, at_home=False))
    resting = promise.of(np.zeros(6))
    pulled = promise.of(np.array([0.0, 0.0, 1e4, 0.0, 0.0, 0.0]))
    np.testing.assert_allclose(resting, promise.expanded)
    assert pulled[2] == pytest.approx(2.0 * CHAIN["gain_percent"] / 100.0 * 1e4, rel=0.2)
    assert set(promise.counts) >= {"noise", "parameters", "gains"}
    assert "clock" in promise.not_counted


def test_the_same_wrench_is_seen_from_every_frame(tmp_path: Path) -> None:
    result, _ = made()
    models = {}
    for frame in ("sensor", "flange", "base"):
        (text,) = preview(result, "python", frame=frame).values()
        space: dict = {"__name__": f"seen_{frame}"}
        exec(compile(text, frame, "exec"), space)
        models[frame] = space["Model"]()
    draw = np.random.default_rng(1)
    joints, rates, bends, forces = (draw.normal(size=6) for _ in range(4))
    seen = {frame: model.from_joints(joints, rates, bends, 30.0 * forces) for frame, model in models.items()}
    place = place_of(result.case_as_told, "flange")
    np.testing.assert_allclose(seen["flange"], place.map @ seen["sensor"], rtol=1e-9, atol=1e-9)
    for half in (slice(0, 3), slice(3, 6)):
        assert np.linalg.norm(seen["base"][half]) == pytest.approx(np.linalg.norm(seen["sensor"][half]))
    pose = models["base"].pose
    posed = models["base"].from_pose(pose, np.zeros(6), np.zeros(6), 30.0 * forces)
    still = models["base"].from_joints(joints, np.zeros(6), np.zeros(6), 30.0 * forces)
    np.testing.assert_allclose(posed, still, atol=1e-9)


def test_c_and_structured_text_and_hal_state_the_same_uncertainty(tmp_path: Path) -> None:
    result, _ = made()
    header, source = c_sources(result, "chain", "flange")
    (tmp_path / "chain.h").write_text(header)
    (tmp_path / "chain.c").write_text(source)
    library = tmp_path / "chain.so"
    subprocess.run(
        ["cc", "-std=c99", "-shared", "-fPIC", "-o", library, tmp_path / "chain.c", "-lm"], check=True, timeout=60
    )
    function = ctypes.CDLL(str(library)).chain_uncertainty
    wrench, expanded = (ctypes.c_double * 6)(10.0, -20.0, 30.0, 1.0, 2.0, -3.0), (ctypes.c_double * 6)()
    function(wrench, expanded)
    promise = anywhere(result, place_of(result.case_as_told, "flange", at_home=False))
    np.testing.assert_allclose(list(expanded), promise.of(np.array(list(wrench))), rtol=2e-3)
    for text in (header, linuxcnc_component(result, "chain", "flange"), structured_text(result, "chain", "flange")):
        assert "origin of the robot's flange" in text
        assert "It counts noise, delay, parameters" in " ".join(text.split())
        assert "Not stated" in text
    assert "u-mz" in linuxcnc_component(result, "chain")


def test_frames_that_a_case_does_not_state_are_refused(tmp_path: Path) -> None:
    result, _ = made()
    with pytest.raises(CaseError, match=r"chain\.tcp"):
        python_module(result, "chain", "tool")
    with pytest.raises(HexciteError, match="frame"):
        preview(result, "json", frame="flange")
    with pytest.raises(HexciteError, match="frame 'wrist' is unknown"):
        preview(result, "c", frame="wrist")


@pytest.mark.parametrize(("name", "number"), [("hexapod", 9), ("strut_sensors", 6), ("ft_wrist", 0)])
def test_a_result_without_tolerances_counts_what_it_has(name: str, number: int, tmp_path: Path) -> None:
    text = python_module(calibration(tmp_path, name, number), "found")
    assert "parameters" in text
    said = " ".join(text.split())
    assert "counts no tolerances" in said
    assert "counts no noise of the channels" in said  # these results do not state it


def test_the_command_writes_the_frame(tmp_path: Path) -> None:
    result, _ = made()
    result.case.save(tmp_path / "arm.toml")
    result.save(tmp_path / "result")
    words = ("export", tmp_path / "result", "--to", "st", "--frame", "flange", "--preview")
    assert "robot's flange" in call(*words, "--case", tmp_path / "arm.toml").out
