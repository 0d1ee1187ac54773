"""The plan of a run, where it lies beside it: the one that a run of hexcite names, or those for the same machine."""

from collections.abc import Iterator
from pathlib import Path

from cases.base.errors import HexciteError
from cases.base.file_reading import MOST_JSON, read_json, read_whole
from cases.schema import Case
from identification.recording.recording import Recording
from planner.plans.folder import fingerprint_of
from planner.plans.plan import Plan

MOST_FOLDERS = 50  # of a place, that are looked into
MOST_PLANS = 8  # with which a run is compared


def plans_at_hand(recording: Recording) -> Plan | tuple[Plan, ...] | None:
    """The plan of a recorded run among the folders beside its files and its program; None where there is none.

    A run that names its plan is of that one alone. Any other may be of one of the plans for a case of the same
    name.
    """
    case = recording.case
    if case is None or case.limits is None:
        return None
    named = None if recording.record is None else recording.record.origin.plan_hash
    plans: list[Plan] = []
    for folder in _folders(recording):
        try:
            file = folder / "plan.json"
            matching = fingerprint_of(read_whole(file, MOST_JSON)) == named if named is not None else _is_of(case, file)
            plan = Plan.load(folder, case, stale=True) if matching else None
        except (HexciteError, OSError):
            continue  # nobody asked for it
        if plan is None:
            continue
        if named is not None:
            return plan
        plans += [plan] if len(plans) < MOST_PLANS else []
    return tuple(plans) or None


def _is_of(case: Case, file: Path) -> bool:
    """Whether a plan is for a case of this name."""
    return bool(read_json(file, "hexcite plan").get("case") == case.name)


def _folders(recording: Recording) -> Iterator[Path]:
    """Folders that hold a plan: those of the recording's files and of its program, and the folders in them."""
    places = [path.resolve() if path.is_dir() else path.resolve().parent for path in recording.paths]
    places += [path.resolve().parent for path in recording.paths if path.is_dir()]
    if recording.record is not None and recording.record.origin.program is not None:
        places.append(Path(recording.record.origin.program).parent)
    for place in dict.fromkeys(places):
        if (place / "plan.json").is_file():
            yield place
        try:
            inside = sorted(place.glob("*/plan.json"))
        except OSError:
            continue
        yield from (file.parent for file in inside[:MOST_FOLDERS])
