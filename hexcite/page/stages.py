"""What a root folder holds of a machine: its plans, programs, runs and results, and what of it is out of date."""

import hashlib
import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from cases.base.errors import HexciteError
from cases.base.file_reading import DAMAGED, MOST_JSON, read_whole
from cases.base.phrases import enumerated
from cases.basis import (
    COMPUTED_FROM,
    CONTENT,
    changes_since,
    content_of,
    plan_basis,
    recording_basis,
    result_basis,
)
from cases.readiness import readiness
from cases.schema import Case, load_case
from cases.tables import CASE_FILE, built_in_cases

STAGES = ("machine", "plan", "program", "data", "result", "use")
MOST = 300  # files and folders of a kind that are looked at
RECORDINGS = frozenset(
    {".csv", ".txt", ".dat", ".tsv", ".asc", ".lvm", ".xml", ".parquet", ".db3", ".mcap", ".bag", ".active", ".log",
     ".out"}
)  # fmt: skip
FORMS = {"ros2": (".yaml", ".json", ".py")}
"""Controllers whose programs have several forms: their suffixes, the usual one first."""
PROGRAMS = frozenset({".ngc", ".nc", ".mpf", ".spf", ".script", ".csv", *(s for own in FORMS.values() for s in own)})
_PLAN_HASH = re.compile(rb"plan hash ([0-9a-f]{8,64})")
_DIALECTS = ("linuxcnc", "sinumerik", "twincat", "setpoints", "urscript", "ros2")


@dataclass(frozen=True)
class Machine:
    """A case: built in, or a folder of the root.

    Args:
        key: its name, of a folder of the root with a + before it, as in addresses.
        argument: what names it on a command line.
        case: None where the file is not read.
        problem: why it is not read.
    """

    key: str
    argument: str
    file: Path
    case: Case | None
    problem: str = ""

    @property
    def own(self) -> bool:
        """Whether it is the user's, and not built in."""
        return self.key.startswith("+")

    def lacks(self, command: str) -> tuple[str, ...]:
        """Tables and keys that a command needs and the case does not have."""
        return () if self.case is None else readiness(self.case)[command]

    @property
    def dialects(self) -> tuple[str, ...]:
        """Controllers that programs can be written for."""
        return tuple(d for d in _DIALECTS if self.case is not None and not self.lacks(f"post --dialect {d}"))


def machine_of(root: Path, key: str) -> Machine | None:
    """The machine of a key; None where there is none."""
    if not key.startswith("+"):
        built_in = built_in_cases()
        return _machine(key, key, built_in[key]) if key in built_in else None
    name = key[1:]
    file = root / name / CASE_FILE
    if "/" in name or name.startswith(".") or not file.is_file() or not file.resolve().is_relative_to(root):
        return None
    return _machine(key, f"{name}/{CASE_FILE}", file)


def own_machines(root: Path) -> list[Machine]:
    """The cases in the folders of the root."""
    files = sorted(root.glob(f"*/{CASE_FILE}"))[:MOST]
    machines = (machine_of(root, f"+{file.parent.name}") for file in files)
    return [machine for machine in machines if machine is not None]


def built_in() -> list[Machine]:
    """The cases that hexcite has."""
    return [_machine(name, name, file) for name, file in built_in_cases().items()]


def _machine(key: str, argument: str, file: Path) -> Machine:
    status = file.stat()
    try:
        return Machine(key, argument, file, case_of(str(file), status.st_mtime_ns, status.st_size))
    except HexciteError as error:
        return Machine(key, argument, file, None, enumerated("semicolon", error.sentences))


def case_key(machine: Machine) -> tuple[str, int, int]:
    """What a case is read by: its file, with the time and size that it has now."""
    status = machine.file.stat()
    return str(machine.file), status.st_mtime_ns, status.st_size


@lru_cache(64)
def case_of(file: str, time_ns: int, size: int) -> Case:
    """The case of a file, read once for each time and size that it has."""
    built_in_names = {str(path): name for name, path in built_in_cases().items()}
    return load_case(built_in_names.get(file, file))


@dataclass(frozen=True)
class Made:
    """A plan, run or result that a command wrote.

    Args:
        name: of its folder in the root.
        record: entries of its JSON.
        changed: what of the case is different since; empty where it is up to date.
        time: when it was written [s].
    """

    name: str
    record: Mapping[str, Any]
    changed: tuple[str, ...]
    time: float
    fingerprint: str = ""

    @property
    def by_hand(self) -> bool:
        """Whether it is the plan of a manual motion, which others are compared with."""
        return self.record.get("family") == "manual"

    @property
    def fresh(self) -> bool:
        """Whether the case is still what it was computed from."""
        return not self.changed


