"""Every remedy of a list of messages is followed, word by word, and the error goes."""

import json
import shutil
from contextlib import chdir
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomlkit

from cases.tables import built_in_cases
from tests.hexcite.command_line import call
from tests.hexcite.remedies import EVERYTHING, Attempt, ways

COMMANDS: list[tuple[str, str]] = [  # the command, with the wrong word behind a bar where the remedy replaces one
    ("identify run.csv", ""),
    ("identify run -o result", ""),
    ("identify run --model 12", "12"),
    ("identify run --fix m=31+-1kg", "m=31+-1kg"),
    ("identify run --fix m", "m"),
    ("identify run --fix m=31", "m=31"),
    ("identify run --prior m=31kg", "m=31kg"),
    ("identify run --drop k33", "k33"),
    ("identify run --weights equals", "equals"),
    ("identify run --standstills", ""),
    ("identify kN.csv --case case.toml", ""),
    ("identify mm.csv --case case.toml", ""),
    ("identify ms.csv --case case.toml", ""),
    ("identify seldom.csv --case case.toml", ""),
    ("post plan --dialect linuxcnc", ""),
    ("post plan -o p.txt", ""),
    ("post plan --dialect linuxcnc -o p.mpf", ""),
    (f"post plan --accept {EVERYTHING} -o program.ngc", ""),
    ("post plan --speed 2", "2"),
    ("post plan --dialect ros2", "ros2"),
    ("post plan --dialect urscript", "urscript"),
    ("post plan --dialect linuxnc", "linuxnc"),
    ("post plan --accept jerkk", "jerkk"),
    ("post stale", ""),
    ("check program.ngc --case ur10_wrist", "ur10_wrist"),
    ("check program.ngc --case hexpod", "hexpod"),
    ("run program.ngc --case hexapod --on virtul -o r2", "virtul"),
    ("run program.ngc --case hexapod --on virtual -o run", ""),
    ("run program.ngc --case hexapod --on virtual --payload 99 -o r3", "99"),
    ("plan hexapod --family ptp --order 3 -o p", "--order"),
    ("plan hexapod --family ptp --moves 1 -o p --duration 8", "1"),
    ("plan hexapod --family ptp --duration 0.01 -o p", "0.01"),
    ("plan hexapod --family splin -o p", "splin"),
    ("plan hexapod --criterion d -o p", "d"),
    ("plan hexapod --starts 0 -o p", "0"),
    ("plan hexapod --payload 17 -o p", "17"),
    ("plan hexapod -o result", ""),
    ("poses hexapod --count 2 -o p", "2"),
    ("poses hexapod --method backwards -o p", "backwards"),
    ("poses hexapod --method all --count 7 -o p", ""),
    ("export result --to urscript", "urscript"),
    ("export result --to Linuxcnc", "Linuxcnc"),
    ("export result --to c -o x.c", ""),
    ("export result --to json -o x.txt", ""),
    ("export doubtful --to json -o x.json", ""),
    ("force run --parameters result -o run.csv", ""),
    ("force run --parameters result -o f.txt", ""),
    ("tare standing.csv --parameters result -o result", ""),
    ("compare plan result --case ur10_wrist -o c", "ur10_wrist"),
    ("compare plan result -o result", ""),
    ("validate hexapod --weights 3 --methods D9M -o v", "3"),
    ("validate hexapod --weights 0 --methods D9n -o v", "D9n"),
    ("look run.csv --case hexapod -o x.txt", ""),
    ("look run.csv --write hexapod", "hexapod"),
    ("case check typo.toml", "blok_ms"),
]  # fmt: skip
FAST = (
    "check",
    "export",
    "look",
    "case",
    "post plan -o",
    "post plan --dialect ros2",
    "identify run --prior",
)  # in `make test`
STEPS = 2  # further errors that may come after the first


