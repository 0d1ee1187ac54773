"""The payload experiment: an ideal machine meets theory exactly, a disturbed one errs as far as it is told why."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import NoReturn

import numpy as np
import pytest
from playwright.sync_api import Browser

from cases.errors import FileProblem, HexciteError
from cases.loading import load_case
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.loaded import Circumstances, pose_fields
from identification.model import identification_model
from identification.motion import Joined, Standstill, Trajectory
from identification.parameters import physical_form
from identification.recording import STRUTS
from identification.runs.conditioning import Conditioning
from identification.trajectories.executed import StrutExecution
from identification.trajectories.profile import StraightMove
from planner.cli.validate import run_validation
from planner.cli.validate_runs import Settings, _keep, _kept, _key, unfinished
from planner.interruption import Interrupted
from planner.precision import with_deviation
from planner.reports.validation import _models
from planner.validation.answer import linear_answer
from planner.validation.causes import BODY, LEFT_OUT, MODE, NOISE, POSE, RIPPLE, Budget
from planner.validation.experiment import Excitation, mounted_weights, steps
from planner.validation.kept import Kept, keep, kept_step
from planner.validation.remedy import remedy_of
from planner.validation.scatter import true_deviations
from planner.validation.step import SHOWN, Identified, Step
from planner.validation.verdict import findings, off_rows
from postprocessors.execute.executed_run import ExecutedRun
from tests.helpers import Harmonic, ideal, paper_poses
from tests.planner.browser import opened
from tests.planner.command_line import call, hexcite, refused
from tests.postprocessors.changed_case import changed
from tests.simulated_machine import PoseExecution, simulate_standstills

CASE = load_case("hexapod")
FOUND = CASE.simulation.disturbances.model_copy(update={"strut_velocity_noise_percent": 0.8})  # slow motions
HOME = CASE.machine.home.vector
Q5N = (1.81, 1.93, 2.07, 2.33, 2.74, 3.14)  # Table 7


def poses() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    places, turns = paper_poses()
    return np.column_stack([places, Rotation.from_matrix(turns).as_euler("xyz")])[::8]


def moving(case: Case, seconds: float = 5.0) -> Excitation:
    """A method that moves."""
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=seconds))
    trigger = np.array([[0.5, seconds - 0.5]])
    return Excitation(case, "D", "", seconds - 1.0, execution, trigger, np.zeros((0, 6)), 0)


def standing(case: Case) -> Excitation:
    """A method that stands still for a quarter of a second in each of twenty poses."""
    box, stations = case.limits.motion, np.random.default_rng(3).permutation(poses())[:20]
    parts: list[Trajectory] = [Standstill(HOME, 0.3)]
    trigger, clock, here = [], 0.3, HOME
    for pose in stations:
        move = StraightMove.fastest(here, pose, box.rate, box.acceleration, box.jerk)
        parts += [move, Standstill(pose, 0.45)]
        clock += move.duration + 0.45
        trigger.append((clock - 0.25, clock))
        here = pose
    execution = PoseExecution(Hexapod.of(case), Joined(tuple(parts)))
    return Excitation(case, "Q", "", clock, execution, np.array(trigger), stations, 0)


@cache
def disturbed(method: str) -> tuple[Step, ...]:
    """Steps of the disturbed machine, without weights and with three."""
    return tuple(steps({"D": moving, "Q": standing}[method](CASE), (0, 3), FOUND))


@pytest.mark.parametrize(("method", "exact"), [(standing, 1e-8), (moving, 2e-3)])
def test_an_ideal_machine_meets_theory_and_truth(method, exact: float):
    """Standing exactly, moving as well as the evaluation's filter passes the motion."""
    found = list(steps(method(ideal(CASE)), (0, 2, 5), None))
    assert [s.load for s in found] == pytest.approx([0.0, 2 * 19.93, 5 * 19.93])
    for step in found:
        assert step.budget is None
        for name in SHOWN:
            if name in step.theory:
                assert step.deviation(name) == pytest.approx(0.0, abs=exact), name
        assert step.estimate.physical["m"].value == pytest.approx(31.83 + step.load, rel=exact)
        for name, true in step.truth.items():
            if name in step.estimate.physical:
                assert step.estimate.physical[name].value == pytest.approx(true, rel=exact, abs=exact)


