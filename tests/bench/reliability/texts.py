"""Text files of every format that is known, damaged and re-arranged: `look` and the reader answer, or refuse in a line.

A base is a short run as a recorder writes it. Damages are those of words, lines and bytes that any text can have; and
those of files: cut, joined, stored in another encoding, compressed, with another file's header.
"""

import gzip
import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from cases.schema import Case
from identification.recording.formats.words import MISSING
from tests.bench.reliability.looked import as_proposed, as_stated
from tests.bench.reliability.recordings import ODD, stained
from tests.bench.reliability.tally import Tally, tallied
from tests.identification.recording.formats import test_lvm, test_shapes, test_sinumerik, test_twincat
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, case_with, csv, rows
from tests.identification.recording.formats.test_halsampler import sampled

RUN = Truth()
SIGNALS = dict(zip(NAMES[1:], test_sinumerik.SIGNALS, strict=True))


@cache
def bases() -> dict[str, tuple[Case, str]]:
    """A file of each layout, and a case that reads it; by name."""
    pins, numbers = {"column_names": NAMES[1:], "clock": {"period_ms": 1.0}}, RUN.numbers()[:, 1:]
    scope: dict[str, list[Any]] = {
        "shared": [True, False],
        "eof": [True, False],
        "delimiter": ["\t", ";"],
        "decimal": [",", "."],
    }
    found: dict[str, tuple[Case, str]] = {
        "commas": (HEXAPOD, csv(RUN.numbers())),
        "semicolons": (case_with(delimiter=";", decimal=","), csv(RUN.numbers(), delimiter=";", decimal=",")),
        "headless": (case_with(column_names=NAMES), "\n".join(rows(RUN.numbers()))),
        "halsampler": (case_with(format="halsampler", **pins), sampled(numbers, tagged=False)),
        "halsampler -t": (case_with(**pins), "overrun\n" + sampled(numbers, tagged=True, first=3)),
        "session": (case_with(columns=SIGNALS), test_sinumerik.session(test_sinumerik.sparse())),
        "trace": (
            case_with(columns=SIGNALS | {"t_s": "time"}),
            "\n".join([",".join(["time", *test_sinumerik.SIGNALS]), *test_sinumerik.sparse()]),
        ),
    }
    for key, choices in scope.items():
        for choice in choices:
            case = test_twincat.case(decimal=choice if key == "decimal" else ",")
            found[f"Scope, {key} {choice!r}"] = case, test_twincat.exported(test_twincat.both(), **{key: choice})
    found |= {f"LVM, {how}": (test_lvm.CASE, form.text()) for how, form in test_lvm.WRITTEN.items()}
    found |= {f"shape, {how}": (HEXAPOD, text) for how, text in test_shapes.READABLE.items()}
    found |= {
        f"header, {how}": (HEXAPOD, "\n".join([*lines, *test_shapes.ROWS]) + "\n")
        for how, lines in test_shapes.HEADERS.items()
    }
    return found


