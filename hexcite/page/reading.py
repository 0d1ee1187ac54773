"""How a recording is read: menus of what `look` proposes, with its reasons, and the `[recording]` that they say."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from markupsafe import Markup

from cases.base.errors import CaseError, HexciteError
from cases.orientation import ANGLES, CONVENTIONS, OF_ANGLES, QUATERNION, ROTATION
from cases.recording_format import (
    CLOCK,
    COLUMNS,
    ROLE_OF,
    ROLE_UNITS,
    TRIGGER,
    Clock,
    FormatName,
    RecordingFormat,
    Role,
)
from cases.schema import Case
from cases.tables import tables_of
from hexcite.page import forms
from hexcite.page.forms import Fields, field
from hexcite.page.refusals import Unfit
from hexcite.page.words import Words

SEPARATORS: Mapping[str, str] = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "blank": " "}
"""Name in a menu -> character between two fields."""
COUNTS = ("header_rows", "names_row", "trailing_rows")
CHOICES: Mapping[str, tuple[str, ...]] = {
    "format": get_args(FormatName), "delimiter": tuple(SEPARATORS), "decimal": (".", ","),
    "encoding": ("utf-8", "cp1252"), "empty": ("missing", "hold", "apart"),
}  # fmt: skip
"""Keys of the layout that menus choose; an empty choice is the usual one."""
CLOCK_UNITS = tuple(unit for unit in get_args(get_args(Clock.model_fields["unit"].annotation)[0]) if unit)


@dataclass(frozen=True)
class Row:
    """What a channel of ours is read from.

    Args:
        name: ours.
        column: of the file; empty where it is read from none.
        unit: that the file is taken to use.
        guessed: whether it follows from values alone.
        reasons: why this column, and why this unit; empty of what has no reason.
        scale: that is stated, as text.
    """

    name: str
    column: str
    unit: str
    guessed: bool
    reasons: tuple[Markup, Markup]
    scale: str


@dataclass(frozen=True)
class Table:
    """The form of one table of `[recording]`: that of all files, or of one of them.

    Args:
        mark: what names of its fields end with.
        file: that it is of; empty where it is of all files.
        rows: channels with the column of each.
        columns: that may be chosen.
        units: role, stated unit, units to choose from.
        settings: keys that are stated, as text; empty where the usual ones hold.
        reasons: key of the settings -> why it has its value.
        conventions: of the orientation: name and words; empty where the file has none.
    """

    mark: str
    file: str
    rows: tuple[Row, ...]
    columns: tuple[str, ...]
    units: tuple[tuple[str, str, tuple[str, ...]], ...]
    settings: Mapping[str, str]
    reasons: Mapping[str, Markup]
    conventions: tuple[tuple[str, str], ...]


def tables(words: Words, answer: Mapping[str, Any], case: Case | None) -> tuple[Table, ...]:
    """The forms of what `look` answered; none of a bag, or where there are no columns.

    Args:
        answer: of `hexcite look --json`.
        case: the machine, which says what it needs.
    """
    if case is None or answer.get("topics") or not answer.get("columns"):
        return ()
    files, settings = answer["files"], answer["settings"]
    if "files" not in settings:
        reasons = {key: why for file in reversed(files) for key, why in _reasons(words, file).items()}
        return (_table(words, "", "", answer["columns"], settings, reasons, _needed(case, answer["columns"])),)
    forms_of_files, begin = [], 0
    for file in files:
        columns = answer["columns"][begin : (begin := begin + len(file["columns"]))]
        if file["table"] is not None:
            form, name = settings["files"][file["table"]], str(file["file"]).rpartition("/")[2]
            forms_of_files.append(_table(words, f"@{file['table']}", name, columns, form, _reasons(words, file), ()))
    return tuple({table.mark: table for table in forms_of_files}.values())


def _table(
    words: Words,
    mark: str,
    file: str,
    columns: list[Mapping[str, Any]],
    settings: Mapping[str, Any],
    reasons: Mapping[str, Markup],
    needed: tuple[str, ...],
) -> Table:
    read_from = {column["meaning"]: column for column in columns if column["meaning"]}
    names = tuple(dict.fromkeys([*needed, *sorted(read_from, key=COLUMNS.index)]))
    scales = settings.get("scale", {})
    rows = tuple(_row(words, name, read_from.get(name), scales) for name in names)
    roles = dict.fromkeys(ROLE_OF[name] for name in names if name in ROLE_OF)
    units_of_file = settings.get("units", {})
    units = tuple((str(role), units_of_file.get(str(role), ""), tuple(ROLE_UNITS[role])) for role in roles)
    clock, trigger = settings.get("clock", {}), settings.get("trigger") or {}
    texts = {key: settings.get(key) for key in (*CHOICES, *COUNTS, "orientation", "filter_cutoff_Hz")}
    texts["delimiter"] = next((name for name, sign in SEPARATORS.items() if sign == settings.get("delimiter")), None)
    texts |= {"unit": clock.get("unit"), "period_ms": clock.get("period_ms"), "bit": trigger.get("bit")}
    return Table(
        mark, file, rows, tuple(dict.fromkeys(column["name"] for column in columns if column["name"])), units,
        {key: _text(value) for key, value in texts.items()}, reasons, _conventions(names),
    )  # fmt: skip


def _reasons(words: Words, file: Mapping[str, Any]) -> dict[str, Markup]:
    codes = file.get("reason_codes") or {}
    return {key: words.reasons(codes.get(key), why) for key, why in file["reasons"].items()}


def _text(value: Any) -> str:
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _row(words: Words, name: str, column: Mapping[str, Any] | None, scales: Mapping[str, Any]) -> Row:
    scale = _text(scales.get(name))
    if column is None:
        return Row(name, "", "", False, (Markup(), Markup()), scale)
    why_column, why_unit = (
        words.reasons(column.get(f"{key}_codes"), column.get(key) or "") for key in ("reason", "unit_reason")
    )
    return Row(name, column["name"], column["unit"], column["guessed"], (why_column, why_unit), scale)


def _needed(case: Case, columns: list[Mapping[str, Any]]) -> tuple[str, ...]:
    """Channels that a run of the machine has; its drives only where no pose is recorded."""
    try:
        drives = tuple(case.drive_columns)
    except HexciteError:
        drives = ()
    pose_columns = {"x_mm", ANGLES[0], QUATERNION[0], ROTATION[0]} & {column["meaning"] for column in columns}
    return (CLOCK, TRIGGER, *(() if pose_columns else drives), *case.sensor_frame.channels)


def _conventions(names: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """The conventions that an orientation with these columns may have, with who writes it."""
    if ANGLES[0] in names:
        possible = list(OF_ANGLES)
    else:
        first = {QUATERNION[0], ROTATION[0]} & {*names}
        possible = [each for each in CONVENTIONS.values() if each.columns[0] in first]
    return tuple((each.name, each.users or each.words) for each in possible)


def chosen_settings(answer: Mapping[str, Any], fields: Fields) -> dict[str, Any]:
    """The table `[recording]` that `look` proposed, with what the menus say in it.

    Raises:
        Unfit: a choice cannot be, or the table cannot be with it.
    """
    settings: dict[str, Any] = dict(answer["settings"])
    if "files" in settings:
        by_table: dict[int, set[str]] = {}
        begin = 0
        for file in answer["files"]:
            columns = answer["columns"][begin : (begin := begin + len(file["columns"]))]
            by_table.setdefault(file["table"], set()).update(column["name"] for column in columns)
        settings["files"] = [
            _with(dict(table), _of(fields, f"@{k}"), by_table.get(k, set()))
            for k, table in enumerate(settings["files"])
        ]
    else:
        settings = _with(settings, _of(fields, ""), {column["name"] for column in answer["columns"]})
    if text := field(fields, "l.filter_cutoff_Hz"):
        settings["filter_cutoff_Hz"] = float(forms.number(fields, "l.filter_cutoff_Hz", 0.01, 1e5)) if text else None
    try:
        tables_of(RecordingFormat, Path("[recording]"), settings)
    except CaseError as error:
        raise Unfit.of(error.sentences) from error
    return settings


def _of(fields: Fields, mark: str) -> dict[str, str]:
    """The fields of one table by their names without its mark."""
    names = (name for name in fields if name.partition("@")[1:] == (mark[:1], mark[1:]))
    return {name.partition("@")[0]: field(fields, name) for name in names}


def _group(chosen: Mapping[str, str], kind: str) -> Iterator[tuple[str, str]]:
    return ((name[len(kind) + 1 :], value) for name, value in chosen.items() if name.startswith(f"{kind}."))


def _with(settings: dict[str, Any], chosen: Mapping[str, str], names: set[str]) -> dict[str, Any]:
    """A table of settings with what the menus of it say."""
    columns, scales, units = (dict(settings.pop(key, None) or {}) for key in ("columns", "scale", "units"))
    trigger = dict(settings.pop("trigger", None) or {})
    for ours, theirs in _group(chosen, "c"):
        if theirs and theirs not in names:
            raise Unfit("no_column", place=ours, text=theirs)
        if not theirs and ours in names:
            raise Unfit("column_is_read", place=ours)
        columns.pop(ours, None)
        if ours == TRIGGER:
            trigger.pop("column", None)
        if theirs and theirs != ours:
            columns[ours] = theirs
    twice = [name for name in {*columns.values()} if list(columns.values()).count(name) > 1]
    if twice:
        raise Unfit("chosen_twice", name=twice[0])
    for ours, text in _group(chosen, "s"):
        scales.pop(ours, None)
        if text:
            scales[ours] = _number(ours, text, -1e12, 1e12)
    for role, unit in _group(chosen, "u"):
        if unit and (role not in {*Role} or unit not in ROLE_UNITS[Role(role)]):
            raise Unfit("no_choice", place=role, text=unit)
        units.pop(role, None)
        if unit:
            units[role] = unit
    if (bit := chosen.get("l.bit")) is not None:
        trigger.pop("bit", None)
        if bit:
            trigger["bit"] = int(_number("bit", bit, 0, 52, whole=True))
            if TRIGGER in columns:
                trigger["column"] = columns.pop(TRIGGER)
    if "column" in trigger and "bit" not in trigger and TRIGGER not in columns:
        columns[TRIGGER] = trigger.pop("column")
    clock = _clock(dict(settings.pop("clock", None) or {}), chosen)
    before = {key: settings.get(key) for key in (*CHOICES, *COUNTS)}
    layout = _layout(settings, chosen)
    if before != {key: layout.get(key) for key in before}:
        columns = {}  # of another layout; those of this one are proposed
        layout.pop("column_names", None)
    parts = {"columns": columns, "scale": scales, "units": units, "trigger": trigger, "clock": clock}
    return layout | {key: value for key, value in parts.items() if value}


def _number(name: str, text: str, low: float, high: float, whole: bool = False) -> float:
    value = float(forms.number({name: [text]}, name, low, high))
    if whole and value != int(value):
        raise Unfit("no_whole_number", place=name, text=text)
    return value


def _clock(clock: dict[str, Any], chosen: Mapping[str, str]) -> dict[str, Any]:
    if (unit := chosen.get("l.unit")) is not None:
        clock.pop("unit", None)
        if unit:
            if unit not in CLOCK_UNITS:
                raise Unfit("no_choice", place="unit", text=unit)
            clock["unit"] = unit
    if (period := chosen.get("l.period_ms")) is not None:
        clock.pop("period_ms", None)
        if period:
            clock["period_ms"] = _number("period_ms", period, 1e-6, 1e9)
    return clock


def _layout(settings: dict[str, Any], chosen: Mapping[str, str]) -> dict[str, Any]:
    """Keys of the layout, and the orientation; an empty choice is the usual one, which is not stated."""
    for key, text in _group(chosen, "l"):
        if key in CHOICES:
            if text and text not in CHOICES[key]:
                raise Unfit("no_choice", place=key, text=text)
        elif key == "orientation":
            if text and text not in CONVENTIONS:
                raise Unfit("no_choice", place=key, text=text)
        elif key not in COUNTS:
            continue
        settings.pop(key, None)
        if text:
            value = SEPARATORS.get(text, text) if key == "delimiter" else text
            settings[key] = int(_number(key, text, 0, 10_000, whole=True)) if key in COUNTS else value
    return settings
