"""Doors of packages: what type checkers see is what users get, and no module hides a public name."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

DOORS = ("hexcite", "cases", "identification", "planner", "postprocessors", "postprocessors.export")


def folder(package: str) -> Path:
    return Path(str(import_module(package).__file__)).parent


@pytest.mark.parametrize("package", DOORS)
def test_the_table_of_a_door_is_what_type_checkers_are_told(package: str):
    tree = ast.parse((folder(package) / "__init__.py").read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    told = {alias.asname: node.module for node in imports for alias in node.names if alias.asname}
    assert told == import_module(package).PUBLIC


@pytest.mark.parametrize("package", DOORS)
def test_every_public_name_is_there_and_no_other(package: str):
    door = import_module(package)
    assert set(dir(door)) == set(door.PUBLIC)
    for name in door.PUBLIC:
        assert getattr(door, name) is getattr(door, name)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = door.nonsense


@pytest.mark.parametrize("package", DOORS)
def test_no_module_has_the_name_of_what_its_door_exports(package: str):
    """Once imported, it would stand in its place."""
    modules = {path.stem for path in folder(package).iterdir() if path.suffix == ".py" or path.is_dir()}
    assert modules.isdisjoint(import_module(package).PUBLIC)


def test_a_door_needs_no_source(tmp_path: Path):
    """As in a zip file of compiled modules."""
    package = tmp_path / "closed"
    package.mkdir()
    source = "from cases.base.doors import door\n__getattr__, __dir__ = door(__name__, {'HexciteError': 'cases'})\n"
    (package / "__init__.py").write_text(source, encoding="utf-8")
    compiling = (
        f"import py_compile; py_compile.compile({str(package / '__init__.py')!r}, {str(package / '__init__.pyc')!r})"
    )
    subprocess.run([sys.executable, "-c", compiling], check=True)
    (package / "__init__.py").unlink()
    code = "import sys; sys.path.insert(0, sys.argv[1]); from closed import HexciteError; print(HexciteError.__name__)"
    run = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=True)
    assert run.stdout == "HexciteError\n"
