"""Tables of setpoints: time is exact, rows follow from each other, struts belong to poses; anything else is refused."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import CaseError, ProgramError
from cases.base.units import DEG, MM
from cases.schema import load_case
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import StraightMove
from postprocessors.blocks import Blocks, ToHome, Trigger
from postprocessors.controllers.virtual import run_virtual
from postprocessors.dialects.setpoints.write import write_setpoints
from postprocessors.excitation import excitation_program
from postprocessors.program import dialect, leaving_out
from postprocessors.proof.proof import ProgramProof, prove_program
from postprocessors.reading import Still, Timed
from postprocessors.writing import proven_program
from tests.helpers import examples, one_line
from tests.postprocessors.changed_case import changed
from tests.postprocessors.independent import strut_lengths
from tests.postprocessors.programs import HOME
from tests.postprocessors.tables import COLUMNS, cells

CASE = load_case("hexapod")
COARSE = changed(CASE, controller__setpoints__cycle_ms=4.0)
LANGUAGE = dialect("setpoints")


def proof(content: bytes, case=CASE) -> ProgramProof:
    reading = LANGUAGE.read(content, "t", case)
    return prove_program(reading, LANGUAGE.guarantees(reading, case))


def moves(case=CASE) -> Blocks:
    """There and back at the limits of the case, the way back with the trigger off."""
    box = case.limits.motion
    limits = box.rate, box.acceleration, box.jerk
    far = HOME + np.r_[np.array([20.0, -15.0, 3.0]) * MM, np.array([1.0, 0.5, -2.0]) * DEG]
    there, back = StraightMove.fastest(HOME, far, *limits), StraightMove.fastest(far, HOME, *limits)
    ends = (Standstill(far, 0.0053), Trigger(False))
    return ("a note", "Größe", ToHome(HOME, 0.05), Standstill(HOME, 0.01), Trigger(True), there, *ends, back)


def harmonic() -> Blocks:
    from planner.families.fourier import FourierFamily

    motion = FourierFamily(2, 1.0, 1, HOME, np.full(6, 0.05)).motion(np.random.default_rng(0).normal(size=18) / 30)
    return excitation_program(motion, CASE)


def test_moves_at_the_limits_are_proven_to_the_last_digit():
    """Rows at whole cycles slow each motion by less than one of them; nothing is rounded over a limit."""
    result = proof(write_setpoints(moves(), CASE))
    assert result.ok
    kinds = {str(c.of): c for c in result.limits.checks}
    assert 0.97 < kinds["jerk"].ratio <= 1.0 + 1e-6
    assert all(str(c.status) == "proven" for c in kinds.values())


def test_a_move_that_no_control_could_tell_apart_stays_where_points_are_followed():
    """Programs of blocks leave it out; a table would leap by its way, 30 nm."""
    box = CASE.limits.motion
    limits = box.rate, box.acceleration, box.jerk
    far = HOME + np.r_[np.array([20.0, -15.0, 3.0]) * MM, np.array([1.0, 0.5, -2.0]) * DEG]
    places = (HOME, far, far + np.r_[3e-5 * MM, np.zeros(5)], HOME)
    motion = Joined(tuple(StraightMove.fastest(a, b, *limits) for a, b in pairwise(places)))
    assert proven_program(motion, CASE, LANGUAGE, "t.csv", ()).proof.ok


def test_a_path_that_stands_within_is_read_back_row_by_row():
    """A curve that rests between its pieces: the reader has two paths with a standstill between them."""
    ease = (np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0]) / 0.4 ** np.arange(6.0))[:, None]
    way = np.r_[np.array([4.0, -3.0, 2.0]) * MM, np.zeros(3)]
    there, stay = ease * way, np.zeros((6, 6))
    there[0], stay[0] = HOME, HOME + way
    motion = PolynomialMotion.of_pieces([(there, 0.4), (stay, 0.3), (stay - ease * way, 0.4)])
    program = proven_program(motion, CASE, LANGUAGE, "t.csv", ())
    excitation = [part for part in program.reading.stretches if part.trigger]
    assert [type(part) for part in excitation].count(Timed) == 2
    table = cells(program.content)
    on = table[table[:, -1] == 1.0]
    np.testing.assert_allclose(on[[0, 400, 699], 1] - 1e3 * HOME[0], [0.0, 4.0, 4.0], atol=1e-8)


@pytest.mark.parametrize("case", [CASE, COARSE], ids=["1 ms", "4 ms"])
def test_time_is_exact_up_to_one_cycle_a_motion(case):
    program = moves()
    read = LANGUAGE.read(write_setpoints(program, case), "t", case).stretches
    cycle = case.controller.setpoints.cycle
    planned = [b.duration for b in program if isinstance(b, StraightMove | Standstill)]
    found = [s.points.duration if isinstance(s, Timed) else s.duration for s in read]
    for wanted, got in zip(planned, found, strict=True):
        assert wanted - 1e-9 <= got < wanted + cycle
        assert got / cycle == pytest.approx(round(got / cycle), abs=1e-6)
    assert [s.trigger for s in read] == [False, True, True, False]


def test_a_plan_reads_back_as_itself():
    program = harmonic()
    read = LANGUAGE.read(write_setpoints(program, CASE), "t", CASE).stretches
    excitation = next(s for s in read if s.trigger and not isinstance(s, Still))
    source = next(b.motion for b in program if getattr(b, "name", "") == "excitation")
    t = np.linspace(0.0, 1.0, 501)
    found, exact = excitation.points.at(t), source.at(t)
    assert excitation.points.duration == pytest.approx(source.duration, abs=1e-9)
    assert np.abs(found.coordinates - exact.coordinates).max() < 1e-8
    assert np.abs(found.rates - exact.rates).max() < 1e-4


def test_struts_are_those_of_the_definition_and_their_derivatives_of_the_rows():
    table = cells(write_setpoints(harmonic(), CASE))
    get = lambda names: table[:, [COLUMNS.index(n) for n in names]]  # noqa: E731
    pose = get(COLUMNS[1:7]) * np.r_[np.full(3, MM), np.full(3, DEG)]
    length = get([f"l{k}_mm" for k in range(1, 7)]) * MM
    assert np.abs(length - strut_lengths(pose, CASE)).max() < 1e-11
    velocity, acceleration = (get([f"{d}{k}_mm_s{p}" for k in range(1, 7)]) * MM for d, p in (("ld", ""), ("ldd", "2")))
    assert np.abs((length[2:] - length[:-2]) / 2e-3 - velocity[1:-1]).max() < 2e-5
    assert np.abs((velocity[2:] - velocity[:-2]) / 2e-3 - acceleration[1:-1]).max() < 0.05


def test_what_is_proven_can_be_run():
    reading = LANGUAGE.read(write_setpoints(moves(), CASE), "t", CASE)
    run = run_virtual(reading, LANGUAGE.guarantees(reading, CASE))
    assert run.trigger.shape == (1, 2)
    assert np.isfinite(run.execution.drives(np.linspace(0.0, run.execution.duration, 50))).all()


def edited(row: int, column: str, change) -> bytes:
    """The table of `moves` with one cell changed; rows count from the first one."""
    lines = write_setpoints(moves(), CASE).decode().split("\n")
    k = next(k for k, line in enumerate(lines) if line.startswith("t_s")) + 1 + row
    cells = lines[k].split(",")
    j = COLUMNS.index(column)
    cells[j] = change(cells[j])
    lines[k] = ",".join(cells)
    return "\n".join(lines).encode()


def plus(step: float):
    return lambda cell: f"{float(cell) + step:.12f}"


def test_a_path_timed_without_jerk_follows_from_itself():
    """Its accelerations change faster than the case's limits of jerk, here and there within a cycle."""
    from planner.families.fourier import FourierFamily
    from planner.retiming import as_fast_as_possible

    slow = FourierFamily(2, 2.0, 1, HOME, np.full(6, 0.05)).motion(np.random.default_rng(0).normal(size=18) / 30)
    motion, _ = as_fast_as_possible(slow, CASE, "path", "jerk")
    program = proven_program(motion, CASE, LANGUAGE, "path.csv", leaving_out(["jerk"]))
    content = program.content
    assert program.proven is not None
    assert program.proven.without == ("jerk",)
    rows = content.decode().split("\n")
    first = rows.index(",".join(COLUMNS)) + 1
    cells = rows[first + 500].split(",")
    cells[COLUMNS.index("y_mm")] = plus(1e-3)(cells[COLUMNS.index("y_mm")])
    with pytest.raises(ProgramError, match=r"y_mm = .* does not follow"):
        proof("\n".join([*rows[: first + 500], ",".join(cells), *rows[first + 501 :]]).encode())


