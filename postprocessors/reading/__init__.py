"""What a program says, after reading and before any judgement: moves, dwells and trigger switches with their lines."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cases.chain import Chain
from cases.errors import ProgramError
from identification.trajectories.moves import Plane

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Move:
    """A straight move in the six coordinates."""

    line: int  # line of the program, counted from 1
    end: Array  # pose at its end, shape (6,) [m, rad]
    duration: float | None  # that the text states [s]; None where the controller times the move itself
    # along XYZ [m/s], or along ABC [rad/s] where XYZ stands still; None where a duration is stated, or of a rapid
    feed: float | None
    exact_stop: bool  # whether the controller comes to rest at the end
    linear: bool  # whether X, Y or Z moves by the controller's own measure: then a feed counts them, else the angles
    # indices of the coordinates of a chain whose way a feed counts; None as `linear` says
    counted: tuple[int, ...] | None = None
    # acceleration of that way, where the text states it: its time law is then the text's [m/s^2 or rad/s^2]
    acceleration: float | None = None


@dataclass(frozen=True, slots=True)
class Turn:
    """A circular move of the origin in a coordinate plane; the other coordinates change in proportion."""

    line: int  # line of the program
    end: Array  # pose at its end, shape (6,) [m, rad]
    plane: Plane  # plane in which it lies
    centre: Array  # along the plane's first and second axis, absolute in {B}, shape (2,) [m]
    angle: float  # turned about the plane's normal, positive counter-clockwise, at most a full circle [rad]
    feed: float  # along the arc [m/s]
    exact_stop: bool  # whether the controller comes to rest at the end


@dataclass(frozen=True, slots=True)
class Polynomial:
    """A polynomial piece in the six coordinates: sum_i c_i p^i for p from 0 to 1."""

    line: int  # line of the program
    coefficients: Array  # c_0 (where the machine stands) to c_d, shape (d + 1, 6) [m, rad]
    duration: float  # if p is passed evenly over it [s]

    @property
    def end(self) -> Array:
        """Pose at its end, shape (6,) [m, rad]."""
        return np.asarray(self.coefficients.sum(axis=0))


@dataclass(frozen=True, slots=True)
class Stand:
    """The machine must stand here before the program starts: the program itself does not bring it there."""

    line: int  # line of the program
    pose: Array  # shape (6,) [m, rad]


@dataclass(frozen=True, slots=True)
class TableRows:
    """A path given row by row, from rest to rest."""

    line: int  # line of the program that holds its first row; the others follow line by line
    cycle: float  # time from row to row [s]
    poses: Array  # shape (k, 6) [m, rad]
    rates: Array  # shape (k, 6) [m/s, rad/s]
    accelerations: Array  # shape (k, 6) [m/s^2, rad/s^2]


@dataclass(frozen=True, slots=True)
class Pause:
    """Standing still for `duration` [s]."""

    line: int
    duration: float


@dataclass(frozen=True, slots=True)
class Switch:
    """The trigger goes on or off."""

    line: int  # line of the program
    on: bool  # what it becomes
    at_once: bool  # now, once all motion before has ended; else with the start of the next move


Event = Stand | Move | Turn | Polynomial | TableRows | Pause | Switch


@dataclass(frozen=True, slots=True)
class Reading:
    """A program as read."""

    file: str  # its name, for messages
    events: tuple[Event, ...]  # events in order
    blocks: int  # number of lines that hold words
    # words that are missing before its first move, without which what another program left shifts its poses
    unsaid: tuple[str, ...] = ()


Found = TypeVar("Found")

_INK = re.compile(r"\S")


def program_lines(text: str, file: str, longest: int, most: float = math.inf) -> list[str]:
    """The lines of a program; only line feeds end one.

    Args:
        text: text of the program, one character a byte (latin-1), so that columns are right whatever the encoding
            really is.
        longest: most characters that the controller takes in a line.
        most: most lines with content that its memory holds.

    Raises:
        ProgramError: a character that is not plain ASCII, a line too long, too many lines; with line and column.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    count = 0
    for number, line in enumerate(lines, start=1):
        if not line.isascii() or not line.replace("\t", " ").isprintable():
            column = next(k for k, c in enumerate(line) if c != "\t" and not " " <= c <= "~")
            raise ProgramError(
                file, number, column + 1, f"character {line[column]!r} is not plain ASCII; remove or replace it"
            )
        if len(line) > longest:
            raise ProgramError(file, number, 0, f"{len(line)} characters, the controller takes {longest}; split it")
        count += bool(line.strip())
        if count > most:
            raise ProgramError(
                file,
                number,
                0,
                f"more than {most} blocks, which is what the controller's memory holds (most_blocks); make the program "
                "shorter, its timed blocks longer, or the memory larger",
            )
    return lines


def each_word(
    text: str,
    position: int,
    pattern: re.Pattern[str],
    found: Callable[[re.Match[str], int], Found],
    unreadable: Callable[[int, str], ProgramError],
) -> Iterator[Found]:
    """What stands in a line from a position on, word by word.

    Args:
        unreadable: makes an error of the column and the first characters of what is not a word.

    Raises:
        ProgramError: something is not a word.
    """
    while (ink := _INK.search(text, position)) is not None:
        match = pattern.match(text, position)
        if match is None:
            raise unreadable(ink.start() + 1, text[ink.start() : ink.start() + 12].rstrip())
        yield found(match, ink.start() + 1)
        position = match.end()


def axis_letters(chain: Chain, controller: str, file: str, endless: bool = True) -> str:
    """The axis of each joint of a chain, which is the joint's name.

    Args:
        endless: whether its axes that turn without end count their turns.

    Raises:
        ProgramError: a joint whose name is not an axis of its kind, or whose turns the controller does not count.
    """
    for joint in chain.joints:
        letters = "ABC" if joint.turns else "XYZ"
        if joint.name not in tuple(letters):
            problem = f"joint {joint.name} {'turns' if joint.turns else 'slides'} and is not an axis of {controller}"
            remedy = (
                f"name it {', '.join(letters)} in machine.chain, or write with --dialect urscript, ros2 or setpoints"
            )
            raise ProgramError(file, 0, 0, f"{problem}; {remedy}")
        if joint.kind == "continuous" and not endless:
            problem = (
                f"joint {joint.name} turns without end: as a modulo axis it would not count its turns on {controller}"
            )
            remedy = 'set the axis up without modulo, and state it as kind = "revolute" with position_deg'
            raise ProgramError(file, 0, 0, f"{problem}; {remedy}")
    return "".join(chain.names)