def test_theory_follows_what_was_identified_without_payload_and_truth_does_not():
    first, second = disturbed("Q")
    bare = first.estimate.physical["m"].value
    assert abs(bare - 31.83) > 1e-3
    assert second.theory["m"] == pytest.approx(bare + 3 * 19.93, rel=1e-12)
    assert second.truth["m"] == pytest.approx(31.83 + 3 * 19.93, rel=1e-12)
    assert second.theory["f_q0_3"] == first.estimate.physical["f_q0_3"].value


@pytest.mark.parametrize("method", ["D", "Q"])
def test_the_parts_of_an_error_add_up_to_it(method: str):
    for step in disturbed(method):
        for name, parts in step.budget.parts.items():
            error = step.estimate.physical[name].value - step.truth[name]
            assert sum(parts.values()) == pytest.approx(error, rel=1e-9)
            assert step.budget.in_std(step.estimate.physical)[name][POSE] == pytest.approx(
                parts[POSE] / step.estimate.physical[name].reported
            )


NO_MODE = {"mode_Hz": 1e5}
NO_POSE_ERROR = {"pose_error_N": 0.0, "pose_error_of_load": 0.0}


@pytest.mark.parametrize(
    ("method", "cause", "off"),
    [(moving, MODE, NO_MODE), (moving, POSE, NO_POSE_ERROR), (standing, POSE, NO_POSE_ERROR)],
)
def test_a_part_is_what_vanishes_when_its_disturbance_is_switched_off(method, cause: str, off: dict):
    """The same run, recorded and identified again without the disturbance: no attribution in sight.

    The delay, which bends the estimate, makes the difference of some tenths of a standard deviation.
    """
    excitation, without_it = method(CASE), FOUND.model_copy(update=off)
    step = disturbed({moving: "D", standing: "Q"}[method])[1]
    once = excitation.moved(0, without_it) if method is standing else None
    without = identify(excitation.recorded(3, without_it, once)[0], CASE)
    largest = 0.0
    for name, parts in step.budget.parts.items():
        std = step.estimate.physical[name].reported
        vanished = (step.estimate.physical[name].value - without.physical[name].value) / std
        assert parts[cause] / std == pytest.approx(vanished, abs=0.3), name
        assert abs(parts[LEFT_OUT]) < 0.2 * std
        largest = max(largest, abs(vanished))
    assert largest > 1.0


def test_nothing_but_ripple_and_sampling_is_left_of_a_machine_without_the_others():
    calm = FOUND.model_copy(update={"mode_Hz": 1e5, "pose_error_N": 0.0, "pose_error_of_load": 0.0})
    (step,) = steps(moving(ideal(CASE)), (0,), calm)
    for parts in step.budget.parts.values():
        assert abs(parts[NOISE]) + abs(parts[POSE]) < 1e-9
        assert abs(parts[MODE]) < 0.01 * max(abs(parts[RIPPLE]), 1e-4)


def test_the_cause_is_the_part_without_which_the_error_is_smallest():
    budget = Budget({"m": 3.0}, {"m": {MODE: 4.0, POSE: -1.1, NOISE: 0.05, RIPPLE: 0.05, LEFT_OUT: 0.0}})
    assert budget.cause("m") == MODE
    other = {MODE: 3.0, POSE: -2.0, NOISE: 0.9, RIPPLE: -0.9, LEFT_OUT: 0.0}
    assert Budget({"m": 1.0}, {"m": other}).cause("m") == NOISE


def test_what_is_off_is_named_with_its_cause():
    """A soft structure makes forces too large: nothing else is to blame."""
    heavy = FOUND.model_copy(update={"mode_Hz": 30.0} | NO_POSE_ERROR)
    found = list(steps(moving(CASE), (0,), heavy))
    rows = off_rows(found)
    assert rows
    assert {row[-1] for row in rows} == {MODE}
    (inside,) = [f for f in findings(CASE, found, {}) if f.claim.startswith("mass, centre")]
    assert not inside.holds
    assert f"{MODE} ({len(rows)})" in inside.figures
    assert off_rows(list(steps(moving(CASE), (0,), None))) == []


