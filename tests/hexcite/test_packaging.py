"""The wheel holds the five packages with their data and nothing else, and works outside the checkout."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("hexcite", "cases", "identification", "planner", "postprocessors")
DATA = (
    "cases/hexapod/case.toml",
    "cases/hexapod/validation.toml",
    "cases/ft_wrist/case.toml",
    "cases/py.typed",
    "hexcite/py.typed",
    "planner/py.typed",
    "hexcite/reports/templates/page.html",
    "hexcite/reports/templates/page.css",
    "hexcite/reports/templates/page.js",
    "hexcite/page/templates/machine.html.jinja",
    "hexcite/page/templates/page.css",
    "hexcite/page/templates/page.js",
    "postprocessors/controllers/linuxcnc/warp.c",
    "postprocessors/controllers/linuxcnc/driver.py",
    "postprocessors/export/calibration.schema.json",
    "postprocessors/export/templates/component.comp.jinja",
    "postprocessors/export/templates/declarations.c.jinja",
    "postprocessors/export/templates/definitions.c.jinja",
    "postprocessors/export/templates/header.h.jinja",
    "postprocessors/export/templates/model.st.jinja",
    "postprocessors/export/templates/source.c.jinja",
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    (file,) = folder.glob("hexcite-*.whl")
    return file


@pytest.fixture(scope="module")
def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of a new environment with the wheel; dependencies come from this one's, by a path at the end."""
    folder = tmp_path_factory.mktemp("environment") / "new"
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    quiet = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-index"]
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", *quiet, str(wheel)]
    subprocess.run(pip, check=True, capture_output=True, timeout=600)
    (site,) = folder.glob("lib/python*/site-packages")
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python


def run(*command: str | Path, cwd: Path) -> str:
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_nothing_but_the_packages_ships(names: set[str]):
    tops = {name.split("/")[0] for name in names}
    assert {t for t in tops if not t.endswith(".dist-info")} == set(PACKAGES)
    (about,) = tops - set(PACKAGES)
    assert about.startswith("hexcite-")
    tests = {n for n in names if any(part.startswith("test") for part in n.lower().split("/"))}
    assert [n for n in names if n.endswith((".png", ".pyc", ".so")) or n in tests] == []


def test_every_module_and_all_data_ship(names: set[str]):
    modules = {str(f.relative_to(ROOT)) for package in PACKAGES for f in (ROOT / package).rglob("*.py")}
    assert modules <= names
    assert set(DATA) <= names
    assert any(n.endswith("licenses/LICENSE") for n in names)


@pytest.mark.repeats
def test_a_new_environment_takes_the_code_from_the_wheel_and_not_from_the_checkout(python: Path, tmp_path: Path):
    code = f"import {', '.join(PACKAGES)}; print(*({', '.join(f'{p}.__file__' for p in PACKAGES)},), sep='\\n')"
    files = run(python, "-c", code, cwd=tmp_path).splitlines()
    assert len(files) == len(PACKAGES)
    for file in files:
        assert Path(file).is_relative_to(python.parents[1]), file


@pytest.mark.repeats
def test_the_command_works_outside_the_checkout(python: Path, tmp_path: Path):
    rows = json.loads(run(python.with_name("hexcite"), "cases", "--json", cwd=tmp_path))["cases"]
    assert {r["name"] for r in rows} >= {"hexapod", "ft_wrist", "clamping_table"}
    assert all(Path(r["file"]).is_relative_to(python.parents[1]) for r in rows)
    checked = json.loads(run(python.with_name("hexcite"), "case", "check", "hexapod", "--json", cwd=tmp_path))
    assert checked["ok"] is True


@pytest.mark.repeats
def test_the_report_finds_its_template_outside_the_checkout(python: Path, tmp_path: Path):
    code = "from hexcite.reports.page import Head, page; print(page('whole', Head('', True, ''), '', (), ()))"
    assert ">whole</h1>" in run(python, "-c", code, cwd=tmp_path)


@pytest.mark.slow
def test_the_wheel_alone_plans_writes_runs_and_identifies(wheel: Path, tmp_path: Path):
    """In an environment that holds the wheel and what it asks for, and nothing else."""
    venv.create(tmp_path / "new", with_pip=True)
    python = tmp_path / "new" / "bin" / "python"
    constraints = ROOT / ".ci" / "constraints.txt"
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-c", constraints, wheel]
    subprocess.run(pip, check=True, capture_output=True, timeout=1800)
    hexcite = python.with_name("hexcite")
    accept = "jerk,strut-acceleration,strut-velocity"
    for words in (
        ("plan", "hexapod", "--family", "manual", "-o", "plan"),
        ("post", "plan", "--accept", accept, "-o", "run.ngc"),
        ("run", "run.ngc", "--case", "hexapod", "-o", "recording"),
        ("look", "recording/recording.csv", "--case", "hexapod", "--json"),
        ("identify", "recording", "-o", "result"),
        ("export", "result", "--to", "c"),
    ):
        run(hexcite, *words, cwd=tmp_path)
    result = json.loads((tmp_path / "result" / "result.json").read_text())
    assert abs(result["parameters"]["m"]["value"] - 31.83) < 0.05