@pytest.mark.parametrize(
    ("row", "column", "change", "words"),
    [
        (40, "x_mm", plus(1e-3), "x_mm = .* does not follow from the row before"),
        (40, "v_b_deg_s", plus(1.0), "v_b_deg_s = .* does not follow"),
        (40, "c_deg", plus(1e-3), "c_deg = .* does not follow"),
        (40, "acc_x_mm_s2", plus(500.0), "does not follow"),
        (40, "l3_mm", plus(1e-4), "l3_mm = .* is not what the pose and its derivatives give"),
        (40, "ld3_mm_s", plus(0.1), "ld3_mm_s = .* the pose"),
        (40, "ldd6_mm_s2", plus(1.0), "ldd6_mm_s2 = .* the pose"),
        (40, "t_s", plus(1e-4), "t_s = .* where rows begin at 0 and follow each 1 ms"),
        (0, "x_mm", plus(1e-3), "x_mm = "),
        (0, "v_x_mm_s", plus(1e-3), "must begin and end at rest"),
        (40, "trigger", lambda c: "0", "trigger = 0 in motion"),
        (40, "trigger", lambda c: "2", "trigger = 2 is neither 0 nor 1"),
        (40, "y_mm", lambda c: "1e3", "'1e3' where a row is 38 plain numbers"),
        (40, "y_mm", lambda c: "nan", "'nan' where a row"),
        (40, "y_mm", lambda c: "", "'' where a row"),
        (40, "y_mm", lambda c: "1.2.3", "'1.2.3' where a row"),
        (40, "y_mm", lambda c: "1,2", "'39 cells' where a row"),
        (40, "y_mm", lambda c: "99999999", "y_mm = 99999999 is not a number of a machine's size"),
    ],
)
def test_a_row_that_is_edited_is_named(row: int, column: str, change, words: str):
    with pytest.raises(ProgramError, match=words) as caught:
        proof(edited(row, column, change))
    first = write_setpoints(moves(), CASE).decode().split("\n").index(",".join(COLUMNS)) + 2
    assert caught.value.line in (first + row, first + row + 1)
    one_line(caught.value)


