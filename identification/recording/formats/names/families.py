"""Families of labels: columns whose names differ in one place, a number, an axis or the name of a joint.

A family is what a recorder writes of an array or of a vector: `q[0]` to `q[5]`, `/ft/force/x` to `/ft/force/z`, or one
label for each joint of a robot. Columns are read by families, so that no group is put together from names of two kinds.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from cases.base.unit_names import is_unit
from identification.recording.formats.names.labels import LONGEST

NUMBER, AXIS, JOINT = "#", "@", "&"  # what stands in the words of a family for the place in which its labels differ
AXES = "xyz"

_BRACKETED = re.compile(r"[\[({<]([^\[\](){}<>]*)[\])}>]")
_ADDRESS = re.compile(r"\s*(?:[+-]?\d+|[XYZABCUWxyzabcuw]|[A-Za-z]\d+|.*[,;].*)\s*")  # index, axis, parts of an address
_UNIT_WORDS = frozenset(
    {"mm", "um", "cm", "m", "deg", "grad", "rad", "mrad", "n", "kn", "nm", "nmm", "s", "ms", "us", "ns", "lbf"}
)
"""Units that end a name without brackets, as in `Fx_N`."""
_PREFIX = re.compile(r"(?<![^\W\d_])(?:lr|fb|di|[abdfnrw])(?=[A-Z][a-z]{2})")  # kinds of variables, as in fActPosition
_WORD = re.compile(
    r"\d+(?:st|nd|rd|th)(?![a-z])"  # an ordinal is a word, not a number
    r"|\d+"
    r"|[A-Z]+(?=[A-Z][a-z]{2})"  # TCPForce
    r"|[A-ZÄÖÜ]?[a-zäöüßµ]+"
    r"|[A-ZÄÖÜ]+"
    r"|[^\W\d_]"
)


@dataclass(frozen=True, slots=True)
class Family:
    """Labels that differ in one place, or one label alone."""

    words: tuple[str, ...]  # of all of them, with NUMBER, AXIS or JOINT in the place in which they differ
    members: Mapping[int, int]  # number, axis or joint, counted from the first of them as 0 -> position in the file

    @property
    def axis(self) -> int | None:
        """The place of the word that names an axis; None where the labels do not differ in that."""
        return next((i for i, word in enumerate(self.words) if word.endswith(AXIS)), None)

    @property
    def rest(self) -> tuple[str, ...]:
        """The words that all of its labels have, of an axis the beginning of its word too: `f` of `fx`."""
        words = (word.removesuffix(AXIS) if word.endswith(AXIS) else word for word in self.words)
        return tuple(word for word in words if word and word not in (NUMBER, JOINT))


def words_of(name: str) -> tuple[str, ...]:
    """Words and numbers of a name, in small letters, without a unit: `Axis1.Pos[0] [mm]` is axis, 1, pos, 0."""
    if len(name) > LONGEST:
        return ()
    bare = _BRACKETED.sub(
        lambda found: found[0] if _ADDRESS.fullmatch(found[1]) or not _is_unit(found[1]) else " ", name
    )
    words = tuple(word.lower() for word in _WORD.findall(_PREFIX.sub("", bare)))
    if len(words) < 2 or words[-1] not in _UNIT_WORDS:
        return words
    return words[:-2] if len(words) > 2 and words[-2] == "in" else words[:-1]  # as in `Fx in N`


def _is_unit(text: str) -> bool:
    return is_unit(text) or not any(map(str.isalpha, text))


def families(labels: Mapping[int, Sequence[str]], joints: Sequence[str] | None = None) -> Iterator[Family]:
    """All families that are whole: numbers in sequence, three axes, all joints.

    Args:
        labels: position in the file -> words of the column's name.
        joints: names of the joints of a chain; None: the machine is not a chain.
    """
    groups: dict[tuple[str, ...], dict[int, list[int]]] = {}
    spelled = [] if joints is None else _spellings(joints)
    for k, label in labels.items():
        for words, member in _places(tuple(label), spelled):
            groups.setdefault(words, {}).setdefault(member, []).append(k)
    for words, members in groups.items():
        if any(len(columns) > 1 for columns in members.values()):
            continue  # names that are there twice say nothing
        first = min(members)
        if NUMBER in words:
            whole = len(members) > 1 and max(members) - first == len(members) - 1
        elif JOINT in words:
            whole = len(members) == len(joints or ())
        else:
            whole = len(members) == len(AXES)
        if whole:
            yield Family(words, {number - first: columns[0] for number, columns in sorted(members.items())})


def _places(
    words: tuple[str, ...], joints: Sequence[tuple[int, tuple[str, ...]]]
) -> Iterator[tuple[tuple[str, ...], int]]:
    """The families that a label may be of, each with its number, axis or joint in it."""
    for i, word in enumerate(words):
        before, behind = words[:i], words[i + 1 :]
        if word.isdecimal():
            yield (*before, NUMBER, *behind), int(word)
            for j in (j for j, other in enumerate(behind) if other == word):  # of `ActPos3 [u1; 3]` both
                yield (*before, NUMBER, *behind[:j], NUMBER, *behind[j + 1 :]), int(word)
        elif word[-1] in AXES:
            yield (*before, word[:-1] + AXIS, *behind), AXES.index(word[-1])
        for number, joint in joints:
            if words[i : i + len(joint)] == joint:
                yield (*before, JOINT, *words[i + len(joint) :]), number


def _spellings(joints: Sequence[str]) -> list[tuple[int, tuple[str, ...]]]:
    """Words of each joint's name, also without a word such as joint where it is told from the others all the same."""
    full = [words_of(joint) for joint in joints]
    short = [tuple(word for word in words if word not in ("joint", "axis")) for words in full]
    distinct = len(set(short)) == len(short) and all(short)
    spellings = [*enumerate(full), *(enumerate(short) if distinct else ())]
    return [
        (number, words) for number, words in dict.fromkeys(spellings) if words and not all(map(str.isdecimal, words))
    ]
