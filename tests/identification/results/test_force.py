"""The calibrated model in use: no contact reads zero, contact reads itself, a tare moves offsets and nothing else."""

import json
import re
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import reduce
from operator import getitem
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import Code, FileProblem, HexciteError, IdentificationError
from cases.base.text_formats import json_text
from cases.basis import COMPUTED_FROM, result_basis
from cases.schema import load_case
from identification.finding import Kind
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Standstill
from identification.recording.recording import Recording
from identification.results.estimate import entries_of
from identification.results.force import force
from identification.results.payload import payload_between, require_two
from identification.results.result import Result
from identification.results.taring import tare
from identification.samples.moving_window import moving_run
from identification.samples.standstills import standstills
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, one_line
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)


def recorded(seed: int = 0, motion_seed: int = 0) -> Recording:
    execution = PoseExecution(HEXAPOD, Harmonic(seed=motion_seed, duration=4.0))
    return simulate_recording(CASE, execution, np.array([[0.3, 3.7]]), seed, "run.csv")


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Result:
    file = tmp_path_factory.mktemp("result") / "result.json"
    file.write_text(json_text(entries_of(estimate_parameters(recorded(), CASE)).to_json()))
    return Result.load(file, CASE)


def standing(samples: int = 400, shift: float = 0.0) -> Recording:
    execution = PoseExecution(HEXAPOD, Standstill(np.add(HOME, [0.05, 0.1, 0.0, 0.1, -0.1, 0.05]), 1.0))
    run = simulate_recording(CASE, execution, np.zeros((0, 2)), 3, "still.csv")
    return replace(
        run, forces=run.forces[:samples] + shift, t=run.t[:samples], drives=run.drives[:samples], trigger=None
    )


@pytest.mark.parametrize("origin", ["1700000000.123456789", "-0.25", "0"])
def test_the_table_has_the_recorders_own_clock_to_a_nanosecond(origin: str, saved: Result, tmp_path: Path) -> None:
    """Of epochs a double keeps a quarter of a microsecond."""
    run = recorded(9, 5)
    found = force(replace(run, origin=Fraction(origin)), saved)
    found.save(tmp_path / "f.csv")
    rows = [line.split(",") for line in (tmp_path / "f.csv").read_text().splitlines()[1:]]
    back = [float(Fraction(row[0]) - Fraction(origin)) for row in rows]
    np.testing.assert_allclose(back, found.t, atol=0.51e-9)
    written = np.array([row[1:] for row in rows], dtype=float)
    np.testing.assert_allclose(written, np.hstack([found.wrench, found.std]), rtol=1e-12)


def test_stamps_of_an_epoch_are_those_of_the_table_of_forces(saved: Result, tmp_path: Path) -> None:
    replace(recorded(9, 5), case=CASE).save(tmp_path / "run")
    head, *rows = (tmp_path / "run" / "recording.csv").read_text().splitlines()
    late = [f"{Decimal(row.split(',')[0]) + 1_700_000_000},{row.split(',', 1)[1]}" for row in rows]
    (tmp_path / "late.csv").write_text("\n".join([head, *late]))
    run = Recording.load(tmp_path / "late.csv", CASE)
    assert run.origin == Fraction(late[0].split(",")[0])
    assert run.t[0] == 0.0


def test_without_contact_the_external_force_of_another_motion_is_noise(saved: Result) -> None:
    found = force(recorded(9, 5), saved, whole=False)
    run = moving_run(recorded(9, 5), CASE, saved.model)
    noise = np.sqrt(run.filter.noise_gain) * np.linalg.norm(CASE.sensor_frame.structure, axis=1)  # of 1 N a sensor
    assert np.all(found.rms < 1.3 * noise)
    assert np.all(found.rms > 0.7 * noise)


def with_values(result: Result, values: np.ndarray) -> Result:
    return replace(result, record=result.record.replaced(values=tuple(values.tolist())))


@pytest.mark.parametrize("axis", range(6))
def test_a_force_that_acts_on_the_platform_is_read_with_its_sign(axis: int, saved: Result) -> None:
    """A load w on the platform is carried by the bars: J^-T times what they read more is -w (quasi-static, g = 0)."""
    wrench = 20.0 * np.eye(6)[axis]
    touched = recorded(2)
    touched = replace(touched, forces=touched.forces - np.linalg.solve(CASE.sensor_frame.structure, wrench))
    found = force(touched, saved, whole=False)
    np.testing.assert_allclose(found.wrench.mean(axis=0), wrench, atol=0.15)