@dataclass(frozen=True)
class Program:
    """A program file, and the plan that it says it was written from."""

    name: str
    plan: str  # name of the plan's folder
    time: float


@dataclass(frozen=True)
class Recording:
    """A recorded run: a file, a folder of the files of one run, a bag, or a folder of a rehearsal."""

    name: str
    simulated: bool
    time: float
    changed: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()  # files of the run below the folder of this name; empty where it is one argument

    @property
    def arguments(self) -> tuple[str, ...]:
        """What names it on a command line."""
        return tuple(f"{self.name}/{part}" for part in self.parts) or (self.name,)


@dataclass(frozen=True)
class Workspace:
    """What the root folder holds of one machine, the newest first."""

    machine: Machine
    plans: tuple[Made, ...]
    programs: tuple[Program, ...]
    recordings: tuple[Recording, ...]
    results: tuple[Made, ...]

    def state(self, stage: str) -> str:
        """How a stage stands: done, open (the next to do), stale, or closed (something before it is missing)."""
        case = self.machine.case
        if stage == "machine":  # values of the example are left, or a plan needs more
            described = case is not None and (case.chain is not None or case.hexapod is not None)
            lacks = described and self.machine.own and self.machine.lacks("plan")
            return "open" if case is None or case.template is not None or lacks else "done"
        if case is None:
            return "closed"
        if stage == "plan":
            return _kind(self.plans, "closed" if self.machine.lacks("plan") else "open")
        if stage == "program":
            fresh = {plan.name for plan in self.plans if plan.fresh}
            if any(program.plan in fresh for program in self.programs):
                return "done"
            return "open" if fresh and self.machine.dialects else "stale" if self.programs else "closed"
        own_run = bool(self.results) or any(recording.simulated for recording in self.recordings)
        if stage == "data":
            return "done" if own_run else "open"  # other files of the folder may be of another machine
        if stage == "result":
            return _kind(self.results, "open" if own_run else "closed")
        return "open" if any(result.fresh for result in self.results) else "closed"


def _kind(made: tuple[Made, ...], otherwise: str) -> str:
    if any(each.fresh for each in made):
        return "done"
    return "stale" if made and otherwise != "closed" else otherwise


def workspace(root: Path, machine: Machine) -> Workspace:
    """What the root folder holds of a machine."""
    case = machine.case
    if case is None:
        return Workspace(machine, (), (), (), ())
    plans = _newest(_made(root, "plan.json", case, _plan_basis))
    results = _newest(_made(root, "result.json", case, lambda about, own: result_basis(own)))
    runs = [
        Recording(run.name, True, run.time, run.changed)
        for run in _made(root, "recording.json", case, lambda about, own: recording_basis(own))
    ]
    programs: list[Program] = []
    files: list[Recording] = []
    for path in sorted(root.iterdir(), key=lambda path: path.name):
        suffix = path.suffix.lower()
        if len(files) < MOST and (run := _run_of(root, path)) is not None:
            files.append(run)
        if path.name.startswith(".") or not path.is_file() or suffix not in PROGRAMS | RECORDINGS:
            continue
        status = path.stat()
        fingerprint = _plan_of(str(path), status.st_mtime_ns, status.st_size) if suffix in PROGRAMS else ""
        plan = next((plan.name for plan in plans if fingerprint and plan.fingerprint.startswith(fingerprint)), "")
        if suffix == ".json" and _is_message(str(path), status.st_mtime_ns, status.st_size):
            begun = [plan.name for plan in plans if path.stem.startswith(plan.name)]
            plan = max(begun, key=len, default="")  # a message of JSON has no place for a fingerprint
        if plan:
            programs.append(Program(path.name, plan, status.st_mtime))
        elif (
            not fingerprint
            and suffix in RECORDINGS
            and not path.name.endswith("-force.csv")
            and not _made_here(str(path), status.st_mtime_ns, status.st_size)
        ):
            files.append(Recording(path.name, False, status.st_mtime))
    return Workspace(machine, plans, _newest(programs[:MOST]), _newest([*runs, *files[:MOST]]), results)


RUN_FILE = "recording.csv"
"""File of a run in the folder of a rehearsal."""
BAG_INDEX = "metadata.yaml"
"""File beside the data of a ROS 2 bag."""
MARK = ".on-its-way"
"""File in a folder whose files are still to come; the server that takes them has it locked."""


