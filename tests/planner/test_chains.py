"""Chains of five, six and seven joints, one on a rail: planned, written, run and identified as hexapods are."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import CaseError, HexciteError, IdentificationError
from cases.recording_format import WRENCH
from cases.schema import Case, load_case
from hexcite._demo import demo
from hexcite._run import execute
from hexcite._write import write
from hexcite.reports.plan import plan_page
from identification.identify import identify
from identification.limits.chain import chain_frames, sensor_motion
from identification.limits.proof import prove
from identification.machines.casadi_batch import over_samples
from identification.machines.serial_chain import SerialChain
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters
from identification.motion.motion import Motion, StandingPoses
from identification.recording.recording import Recording, read
from identification.simulate import truth_rows
from planner.bounds.bound import compute_bound
from planner.families.ptp import shortest_phase
from planner.families.settings import FamilySettings, Fourier, PointToPoint, Spline
from planner.plans.making import make
from planner.plans.plan import Plan
from planner.request import Request
from planner.search.parallel import run_here, silent
from tests.chains import chain_case
from tests.helpers import few
from tests.hexcite.command_line import call, refused

PLANS: dict[int, FamilySettings] = {5: PointToPoint(moves=8), 6: Fourier(order=3), 7: Spline(knots=40)}


class Plans(dict[int, Plan]):
    """Plans by the number of joints, each made when it is asked for, saved and loaded."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __missing__(self, joints: int) -> Plan:
        plan = make(Request(PLANS[joints], 3.0, starts=1, model=6), chain_case(joints), silent, run_here)
        plan.save(self.folder / str(joints))
        self[joints] = Plan.load(self.folder / str(joints), chain_case(joints))
        return self[joints]


@pytest.fixture(scope="module")
def plans(tmp_path_factory: pytest.TempPathFactory) -> Plans:
    return Plans(tmp_path_factory.mktemp("plans"))


@pytest.mark.slow
def test_phases_of_moves_are_absent_or_last_as_long_as_their_controller_needs(plans: Plans) -> None:
    """What a solver leaves of an absent phase is some microseconds, for which no program has room."""
    motion: Any = plans[5].motion
    case, parts = chain_case(5), motion.parts
    phases = np.array([part.profile.lengths for part in parts])
    shortest = shortest_phase(case.controller.cycle)
    assert np.all((phases == 0.0) | (phases >= shortest * (1 - 1e-6)))
    assert sum(part.duration for part in parts) == pytest.approx(3.0, rel=1e-12)


class Runs(dict[int, Recording]):
    """Runs of these plans as tables of set points, each executed when it is asked for."""

    def __init__(self, plans: Plans) -> None:
        self.plans = plans

    def __missing__(self, joints: int) -> Recording:
        program = write(self.plans[joints], "setpoints")
        assert program.proof.ok
        assert program.text.splitlines()[-1].count(",") == 1 + 3 * joints  # time, three times the joints, trigger
        self[joints] = execute(program, self.plans[joints].case, "virtual", seed=joints)[1]
        return self[joints]


@pytest.fixture(scope="module")
def runs(plans: Plans) -> Runs:
    return Runs(plans)


@pytest.mark.parametrize("joints", PLANS)
def test_proof_and_search_move_the_sensor_alike(joints: int):
    """Homogeneous frames in NumPy and the recursion in CasADi share no line."""
    case = chain_case(joints)
    home, box = case.need_motion("a test")
    draw = np.random.default_rng(joints)
    q = home + draw.uniform(*box.coordinates, (50, joints))
    rates, accelerations = draw.uniform(-3.0, 3.0, (2, 50, joints))
    none = np.zeros_like(q)
    motion = Motion(np.arange(50.0), q, rates, accelerations, none)
    (turn, first, second), acceleration = sensor_motion(chain_frames(motion, case.chain))
    _, columns, twist, twist_rate = over_samples(SerialChain.of(case).motion, q, rates, accelerations)
    np.testing.assert_allclose(turn, columns.reshape(-1, 3, 3).transpose(0, 2, 1), atol=1e-12)
    np.testing.assert_allclose(acceleration, twist_rate[:, :3], atol=1e-11)
    spin = first @ turn.transpose(0, 2, 1)
    np.testing.assert_allclose(spin[:, [2, 0, 1], [1, 2, 0]], twist[:, 3:], atol=1e-11)
    change = second @ turn.transpose(0, 2, 1) + first @ first.transpose(0, 2, 1)
    np.testing.assert_allclose(change[:, [2, 0, 1], [1, 2, 0]], twist_rate[:, 3:], atol=1e-11)


