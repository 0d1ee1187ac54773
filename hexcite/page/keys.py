"""What the tables of a case file may hold: keys, what each means, and values to begin from where one is missing."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal, get_args, get_origin

from cases.base.places import Place
from cases.chain import Joint, JointLimit
from cases.controller import ControllerName
from cases.editing import at, commented
from cases.machine import Joints, Ring
from cases.poses import Poses
from cases.readiness import languages_of
from cases.recording_format import RecordingFormat
from cases.scaffold import explanations
from cases.schema import Case
from cases.tables import Part, built_in_cases
from cases.tolerances import KINDS, TYPICAL, Tolerances
from hexcite.page.units import same_thing

Table = Mapping[str, Any]
WAY = 20.0  # [deg or mm] to either side of home, to begin from
SIMULATED_BODY: Place = ("simulation", "parameters", "body")


def _inner(annotation: Any) -> Iterator[Any]:
    yield annotation
    for each in get_args(annotation):
        yield from _inner(each)


def _parts(annotation: Any) -> list[type[Part]]:
    return [each for each in _inner(annotation) if isinstance(each, type) and issubclass(each, Part)]


def _leaf(part: type[Part], key: str) -> bool:
    """Whether a key has a value and no table; tolerances are numbers, though they may be tables."""
    return part is Tolerances or not _parts(part.model_fields[key].annotation)


def part_of(place: Place, data: Table) -> type[Part] | None:
    """The class of the table at a place; None where a case has no such table."""
    part: type[Part] = Case
    for k, key in enumerate(place):
        if isinstance(key, int):
            continue
        field = part.model_fields.get(key)
        kinds = [] if field is None else _parts(field.annotation)
        if not kinds:
            return None
        table = at(data, place[: k + 1])
        table = table[0] if isinstance(table, list) and table else table
        keys = {*table} if isinstance(table, Mapping) else set[str]()
        part = max(
            kinds, key=lambda kind: len(keys & kind.model_fields.keys()) - 100 * len(keys - kind.model_fields.keys())
        )
    return part


def words_of(part: type[Part] | None) -> Mapping[str, str]:
    """What the keys of a table mean."""
    return {} if part is None else explanations(part)


def choices_of(part: type[Part] | None, key: str) -> tuple[str, ...]:
    """The texts among which a value is one; empty where it is not a choice."""
    field = None if part is None else part.model_fields.get(key)
    literals = [] if field is None else [each for each in _inner(field.annotation) if get_origin(each) is Literal]
    return tuple(text for text in get_args(literals[0]) if isinstance(text, str)) if literals else ()


def is_text(part: type[Part] | None, key: str) -> bool:
    """Whether the value of a key is a text."""
    field = None if part is None else part.model_fields.get(key)
    return field is not None and (str in _inner(field.annotation) or bool(choices_of(part, key)))


@lru_cache(16)
def _built_in(name: str) -> dict[str, Any]:
    return tomllib.loads(built_in_cases()[name].read_text(encoding="utf-8"))


def example_of(data: Table) -> Table:
    """The built-in case that a case was begun from, else the one whose machine is most like it."""
    if data.get("template") in built_in_cases():
        return _built_in(str(data["template"]))
    joints = at(data, ("machine", "chain", "joints"))

    def likeness(name: str) -> tuple[int, ...]:
        other = _built_in(name)
        others = at(other, ("machine", "chain", "joints")) or []
        kinds = [joint.get("kind") for joint in joints] if isinstance(joints, list) else []
        same = [joint.get("kind") for joint in others] == kinds
        return (
            isinstance(at(other, ("machine", "chain")), Mapping) == isinstance(joints, list),
            other["setup"] == data.get("setup"),
            same,
            len({*other} & {*data}),
        )

    return _built_in(max(built_in_cases(), key=likeness))


def missing(data: Table, case: Case | None, content: str = "") -> dict[Place, Any]:
    """Keys that the tables of a case may have and do not have, with values to begin from; None where there is none.

    What stands in the file as a comment goes before all else. Of tables that it does not have at all, those that the
    case which is most like it has, `[tolerances]`, `[limits.margin]` and the joints of `[limits.motion]`.
    """
    example, examples = example_of(data), dict[Place, Any]()
    for place, table in _tables((), data):
        part = part_of(place, data)
        if part is None:
            continue
        for key in part.model_fields:
            if key in table or not _leaf(part, key) or not _fits(part, key, table, "chain" in data.get("machine", {})):
                continue
            examples[(*place, key)] = typical(data, example, (*place, key), part)
        for key, field in part.model_fields.items():
            if key not in table and not _leaf(part, key):
                examples |= _table(data, example, (*place, key), _parts(field.annotation)[0], case)
    for key, value in (data.get("nominal") or {}).items():  # the simulated machine is this one, not that of the example
        if (*SIMULATED_BODY, key) in examples:
            examples[*SIMULATED_BODY, key] = value
    as_comments = commented(content)
    return {place: as_comments.get(place, value) for place, value in examples.items()}


def _table(data: Table, example: Table, place: Place, part: type[Part], case: Case | None) -> dict[Place, Any]:
    """Values of a table that a case does not have."""
    chain = at(data, ("machine", "chain", "joints"))
    if part is Tolerances:
        able = KINDS if case is None else case.tolerable
        return {(*place, key): TYPICAL.get(key) for key in KINDS if key in able}
    if place == ("limits",) and chain:
        joints = _joint_limits(data, example, (*place, "motion", "joints"))
        return joints | _table(
            data, example, (*place, "margin"), _parts(part.model_fields["margin"].annotation)[0], case
        )
    if (place[0] == "workspace" and not at(data, ("machine", "home"))) or place[0] in ("sensor_frame", "machine"):
        return {}
    example_value = at(example, place)
    if place[0] == "controller" and not isinstance(example_value, Mapping):  # of a control that the example has not
        controllers = tuple(ControllerName) if case is None else languages_of(case)
        example_value = _of_such_a_machine(data, place) if place[-1] in controllers else None
    if isinstance(example_value, Mapping):
        return dict(leaves(place, example_value))
    if place[0] in ("simulation", "payloads") or (len(place) > 1 and place[0] != "limits"):
        return {}
    keys = {key: field.default for key, field in part.model_fields.items() if _leaf(part, key)}
    return {
        (*place, key): value if isinstance(value, bool | int | float | str) else None for key, value in keys.items()
    }


def _of_such_a_machine(data: Table, place: Place) -> Table | None:
    """The table at a place of a built-in case with the same kind of machine; None where none has it."""
    chain = isinstance(at(data, ("machine", "chain")), Mapping)
    cases = [_built_in(name) for name in built_in_cases()]
    alike = [case for case in cases if isinstance(at(case, ("machine", "chain")), Mapping) == chain]
    return next((table for case in alike if isinstance(table := at(case, place), Mapping)), None)


def _joint_limits(data: Table, example: Table, place: Place) -> dict[Place, Any]:
    examples = dict[Place, Any]()
    for k, joint in enumerate(at(data, ("machine", "chain", "joints"))):
        examples[(*place, k, "name")] = joint.get("name", "")
        unit, si = ("mm", "m") if joint.get("kind") == "prismatic" else ("deg", "rad")
        for key in (f"position_{unit}", f"velocity_{unit}_s", f"acceleration_{si}_s2", f"jerk_{si}_s3"):
            examples[(*place, k, key)] = typical(data, example, (*place, k, key), JointLimit)
    return examples


def leaves(place: Place, value: Any) -> Iterator[tuple[Place, Any]]:
    """Values that are not tables, each with its place."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from leaves((*place, key), inner)
    elif isinstance(value, list) and value and all(isinstance(each, Mapping) for each in value):
        for k, inner in enumerate(value):
            yield from leaves((*place, k), inner)
    elif isinstance(value, bool | int | float | str | list):
        yield place, value