def _run_of(root: Path, folder: Path) -> Recording | None:
    """The run in a folder of nothing but recorded files, or of a bag; None where it is no such folder."""
    if folder.name.startswith(".") or not folder.is_dir() or not folder.resolve().is_relative_to(root):
        return None
    entries = [entry for entry in sorted(folder.iterdir())[: MOST + 1] if not entry.name.startswith(".")]
    if (folder / MARK).exists():
        return None
    bag = any(entry.name == BAG_INDEX for entry in entries)
    recorded = [entry for entry in entries if entry.suffix.lower() in RECORDINGS and entry.is_file()]
    if not recorded or len(entries) > MOST or len(recorded) + bag != len(entries):
        return None
    parts = () if bag else tuple(entry.name for entry in recorded)
    return Recording(folder.name, False, folder.stat().st_mtime, (), parts)


def _newest(items: Any) -> Any:
    return tuple(sorted(items, key=lambda item: -item.time))


def _plan_basis(about: Mapping[str, Any], case: Case) -> dict[str, Any]:
    return plan_basis(case, int(about.get("payload", 0)), about.get("family") == "poses")


def _made(
    root: Path, name: str, case: Case, basis: Callable[[Mapping[str, Any], Case], dict[str, Any]]
) -> Iterator[Made]:
    for file in sorted(root.glob(f"*/{name}"))[:MOST]:
        if file.parent.name.startswith(".") or not file.resolve().is_relative_to(root):
            continue  # hidden: a command is at work on it, or was killed
        try:
            status = file.stat()
            record, fingerprint = _record(str(file), status.st_mtime_ns, status.st_size)
            of_this = record.get("case") == case.name
            changed = tuple(changes_since(record, basis(record, case), case.hash)) if of_this else ()
        except (OSError, RecursionError, HexciteError, *DAMAGED):
            continue  # the command that uses it says so
        if of_this:
            yield Made(file.parent.name, record, changed, status.st_mtime, fingerprint)


_ENTRIES: Mapping[str, tuple[type, ...]] = {
    **dict.fromkeys(("parameters", "limits", "predicted_std", COMPUTED_FROM), (dict,)),
    **dict.fromkeys(("tried", "settings", "asked", "budget", "run", "channel_noise", "pooled"), (dict, type(None))),
    **dict.fromkeys(("findings", "notes"), (list,)),
    "not_counted": (list, type(None)),
}
"""What stages look into of a record, with its kinds in JSON."""


def _require_sound(record: Any) -> None:
    """Raises ValueError for what no command has written: a record that was changed by hand, or is of other kinds."""
    if not isinstance(record, dict) or record.get(CONTENT) not in (None, content_of(record)):
        raise ValueError("was changed")
    tables = [record[name] for name in ("parameters", "budget") if isinstance(record.get(name), dict)]
    objects = [*(value for table in tables for value in table.values()), *record.get("findings", ())]
    if any(name in record and not isinstance(record[name], kinds) for name, kinds in _ENTRIES.items()) or not all(
        isinstance(value, dict) for value in objects
    ):
        raise ValueError("holds another kind of value")


@lru_cache(256)
def _record(file: str, time_ns: int, size: int) -> tuple[dict[str, Any], str]:
    content = read_whole(Path(file), MOST_JSON)  # of a file, not of a pipe, which would hold the page up
    record = json.loads(content)
    _require_sound(record)
    return record, hashlib.sha256(content).hexdigest()


@lru_cache(1024)
def _plan_of(file: str, time_ns: int, size: int) -> str:
    """The fingerprint of the plan that a program names; empty where it names none."""
    try:
        with open(file, "rb") as stream:
            match = _PLAN_HASH.search(stream.read(4096))
    except OSError:
        return ""
    return match[1].decode() if match else ""


def is_program(root: Path, name: str) -> bool:
    """Whether a file of the root is a program of hexcite, of whatever machine."""
    path = root / name
    if path.parent != root or path.suffix.lower() not in PROGRAMS or not path.is_file():
        return False
    status = path.stat()
    return bool(_plan_of(str(path), status.st_mtime_ns, status.st_size))


@lru_cache(1024)
def _is_message(file: str, time_ns: int, size: int) -> bool:
    """Whether a file is a joint trajectory."""
    try:
        with open(file, "rb") as stream:
            return stream.read(64).lstrip().startswith(b'{"joint_names"')
    except OSError:
        return False


@lru_cache(1024)
def _made_here(file: str, time_ns: int, size: int) -> bool:
    """Whether a file is an export of hexcite, which says so in its first lines."""
    try:
        with open(file, "rb") as stream:
            return b"made by hexcite" in stream.read(1024)
    except OSError:
        return False


def free(root: Path, name: str, taken: set[str], suffix: str = "") -> str:
    """A name in the root that nothing has, and no command under way will write."""
    k, candidate = 1, f"{name}{suffix}"
    while candidate in taken or (root / candidate).exists() or (root / candidate).is_symlink():
        k += 1
        candidate = f"{name}-{k}{suffix}"
    return candidate
