"""Damaged programs of every dialect: what is still called proven other judges must let pass.

The judges share nothing with the readers: a naive reading of moves at a feed, divided differences of timed points, and
for LinuxCNC its own interpreter, `rs274`.
"""

import random
import re
from collections.abc import Callable
from functools import cache

import numpy as np

from cases.schema import Case, load_case
from postprocessors.program import dialect
from postprocessors.proof.proof import ProgramProof, prove_program
from postprocessors.reading import Reading, Timed
from tests.bench.reliability.tables import damaged_table
from tests.bench.reliability.tally import Tally, tallied
from tests.postprocessors.canonical import interpreted_share, missing_interpreter
from tests.postprocessors.edited import moves, path
from tests.postprocessors.independent import share_of_limits
from tests.postprocessors.naive import naive_share
from tests.postprocessors.other_dialects import BOTH, LINUXCNC, Typed, smooth_points
from tests.postprocessors.programs import there_and_back
from tests.postprocessors.tables import as_csv, share_as_driven

CASE = load_case("hexapod")
ROUNDED = 1.0 + 1e-3  # of a limit
CHARACTERS = "0123456789.-+ XYZABCFGMPIJK()[]=\n;,eE%#/$\"'\t\u00e9\u0661"
_POLY = (
    "G64 G93\nPOLY PO[X]=(0.01,0,0.01) PO[C]=(0.001,0,0.001) PL=1 F600\n"
    "POLY PO[X]=(0.02,0.01,-0.01) PO[C]=(0.002) F600\nG94 G60 G1\nDO $A_OUT[1]=0\nG4 F0.1"
)
_TYPED = {
    "linuxcnc": "(small)\nG4 P0.1\nM64 P0\n{path}\nM65 P0\nG1 X5 A1 F3000\nG0 X0 Y0 Z900 A0\nG17 G3 X0 Y0 I5 J0 F3000",
    "sinumerik": f"; small\nDO $A_OUT[1]=1\n{{path}}\n{_POLY}\nG1 X5 A2=1 F3000\nG0 X0 Y0 Z900 A2=0\n"
    "G17 G3 X0 Y0 I5 J0 F3000",
    "twincat": "; small\nM100\n{path}\nM101\nG04 0.1\n"
    "G1 G60 X5 A1 F3000\nG0 G60 X0 Y0 Z900 A0\nG17 G3 G60 X0 Y0 I5 J0 F3000",
}


@cache
def originals(name: str) -> tuple[str, ...]:
    """Programs of a dialect: moves, a dense path as it is written, and a bit of everything."""
    typed = {t.name: t for t in (*BOTH, LINUXCNC)}[name]
    return moves(name), path(name), typed.text(_TYPED[name].format(path=typed.timed(_points(typed))))


def _points(typed: Typed) -> list[str]:
    return there_and_back(10) if typed is LINUXCNC else smooth_points(typed, "X", 2.0, 6)


def edited(text: str, draw: random.Random) -> str:
    """The text with a character, a number, a word or a line lost, doubled, swapped or changed."""
    kind = draw.choice(["character", "digit", "sign", "point", "delete", "double", "swap", "word", "letter", "end"])
    if kind == "character":
        k, character = draw.randrange(len(text)), draw.choice(CHARACTERS)
        return text[:k] + draw.choice([character, "", character + text[k], text[k] * 2]) + text[k + 1 :]
    if kind == "end":
        return text[: draw.randrange(len(text))] if draw.random() < 0.2 else text + draw.choice(CHARACTERS)
    lines = text.rstrip("\n").split("\n")
    if kind in ("delete", "double", "swap"):
        k = draw.randrange(max(1, len(lines) - 1))
        new = {"delete": lines[k + 1 : k + 2], "double": [lines[k], *lines[k : k + 2]], "swap": lines[k : k + 2][::-1]}
        lines[k : k + 2] = new[kind]
        return "\n".join(lines) + "\n"
    pattern = {"word": r"\b[GM]\d+\b ?", "letter": r"[XYZABC](?=-?\d)"}.get(kind, r"(?<=[XYZABCFIJ=])-?\d+(?:\.\d+)?")
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    match = draw.choice(found)
    old = match[0]
    k = draw.randrange(len(old))
    word = {
        "digit": lambda: old[:k] + (str(draw.randrange(10)) if old[k].isdigit() else old[k]) + old[k + 1 :],
        "sign": lambda: old[1:] if old[0] == "-" else f"-{old}",
        "point": lambda: f"{float(old) * 10 ** draw.choice([-1, 0, 1]):.6f}",
        "word": lambda: "",
        "letter": lambda: draw.choice("XYZABC"),
    }[kind]()
    return text[: match.start()] + word + text[match.end() :]


