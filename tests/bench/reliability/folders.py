"""Damaged cases, and folders of plans, runs and results: refused in one line, or used with every limit satisfied."""

import json
import random
import tempfile
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from cases.base.errors import Code, HexciteError
from cases.readiness import readiness
from cases.schema import load_case
from cases.tables import built_in_cases
from hexcite.reports.case_figures import case_figures, has_motion_box, leftovers
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording
from planner.box.reach import reach
from postprocessors.program import read_program
from postprocessors.proof.proof import prove_program
from tests.bench.reliability.programs import ROUNDED
from tests.bench.reliability.recordings import file_of, simulated, stained
from tests.bench.reliability.tally import Tally, tallied
from tests.bench.reliability.trees import damaged
from tests.cases.editing import written
from tests.hexcite.command_line import Answer, call, hexcite
from tests.postprocessors.canonical import interpreted_share, missing_interpreter
from tests.postprocessors.edited import moves

ACCEPT = ("--accept", "velocity,acceleration,jerk,strut-velocity,strut-acceleration,sensor-force")
IDENTIFIED = 10  # one folder of a run of so many is identified
SECOND = 2  # files are damaged as text in one of so many tries, as data in the others


def tally_of_cases(seeds: range, folder: Path) -> Tally:
    """Damaged cases, through all that `hexcite case check` says of them."""
    originals = {name: file.read_text(encoding="utf-8") for name, file in built_in_cases().items()}

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        text = originals["hexapod" if draw.random() < 0.7 else draw.choice(list(originals))]
        if seed % SECOND:
            data = tomllib.loads(text)
            for _ in range(draw.randint(1, 3)):
                data = damaged(data, draw)
            file = written(folder, _without_none(data))
        else:
            file = str(folder / "case.toml")
            Path(file).write_bytes(stained(text, draw))

        def check():
            case = load_case(file)
            return (
                case_figures(case, file),
                case,
                reach(case) if has_motion_box(case) else None,
                readiness(case),
                leftovers(case),
            )

        found = tally.attempt(seed, check, file)
        if found is None:
            return
        figures, case, reached, *_ = found
        json.dumps(figures, allow_nan=False)
        if has_motion_box(case) and case.hexapod is not None:
            home = case.machine.home.vector
            again = Hexapod.of(case).poses(Hexapod.of(case).strut_lengths(home[None]))[0]
            if not np.allclose(again, home, rtol=0.0, atol=1e-6):
                tally.defect(seed, f"home {home} is taken for {again}")
            if not 0.0 <= reached.share <= 1.0:
                tally.defect(seed, f"reach {reached.share}")

    return tallied("cases", seeds, one)


def _without_none(value):
    if isinstance(value, dict):
        return {k: _without_none(v) for k, v in value.items() if v is not None}
    return [_without_none(v) for v in value if v is not None] if isinstance(value, list) else value


@cache
def _plans() -> tuple[dict[str, bytes], ...]:
    """Files of plans: a hand-made motion, a Fourier series, moves, poses."""
    quick = ("--starts", 1, "--duration", 6)
    commands = (
        ("plan", "hexapod", "--family", "manual"),
        ("plan", "hexapod", "--family", "fourier", "--order", 2, "--model", 0, *quick),
        ("plan", "hexapod", "--family", "ptp", "--moves", 8, *quick),
        ("poses", "hexapod", "--count", 6, "--method", "backward", "--candidates", 60),
    )
    return tuple(_made(command) for command in commands)


@cache
def _result() -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as name:
        run = Path(name) / "run.csv"
        run.write_bytes(file_of(simulated().rows))
        return _made(("identify", run, "--case", "hexapod"))


def _made(command: tuple[object, ...]) -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as name:
        answer = hexcite(*command, "-o", Path(name) / "made")
        assert answer.code == 0, answer
        return {f.name: f.read_bytes() for f in (Path(name) / "made").iterdir() if f.suffix in (".json", ".csv")}


