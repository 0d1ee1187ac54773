"""Programs of the page beside the INI file of a LinuxCNC machine."""

from pathlib import Path

import pytest
from starlette.testclient import TestClient

import hexcite as hx
from cases.base.errors import FileProblem, HexciteError
from cases.schema import load_case
from hexcite.page.machine_inis import includes_beyond, inis
from planner.plans.plan import Plan
from postprocessors.controllers.linuxcnc.configuration import ini_text

ACCEPT = ("jerk", "strut acceleration", "sensor force")


@pytest.fixture(scope="module")
def plan() -> Plan:
    return hx.plan(load_case("hexapod"), hx.Manual())


def test_a_program_is_written_beside_the_ini_of_its_machine_and_refused_beside_another(plan: Plan, tmp_path: Path):
    own, other = tmp_path / "own.ini", tmp_path / "other.ini"
    text = ini_text(plan.case, 1.0)
    own.write_text(text)
    other.write_text(text.replace("MAX_VELOCITY = ", "MAX_VELOCITY = 9"))
    assert hx.write(plan, "linuxcnc", ini=own, accept=ACCEPT).proof.ok
    with pytest.raises(FileProblem) as caught:
        hx.write(plan, "linuxcnc", ini=other, accept=ACCEPT)
    assert str(other) in caught.value.place
    with pytest.raises(HexciteError, match="is not a LinuxCNC program"):
        hx.write(plan, "setpoints", ini=own)


def test_the_page_offers_inis_of_its_folder_and_none_that_leads_out_of_it(client: TestClient, root: Path):
    assert client.put("/upload/mill.ini", content=b"[TRAJ]\nLINEAR_UNITS = mm\n").status_code == 200
    (root / "away.ini").symlink_to("/etc/hostname")
    assert inis(root) == ["mill.ini"]
    assert not includes_beyond(root, "mill.ini")
    for line in ("#INCLUDE /etc/passwd", "  #INCLUDE ../more.inc", "#INCLUDE ~/more.inc"):
        (root / "mill.ini").write_text(f"[TRAJ]\n{line}\n")
        assert includes_beyond(root, "mill.ini"), line
    (root / "mill.ini").write_text("#INCLUDE more.inc\n")
    assert not includes_beyond(root, "mill.ini")
