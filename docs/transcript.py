"""Runs the commands that a page shows, and compares what they print with what the page shows.

    python docs/transcript.py docs/tutorial.md      # writes the outputs anew

A block ```` ```console ```` holds commands, each behind `$ `, and below each what it prints. A line `...` stands for
any lines. Words must be the same; numbers may differ by `TOLERANCE`, or by one in the last digit that is shown, for
optimisers and libraries round differently on each processor.
"""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path

TOLERANCE = Decimal("0.3")
_BLOCK = re.compile(r"(?<=^```console\n)(.*?)(?=^```$)", re.M | re.S)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_REST = "..."


def steps_of(page: str) -> Iterator[tuple[str, list[str]]]:
    """The commands of a page as they are typed, each with the lines that the page shows below it."""
    for block in _BLOCK.findall(page):
        for part in re.split(r"^\$ ", block, flags=re.M)[1:]:
            command, *shown = part.splitlines()
            yield command, shown


def printed(command: str, folder: Path) -> list[str]:
    """Lines that a command prints, on both streams, without blank lines and trailing blanks."""
    words = shlex.split(command, comments=True)
    if words[0] == "hexcite":
        words[0] = str(Path(sys.executable).with_name("hexcite"))
    environment = os.environ | {"COLUMNS": "100"}
    done = subprocess.run(
        words, cwd=folder, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    return [line.rstrip() for line in done.stdout.splitlines() if line.strip()]


def matched(shown: Sequence[str], lines: Sequence[str]) -> list[str]:
    """The lines of an output that a page shows, with `...` for the others.

    Raises:
        ValueError: a line of the page is not in the output.
    """
    found: list[str] = []
    place = 0
    for k, line in enumerate(shown):
        if line == _REST:
            found.append(line)
            continue
        free = k > 0 and shown[k - 1] == _REST
        there = [n for n in range(place, len(lines)) if _words(lines[n]) == _words(line)]
        if not there or (not free and there[0] != place):
            raise ValueError(f"the page shows {line!r}, the command printed:\n" + "\n".join(lines))
        found.append(lines[there[0]])
        place = there[0] + 1
    if place < len(lines) and (not shown or shown[-1] != _REST):
        raise ValueError("the page does not show:\n" + "\n".join(lines[place:]))
    return found


def far_off(shown: str, line: str) -> bool:
    """Whether a number of a line differs from the page's by more than `TOLERANCE` and by more than its last digit."""
    pairs = zip(_NUMBER.findall(shown), _NUMBER.findall(line), strict=True)
    return any(abs(Decimal(a) - Decimal(b)) > max(TOLERANCE * abs(Decimal(a)), _last_digit(a)) for a, b in pairs)


def _last_digit(number: str) -> Decimal:
    """What one in the last digit of a number is worth."""
    exponent = Decimal(number).as_tuple().exponent
    assert isinstance(exponent, int)  # not of NaN
    return Decimal(1).scaleb(exponent)


def _words(line: str) -> str:
    return " ".join(_NUMBER.sub("#", line).split()).replace("─", "")


def rewritten(page: str, folder: Path) -> str:
    """The page with the outputs that its commands have now."""

    def block(match: re.Match[str]) -> str:
        lines: list[str] = []
        for command, shown in steps_of(f"```console\n{match[1]}```\n"):
            output = printed(command, folder)
            lines += [f"$ {command}", *(matched(shown, output) if shown else output)]
        return "".join(f"{line}\n" for line in lines)

    return _BLOCK.sub(block, page)


if __name__ == "__main__":
    import tempfile

    for name in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as place:
            text = rewritten(Path(name).read_text(encoding="utf-8"), Path(place))
        Path(name).write_text(text, encoding="utf-8")