def _tables(place: Place, value: Any) -> Iterator[tuple[Place, Table]]:
    if isinstance(value, Mapping):
        yield place, value
        for key, inner in value.items():
            yield from _tables((*place, key), inner)
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            if isinstance(inner, Mapping):
                yield from _tables((*place, k), inner)


def _fits(part: type[Part], key: str, table: Table, chain: bool) -> bool:
    """Whether a key can stand beside those that a table has; those of files are for the stage Data."""
    if (part is RecordingFormat and key not in ("filter_cutoff_Hz", "rate_Hz")) or (
        part is Poses and chain and key not in ("settle_s", "average_s")
    ):
        return False
    if any(same_thing(key, other) for other in table):
        return False
    if part is Ring or part is Joints or key in ("schema_version", "name", "template"):
        return False
    if part is Joint or part is JointLimit:
        slides = table.get("kind") == "prismatic" or "position_mm" in table
        of_its_unit = key.endswith(("_mm", "_mm_s", "_m_s2", "_m_s3", "_N")) == slides
        endless = table.get("kind") == "continuous" and key.startswith("position")
        twin = key.endswith(("_deg_s2", "_deg_s3"))
        return not endless and not twin and (of_its_unit or key in ("rpy_deg", "origin_mm"))
    return not key.startswith("angular_") or "_deg_s" not in key or key == "angular_velocity_deg_s"


def typical(data: Table, example: Table, place: Place, part: type[Part]) -> Any:
    """A value to begin from: the usual one, the default, or that of the case which is most like it; None for none."""
    key = place[-1]
    if part is Tolerances:
        return TYPICAL.get(str(key))
    if part is Joint and str(key).startswith("home_"):
        low, high = at(data, (*place[:-1], str(key).replace("home", "position"))) or (-1.0, 1.0)
        return 0.0 if low <= 0.0 <= high else round((low + high) / 2.0, 1)
    if part is JointLimit and str(key).startswith("position_"):
        return _way(data, place)
    default = part.model_fields[str(key)].default
    if isinstance(default, bool | int | float | str):
        return default
    if isinstance(default, tuple) and default and all(isinstance(each, float) for each in default):
        return list(default)
    return _alike(example, place)


def _way(data: Table, place: Place) -> list[float]:
    """Of a joint from home, inside its ends."""
    joint = at(data, ("machine", "chain", "joints", place[-2])) or {}
    unit = str(place[-1]).rpartition("_")[2]
    home = joint.get(f"home_{unit}", 0.0)
    low, high = joint.get(f"position_{unit}", (-1e9, 1e9))
    return [max(-WAY, low - home), min(WAY, high - home)]


def _alike(example: Table, place: Place) -> Any:
    """The value of an example at a place, of lists of tables that of an entry with it."""
    value: Any = example
    for k, key in enumerate(place):
        if isinstance(key, int):
            rest: Sequence[str | int] = place[k + 1 :]
            entries = [at(each, tuple(rest)) for each in value] if isinstance(value, list) else []
            stated = [each for each in entries if each is not None]
            return entries[key] if key < len(entries) and entries[key] is not None else (stated or [None])[-1]
        value = value.get(key) if isinstance(value, Mapping) else None
    return value