def test_where_the_mode_is_the_cause_the_recording_is_identified_with_it():
    heavy = FOUND.model_copy(update={"mode_Hz": 30.0} | NO_POSE_ERROR)
    excitation = moving(CASE)
    found = list(steps(excitation, (0,), heavy))
    remedy = remedy_of(excitation, found[0], heavy)
    assert remedy is not None
    assert {row[2] for row in remedy.rows()} == {row[2] for row in off_rows(found)}
    again = identify(excitation.recorded(0, heavy)[0], CASE, conditioning=Conditioning(flexible=True))
    assert Identified.of(again) == remedy.estimate
    assert remedy.estimate.mode == pytest.approx(30.0, rel=0.3)  # of a series that ends after its first term
    for name in remedy.names:
        true = found[0].truth[name]
        assert remedy.error(name) == (again.physical[name].value - true) / again.physical[name].reported
    calm = heavy.model_copy(update=NO_MODE)
    (quiet,) = steps(excitation, (0,), calm)
    assert remedy_of(excitation, quiet, calm) is None


def test_true_deviations_are_the_scatter_over_machines_that_err_with_the_pose_otherwise():
    """Each machine's own waves, through the evaluation of the same run; of 60 machines a deviation is 9 % uncertain."""
    excitation = moving(CASE)
    recording, _ = excitation.recorded(3, FOUND)
    estimate = identify(recording, CASE)
    answer = linear_answer(CASE, recording, estimate)
    load = 3 * 19.93
    weight, poses = 9.81 * load, Hexapod.of(CASE).poses(recording.struts)
    machines = [pose_fields(FOUND.model_copy(update={"pose_error_seed": 50 + k}), HOME, poses) for k in range(60)]
    moves = answer.of(np.stack([answer.seen(fields.of(weight)) for fields in machines], axis=2))
    form, none = physical_form(identification_model(CASE, 9)), np.zeros((20, 20))
    values = np.array([form.of(estimate.values + move, none)[0] for move in moves.T])
    told = true_deviations(CASE, answer, estimate, FOUND, load)
    assert set(told) == set(estimate.physical)
    scatter = {p.name: v for p, v in zip(form.parameters, values.std(axis=0, ddof=1), strict=True)}
    by_pose = {n: np.sqrt(told[n] ** 2 - estimate.physical[n].std ** 2) for n in told}
    ratios = np.array([scatter[n] / by_pose[n] for n in told])
    assert 0.6 < ratios.min() <= ratios.max() < 1.5
    assert np.sqrt(np.mean(ratios**2)) == pytest.approx(1.0, abs=0.15)


def test_what_forces_move_an_estimate_by_is_foretold():
    excitation = moving(CASE)
    recording, _ = excitation.recorded(0, None)
    estimate = identify(recording, CASE)
    answer = linear_answer(CASE, recording, estimate)
    push = 0.5 * np.sin(np.arange(len(recording.t))[:, None] * [0.003, 0.004, 0.005, 0.006, 0.007, 0.008])
    foretold = answer.of(answer.seen(push)[:, :, None])[:, 0]
    pushed = identify(replace(recording, forces=recording.forces + push), CASE)
    moved = pushed.values - estimate.values
    assert np.linalg.norm(foretold) > 0.0
    np.testing.assert_allclose(foretold, moved, atol=0.02 * np.abs(moved).max())


def claimed(
    ours: float,
    theirs: float,
    seconds: tuple[float, float],
    method: str,
    robust: tuple[float, float] = (0.0, 0.0),
    true: tuple[float, float] | None = None,
) -> list[bool]:
    """Whether ptp's standard deviations are found to be smaller: by (28), with noise that has memory, and in truth."""

    def told(plain: float, other: float) -> SimpleNamespace:
        return SimpleNamespace(std=plain, std_robust=other, reported=max(plain, other))

    def row(name: str, plain: float, other: float, t: float, k0: float, true: dict[str, float]) -> SimpleNamespace:
        estimate = SimpleNamespace(physical={"m": told(plain, other), "k0": told(k0, 0.0)})
        return SimpleNamespace(method=name, weights=0, estimate=estimate, duration=t, truth={}, scatter=true)

    rows = [
        row("ptp", ours, robust[0], seconds[0], 0.001, dict.fromkeys(("m", "k0"), true[0]) if true else {}),
        row(method, theirs, robust[1], seconds[1], 0.01, dict.fromkeys(("m", "k0"), true[1]) if true else {}),
    ]
    return [found.holds for found in findings(CASE, rows, {})]