def _lay(folder: Path, files: dict[str, bytes], main: str, draw: random.Random, seed: int) -> None:
    """Writes the files with one of them damaged."""
    for name, content in files.items():
        if name == main and seed % SECOND:
            data = json.loads(content)
            if draw.random() < 0.5:
                data.pop("content", None)  # as version 0.2 wrote it
            for _ in range(draw.randint(1, 2)):
                data = damaged(data, draw)
            content = json.dumps(data).encode()
        elif name == main or draw.random() < 0.1:
            content = stained(content.decode(), draw)
        if draw.random() > 0.01:
            (folder / name).write_bytes(content)


def _tried(tally: Tally, seed: int, place: str, *words: object) -> Answer | None:
    """The answer of a command that succeeds; its refusal counts as such."""

    def command() -> Answer:
        answer = call(*words)
        if answer.code == 1 and "internal error" not in answer.err and answer.err.count("\n") == 1:
            raise HexciteError(problem=answer.err.rstrip("\n"), code=Code.WRONG_KIND)
        if (answer.code, answer.err) != (0, ""):
            raise RuntimeError(f"{words}: {answer}")
        return answer

    return tally.attempt(seed, command, place)


def tally_of_plans(seeds: range, folder: Path) -> Tally:
    """Damaged plan folders, from which programs are written; these are judged by `check` and by rs274."""

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        with tempfile.TemporaryDirectory(dir=folder) as name:
            plan, program = Path(name) / "plan", Path(name) / "p.ngc"
            plan.mkdir()
            _lay(plan, draw.choice(_plans()), "plan.json", draw, seed)
            if _tried(tally, seed, name, "post", plan, *ACCEPT, "-o", program, "--json") is None:
                return
            case = load_case("hexapod")
            read = read_program(program, case)
            if not prove_program(read.reading, read.guarantees).ok:
                tally.defect(seed, "a program is written that is not proven")
            share = 0.0 if missing_interpreter() else interpreted_share(read.content, case)
            if isinstance(share, str) or not share <= ROUNDED:
                tally.defect(seed, f"a program is written that uses {share} of a limit as rs274 understands it")

    return tallied("plan folders", seeds, one)


@cache
def _run() -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as name:
        program = Path(name) / "p.ngc"
        program.write_text(moves("linuxcnc"), encoding="ascii")
        return _made(("run", program, "--case", "hexapod"))


def tally_of_recordings(seeds: range, folder: Path) -> Tally:
    """Damaged folders of runs, read with the case that they name; one in so many is identified too."""

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        with tempfile.TemporaryDirectory(dir=folder) as name:
            run = Path(name) / "run"
            run.mkdir()
            _lay(run, _run(), "recording.json", draw, seed)
            recording = tally.attempt(seed, lambda: Recording.load(run), "")
            if recording is None:
                return
            if not (repr(recording).isascii() and np.isfinite(recording.forces).all()):
                tally.defect(seed, f"not finite, or no text: {recording!r}")
            if seed % IDENTIFIED == 0:
                _tried(tally, seed, "", "identify", run, "-o", Path(name) / "result", "--json")

    return tallied("folders of runs", seeds, one)


def tally_of_results(seeds: range, folder: Path) -> Tally:
    """Damaged result folders, through the commands that take them."""

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        with tempfile.TemporaryDirectory(dir=folder) as name:
            result = Path(name) / "result"
            result.mkdir()
            _lay(result, _result(), "result.json", draw, seed)
            commands: tuple[Callable[[], tuple[object, ...]], ...] = (
                lambda: ("export", result, "--to", "json", "--force", "-o", Path(name) / "m.json"),
                lambda: ("export", result, "--to", "c", "--force", "-o", Path(name) / "c"),
                lambda: ("compare", result, "-o", Path(name) / "comparison"),
                lambda: ("payload", result, result),
            )
            answer = _tried(tally, seed, "result" if seed % 4 < 3 else "", *commands[seed % 4](), "--json")
            if answer is not None and "NaN" in answer.out:
                tally.defect(seed, "an answer that is not JSON")

    return tallied("result folders", seeds, one)