def test_a_table_for_another_cycle_home_or_machine_is_refused():
    content = write_setpoints(moves(), CASE)
    with pytest.raises(ProgramError, match=r"each 4 ms.*cycle"):
        proof(content, COARSE)
    with pytest.raises(ProgramError, match=r"z_mm = .* not at home"):
        proof(content, changed(CASE, machine__home={**CASE.machine.home.model_dump(), "z_mm": 901.0}))
    ring = {"radius_mm": 701.0, "half_angle_deg": 12.0, "pair_centres_deg": (90.0, 210.0, 330.0), "z_mm": 0.0}
    with pytest.raises(ProgramError, match=r"l1_mm = .* the pose"):
        proof(content, changed(CASE, machine__base={"ring": ring}))
    with pytest.raises(ProgramError, match="the controller's memory holds 20"):
        proof(content, changed(CASE, controller__setpoints__most_rows=20))


def test_a_limit_that_is_passed_is_named_with_its_row():
    tight = changed(CASE, limits__motion__velocity_mm_s=(100.0, 100.0, 100.0), controller__safe_feed_mm_min=300.0)
    result = proof(write_setpoints(moves(), CASE), tight)
    assert not result.ok
    with pytest.raises(ProgramError, match=r"t, line \d+: velocity \(x\) reaches"):
        result.require()


def test_a_case_without_the_table_is_told_so():
    case = CASE.model_copy(update={"controller": CASE.controller.model_copy(update={"setpoints": None})})
    for work in (lambda: write_setpoints(moves(), case), lambda: LANGUAGE.read(b"x", "t", case)):
        with pytest.raises(CaseError, match=r"controller\.setpoints: .*missing.*dialect setpoints"):
            work()


def test_a_table_without_any_motion_is_a_standstill():
    program = (ToHome(HOME, 0.05), Standstill(HOME, 0.01))
    assert [type(s) for s in LANGUAGE.read(write_setpoints(program, CASE), "t", CASE).stretches] == [Still]
    with pytest.raises(ProgramError, match="contains no motion"):
        proof(write_setpoints(program, CASE))
    assert Standstill(HOME, 0.01).duration == 0.01


@settings(max_examples=examples(15))
@given(position=st.floats(0.0, 0.999), byte=st.integers(0, 255), kind=st.sampled_from("rdi"))
def test_a_damaged_table_ends_in_a_proof_or_in_one_line(position: float, byte: int, kind: str):
    content = write_setpoints(moves(), CASE)
    k = int(position * len(content))
    middle = {"r": bytes([byte]), "d": b"", "i": bytes([byte, content[k]])}[kind]
    try:
        assert np.isfinite(proof(content[:k] + middle + content[k + 1 :]).duration)
    except ProgramError as error:
        assert one_line(error).startswith("t")


def test_a_table_that_breaks_off_behind_its_last_name_is_refused_in_one_line():
    content = write_setpoints(moves(), CASE)
    names = next(line for line in content.split(b"\n") if not line.startswith(b"#"))
    with pytest.raises(ProgramError, match="the file is truncated"):
        proof(content[: content.index(names) + len(names)])


@settings(max_examples=examples(10))
@given(position=st.floats(0.0, 0.999))
def test_a_table_that_breaks_off_is_refused(position: float):
    content = write_setpoints(moves(), CASE)
    with pytest.raises(ProgramError):
        proof(content[: int(position * (len(content) - 1))])