def test_weight_is_an_external_force_downwards(saved: Result) -> None:
    """A body of 1 kg more than the parameters know pulls with 9.81 N along gravity."""
    heavier = with_values(saved, saved.values - np.eye(20)[0])  # the parameters know 1 kg less
    still = standing()
    found = force(replace(still, t=None), heavier)
    run = HEXAPOD.poses(still.drives[:1])[0]
    from scipy.spatial.transform import Rotation

    expected = Rotation.from_euler("xyz", run[3:]).as_matrix().T @ [0.0, 0.0, -9.81]
    np.testing.assert_allclose(found.wrench[:, :3].mean(axis=0), expected, atol=0.3)


def test_a_tare_moves_the_offsets_by_the_drift_and_nothing_else(saved: Result) -> None:
    base, drifted = (tare(standing(shift=s), saved) for s in (0.0, 2.5))
    names = saved.model.names
    moved = np.array([n.startswith("f_q0") for n in names])
    np.testing.assert_allclose((drifted.values - base.values)[moved], 2.5, atol=1e-9)
    np.testing.assert_array_equal(drifted.values[~moved], saved.values[~moved])
    assert any("has drifted" in note for note in drifted.notes), (drifted.notes, base.values[moved], saved["f_q0_1"])
    assert not any("has drifted" in note for note in base.notes)


def test_after_a_tare_forces_of_that_pose_are_known_as_well_as_its_mean(saved: Result) -> None:
    """What the rest of the model is uncertain of there is in the offsets, which make up for it."""
    tared, record = tare(standing(), saved), standing()
    matrix = standstills(record, CASE, saved.model).matrices[0]
    deviations = np.sqrt(np.diag(matrix @ tared.covariance @ matrix.T))
    assert np.all((deviations * np.sqrt(400) > 0.9) & (deviations * np.sqrt(400) < 1.8))  # white noise of 1 N
    offsets = [n.startswith("f_q0") for n in saved.model.names]
    assert np.all(np.sqrt(np.diag(tared.covariance))[offsets] > deviations)


def test_a_tare_in_coloured_noise_is_less_certain(saved: Result) -> None:
    record = standing()
    slow = replace(record, forces=record.forces + 2.0 * np.sin(np.arange(400) / 40.0)[:, None])
    matrix = standstills(record, CASE, saved.model).matrices[0]
    deviations = np.sqrt(np.diag(matrix @ tare(slow, saved).covariance_robust @ matrix.T))
    assert np.all(deviations > 3.0 / np.sqrt(400))


def test_a_standstill_that_is_short_for_its_noise_is_told_so(saved: Result) -> None:
    record, draw = standing(), np.random.default_rng(3)
    slow = replace(record, forces=record.forces + np.cumsum(draw.normal(size=(400, 6)), axis=0))
    told = {k: tare(of, saved).record.findings for k, of in (("slow", slow), ("white", record))}
    shares = {k: [f.quantity["slow_noise"] for f in of if "slow_noise" in f.quantity] for k, of in told.items()}
    assert not shares["white"]
    assert shares["slow"][0] > 0.5


def test_a_tared_result_is_a_result(saved: Result, tmp_path: Path) -> None:
    tared = tare(standing(shift=2.5), saved)
    tared.save(tmp_path / "tared")
    again = Result.load(tmp_path / "tared", CASE)
    np.testing.assert_allclose(again.values, tared.values)
    assert tared["f_q0_1"].value == pytest.approx(tared.values[again.model.names.index("f_q0_1")])


def test_findings_are_saved_and_loaded(saved: Result, tmp_path: Path) -> None:
    sound = recorded()
    forces = sound.forces.copy()
    forces[500, 2] += 80.0
    estimate = estimate_parameters(replace(sound, forces=forces), CASE)
    assert {(f.kind, f.severity) for f in estimate.findings} >= {(Kind.DAMAGE, "warning")}
    Result(CASE, entries_of(estimate)).save(tmp_path / "result")
    loaded = Result.load(tmp_path / "result", CASE)
    assert loaded.findings == estimate.findings
    assert (loaded.warnings, loaded.notes) == (estimate.warnings, estimate.notes)
    tared = tare(standing(shift=2.5), saved)
    assert tared.findings[: len(saved.findings)] == saved.findings
    assert any("drifted" in note for note in tared.notes)
    read = json.loads((tmp_path / "result" / "result.json").read_text())
    assert read["warnings"] == [f["sentence"] for f in read["findings"] if f["severity"] == "warning"]


