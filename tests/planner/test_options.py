"""Options are declared once: commands, arguments, requests and grids are made of the declarations."""

import ast
import re
from dataclasses import dataclass, fields
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, TypedDict, get_args

import pytest
import typer
from typer.testing import CliRunner

import hexcite as hx
from cases.base.errors import option
from cases.base.options import Option, default_of, documented, options_of
from hexcite.cli import app
from hexcite.cli.console import out
from hexcite.cli.declared import takes
from hexcite.studies.spec import VARIED, Grid
from planner.options import PlanOptions, PoseOptions
from planner.request import PoseRequest, Request


class OvenOptions(TypedDict, total=False):
    heat: Annotated[float, Option(f"How hot; see {option('run_time')}.", 180.0, unit="degC")]
    run_time: Annotated[int | None, Option("How long.")]
    dishes: Annotated[list[object], Option("What to bake.", (), written="File; repeatable.", read_as=list[Path])]


@dataclass(frozen=True)
class FanOptions:
    strong: Annotated[bool, Option("twice the air.")] = False
    program: Annotated[str, Option("which one.", flag="as")] = "grill"


@takes(OvenOptions, families={"fan": FanOptions})
def bake(output: Annotated[Path | None, out("Where.")] = None, **options: Any) -> None:
    print(sorted(options.items()), output)


def baked(*words: str) -> str:
    app = typer.Typer(rich_markup_mode=None)
    app.command()(bake)
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return done.output


def test_a_command_is_given_the_options_that_are_declared():
    usual = {"dishes": None, "heat": 180.0, "program": "grill", "run_time": None, "strong": False}
    assert baked() == f"{sorted(usual.items())} None\n"
    typed = {"dishes": [Path("pie")], "heat": 90.0, "program": "toast", "run_time": 5, "strong": True}
    words = "--heat 90 --run-time 5 --dishes pie --as toast --strong -o tray"
    assert baked(*words.split()) == f"{sorted(typed.items())} tray\n"


def test_help_of_a_command_has_the_meanings_in_words_of_the_command_line():
    text = " ".join(baked("--help").split())
    assert "How hot; see --run-time. [default: 180.0]" in text
    assert "fan: twice the air." in text
    assert text.index("--dishes") < text.index("--output")


def test_the_same_declaration_documents_a_function():
    @documented(OvenOptions)
    def oven(rack: int, **options: Any) -> None:
        """Bakes.

        Args:
            rack: which one.
            OPTIONS
        """

    assert "    heat: How hot; see run_time. By default 180.0.\n" in (oven.__doc__ or "")
    assert [*signature(oven).parameters] == ["rack", "heat", "run_time", "dishes"]


@pytest.mark.parametrize(("function", "declaration"), [(hx.plan, PlanOptions), (hx.plan_poses, PoseOptions)])
def test_help_of_the_library_says_what_each_option_is(function: Any, declaration: type):
    for each in options_of(declaration):
        assert signature(function).parameters[each.name].annotation == each.kind
        assert f"{each.name}: {each.option.meaning[:20]}" in function.__doc__


@pytest.mark.parametrize(("request_kind", "declaration"), [(Request, PlanOptions), (PoseRequest, PoseOptions)])
def test_a_request_takes_what_is_declared(request_kind: Any, declaration: type):
    assert {each.name for each in options_of(declaration)} <= {field.name for field in fields(request_kind)}


def test_a_grid_has_one_value_of_each_option_until_it_is_told_more():
    grid = Grid()
    keys = {"duration": "duration_s", "period": "period_s"}
    assert [*Grid.model_fields] == ["family", *(keys.get(name, name) for name in VARIED)]
    assert getattr(grid, "order") == (hx.Fourier().order,)  # noqa: B009 (its fields are made)
    usual = Request()
    for name in ("criterion", "payload", "seed", "solver", "duration"):
        assert getattr(grid, keys.get(name, name)) == (getattr(usual, name),)


SHARED = ["bound", "retime", "write", "check", "run", "demo", "study", "plan", "plan_poses"]
SHARED += ["identify", "force", "export", "preview"]
WITHOUT_DEFAULT = {"case", "program", "plan", "output", "overwrite", "progress", "file", "at", "spec", "target"}


@pytest.mark.parametrize("name", SHARED)
def test_a_command_and_its_function_have_the_same_defaults(name: str):
    """A command says none where its function's default is empty, and reads texts where it takes paths."""
    called = {"write": "post", "plan_poses": "poses", "preview": "export"}.get(name, name)
    command = next(c.callback for c in app.registered_commands if c.callback.__name__ == called)
    library, typed = signature(getattr(hx, name)).parameters, signature(command).parameters
    shared = {*library} & {*typed} - WITHOUT_DEFAULT
    assert shared
    for each in shared:
        if (name, each) != ("plan", "payload"):  # which is a range too, written as text
            assert (library[each].default or None) == (typed[each].default or None), each


def test_a_function_shows_the_default_of_what_it_declares():
    Heat = Annotated[float, Option("How hot.", 180.0, unit="degC")]

    @documented()
    def grill(rack: int, heat: Heat = default_of(Heat)) -> None:
        """Grills.

        Args:
            rack: which one.
            OPTIONS
        """

    assert signature(grill).parameters["heat"].default == 180.0
    assert signature(grill).parameters["heat"].annotation is float
    assert "    heat: How hot. By default 180.0.\n" in f"{grill.__doc__}\n"


def test_every_target_of_export_is_named_by_its_option():
    from postprocessors.export.targets import LOADS, TARGETS
    from postprocessors.options import ExportTarget, PayloadTarget

    def named(kind: Any) -> set[str]:
        (said,) = (extra for extra in get_args(kind)[1:] if isinstance(extra, Option))
        return set(re.findall(r"[a-z0-9-]+", said.meaning))

    assert {*TARGETS} <= named(ExportTarget)
    assert {*LOADS} <= named(PayloadTarget)


def named_in_texts() -> list[tuple[str, str]]:
    """What texts of the library name by `option`: argument of Python, and what is typed."""
    calls = [
        node
        for package in ("cases", "identification", "planner", "postprocessors", "hexcite")
        for file in (Path(hx.__file__).parents[1] / package).rglob("*.py")
        if file.name != "errors.py" and file.parent.name != "cli"
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "option"
    ]
    literals = [[a.value for a in call.args if isinstance(a, ast.Constant)] for call in calls]
    return sorted({(str(names[0]), str(names[-1]).replace("_", "-")) for names in literals if names})


def test_texts_name_arguments_that_there_are_in_python_and_on_the_command_line():
    """Else a remedy could be carried out in one of both only."""
    public = [getattr(hx, name) for name in dir(hx) if not name.startswith("_")]
    public += [hx.Plan.load, hx.Result.load, hx.Recording.load, hx.Plan.save, hx.Result.save]
    arguments = {p for each in public if callable(each) for p in signature(each).parameters}
    command = typer.main.get_command(app)
    commands = [command, *getattr(command, "commands", {}).values()]
    commands += [c for group in commands for c in getattr(group, "commands", {}).values()]
    typed = {word.removeprefix("--") for each in commands for p in each.params for word in p.opts}
    texts = named_in_texts()
    assert len(texts) > 40
    arguments.add("port")  # of the page, which the command line alone opens
    assert [python for python, _ in texts if python.split()[0] not in arguments] == []
    assert [flag for _, flag in texts if flag.split()[0] not in typed] == []
