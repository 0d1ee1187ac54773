"""Which table of a case reads each column of a run by several recorders, so that remedies name keys with an effect."""

from collections.abc import Mapping

from cases.orientation import ANGLES
from cases.recording_format import ROLE_OF, SHIFTED
from cases.schema import Case
from identification.findings.causes.remedies import Path

_FILES = ("recording", "files")
_BY_COLUMN = ("columns", "scale", "offset")


def as_one_table(case: Case, numbers: Mapping[str, int]) -> Case:
    """The case with what its tables say of their columns in `[recording]` too, where causes are looked for.

    Args:
        case: the case.
        numbers: our columns that a table of `[[recording.files]]` reads -> its number, from 0 (`tables_of_columns`).
    """
    if not numbers:
        return case
    form = case.recording
    update: dict[str, object] = {}
    for key in _BY_COLUMN:
        values = {ours: value for ours, value in getattr(form, key).items() if ours not in numbers}
        for ours, number in numbers.items():
            if ours in (of_table := getattr(form.files[number], key)):
                values[ours] = of_table[ours]
        update[key] = values
    roles = {ROLE_OF[ours]: number for ours, number in numbers.items() if ours in ROLE_OF}
    units = {role: unit for role, unit in form.units.items() if role not in roles}
    update["units"] = units | {
        role: form.files[number].units[role] for role, number in roles.items() if role in form.files[number].units
    }
    if (channel := case.sensor_frame.channels[0]) in numbers:
        update["clock"] = form.files[numbers[channel]].clock
    if ANGLES[0] in numbers:
        update["orientation"] = form.files[numbers[ANGLES[0]]].orientation
    return case.model_copy(update={"recording": form.model_copy(update=update)})


def places_in_tables(path: Path, numbers: Mapping[str, int]) -> list[Path]:
    """Where a key of `[recording]` stands in the file: in the table that reads its column, a clock's in each of them.

    >>> places_in_tables(("recording", "columns", "f1_N"), {"f1_N": 1})
    [('recording', 'files', 1, 'columns', 'f1_N')]
    """
    if path[0] != "recording" or not numbers or len(path) < 2:
        return [path]
    key, rest = path[1], path[1:]
    found: list[int | None]
    if key in _BY_COLUMN and len(path) > 2:
        found = [numbers.get(str(path[2]))]
    elif key == "units" and len(path) > 2:
        found = [next((number for ours, number in numbers.items() if ROLE_OF.get(ours) == path[2]), None)]
    elif key == "orientation":
        found = [numbers.get(ANGLES[0])]
    elif path[1:3] == ("clock", "offset_s") and len(path) > 3:
        shifted = next(columns for stream, columns in SHIFTED.items() if stream == path[3])
        found = [next((numbers[ours] for ours in shifted if ours in numbers), None)]
    elif key == "clock":
        found = [*dict.fromkeys(numbers.values())]
    else:
        found = [None]
    return [path if number is None else (*_FILES, number, *rest) for number in found]
