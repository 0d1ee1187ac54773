"""Commands killed at random instants, and computers that let nobody write: artefacts are whole or absent."""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from tests.bench.reliability.tally import Tally
from tests.hexcite.command_line import ACCEPT, PROGRAM, hexcite

INTERRUPTED = 130  # exit code
LIMIT = 900.0  # [s] on the wall for a command on a busy computer


class Work(NamedTuple):
    """A command whose output can be whole or absent.

    Args:
        words: the command without its output.
        output: file or folder that it writes.
        parts: what must stand in a folder that is whole.
    """

    words: tuple[str, ...]
    output: str
    parts: tuple[str, ...] = ()


WORKS = {
    "plan": Work(
        ("plan", "hexapod", "--family", "manual", "--json"), "plan-new", ("plan.json", "motion.csv", "report.html")
    ),
    "run": Work(("run", "p.ngc", "--case", "hexapod", "--json"), "run-new", ("recording.json", "recording.csv")),
    "identify": Work(("identify", "run", "--json"), "result-new", ("result.json", "report.html")),
    "validate": Work(
        ("validate", "hexapod", "--weights", "0", "--methods", "D9M", "--on", "virtual", "--json"),
        "validation", ("validation.json", "report.html"),
    ),
    "study": Work(("study", "hexapod", "--spec", "small.toml", "--workers", "1", "--json"), "study"),
}  # fmt: skip
STUDY = 'schema_version = 1\nname = "small"\n[grid]\nfamily = "fourier"\norder = [2, 3]\nmodel = [0]\nseed = [0]\n'


def prepared(folder: Path) -> None:
    """What the commands begin with: a plan, its program, a run of it, and a cache of their own."""
    os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
    assert hexcite("plan", "hexapod", "--family", "manual", "-o", folder / "plan").code == 0
    assert hexcite("post", folder / "plan", *ACCEPT, "-o", folder / "p.ngc").code == 0
    assert hexcite("run", folder / "p.ngc", "--case", "hexapod", "-o", folder / "run").code == 0
    (folder / "small.toml").write_text(STUDY, encoding="utf-8")


def whole_or_absent(place: Path, parts: tuple[str, ...]) -> str | None:
    """What is wrong with an output; None where it is whole or not there."""
    if not place.exists():
        return None
    for file in place.rglob("*.json"):
        json.loads(file.read_text(encoding="utf-8"))
    missing = [part for part in parts if not (place / part).exists()]
    return f"{place.name} misses {', '.join(missing)}" if missing else None


def _started(work: Work, folder: Path, limits: Callable[[], None] | None = None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [PROGRAM, *work.words, "-o", work.output, *(["--overwrite"] if work.output != "study" else [])],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=limits,
    )  # fmt: skip


def _ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Exit code and standard error; whatever is left of its session is taken away."""
    try:
        _, said = process.communicate(timeout=LIMIT)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    return process.returncode, said


def tally_of_kills(seeds: range, folder: Path) -> Tally:
    """Commands that end by a signal at random instants of their work, one a seed, in turn; each is then repeated.

    Half of them by kill -9, the others by Ctrl-C or kill: these say what stands there, and leave nothing else.
    """
    tally, lasted = Tally("commands by signals"), dict.fromkeys(WORKS, 0.0)
    prepared(folder)
    for seed in seeds:
        name, draw = list(WORKS)[seed % len(WORKS)], random.Random(seed)
        work = WORKS[name]
        if not lasted[name]:  # how long it takes, undisturbed
            began = time.monotonic()
            code, said = _ended(_started(work, folder))
            lasted[name] = time.monotonic() - began
            if code:
                tally.defect(seed, f"{name} fails undisturbed: {said}")
                return tally
        if draw.random() < 0.5:
            _removed(folder / work.output)
        before, number = _parts(folder), draw.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
        process = _started(work, folder)
        time.sleep(draw.uniform(0.0, lasted[name]))
        if number == signal.SIGTERM:  # of one process, as `kill` sends it
            process.send_signal(number)
        else:
            os.killpg(process.pid, number)
        code, said = _ended(process)
        tally.counts["killed" if code < 0 else "over before" if code == 0 else "interrupted"] += 1
        if code == INTERRUPTED:
            if not said.splitlines()[-1].startswith("hexcite: interrupted; ") or "Traceback" in said:
                tally.defect(seed, f"{name} interrupted: {said}")
            if left := _parts(folder) - before:
                tally.defect(seed, f"{name} interrupted leaves {left}")
        elif code > 0:
            tally.defect(seed, f"{name} by {number.name}: exit code {code}, {said}")
        if problem := whole_or_absent(folder / work.output, work.parts):
            tally.defect(seed, f"{name} killed: {problem}")
        code, said = _ended(_started(work, folder))
        problem = whole_or_absent(folder / work.output, work.parts)
        if code or problem or not (folder / work.output).exists():
            tally.defect(seed, f"{name} repeated after a kill: exit code {code}, {said}, {problem}")
        print(tally.row(), file=sys.stderr, flush=True)
    return tally


def _parts(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir() if p.name.endswith((".part", ".old", ".try"))}


def _removed(place: Path) -> None:
    for path in (place, place.with_name(f"{place.name}.unfinished")):
        shutil.rmtree(path, ignore_errors=True)


SIZES = (0, 100, 4_000, 60_000, 400_000, 50_000_000)  # bytes of a file, reached early and late


def tally_of_full_disks(seeds: range, folder: Path) -> Tally:
    """Commands whose files may not grow beyond a size, one a seed, in turn, as on a disk that is full."""
    tally = Tally("commands on a full disk")
    prepared(folder)
    for k in seeds:
        size = SIZES[k % len(SIZES)]
        for name in ("plan", "run", "identify"):
            work = WORKS[name]
            _removed(folder / work.output)
            before = _parts(folder)  # of commands that were killed

            def limited(size: int = size) -> None:
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # as Python does: an error of the write
                resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

            code, said = _ended(_started(work, folder, limited))
            tally.counts["done" if code == 0 else "refused"] += 1
            one_line = said.count("\n") == 1 and "Traceback" not in said and "internal error" not in said
            if code not in (0, 1) or (code == 1 and not one_line):
                tally.defect(k, f"{name} with files of {size} bytes at most: exit code {code}, {said}")
            if problem := whole_or_absent(folder / work.output, work.parts):
                tally.defect(k, f"{name} with files of {size} bytes at most: {problem}")
            if left := _parts(folder) - before:
                tally.defect(k, f"{name} with files of {size} bytes at most leaves {left}")
    return tally