def _proven(name: str, content: bytes, case: Case) -> tuple[Reading, ProgramProof]:
    language = dialect(name)
    reading = language.read(content, "p", case)
    return reading, prove_program(reading, language.guarantees(reading, case))


def tally_of_programs(name: str, seeds: range) -> Tally:
    """Damaged programs of a dialect, read and proven; of LinuxCNC's each one that is accepted is interpreted too."""
    interpreter = name == "linuxcnc" and missing_interpreter() is None
    judged_by_rs274 = 0

    def one(seed: int, tally: Tally) -> None:
        nonlocal judged_by_rs274
        draw = random.Random(seed)
        which = seed % len(originals(name))
        text = originals(name)[which]
        for _ in range(draw.randint(1, 5)):
            text = edited(text, draw)
        content = text.encode("utf-8" if draw.random() < 0.1 else "latin-1", "replace")
        found = tally.attempt(seed, lambda: _proven(name, content, CASE), "p")
        if found is None:
            return
        reading, proof = found
        if proof.ok != (not proof.violations) or not np.isfinite(proof.duration):
            tally.defect(seed, "the proof contradicts itself")
        if any(not 1 <= v.line <= text.count("\n") + 1 for v in proof.violations):
            tally.defect(seed, "a violation in a line that is not there")
        if not proof.ok:
            return
        tally.counts.update({"answered": -1, "proven": 1})
        shares: dict[str, float | str] = {}
        for stretch in reading.stretches:
            if isinstance(stretch, Timed) and hasattr(stretch.points, "poses"):
                shares["timed points"] = share_of_limits(stretch.points.times, stretch.points.poses, CASE)
        if which == 0:
            shares["a naive reading"] = naive_share(name, text)
        if interpreter:
            judged_by_rs274 += 1
            shares["rs274"] = interpreted_share(content, CASE)
        for judge, share in shares.items():
            if isinstance(share, str) or not share <= ROUNDED:
                tally.defect(seed, f"proven, but {judge} finds {share} of a limit in\n{text}")

    tally = tallied(f"{name} programs", seeds, one)
    if interpreter:
        tally.what += f", {judged_by_rs274} accepted ones judged by rs274"
    return tally


def tally_of_tables(seeds: range) -> Tally:
    """Damaged tables of setpoints, read and proven."""

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        table = damaged_table(draw)
        content = as_csv(table)
        found = tally.attempt(seed, lambda: _proven("setpoints", content, CASE), "p")
        if found is not None and found[1].ok:
            tally.counts.update({"answered": -1, "proven": 1})
            if not share_as_driven(table) <= ROUNDED:
                tally.defect(seed, f"proven, but {share_as_driven(table):.4g} of a limit as driven")

    return tallied("tables of setpoints", seeds, one)


DIALECTS: dict[str, Callable[[range], Tally]] = {
    **{name: (lambda seeds, name=name: tally_of_programs(name, seeds)) for name in _TYPED},
    "setpoints": tally_of_tables,
}
"""Dialect -> its tally over seeds."""
