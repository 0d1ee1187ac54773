"""Files and folders that are either whole or absent, also when the process is killed while it writes."""

import errno
import glob
import hashlib
import json
import logging
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from itertools import chain, count
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from cases.base.errors import WITH_OUTPUT, Code, FileProblem, option


class FolderKind(NamedTuple):
    """A kind of folder that hexcite writes."""

    name: str  # what it is, for messages
    contents: frozenset[str]  # names of everything that it may hold
    record: str = ""  # the file that says what it is; folders of 0.2 are known by it, later ones by their marker
    beside: frozenset[str] = frozenset()  # what others may make of it there, and may be replaced too


MARKER = ".hexcite"
"""The file in a folder of ours that lists all its files: what is not listed is not ours."""
_RECORDED = frozenset({"case", "case_hash", "rows", "schema_version", "source"})  # keys of our records, one at least
_DRAWN = frozenset({".parquet", ".csv", ".json", ".html", ".svg", ".png", ".ngc", ".mpf", ".nc", ".script", ".yaml"})
_DEEPEST = 3  # folders of 0.2 inside each other

PLAN = FolderKind("a plan", frozenset({"plan.json", "motion.csv", "poses.csv", "plots", "report.html"}), "plan.json")
RUN = FolderKind("a run", frozenset({"recording.json", "recording.csv"}), "recording.json")
RESULT = FolderKind(
    "a result", frozenset({"result.json", "identifiability.json", "plots", "report.html", "runs"}), "result.json"
)
COMPARISON = FolderKind("a comparison", frozenset({"comparison.json", "report.html", "plots"}), "comparison.json")
VALIDATION = FolderKind(
    "a validation", frozenset({"validation.json", "report.html", "plots", "plans", "programs"}), "validation.json"
)
DEMO = FolderKind(
    "a demo",
    frozenset({"plan", "recording", "result", "report.html", "manual", "fourier"})
    | {f"excitation{suffix}" for suffix in (".ngc", ".mpf", ".nc", ".csv", ".script", ".yaml")},
    "plan/plan.json",
)


def _flush(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Raises FileProblem where the system refuses to write to a place."""
    try:
        yield
    except FileProblem:  # of something else that the block read or wrote
        raise
    except OSError as error:
        raise FileProblem(
            place=path,
            problem=f"cannot be written ({_reason(error)})",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        ) from error


def _reason(error: OSError) -> str:
    return error.strerror or str(error)


def umask() -> int:
    """The permissions that new files of this process lack."""
    current = os.umask(0)
    os.umask(current)
    return current


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yields a path to write to; it appears as `path` when the block ends without an error. Raises FileProblem."""
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        _clear_leftovers(path)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=PART, dir=path.parent)
        os.close(handle)
        part = Path(name)
        try:
            with in_use(part):
                yield part
                part.chmod(0o666 & ~umask())
                _flush(part)
                os.replace(part, path)
            WRITTEN.info("%s", path)
        finally:
            part.unlink(missing_ok=True)


WRITTEN = logging.getLogger("hexcite.written")
"""Where each file and folder is logged as it appears."""
ABANDONED = 5.0  # [s] after which what nobody has locked is a leftover: it is locked as soon as it is made
PART, TRY, OLD = ".hexcite.part", ".hexcite.try", ".hexcite.old"
"""How names of what is half written, tried, or set aside end; they begin with a dot and the name of the place."""
_LEFTOVER = re.compile(r"\.(?P<place>.+)\.[a-z0-9_]{8}(?P<kind>\.hexcite\.(part|try|old))", re.DOTALL)


@contextmanager
def in_use(part: Path) -> Iterator[None]:
    """Inside, other commands know that a file or folder under way is not a leftover; a killed process lets go of it."""
    handle = None
    with suppress(OSError):
        handle = os.open(part, os.O_RDONLY)
    try:
        if handle is not None:
            _locked(handle)
        yield
    finally:
        if handle is not None:
            os.close(handle)