def test_a_method_is_better_only_where_all_its_deviations_are_smaller_in_no_more_time():
    assert claimed(0.1, 0.2, (12.0, 12.0), "D9N") == [True, True]
    assert claimed(0.2, 0.1, (12.0, 12.0), "D9N") == [False, False]
    assert claimed(0.1, 0.2, (12.5, 12.0), "D9N") == [False, False]
    assert claimed(0.1, 0.2, (12.03, 12.0), "D9N") == [True, True]


def test_noise_with_memory_is_another_question():
    assert claimed(0.1, 0.2, (12.0, 12.0), "D9N", (0.5, 0.4)) == [True, False]
    assert claimed(0.2, 0.1, (12.0, 12.0), "D9N", (0.3, 0.4)) == [False, True]


def test_true_deviations_are_another_one():
    equal, times = (0.3, 0.3), (12.0, 12.0)
    assert claimed(0.1, 0.2, times, "D9N", equal, (0.4, 0.5)) == [True, False, True]
    assert claimed(0.1, 0.2, times, "D9N", equal, (0.5, 0.4)) == [True, False, False]


def test_against_standing_still_the_measuring_time_counts():
    assert claimed(0.2, 0.1, (12.0, 1000.0), "Q5M") == [True]
    assert claimed(0.2, 0.1, (12.0, 12.0), "Q5M") == [False]


def test_values_are_rounded_to_two_digits_of_their_deviation():
    assert with_deviation(0.77256, 0.634) == "0.77 ± 0.63"
    assert with_deviation(31.8834, 0.0571) == "31.883 ± 0.057"
    assert with_deviation(131.88, 12.3) == "132 ± 12"


def test_models_side_by_side_show_what_the_methods_tell():
    """Of poses alone no inertia, and no word of motions that were not made."""
    table, note = _models(CASE, {5: disturbed("Q")[0].estimate})
    assert not any(row[0].startswith("IC") for row in table.rows)
    assert "480 poses" in note.text
    assert "hand-made" not in note.text
    table, note = _models(CASE, {9: disturbed("D")[0].estimate})
    assert any(row[0].startswith("IC33") for row in table.rows)
    assert "480 poses" not in note.text


def test_numbers_of_weights_are_chosen():
    assert mounted_weights(CASE, None) == (0, 1, 2, 3, 4, 5)
    assert mounted_weights(CASE, "0, 3,5") == (0, 3, 5)
    for wrong in ("1,2", "0,6", "0,x", "", "0,3,3", "0,5,3"):
        with pytest.raises(HexciteError, match="how many are mounted"):
            mounted_weights(CASE, wrong)


def test_errors_of_the_whole_body_are_told():
    assert set(disturbed("D")[1].budget.parts) == set(BODY)
    assert set(disturbed("Q")[1].budget.parts) == {"m", "xC", "yC", "zC"}


def test_the_command_prints_table_7_and_says_what_machine_it_was(tmp_path: Path, browser: Browser):
    answer = hexcite(
        "validate", "hexapod", "--methods", "Q5N", "--weights", "0,5", "-o", tmp_path / "v", "--json"
    ).json()
    assert answer["simulated"] is True
    assert "structural mode" in answer["machine"]
    assert answer["not_run"] == {}
    assert [row["weights"] for row in answer["rows"]] == [0, 5]
    for row in answer["rows"]:
        printed = Q5N[row["weights"]]
        assert printed / 1.5 < row["s0_N"] < printed * 1.5
        assert row["duration_s"] == pytest.approx(70.0, abs=2.0)
        assert abs(row["relative_deviation"]["m"]) < 0.02
    held = {p.name for p in (tmp_path / "v").iterdir()}
    assert held == {"report.html", "validation.json", "plots", "plans", "programs"}
    assert (tmp_path / "v" / "programs" / "Q5N.mpf").is_file()
    with opened(browser, Path(answer["report"]), 400) as tab:
        assert (tab.errors, tab.requests) == ([], [])
        assert "100 kg" in tab.page.locator("table").nth(1).inner_text()


class Stopped(Exception):
    """Something that ends a validation."""