@pytest.mark.parametrize("joints", few(6, 5, 7))
@pytest.mark.repeats
def test_a_plan_keeps_every_limit_and_rests_at_both_ends(joints: int, plans: Plans):
    plan = plans[joints]
    report = prove(plan.motion, plan.case)
    assert report.kept
    assert report.worst_ratio > 0.95
    names = {str(check.of) for check in report.checks}
    assert {"angle", "angular velocity", "angular acceleration", "angular jerk", "joint angle"} <= names
    assert {"sensor force", "sensor moment"} <= names
    assert ("acceleration" in names) == (joints == 7)  # of the rail
    ends = plan.motion.at([0.0, plan.duration])
    assert ends.coordinates.shape == (2, joints)
    np.testing.assert_allclose(ends.rates, 0.0, atol=1e-9)


@pytest.mark.repeats
@pytest.mark.parametrize("joints", few(6, 5, 7))
def test_a_plan_is_far_better_than_chance_and_below_its_bound(joints: int, plans: Plans):
    plan = plans[joints]
    worth = plan.of_motion[1]
    assert not worth.bound.certified
    assert 0.05 < worth.d_efficiency < 1.0


@pytest.mark.repeats
def test_the_page_warns_of_nothing_that_nobody_can_change(plans: Plans):
    """No bound of a chain is proven, whatever its user does."""
    plan = plans[6]
    page = plan_page(plan)
    (verdict,) = re.findall(r'(?s)<p class="verdict.*?</p>', page)
    assert "bound" not in verdict
    assert "estimate" not in verdict
    assert "(an estimate)" in page


@pytest.mark.repeats
def test_the_bound_holds_for_random_designs():
    case = chain_case(6)
    model = identification_model(case, 6)
    bound = compute_bound(case, model, time_limit=20.0)
    assert bound.dmax == pytest.approx(16.0, rel=0.02)  # the equivalence theorem: u at the best design
    assert bound.design_logdet <= bound.logdet < bound.design_logdet + 0.2


@pytest.mark.parametrize("joints", few(6, 5, 7))
def test_a_run_gives_the_true_parameters_within_their_deviations(joints: int, plans: Plans, runs: Runs):
    plan, recording = plans[joints], runs[joints]
    executed = recording.executed
    assert executed.path_error_mm < 1.0
    assert executed.d_efficiency == pytest.approx(executed.d_efficiency_planned, rel=0.02)
    result = identify(recording, plan.case)
    assert result.estimate is not None
    assert result.estimate.model.number == 6
    rows = truth_rows(plan.case, result.estimate)
    assert len(rows) == 16
    assert max(abs(row["error"] / row["std"]) for row in rows) < 4.0
    delay = result.estimate.delay
    assert delay is not None
    assert delay.value == pytest.approx(4e-3, abs=4.0 * delay.std + 1e-4)  # 3 ms and half a cycle
    predicted = np.array([row["std"] / plan.predicted_std[row["name"]] for row in rows])
    assert 0.8 < np.exp(np.mean(np.log(predicted))) < 1.6


def test_recordings_of_joints_are_read_back(runs: Runs, tmp_path: Path):
    recording = replace(runs[6], case=load_case("ur10_wrist"))
    recording.save(tmp_path / "run")
    head = (tmp_path / "run" / "recording.csv").read_text().split("\n", 1)[0]
    joints = [f"q{k}_deg" for k in range(1, 7)]
    assert head.replace('"', "").split(",") == ["t_s", *joints, *WRENCH, "trigger"]
    again = Recording.load(tmp_path / "run")
    np.testing.assert_allclose(again.drives, recording.drives, atol=1e-9)
    np.testing.assert_allclose(again.forces, recording.forces, atol=1e-6)


def test_a_step_of_the_gravity_is_felt_by_a_chain_that_hangs(plans: Plans):
    """Turned upside down, the same joints make other forces: gravity counts in {B}."""
    case = chain_case(6)
    down = case.model_copy(update={"gravity_m_s2": (0.0, 0.0, 9.81)})
    model, other = identification_model(case, 6), identification_model(down, 6)
    home = case.need_motion("a test")[0]
    still = np.zeros_like(home)
    upright, hanging = (m.coordinate_regressor(home, still, still).full() for m in (model, other))
    np.testing.assert_allclose(upright[:, 0], -hanging[:, 0])
    assert abs(upright[2, 0]) == pytest.approx(9.81)  # the flange points down


def test_a_chain_that_turns_about_one_axis_names_what_it_cannot_identify():
    case = chain_case(6)
    data = case.model_dump(mode="json", exclude_unset=True)
    data["machine"]["chain"]["joints"] = data["machine"]["chain"]["joints"][:1]
    data["limits"]["motion"]["joints"] = data["limits"]["motion"]["joints"][:1]
    upright = Case.model_validate(data).found_at("ur10_wrist")  # it turns about the vertical alone
    with pytest.raises(HexciteError, match=r"any motion in this box.*mzC.* not determined"):
        make(Request(Fourier(order=3), 4.0, starts=1, model=6), upright, silent, run_here)