def _locked(handle: int) -> bool:
    """Whether an open file or folder is locked by this call; False where another process has it, or none can."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (ImportError, OSError):
        return False
    return True


def _clear_leftovers(path: Path) -> None:
    """Removes what commands that were killed left of a place, half written."""
    for suffix in (PART, TRY):
        for part in path.parent.glob(f".{glob.escape(path.name)}.*{suffix}"):
            _clear(part)


def _clear(part: Path) -> None:
    """Removes what is half written, where no process has it any more."""
    with suppress(OSError):
        if part.is_symlink():
            return
        with abandoned(part) as is_so:
            if is_so:
                shutil.rmtree(part, ignore_errors=True) if part.is_dir() else part.unlink()


@contextmanager
def abandoned(part: Path) -> Iterator[bool]:
    """Whether no process has a file or folder that is under way; inside, no other one takes it for a leftover.

    Raises:
        OSError: it cannot be looked at.
    """
    if time.time() - part.lstat().st_mtime < ABANDONED:
        yield False
        return
    handle = os.open(part, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))  # whatever stands there
    try:
        yield _locked(handle)
    finally:
        os.close(handle)


def tidy(folder: Path) -> list[Path]:
    """Clears a folder of what killed commands left in it; returns places whose earlier content stands there again.

    What is half written goes. What a command had set aside to replace it, and did not, comes back to its place.
    """
    back = []
    for part in sorted(folder.iterdir()):
        known = _LEFTOVER.fullmatch(part.name)
        if known is None:
            continue
        if known["kind"] != OLD:
            _clear(part)
            continue
        place = folder / known["place"]
        with suppress(OSError):
            if part.is_symlink() or not part.is_dir() or time.time() - part.lstat().st_mtime < ABANDONED:
                continue
            if not os.path.lexists(place):
                os.rename(part / place.name, place)
                back.append(place)
                part.rmdir()
            elif not any(part.iterdir()):
                part.rmdir()
    return back


def free_name(path: Path, separator: str = "-") -> Path:
    """`path` where nothing stands there, else the first of path-2, path-3, .. that is free."""
    names = (path.with_name(f"{path.stem}{separator}{k}{path.suffix}") for k in count(2))
    return next(p for p in chain([path], names) if not os.path.lexists(p))


def output_place(named: Path | None, usual: Path, overwrite: bool, separator: str = "-") -> Path:
    """Where a command writes: the place that was named with -o, else the usual one, or a free name beside it."""
    if named is not None:
        return named
    return usual if overwrite else free_name(usual, separator)


def _refuse_to_replace(path: Path, content: str) -> NoReturn:
    raise FileProblem(
        place=path,
        problem=f"{content} stands there",
        remedy=f"choose another place{WITH_OUTPUT}, or replace it with {option('overwrite')}",
        code=Code.EXISTS,
    )


def check_file(path: Path, suffixes: Iterable[str], inputs: Iterable[Path] = (), overwrite: bool = False) -> None:
    """Raises FileProblem, before the work starts, for an output file that could not be written, or has a wrong ending.

    Args:
        suffixes: endings that it may have, in lower case; upper case in `path` is as good.
        inputs: what the work reads, which is never overwritten.
        overwrite: whether a file that stands there may be replaced.
    """
    allowed = tuple(suffixes)
    if path.suffix.lower() not in allowed:
        ending = repr(path.suffix) if path.suffix else "no suffix"
        raise FileProblem(
            place=path,
            problem=f"ends in {ending}",
            remedy=f"name a file that ends in {' or '.join(allowed)}",
            code=Code.WRONG_KIND,
        )
    _require_place(path)
    if path.is_dir():
        raise FileProblem(
            place=path, problem="is a folder", remedy=f"name a file in it{WITH_OUTPUT}", code=Code.WRONG_KIND
        )
    for source in inputs:
        if path.exists() and source.exists() and path.samefile(source):
            raise FileProblem(
                place=path,
                problem="is also what is read",
                remedy=f"choose another place{WITH_OUTPUT}",
                code=Code.NOT_WRITABLE,
            )
    if path.exists() and not overwrite:
        _refuse_to_replace(path, "a file")


def check_folder(path: Path, kind: FolderKind, inputs: Iterable[Path] = (), overwrite: bool = False) -> None:
    """Raises FileProblem, before the work starts, for an output folder that could not be written.

    A folder that stands there is replaced only if it is empty, or of the same kind, with nothing else in it, and
    `overwrite` is set, so that no slip of `-o` wipes what is not ours, or another result of ours. None of `inputs`,
    which the work reads, may be in it.
    """
    if path.resolve() == Path.cwd() or path.resolve() in Path.cwd().parents:
        raise FileProblem(
            place=path,
            problem="is the folder that you work in",
            remedy=f"name a new one{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    for source in inputs:
        if path.resolve() in (source.resolve(), *source.resolve().parents):
            raise FileProblem(
                place=path,
                problem=f"holds {source}, which is read",
                remedy=f"choose another place{WITH_OUTPUT}",
                code=Code.NOT_WRITABLE,
            )
    if os.path.islink(path):
        raise FileProblem(
            place=path,
            problem="exists and is not a folder but a link",
            remedy=f"name the folder itself{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    entries, other = _looked_at(path, kind)
    if other:
        raise FileProblem(
            place=path,
            problem=f"is not {kind.name} of hexcite's ({other})",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    if entries and not overwrite:
        _refuse_to_replace(path, kind.name)
    if entries and not _may_be_written(path):
        raise FileProblem(
            place=path,
            problem="cannot be replaced (Permission denied)",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    _require_place(path)


_LOOKS = 100  # at a folder that other commands are replacing


def _may_be_written(path: Path) -> bool:
    """Whether what stands at a place may be replaced; where nothing does, another command has just set it aside."""
    return any(os.access(path, os.W_OK) or not os.path.lexists(path) for _ in range(_LOOKS))


def _looked_at(path: Path, kind: FolderKind) -> tuple[set[str], str]:
    """Names in a folder, and what is not ours in it, both of one folder: another command may be replacing it."""
    for _ in range(_LOOKS):
        before = _identity(path)
        try:
            entries = {entry.name for entry in path.iterdir()}
        except (NotADirectoryError, FileNotFoundError) as error:
            # where a file stands above it, this is reported later
            if isinstance(error, NotADirectoryError) and os.path.lexists(path):
                raise FileProblem(
                    place=path,
                    problem="exists and is not a folder",
                    remedy=f"choose another place{WITH_OUTPUT}",
                    code=Code.NOT_WRITABLE,
                ) from error
            return set(), ""
        except OSError as error:
            raise FileProblem(
                place=path,
                problem=f"cannot be read ({_reason(error)})",
                remedy=f"choose another place{WITH_OUTPUT}",
                code=Code.NOT_WRITABLE,
            ) from error
        other = _foreign(path, entries, kind) if entries else ""
        if _identity(path) == before:
            break
    return entries, other


def _identity(path: Path) -> int | None:
    """Number of a folder on its disk; None where there is none."""
    try:
        return path.stat().st_ino
    except (OSError, ValueError):
        return None


def _foreign(path: Path, entries: set[str], kind: FolderKind) -> str:
    """What says that a folder is not one of a kind that hexcite wrote; empty where it is."""
    marked = _marked(path)
    if marked is None or marked[0] != kind.name:
        if others := sorted(entries - kind.contents - {MARKER}):
            return f"it holds {others[0]}"
        if marked is not None:
            return f"it is {marked[0]}"
        if kind.record and not _is_record(path / kind.record):
            return f"it has no {kind.record} of hexcite's"
    for name in _files(path):
        of_the_kind = len(name.parts) <= _DEEPEST and (len(name.parts) == 1 or name.suffix in _DRAWN)
        listed = of_the_kind if marked is None else name.as_posix() in marked[1]
        if not listed and name.name != MARKER and name.as_posix() not in kind.beside:
            return f"it holds {name}"
    return ""


def _marked(path: Path) -> tuple[str, frozenset[str]] | None:
    """Kind and files of a folder by its marker; None where it has none that says them."""
    try:
        content = json.loads(read_whole(path / MARKER, MOST_JSON))
        return str(content["kind"]), frozenset(map(str, content["files"]))
    except (FileProblem, *DAMAGED, RecursionError):
        return None


def _is_record(file: Path) -> bool:
    """Whether a file is one of ours by which folders without a marker are known."""
    try:
        content = read_whole(file, MOST_JSON)
        return b"hexcite" in content if file.suffix == ".h" else not _RECORDED.isdisjoint(json.loads(content))
    except (FileProblem, *DAMAGED, RecursionError):
        return False


def _files(folder: Path) -> Iterator[Path]:
    """Everything in a folder but folders with something in them, relative to it."""
    for place, folders, files in os.walk(folder):
        below = Path(place).relative_to(folder)
        links = [name for name in folders if os.path.islink(os.path.join(place, name))]
        yield from (below / name for name in (*files, *links))
        if not folders and not files and below.parts:
            yield below


LEAST_SPACE = 2**23  # bytes that results, with their pages, take at most


def _require_place(path: Path) -> None:
    """Tries to write beside `path`, since permission bits do not say all that a file system allows."""
    above = next(p for p in path.absolute().parents if os.path.lexists(p))
    try:
        os.rmdir(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=TRY, dir=above))
    except OSError as error:
        reason = _reason(error) if above.is_dir() else f"{above} is not a folder"
        raise FileProblem(
            place=path,
            problem=f"cannot be written ({reason})",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        ) from error
    if (free := shutil.disk_usage(above).free) < LEAST_SPACE:
        raise FileProblem(
            place=path,
            problem=f"cannot be written ({free / 2**20:.1f} MB are left there)",
            remedy="make room there",
            code=Code.NOT_WRITABLE,
        )


@contextmanager
def atomic_folder(path: Path, kind: FolderKind, overwrite: bool = False) -> Iterator[Path]:
    """Yields an empty folder to fill; it takes the place of `path` only when the block ends without an error.

    With `overwrite`, a folder of the same kind is replaced as a whole. Without, what another command has written there
    in the meantime stays, and the new folder appears under a free name beside it: FileProblem names that, or why the
    place cannot be written.
    """
    check_folder(path, kind, overwrite=True)
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        _clear_leftovers(path)
        part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=PART, dir=path.parent))
        try:
            with in_use(part):
                yield part
                listed = {"kind": kind.name, "files": sorted(name.as_posix() for name in _files(part))}
                (part / MARKER).write_text(json_text(listed), encoding="utf-8")
                part.chmod(0o777 & ~umask())
                for file in part.rglob("*"):
                    _flush(file)
                placed = _put(part, path, overwrite)
            WRITTEN.info("%s", placed)
            if placed != path:
                raise FileProblem(
                    place=path,
                    problem=f"{kind.name} stands there by now and stays",
                    remedy=f"the new one is in {placed}",
                    code=Code.EXISTS,
                )
        finally:
            shutil.rmtree(part, ignore_errors=True)


def _put(part: Path, path: Path, overwrite: bool) -> Path:
    """Renames a folder to `path`, or to a free name where another stands there and stays; returns where it is.

    Other commands may write the same folder at the same time: whoever comes first or last, each finds a place.
    """
    place, aside = path, list[Path]()
    try:
        while True:
            try:
                os.rename(part, place)
                return place
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
            with suppress(FileNotFoundError):  # another command has just set it aside
                if overwrite or not any(path.iterdir()):
                    aside.append(Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=OLD, dir=path.parent)))
                    os.rename(path, aside[-1] / path.name)
                else:
                    place = free_name(path)
    except OSError:
        if aside and not path.exists():
            os.rename(aside[-1] / path.name, path)
        raise
    finally:
        for old in aside:
            shutil.rmtree(old, ignore_errors=True)


MOST_JSON = 64 * 2**20
"""Bytes of a JSON file that is read; those of plans and results are far smaller."""


def read_whole(path: Path, most: int) -> bytes:
    """All that a file of at most `most` bytes holds.

    Raises:
        FileProblem: there is no such file, it is larger, or it is a pipe or device, which may never end.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            kind = "a folder" if path.is_dir() else "a pipe or device"
            raise FileProblem(
                place=path,
                problem=f"cannot be read (is {kind}, not a file)",
                remedy="name a file",
                code=Code.UNREADABLE,
            )
        with open(path, "rb", opener=_at_once) as stream:
            content: bytes | None = stream.read(most + 1)
        if content is None:
            raise FileProblem(
                place=path,
                problem="cannot be read (it holds nothing that is there at once)",
                remedy="name a file",
                code=Code.UNREADABLE,
            )
    except FileProblem:
        raise
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        reason = _reason(error) if isinstance(error, OSError) else str(error)
        raise FileProblem(
            place=path, problem=f"cannot be read ({reason})", remedy="name a readable file", code=Code.UNREADABLE
        ) from error
    if len(content) > most:
        raise FileProblem(
            place=path, problem=f"is larger than {most / 2**20:g} MB", remedy="name another file", code=Code.UNREADABLE
        )
    return content


