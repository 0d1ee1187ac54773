"""The real controller measures at poses: LinuxCNC runs the program, its trigger marks the standstills."""

from pathlib import Path

import pytest

from tests.hexcite.command_line import call

COUNT = 5


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_poses_run_on_linuxcnc_are_identified(tmp_path: Path) -> None:
    plan, program, run = tmp_path / "plan", tmp_path / "poses.ngc", tmp_path / "run"
    call("poses", "hexapod", "--count", COUNT, "--method", "backward", "-o", plan, "--json").json()
    call("post", plan, "--accept", "jerk,strut-acceleration", "-o", program, "--json").json()
    answer = call("run", program, "--case", "hexapod", "--on", "linuxcnc", "-o", run, "--json").json()
    assert answer["poses"] == COUNT
    assert answer["path_error_mm"] < 0.01
    result = call("identify", run, "--poses", plan, "-o", tmp_path / "result", "--json").json()
    assert result["standstills"]["count"] == COUNT
    for name, truth in {"m": 31.83, "k0": 24.05, "f_q0_3": 328.38}.items():
        found = result["parameters"][name]
        assert abs(found["value"] - truth) < 5.0 * found["std"]