@pytest.mark.slow
def test_an_interrupted_validation_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    words = ("hexapod", "Q5N", "0,3", None, Settings("virtual", 1, 0), False, tmp_path / "v", True)
    kept = tmp_path / "v.unfinished"

    def ends(by: BaseException) -> None:
        def steps(*_: object) -> NoReturn:
            raise by

        monkeypatch.setattr("planner.validation.experiment.steps", steps)
        with pytest.raises(type(by)) as raised:
            run_validation(*words)
        assert [p.name for p in tmp_path.iterdir()] == ["v.unfinished"]
        if isinstance(by, Interrupted):
            assert "kept in v.unfinished, the same command goes on" in str(raised.value)

    ends(Interrupted())
    plan = (kept / "plans" / "Q5N" / "plan.json").read_bytes()
    with monkeypatch.context() as patched:
        patched.setattr("planner.cli.poses.make_poses", None)  # nothing is planned again
        ends(Stopped())
    assert (kept / "plans" / "Q5N" / "plan.json").read_bytes() == plan
    monkeypatch.undo()
    done: list[int] = []

    def one_more(excitation: Excitation, mounted: Sequence[int], *others: object) -> Iterator[Step]:
        done.append(mounted[0])
        yield from steps(excitation, mounted[:1], *others)
        raise Interrupted

    monkeypatch.setattr("planner.validation.experiment.steps", one_more)
    for _ in range(2):
        with pytest.raises(Interrupted):
            run_validation(*words)
    assert done == [0, 3]
    monkeypatch.setattr("planner.validation.experiment.steps", None)  # nothing is executed or identified again
    monkeypatch.setattr("planner.cli.validate_runs._excitation", None)
    resumed = run_validation(*words)
    assert [p.name for p in tmp_path.iterdir()] == ["v"]
    assert (tmp_path / "v" / "plans" / "Q5N" / "plan.json").read_bytes() == plan
    monkeypatch.undo()
    at_once = run_validation(*words[:4], Settings("virtual", 1, 0, tmp_path / "v"), False, tmp_path / "w", True)
    assert resumed["rows"] == at_once["rows"]
    assert resumed["executed"] == at_once["executed"]


def test_a_finished_step_is_found_again_as_it_was(tmp_path: Path):
    (tmp_path / "steps").mkdir()
    heavy = FOUND.model_copy(update={"mode_Hz": 30.0} | NO_POSE_ERROR)
    (step,) = steps(moving(CASE), (0,), heavy)
    done = Kept("key", "virtual", step, remedy_of(moving(CASE), step, heavy))
    assert done.remedy is not None
    keep(tmp_path, done)
    assert kept_step(tmp_path, "D", 0, "key") == done
    assert kept_step(tmp_path, "D", 0, "another program's") is None
    assert kept_step(tmp_path, "D", 1, "key") is None
    (file,) = (tmp_path / "steps").iterdir()
    file.write_text(file.read_text(encoding="utf-8").replace('"load"', '"weight"'), encoding="utf-8")
    assert kept_step(tmp_path, "D", 0, "key") is None


def test_what_other_settings_left_behind_is_not_used(tmp_path: Path):
    def left(settings: Settings, make: bool) -> bool:
        with suppress(Stopped), unfinished(tmp_path / "v", CASE, settings) as folder:
            known = (folder / "plans" / "ptp" / "plan.json").is_file()
            if make:
                (folder / "plans" / "ptp").mkdir(exist_ok=True)
                (folder / "plans" / "ptp" / "plan.json").touch()
            raise Stopped
        return known

    assert not left(Settings("virtual", 2, 0), True)
    assert left(Settings("linuxcnc", 2, 0), True)  # plans are the same, whatever executes them
    assert not left(Settings("virtual", 2, 1), False)
    assert not (tmp_path / "v.unfinished").exists()  # nothing in it is worth keeping
    (tmp_path / "v.unfinished").mkdir()
    (tmp_path / "v.unfinished" / "diary.txt").touch()
    with pytest.raises(FileProblem, match=r"v\.unfinished: is not an unfinished validation .*diary\.txt"):
        left(Settings("virtual", 2, 0), False)