def _at_once(name: str, flags: int) -> int:
    """Opens a file of which a read answers at once, also where the system only calls it a file (/proc/kmsg)."""
    return os.open(name, flags | getattr(os, "O_NONBLOCK", 0))


def write_text(path: Path, text: str) -> None:
    """Writes `text` to `path` as a whole or not at all."""
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")


_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")  # of TOML, which needs no quotes


def toml_text(values: Mapping[str, Any], table: str = "") -> str:
    """TOML of plain values: tables as sections, those in lists inline."""
    tables = {key: value for key, value in values.items() if isinstance(value, dict)}
    lines = [f"{_toml_key(key)} = {toml_value(value)}" for key, value in values.items() if key not in tables]
    lines = [*([f"[{table}]"] if table and (lines or not tables) else []), *lines]
    for key, value in tables.items():
        lines += ["", toml_text(value, f"{table}.{_toml_key(key)}" if table else _toml_key(key))]
    return "\n".join(lines)


def toml_value(value: Any) -> str:
    """A value as TOML writes it in one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_toml_key(key)} = {toml_value(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    text = json.dumps(value, ensure_ascii=False)
    return text if text.isprintable() else "".join(c if c.isprintable() else _of_toml(c) for c in text)


def ascii_text(text: str) -> str:
    """A text in double quotes and plain ASCII, as TOML and YAML write it."""
    return "".join(c if c.isascii() else _of_toml(c) for c in json.dumps(text, ensure_ascii=False))


def _of_toml(character: str) -> str:
    """A character that no paper shows, as TOML and YAML write it."""
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _toml_key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else toml_value(key)


def json_text(value: Any) -> str:
    """JSON with two-space indent; NaN and infinity are refused, since they are not JSON."""
    return json.dumps(value, indent=2, allow_nan=False) + "\n"


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a number of JSON")


def read_json(path: Path, made_by: str) -> dict[str, Any]:
    """Reads a JSON object; raises FileProblem, which names the command that writes such files, where there is none."""
    try:
        value = json.loads(read_whole(path, MOST_JSON).decode("utf-8"), parse_constant=_refuse)
    except FileProblem as error:
        raise FileProblem(
            place=path, problem=error.problem, remedy=f"{made_by} writes it", code=Code.UNREADABLE
        ) from error
    except ValueError as error:
        raise FileProblem(
            place=path, problem=f"is not JSON ({error})", remedy=f"write it again with {made_by}", code=Code.DAMAGED
        ) from error
    except RecursionError as error:
        raise FileProblem(
            place=path, problem="is nested too deeply", remedy=f"write it again with {made_by}", code=Code.DAMAGED
        ) from error
    if not isinstance(value, dict):
        raise FileProblem(
            place=path, problem="holds no JSON object", remedy=f"write it again with {made_by}", code=Code.DAMAGED
        )
    return value


DAMAGED = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError)
"""What a JSON object raises where it is taken apart and is not of the shape that `the command gave it."""

_TOOLS = ("hexcite", "numpy", "scipy", "casadi", "pyarrow")


def provenance(files: Sequence[Path]) -> dict[str, Any]:
    """Origin of what was computed from files: `inputs`, each with its SHA-256, and `versions`."""
    return {"inputs": [{"file": str(f), "sha256": sha256_of(f)} for f in files], "versions": _versions()}


def date_of(files: Sequence[Path]) -> str:
    """When the first of files was written, as its folder says, in ISO 8601 with its zone, to the second."""
    first = min(file.stat().st_mtime for file in files)
    return datetime.fromtimestamp(first).astimezone().isoformat(timespec="seconds")


def sha256_of(file: Path) -> str:
    """SHA-256 of what a file holds, read piece by piece."""
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _versions() -> dict[str, str]:
    from importlib.metadata import PackageNotFoundError, version  # which `hexcite --help` does without

    versions = {}
    for name in _TOOLS:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:  # run from a folder that was never installed
            versions[name] = "unknown"
    return versions
