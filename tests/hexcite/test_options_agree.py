"""An option has one meaning and one default, wherever it may be given: command line, library, request and study."""

import inspect
from dataclasses import MISSING, fields
from typing import Any

import pytest

from hexcite.cli.plan import OPTIONS as NAMES
from hexcite.cli.plan import SEARCHED, plan
from hexcite.cli.poses import poses
from hexcite.studies.spec import OPTIONS as WITH_UNITS
from hexcite.studies.spec import Grid
from planner._plan import PoseSettings, Settings
from planner.families.settings import FAMILIES
from planner.request import OWNERS, PoseRequest, Request

OF_ONE_FAMILY = {
    setting.name: setting.default for name in set(OWNERS.values()) for setting in fields(FAMILIES[name])
}  # the default of each setting that one family alone has


def defaults(kind: Any) -> dict[str, Any]:
    """Defaults of a dataclass by field."""
    made = {f.name: f.default if f.default_factory is MISSING else f.default_factory() for f in fields(kind)}
    return {name: None if default in ({}, ()) else default for name, default in made.items()}


def typed(command: Any) -> dict[str, Any]:
    """Defaults of a command by parameter."""
    return {name: parameter.default for name, parameter in inspect.signature(command).parameters.items()}


@pytest.mark.parametrize("name", sorted(OF_ONE_FAMILY))
def test_an_option_of_a_family_has_its_default_on_the_command_line(name: str) -> None:
    assert typed(plan)[name] == OF_ONE_FAMILY[name]


def test_options_of_every_family_have_the_defaults_of_a_request() -> None:
    own, given = defaults(Request), typed(plan)
    said = {"duration", "model", "payload", "payload_from", "family"}  # read from the case, or typed in other words
    for name in {*own} - said:
        assert given[name] == own[name], name
    assert given["payload"] == str(own["payload"])
    assert {*SEARCHED} <= {*own}
    assert {*NAMES} <= {*OF_ONE_FAMILY}


def test_options_of_poses_have_the_defaults_of_a_request() -> None:
    own, given = defaults(PoseRequest), typed(poses)
    for name in ({*own} & {*given}) - {"model"}:  # of the case, where it is not given
        assert given[name] == own[name], name


def test_the_library_takes_what_a_request_takes() -> None:
    assert {*Settings.__annotations__} == {*defaults(Request)} - {"family", "duration"}
    assert {*PoseSettings.__annotations__} == {*defaults(PoseRequest)}


@pytest.mark.parametrize("name", Grid.model_fields)
def test_a_study_has_the_names_and_defaults_of_a_plan(name: str) -> None:
    own = WITH_UNITS.get(name, name)
    (usual,) = getattr(Grid(), name)
    if own in OWNERS:
        assert usual == OF_ONE_FAMILY[own]
    elif own not in ("family", "model"):  # of the paper's study, and of the case
        assert usual == defaults(Request)[own]
