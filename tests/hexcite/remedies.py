"""Remedies as people follow them: what a message proposes, done to the command or to the case."""

import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import tomlkit


class Attempt(NamedTuple):
    """A command that was refused, in the folder where its files are."""

    folder: Path
    words: tuple[str, ...]
    wrong: str = ""  # the word that the message is about

    def without(self, word: str) -> tuple[str, ...]:
        """The words without an option, and without its value where it has one."""
        at = self.words.index(word)
        more = at + 1 < len(self.words) and not self.words[at + 1].startswith("-")
        return self.words[:at] + self.words[at + 1 + more :]

    def instead(self, new: str) -> tuple[str, ...]:
        """The words with another in place of the wrong one."""
        assert self.wrong in self.words, (self.wrong, self.words)
        return tuple(new if word == self.wrong else word for word in self.words)

    def output(self, suffix: str = "") -> tuple[str, ...]:
        """The words with another place to write to."""
        words = self.without("-o") if "-o" in self.words else self.words
        before = Path(self.words[self.words.index("-o") + 1]).suffix if "-o" in self.words else ""
        return (*words, "-o", f"another{suffix or before}")


def _set(attempt: Attempt, match: re.Match[str], within: str = "") -> tuple[str, ...]:
    """Sets a key of the case in the folder, of a table where it does not name it itself."""
    file = attempt.folder / "case.toml"
    document = tomlkit.parse(file.read_text(encoding="utf-8"))
    *tables, key = f"{within}{match['key']}".split(".")
    table = document
    for name in tables:
        table = table.setdefault(name, tomlkit.table())
    table[key] = tomlkit.parse(f"x = {match['value'].replace(chr(39), chr(34))}")["x"]
    file.write_text(tomlkit.dumps(document), encoding="utf-8")
    return attempt.words


def _set_of_recording(attempt: Attempt, match: re.Match[str]) -> tuple[str, ...]:
    return _set(attempt, match, "recording.")


def _meant(attempt: Attempt, match: re.Match[str]) -> tuple[str, ...]:
    """The right word in the command, or in the files of cases that it names."""
    if attempt.wrong in attempt.words:
        return attempt.instead(match[1])
    for file in (attempt.folder / word for word in attempt.words if word.endswith(".toml")):
        file.write_text(re.sub(rf"\b{attempt.wrong}\b", match[1], file.read_text(encoding="utf-8")), encoding="utf-8")
    return attempt.words


def _appended(attempt: Attempt, match: re.Match[str]) -> tuple[str, ...]:
    return (*attempt.words, *shlex.split(match[1]))


def _option_in_place(attempt: Attempt, match: re.Match[str]) -> tuple[str, ...]:
    """The option and value that a message writes out, in place of those with the wrong value."""
    at = attempt.words.index(attempt.wrong)
    return (*attempt.words[: at - 1], *shlex.split(match[1]), *attempt.words[at + 1 :])


WAYS: tuple[tuple[str, Callable[[Attempt, re.Match[str]], tuple[str, ...]]], ...] = (
    (r"set (?P<key>[a-z_]+(?:\.\w+)+) = (?P<value>'[^']*'|[\d.]+)", _set),
    (r"(?P<key>filter_cutoff_Hz) = [\d.]+ is too high .*; at most (?P<value>[\d.]+)", _set_of_recording),
    (r"did you mean '?([\w.-]+?)'?\?", _meant),
    (r"write (?:it|this one) with (--accept \S+)", _appended),
    (r"write (?:it as |an uncertain value as )?(--(?:fix|prior) \S+)", _option_in_place),
    (r"has no unit; give (\w+)", lambda a, m: a.instead(a.wrong + m[1])),
    (r"choose another place with -o", lambda a, m: a.output()),
    (r"name a file that ends in (\.\w+)", lambda a, m: a.output(m[1])),
    (r"programs end in (\.\w+)", lambda a, m: (*a.output(m[1]), "--accept", EVERYTHING)),
    (r"name a folder with -o", lambda a, m: (*a.without("-o"), "-o", "another")),
    (r"choose another --dialect", lambda a, m: (*a.instead("linuxcnc"), "--accept", EVERYTHING)),
    (r"replace it with (--overwrite)", _appended),
    (r"go on at your own risk with (--stale)", _appended),
    (r"name it with --case", lambda a, m: (*a.words, "--case", "hexapod")),
    (r"name its own case with --case", lambda a, m: a.instead("hexapod")),
    (r"(?:leave --case out|leave --poses and)", lambda a, m: a.without("--case")),
    (r"leave it out", lambda a, m: a.without(a.wrong)),
    (r"leave --count out", lambda a, m: a.without("--count")),
    (r"or choose (--family \w+)", lambda a, m: (*a.without("--family"), *m[1].split())),
    (r"choose (?:at least|at most|about) ([\d.]+)", lambda a, m: a.instead(m[1])),
    (r"choose (?:--\w+ )?([\d.]+) to [\d.]+", lambda a, m: a.instead(m[1])),
    (r"choose ([\d.]+) for a first try", lambda a, m: (*a.instead(m[1]), "--accept", EVERYTHING)),
    (r"; choose (?:from )?([A-Za-z0-9_-]+),", lambda a, m: a.instead(m[1])),
    (r"ask for (\d+) or more", lambda a, m: a.instead(m[1])),
    (r"export (--to c)\b", lambda a, m: a.instead("c")),
    (r"export with (--force)", _appended),
    (r"identify the run as a motion", lambda a, m: a.without("--standstills")),
    (r"(hexcite case new NAME --like \w+)", lambda a, m: a.instead("case.toml")),
    (r"as in (\d[\d,]*)$", lambda a, m: a.instead(m[1])),
)  # fmt: skip
"""How a remedy reads, and what a reader does to the command or the case."""
EVERYTHING = "acceleration,jerk,strut-acceleration,sensor-force"


def ways(message: str, attempt: Attempt) -> Iterator[Callable[[Attempt], tuple[str, ...]]]:
    """All that a message proposes, each as what makes the next command of an attempt."""
    for pattern, follow in WAYS:
        if match := re.search(pattern, message):
            yield lambda again, follow=follow, match=match: follow(again, match)
