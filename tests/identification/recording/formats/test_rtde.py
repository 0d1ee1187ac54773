"""Recordings as the client of Universal Robots writes them: blanks between columns, names and radians of its own."""

from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.looks.looking import look
from identification.recording.recording import read
from tests.chains import swing, swung_forces

COLUMNS = {
    "t_s": "timestamp",
    **{f"q{k + 1}_deg": f"actual_q_{k}" for k in range(6)},
    **{name: f"ft_raw_wrench_{k}" for k, name in enumerate(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"))},
    "trigger": "actual_digital_output_bits",
}


def rtde_case() -> Case:
    data = load_case("ur10_wrist").model_dump(exclude_none=True)
    data["recording"] |= {"delimiter": " ", "units": {"joints": "rad"}, "columns": COLUMNS}
    return Case.model_validate(data)


def test_radians_names_and_the_output_bit_are_read(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    t = 17_000.0 + np.arange(400) / 500.0
    q, wrench = 0.3 * rng.normal(size=(2, 400, 6))  # joints that do not leap
    trigger = ((t > t[100]) & (t < t[300])).astype(int)
    rows = [
        " ".join([f"{t[k]:.6f}", *(repr(float(v)) for v in (*q[k], *wrench[k])), str(trigger[k])]) for k in range(400)
    ]
    file = tmp_path / "robot_data.csv"
    file.write_text("\n".join([" ".join(COLUMNS.values()), *rows]) + "\n")
    found = read(file, rtde_case())
    assert found.drives is not None
    assert found.t is not None
    np.testing.assert_allclose(found.drives, q, atol=1e-12)
    np.testing.assert_allclose(found.forces, wrench, atol=1e-12)
    np.testing.assert_array_equal(found.trigger, trigger == 1)
    assert np.diff(found.t) == pytest.approx(np.full(399, 0.002), abs=1e-6)


def test_a_joint_without_ends_is_read_through_its_turns(tmp_path: Path) -> None:
    """An encoder that begins anew after a turn says the same as one that counts turns; a gap in it does not matter."""
    data = load_case("ur10_wrist").model_dump(exclude_none=True)
    last = data["machine"]["chain"]["joints"][5]
    last["kind"] = last.pop("position_deg") and "continuous"
    case = Case.model_validate(data)
    t = np.arange(400) / 500.0
    q = np.zeros((400, 6))
    q[:, 5] = 500.0 * np.sin(6.0 * t)
    columns = [*case.drive_columns, "fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]

    def recorded(name: str, turned: np.ndarray) -> np.ndarray:
        text = [[f"{v:.9f}" for v in row] for row in np.column_stack([t, turned, np.ones((400, 6))])]
        text[50][6] = "nan"
        file = tmp_path / name
        file.write_text("\n".join([",".join(["t_s", *columns]), *map(",".join, text)]) + "\n", encoding="utf-8")
        return read(file, case).drives

    counted = recorded("counted.csv", q)
    wrapped = recorded("wrapped.csv", np.column_stack([q[:, :5], (q[:, 5] + 180.0) % 360.0 - 180.0]))
    np.testing.assert_allclose(wrapped, counted, atol=1e-9)


def test_a_look_takes_the_raw_wrench_and_no_commanded_joints_for_forces(tmp_path: Path) -> None:
    """Of all that the client records: the wrench of the sensor, not that which the robot has compensated."""
    t = np.arange(0.0, 8.0, 0.002)
    q, rates, _ = swing(t)
    wrench = swung_forces(t)
    groups = {"target_q": q, "target_qd": rates, "actual_q": q, "actual_qd": rates}
    groups |= {"actual_TCP_force": 0.01 * wrench, "ft_raw_wrench": wrench}
    names = ["timestamp", *(f"{name}_{k}" for name in groups for k in range(6)), "actual_digital_output_bits"]
    table = np.column_stack([t + 1000.0, *groups.values(), (t > 0.5) & (t < 7.5)])
    file = tmp_path / "robot_data.csv"
    np.savetxt(file, table, fmt=["%.6f"] * 37 + ["%d"], header=" ".join(names), comments="")
    found = look(file, load_case("ur10_wrist"))
    assert found.reads
    columns = found.settings["columns"]
    assert {ours: columns[ours] for ours in COLUMNS} == COLUMNS
    assert set(columns) == set(COLUMNS)
    assert found.settings["units"] == {"joints": "rad"}