def test_a_tare_in_motion_is_refused(saved: Result) -> None:
    with pytest.raises(IdentificationError, match=r"run\.csv: struts .* mm, at most 0\.1 mm"):
        tare(recorded(), saved)


def added(saved: Result, body: np.ndarray) -> Result:
    return replace(with_values(saved, saved.values + np.r_[body, np.zeros(10)]), file=Path("after"))


def test_the_payload_is_the_body_that_was_added(saved: Result) -> None:
    """20 kg at (10, 20, 180) mm, with its inertia carried to the origin by Steiner."""
    m, c, inertia = 20.0, np.array([0.01, 0.02, 0.18]), np.diag([0.2, 0.25, 0.15])
    about_origin = inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
    body = np.r_[m, m * c, about_origin[np.triu_indices(3)]]
    found = payload_between(saved, added(saved, body)).parameters
    got = [found[n].value for n in ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")]
    np.testing.assert_allclose(got, [20.0, 0.01, 0.02, 0.18, 0.2, 0.25, 0.15], rtol=1e-9)
    assert found["m"].std == pytest.approx(np.sqrt(2 * saved.covariance[0, 0]))


def test_one_recording_is_not_taken_for_two(saved: Result) -> None:
    with pytest.raises(IdentificationError, match=r"of the same recording as .*without") as caught:
        require_two(saved, saved)
    one_line(caught.value)
    first, again, other = (
        replace(saved, file=Path(name), record=saved.record.replaced(inputs=({"file": name, "sha256": content},)))
        for name, content in (("a", "5e6f"), ("copy/result.json", "5e6f"), ("after", "7a8b"))
    )
    with pytest.raises(IdentificationError, match="same recording as") as caught:
        require_two(first, again)
    one_line(caught.value)
    require_two(first, other)


def test_runs_that_were_never_saved_are_told_apart_by_their_figures(saved: Result) -> None:
    """Two simulated runs have one name, and no files."""
    first = replace(saved, file=None, record=saved.record.replaced(inputs=()))
    other = replace(first, record=first.record.replaced(s0=first.record.s0 * 1.01))
    assert first.source == other.source
    require_two(first, other)
    with pytest.raises(IdentificationError) as caught:
        require_two(first, replace(first))
    assert caught.value.code is Code.OTHER_SOURCE


def test_no_payload_is_no_payload(saved: Result) -> None:
    with pytest.raises(IdentificationError, match="not by a payload"):
        payload_between(saved, replace(saved, file=Path("after")))


def test_results_of_different_models_are_compared_with_a_warning(saved: Result) -> None:
    body = added(saved, np.r_[5.0, np.zeros(9)])
    cut = {key: tuple(map(tuple, getattr(saved, key)[:18, :18])) for key in ("covariance", "covariance_robust")}
    linear = {key: getattr(saved.record, key)[:18] for key in ("names", "values")}
    static = replace(saved, record=saved.record.replaced(model=7, **cut, **linear))
    assert any("models 7 and 9 differ" in w for w in payload_between(static, body).warnings)


GONE = object()


def damaged(saved: Result, folder: Path, place: tuple[str | int, ...], value: object) -> Path:
    """The result with another entry at a place, or without it."""
    data = json.loads(Path(saved.source).read_text())
    *above, last = place
    entry = reduce(getitem, above, data)
    if value is GONE:
        del entry[last]
    else:
        entry[last] = value(entry[last]) if callable(value) else value
    (folder / "result.json").write_text(json.dumps(data))
    return folder / "result.json"


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (("schema_version",), 99, "schema_version 99"),
        (("linear",), {}, "entry linear.names is missing or damaged"),
        (("covariance",), [[1.0]], "its parameters are not those of model 9"),
        (("delay_s",), "late", "entry delay_s is missing or damaged"),
        (("parameters", "m", "std_robust"), GONE, "entry parameters.m.std_robust is missing or damaged"),
        (("parameters", "m", "unit"), GONE, "entry parameters.m.unit is missing or damaged"),
        (("parameters", "m", "value"), "31.8", "entry parameters.m.value is missing or damaged"),
        (("parameters", "m", "more"), 1.0, "entry parameters.m.more is missing or damaged"),
        (("parameters", "m"), GONE, "its parameters are not those of model 9"),
        (("covariance_robust",), GONE, "entry covariance_robust is missing or damaged"),
        (("inputs",), GONE, "entry inputs is missing or damaged"),
        (("s0",), None, "entry s0 is missing or damaged"),
        (("s0",), -1.0, "entry s0 is missing or damaged"),
        (("samples",), GONE, "entry samples is missing or damaged"),
        (("condition",), "large", "entry condition is missing or damaged"),
        (("findings",), [{"kind": "weather"}], "entry findings.0.kind is missing or damaged"),
        (("model",), 11, "there is no model 11|model 11"),
    ],
)
def test_a_damaged_result_is_named(
    place: tuple[str | int, ...], value: object, says: str, saved: Result, tmp_path: Path
) -> None:
    file = damaged(saved, tmp_path, place, value)
    with pytest.raises(FileProblem, match=says) as caught:
        Result.load(file, CASE)
    assert one_line(caught.value).startswith(str(file))
    assert "identify again" in str(caught.value)