@pytest.fixture(scope="session")
def desk(shared: Path, chain: dict[str, dict[str, Any]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan, its program, run and result, and files with one mistake each."""
    folder = tmp_path_factory.mktemp("desk")
    for name, source in {"plan": "plan", "run": "recording", "result": "result"}.items():
        shutil.copytree(shared / source, folder / name)
    shutil.copy(shared / "excitation.ngc", folder / "program.ngc")
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8")
    (folder / "case.toml").write_text(text, encoding="utf-8")
    header, *rows = (folder / "run" / "recording.csv").read_text().splitlines()
    header = header.replace('"', "")
    names, table = header.split(","), np.array([row.split(",") for row in rows], dtype=float)
    forces = np.array([name.startswith("f") for name in names])
    struts, time = np.array([name.startswith("l") for name in names]), np.array(names) == "t_s"
    factors = {"kN": (forces, 1e-3), "mm": (struts, 1e-3), "ms": (time, 1e3), "seldom": (time, 1.0)}
    for name, (columns, factor) in factors.items():
        changed = np.where(columns, table * factor, table)
        if name == "seldom":  # a rate for which the filter is too high
            changed = changed[::8]
        np.savetxt(folder / f"{name}.csv", changed, delimiter=",", header=header, comments="", fmt="%.9g")
    standing = np.repeat(table[:1], 400, axis=0)
    standing[:, time] = np.arange(400)[:, None] * 1e-3
    standing[:, forces] += np.random.default_rng(0).normal(0.0, 0.1, (400, 6))
    np.savetxt(folder / "standing.csv", standing, delimiter=",", header=header, comments="", fmt="%.9g")
    shutil.copy(folder / "run" / "recording.csv", folder / "run.csv")
    _doubtful(folder)
    _stale(folder, text)
    (folder / "typo.toml").write_text(text.replace("\nblock_ms", "\nblok_ms"), encoding="utf-8")
    return folder


def _doubtful(folder: Path) -> None:
    """A result of which a finding says that its values are in doubt."""
    shutil.copytree(folder / "result", folder / "doubtful")
    file = folder / "doubtful" / "result.json"
    record = json.loads(file.read_text())
    record.pop("content")  # results of 0.2 have none
    said = {"kind": "model", "severity": "warning", "sentence": "a contact", "place": "", "quantity": {}}
    file.write_text(json.dumps(record | {"findings": [said]}))


def _stale(folder: Path, text: str) -> None:
    """A plan of a case that has changed since."""
    case = folder / "own" / "case.toml"
    case.parent.mkdir()
    case.write_text(text.replace('name = "hexapod"', 'name = "own"'), encoding="utf-8")
    with chdir(folder):
        assert call("poses", "own/case.toml", "--count", "20", "-o", "stale").code == 0
    document = tomlkit.parse(case.read_text(encoding="utf-8"))
    document["nominal"]["mass_kg"] = 30.0
    case.write_text(tomlkit.dumps(document), encoding="utf-8")


def copied(desk: Path, place: Path) -> Path:
    """The desk in another folder, on which a remedy may be tried."""
    shutil.copytree(desk, place)
    return place


def refusal(words: tuple[str, ...]) -> str | None:
    """The message of a command that is refused; None where it is not."""
    answer = call(*words)
    assert "internal error" not in answer.err, answer.err
    return None if answer.code == 0 else answer.err + answer.out


@pytest.mark.parametrize(
    ("command", "wrong"),
    [
        pytest.param(command, wrong, marks=[] if command.startswith(FAST) else [pytest.mark.slow], id=command)
        for command, wrong in COMMANDS
    ],
)
def test_a_remedy_works(command: str, wrong: str, desk: Path, tmp_path: Path) -> None:
    """Each way that the message offers is tried on a fresh desk: the same message does not come again."""
    words = tuple(command.split())
    attempt = Attempt(copied(desk, tmp_path / "0"), words, wrong)
    with chdir(attempt.folder):
        message = refusal(words)
    assert message is not None, "it is not refused"
    offered = [*ways(message, attempt)]
    assert offered, message
    for number, follow in enumerate(offered, 1):
        folder = copied(desk, tmp_path / str(number))
        with chdir(folder):
            again = follow(attempt._replace(folder=folder))
            after = refusal(again)
            for _ in range(STEPS):  # another error, which has a remedy of its own
                if after is None or after == message:
                    break
                further = attempt._replace(folder=folder, words=again)
                again = next(ways(after, further))(further)
                after = refusal(again)
        assert after is None, (message, again, after)