@pytest.mark.parametrize("number", [1, 5, 9])
def test_error_terms_of_a_platform_are_refused(number: int):
    with pytest.raises(IdentificationError, match=r"K1 to K5.*choose model 6"):
        identification_model(chain_case(6), number)


@pytest.mark.parametrize("dialect", ["sinumerik", "twincat"])
def test_languages_of_hexapods_are_refused_in_one_line(dialect: str, plans: Plans):
    with pytest.raises(CaseError) as caught:
        write(plans[6], dialect)
    assert "\n" not in str(caught.value)


def test_a_plan_of_other_joints_is_refused(plans: Plans, tmp_path: Path):
    plans[6].save(tmp_path / "six")
    with pytest.raises(HexciteError, match="not have the 7 coordinates"):
        Plan.load(tmp_path / "six", chain_case(7))


def test_sensors_too_weak_for_the_load_at_rest_are_named():
    data = chain_case(6).model_dump(mode="json", exclude_unset=True)
    data["sensors"]["range_N"] = 20.0
    weak = Case.model_validate(data).found_at("ur10_wrist")
    with pytest.raises(HexciteError, match=r"sensor force .* limit .*16; .*sensors\.range_N"):
        make(Request(PointToPoint(moves=8), 4.0, starts=1, model=6), weak, silent, run_here)


def test_standing_outside_a_joints_end_is_reported():
    case = chain_case(6)
    home = case.need_motion("a test")[0]
    away = home.copy()
    away[2] = np.deg2rad(-200.0)
    report = prove(StandingPoses(np.array([home, away])), case, 1.0, in_box=False)
    assert [check.name for check in report.violations] == ["joint angle (elbow)"]


@pytest.mark.slow
def test_the_demo_of_the_robot_is_right_within_its_deviations(tmp_path: Path):
    done = demo(load_case("ur10_wrist"), tmp_path / "demo", "virtual")
    assert done.worst < 4.0
    assert (tmp_path / "demo" / "excitation.csv").is_file()  # set points, for the virtual controller


def test_averaged_standstills_of_a_chain_give_mass_and_offsets(tmp_path: Path):
    case = load_case("ur10_wrist")
    rigid = identification_model(case, 6)
    truth = linear_parameters(rigid, case.need_simulation("a test").parameters)
    home, box = case.need_motion("a test")
    draw = np.random.default_rng(0)
    lines = [",".join((*case.drive_columns, *WRENCH))]
    for _ in range(12):
        q, still = home + draw.uniform(*box.coordinates), np.zeros_like(home)
        forces = (rigid.coordinate_regressor(q, still, still).full() @ truth).ravel()
        lines.append(",".join(f"{v:.9f}" for v in (*np.rad2deg(q), *forces)))
    file = tmp_path / "standing.csv"
    file.write_text("\n".join(lines) + "\n")
    result = identify(read(file, case), case)
    assert result.estimate is not None
    assert result.estimate.model.number == 0
    assert result["m"].value == pytest.approx(2.61, abs=1e-6)
    assert result["f_q0_5"].value == pytest.approx(-0.22, abs=1e-6)


@pytest.mark.parametrize("name", ["ur10_wrist", "five_axis_table"])
def test_a_chain_is_drawn_with_its_joints(name: str, tmp_path: Path):
    assert call("case", "show", name, "-o", tmp_path / "chain.svg").code == 0
    text = (tmp_path / "chain.svg").read_text(encoding="utf-8")
    labels = ", ".join(re.findall("<!-- (.*) -->", text)).split(", ")  # joints at one place are named together
    assert set(labels) >= set(load_case(name).chain.names)


@pytest.mark.parametrize("command", ["validate ur10_wrist", "validate strut_sensors"])
def test_a_validation_says_in_one_line_which_machines_it_is_for(command: str):
    assert "platform" in refused(*command.split())


def test_a_home_inside_a_box_is_one_line_for_every_command(tmp_path: Path):
    text = (Path("cases") / "ur10_wrist" / "case.toml").read_text(encoding="utf-8")
    file = tmp_path / "case.toml"
    file.write_text(text.replace("z_mm = [-500.0, -10.0]", "z_mm = [-500.0, 700.0]"), encoding="utf-8")
    for command in (("case", "check"), ("plan",), ("poses",)):
        assert "distance from floor" in refused(*command, file)


def test_a_chain_that_cannot_turn_its_load_is_named_by_every_command_that_would_need_it(tmp_path: Path):
    """The base joint alone turns it about the vertical: where its centre of gravity is along it changes nothing."""
    lines = (Path("cases") / "ur10_wrist" / "case.toml").read_text(encoding="utf-8").splitlines()
    others = ("shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3")
    kept = [line for line in lines if not line.strip().startswith(tuple(f'{{ name = "{name}"' for name in others))]
    file = tmp_path / "case.toml"
    file.write_text("\n".join(kept), encoding="utf-8")
    for command in ("plan", "bound", "poses"):
        assert "mzC" in refused(command, file)