def test_parameters_of_another_case_are_refused(saved: Result) -> None:
    with pytest.raises(HexciteError, match=r"case hexapod, not ft_wrist"):
        Result.load(Path(saved.source), load_case("ft_wrist"))


@pytest.mark.parametrize(
    ("place", "says"),
    [
        (("parameters", "m", "value"), "m is .* by the linear parameters .* value or deviation"),
        (("parameters", "IC11", "std"), "IC11 is .* by the linear parameters .* value or deviation"),
        (("parameters", "m", "std_robust"), "m is .* by the linear parameters .* value or deviation"),
        (("linear", "values", 0), "m is .* by the linear parameters .* value or deviation"),
        (("covariance", 0, 0), "m is .* by the linear parameters .* value or deviation"),
        (("covariance_robust", 0, 0), "m is .* by the linear parameters .* value or deviation"),
        (("covariance_robust", 19, 1), "a covariance is not symmetric"),
    ],
)
@pytest.mark.parametrize("factor", [1.05, -1.0])
def test_a_number_changed_by_hand_is_noticed(
    place: tuple[str | int, ...], says: str, factor: float, saved: Result, tmp_path: Path
) -> None:
    file = damaged(saved, tmp_path, place, lambda number: number * factor)
    with pytest.raises(FileProblem) as caught:
        Result.load(file, CASE)
    assert re.search(rf"^{re.escape(str(file))}: {says}:? changed by hand; identify again", str(caught.value))


def test_a_unit_changed_by_hand_is_noticed(saved: Result, tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"xC is .*mm, by the linear parameters .* m\b.*identify again"):
        Result.load(damaged(saved, tmp_path, ("parameters", "xC", "unit"), "mm"), CASE)


def test_a_case_of_ones_own_is_looked_at_too(saved: Result, tmp_path: Path) -> None:
    file = damaged(saved, tmp_path, (COMPUTED_FROM,), result_basis(CASE))
    sensors = CASE.sensors.model_copy(update={"force_noise_N": 2.0})
    changed = CASE.model_copy(update={"sensors": sensors})
    with pytest.raises(FileProblem, match=r"result\.json: case hexapod .*sensors\.force_noise_N .*stale"):
        Result.load(file, changed)
    (remark,) = Result.load(file, changed, stale=True).remarks
    assert remark.startswith("stale: ")


def test_a_tare_names_every_channel_before_and_after(saved: Result) -> None:
    shift = np.array([0.0, 0.5, 0.0, -2.0, 0.0, 0.1])
    still = standing()
    tared = tare(replace(still, forces=still.forces + shift), saved)
    table = tared.record.tared
    assert list(table) == [f"f{k}_N" for k in range(1, 7)]
    for k, entry in enumerate(table.values(), 1):
        assert entry["before"] == saved[f"f_q0_{k}"].value
        assert entry["after"] == tared[f"f_q0_{k}"].value
        assert abs(entry["after"] - entry["before"] - shift[k - 1]) < 4.0 * entry["change_std"]
    for name in table:
        assert re.search(rf"^ *{name} .* N$", str(tared), re.MULTILINE)
