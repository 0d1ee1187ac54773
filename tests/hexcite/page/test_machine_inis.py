"""Programs of the page beside the INI file of a LinuxCNC machine."""

from pathlib import Path

import pytest
from starlette.testclient import TestClient

import hexcite as hx
from cases.base.errors import FileProblem, HexciteError
from cases.schema import load_case
from hexcite.page.actions.common import Context
from hexcite.page.actions.table import ACTIONS, asked
from hexcite.page.forms import ini_in
from hexcite.page.jobs import Jobs
from hexcite.page.journal import Journal
from hexcite.page.machine_inis import includes_beyond, inis
from hexcite.page.refusals import Unfit
from hexcite.page.stages import machine_of, workspace
from hexcite.page.views.data import shown
from planner.plans.plan import Plan
from postprocessors.controllers.linuxcnc.configuration import ini_text

LINUXCNC = {"dialect": ["linuxcnc"]}
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


def test_a_rehearsal_on_linuxcnc_takes_the_ini_of_the_program(root: Path, plan: Plan):
    plan.save(root / "plan")
    hx.write(plan, "linuxcnc", file=root / "made.ngc", accept=ACCEPT).save(root / "made.ngc")
    (root / "mill.ini").write_text("[TRAJ]\nLINEAR_UNITS = mm\n")
    machine = machine_of(root, "hexapod")
    assert machine is not None
    written = asked(
        ACTIONS["program"], Context(root, machine, Jobs(root)), {"plan": ["plan"], "ini": ["mill.ini"]} | LINUXCNC
    )
    assert ini_in(written.command) == "mill.ini"
    written.state = "done"
    Journal(root).write("1-1-1", written.record)
    context = Context(root, machine, Jobs(root))
    assert shown(context, workspace(root, machine), {})["ini"] == "mill.ini"
    fields = {"program": ["made.ngc"], "ini": ["mill.ini"]}
    assert ini_in(asked(ACTIONS["rehearse"], context, fields | {"on": ["linuxcnc"]}).command) == "mill.ini"
    assert ini_in(asked(ACTIONS["rehearse"], context, fields | {"on": ["virtual"]}).command) == ""
    (root / "mill.ini").write_text("#INCLUDE /etc/passwd\n")
    with pytest.raises(Unfit, match="includes files"):
        asked(ACTIONS["rehearse"], context, fields | {"on": ["linuxcnc"]})