def _words_changed(text: str, draw: random.Random) -> str:
    """Some fields replaced by words that stand in fields of the field."""
    lines = text.split("\n")
    separator = max(",;\t ", key=lines[len(lines) // 2].count)
    words = [
        *ODD,
        *MISSING,
        "TRUE",
        "FALSE",
        "12:34:56",
        "2024-03-05T10:11:12",
        "1.5D+03",
        "******",
        "\ufeff",
        "Ω",
        "\x1a",
    ]
    for _ in range(draw.randint(1, 6)):
        k = draw.randrange(len(lines))
        fields = lines[k].split(separator)
        fields[draw.randrange(len(fields))] = draw.choice(words)
        lines[k] = separator.join(fields)
    return "\n".join(lines)


def _fields_moved(text: str, draw: random.Random) -> str:
    """Columns left out, doubled or exchanged, in all lines or in some."""
    lines = text.split("\n")
    separator = max(",;\t ", key=lines[len(lines) // 2].count)
    a, b, how, part = draw.randrange(16), draw.randrange(16), draw.randrange(4), draw.choice([1.0, 0.5, 0.05])
    result = []
    for line in lines:
        fields = line.split(separator)
        if draw.random() < part and max(a, b) < len(fields):
            if how == 0:
                del fields[a]
            elif how == 1:
                fields.insert(b, fields[a])
            elif how == 2:
                fields[a], fields[b] = fields[b], fields[a]
            else:
                fields.append(draw.choice(["", "", "a remark", "1"]))
        result.append(separator.join(fields))
    return "\n".join(result)


def _lines_moved(text: str, draw: random.Random) -> str:
    """A part of the lines left out, doubled, shuffled or put at another place."""
    lines = text.split("\n")
    start = draw.randrange(len(lines))
    part = slice(start, start + draw.randint(1, 12))
    cut, rest = lines[part], lines[: part.start] + lines[part.stop :]
    match draw.randrange(4):
        case 0:
            lines = rest
        case 1:
            lines = lines[: part.start] + cut + lines[part.start :]
        case 2:
            draw.shuffle(cut)
            lines[part] = cut
        case _:
            at = draw.randrange(len(rest) + 1)
            lines = rest[:at] + cut + rest[at:]
    return "\n".join(lines)


def _joined(text: str, draw: random.Random) -> str:
    """Parts of two files behind each other."""
    other = draw.choice([other for _, other in bases().values()])
    return text[: draw.randrange(len(text))] + other[draw.randrange(len(other)) :]


def _signs_changed(text: str, draw: random.Random) -> str:
    """Separators, decimal signs, quotes or ends of lines exchanged."""
    exchanged = [
        (",", ";"), (";", ","), (".", ","), (",", "\t"), ("\t", " "), (" ", "  "), ("\n", "\r\n"), ("\n", "\r"),
        ("\n", "\n\n"), (",", '","'), ("\n", ",\n"), ("\n", " \n"), ("e", "D"), ("0", "O"), ("\n", "\n#"),
        ("<", "&lt;"),
    ]  # fmt: skip
    old, new = draw.choice(exchanged)
    return text.replace(old, new, draw.choice([-1, -1, draw.randint(1, 40)]))


def _stained(text: str, draw: random.Random) -> str:
    return stained(text.encode("latin-1", "replace").decode("latin-1"), draw).decode("latin-1")


DAMAGES: tuple[Callable[[str, random.Random], str], ...] = (
    _words_changed, _fields_moved, _lines_moved, _joined, _signs_changed, _stained,
)  # fmt: skip


def _stored(text: str, draw: random.Random) -> bytes:
    """The text in bytes: in some encoding, some of them damaged, or compressed."""
    encoding = draw.choice(["utf-8", "utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le", "utf-32"])
    data = text.encode(encoding, "replace")
    for _ in range(draw.choice([0, 0, 0, 1, 4])):
        at = draw.randrange(len(data) + 1)
        data = data[:at] + bytes(draw.choices(range(256), k=draw.randrange(4))) + data[at + draw.randrange(4) :]
    if draw.random() < 0.1:
        data = gzip.compress(data)
    if draw.random() < 0.1:
        data = data[: draw.randrange(len(data) + 1)] + bytes(draw.choice([0, 3, 5000]))
    return data


def damaged(seed: int) -> tuple[str, Case, bytes]:
    """Name of the layout, the case that reads it, and the file of a seed."""
    draw = random.Random(seed)
    name = list(bases())[seed % len(bases())]
    case, text = bases()[name]
    for _ in range(draw.choice([0, 1, 1, 1, 2, 3])):
        text = draw.choice(DAMAGES)(text, draw)
    return name, case, _stored(text, draw)


def tally_of_texts(seeds: range, folder: Path) -> Tally:
    """Damaged files of each format: read as the case says, looked at, and read as is proposed."""
    file = folder / "run.txt"

    def one(seed: int, tally: Tally) -> None:
        name, case, content = damaged(seed)
        file.write_bytes(content)
        as_stated(file, case, name, seed, tally)
        for own in (case, HEXAPOD):
            as_proposed(file, own, name, seed, tally)

    return tallied("texts of all formats", seeds, one)