def test_a_run_is_kept_for_exactly_its_program(tmp_path: Path):
    kept = tmp_path / "p.npz"
    assert _kept("key", CASE, True, kept) is None
    t = np.arange(500) * 1e-3
    lengths = Hexapod.of(CASE).strut_lengths(Harmonic(seed=1, duration=0.5).at(t).pose)
    execution = StrutExecution.of_log(Hexapod.of(CASE), 1e-3, lengths)
    run = ExecutedRun("LinuxCNC 2.9", execution, np.array([[0.1, 0.4]]), real=True, remark="late")
    _keep(run, "key", kept)
    again = _kept("key", CASE, True, kept)
    assert again is not None
    assert (again.controller, again.remark, again.real) == ("LinuxCNC 2.9", "late", True)
    np.testing.assert_array_equal(again.trigger, run.trigger)
    for order in (0, 1, 2):
        np.testing.assert_array_equal(again.execution.struts(t, order), execution.struts(t, order))
    assert _kept("another program's", CASE, True, kept) is None


def test_what_a_run_follows_from_changes_its_key(tmp_path: Path):
    program = tmp_path / "p.ngc"
    keys = set()
    for text, case, on, disturbed in (
        ("G1 X1", CASE, "virtual", FOUND),
        ("G1 X2", CASE, "virtual", FOUND),
        ("G1 X1", CASE, "linuxcnc", FOUND),
        ("G1 X1", CASE, "virtual", None),
        ("G1 X1", changed(CASE, controller__virtual_look_ahead="block_limited"), "virtual", FOUND),
    ):
        program.write_text(text, encoding="ascii")
        keys.add(_key(program, case, Settings(on, 1, 0), disturbed))
    assert len(keys) == 5


def write_standstills(case: Case, file: Path, weights: int) -> None:
    """As a real machine would record it: struts and forces, a row a pose."""
    around = Circumstances(case.payloads.weights[:weights])
    recording = simulate_standstills(case, poses(), 1000, weights, around)
    struts = Hexapod.of(case).strut_lengths(poses()) * 1e3
    header = ",".join((*STRUTS, *(f"f{k}_N" for k in range(1, 7))))
    np.savetxt(file, np.hstack([struts, recording.forces]), delimiter=",", header=header, comments="", fmt="%.8f")


def test_recordings_of_a_machine_are_validated_without_knowing_its_truth(tmp_path: Path):
    (tmp_path / "runs" / "static").mkdir(parents=True)
    for k in range(3):
        write_standstills(CASE, tmp_path / "runs" / "static" / f"{k}.csv", k)
    answer = call("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "v", "--json").json()
    assert answer["simulated"] is False
    assert [row["method"] for row in answer["rows"]] == ["static"] * 3
    for row in answer["rows"]:
        assert row["error_in_std"] == {}
        assert abs(row["relative_deviation"]["m"]) < 5e-3
        assert abs(row["relative_deviation"]["f_q0_3"]) < 1e-3
    runs = ("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "w")
    assert "holds no folder of that name, but static" in refused(*runs, "--methods", "ptp")
    for option in (("--weights", "0"), ("--on", "linuxcnc"), ("--plans", tmp_path), ("--undisturbed",)):
        assert f"{option[0]}: nothing is simulated with --recordings" in refused(*runs, *option)
    (tmp_path / "runs" / "static" / "1.csv").unlink()
    assert "holds runs up to 2, but not 1" in refused(*runs, "--methods", "static")
    assert not (tmp_path / "w").exists()


def test_what_cannot_be_validated_is_refused(tmp_path: Path):
    assert "method 'Q6' is unknown" in refused("validate", "hexapod", "--methods", "Q6", "-o", tmp_path / "v")
    assert "name each once" in refused("validate", "hexapod", "--methods", "ptp,ptp", "-o", tmp_path / "v")
    assert "how many are mounted" in refused("validate", "hexapod", "--weights", "1", "-o", tmp_path / "v")
    assert "holds no plan" in refused(
        "validate", "hexapod", "--methods", "Q5N", "--plans", tmp_path, "-o", tmp_path / "v"
    )
    assert "payloads: is missing" in refused("validate", "ft_wrist", "-o", tmp_path / "v")
    (tmp_path / "runs" / "one").mkdir(parents=True)
    write_standstills(CASE, tmp_path / "runs" / "one" / "0.csv", 0)
    said = refused("validate", "hexapod", "--recordings", tmp_path / "runs", "-o", tmp_path / "v")
    assert "a validation needs at least 0 and 1" in said
    assert not (tmp_path / "v").exists()
