"""What became of many damaged inputs: how many were answered, refused in one line, or met a defect."""

import contextlib
import signal
import sys
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeVar

from cases.base.errors import HexciteError
from tests.helpers import one_line

Answer = TypeVar("Answer")

PROGRESS = 100  # inputs after which a long tally says how far it is
HANG = 20.0  # [s] of processor time: the computer may have other work


class Hang(BaseException):
    """A call that takes longer than `HANG`."""


@dataclass
class Tally:
    """Counts of one kind of input.

    Args:
        what: kind of input, for people.
        counts: inputs by outcome.
        defects: what is wrong, each with the seed that repeats it.
    """

    what: str
    counts: Counter[str] = field(default_factory=Counter)
    defects: list[str] = field(default_factory=list)

    @property
    def tried(self) -> int:
        """Number of inputs."""
        return self.counts.total()

    def attempt(self, seed: int, call: Callable[[], Answer], place: str) -> Answer | None:
        """What the call answers; None where it refuses in one line that names `place`, or meets a defect."""
        try:
            with warnings.catch_warnings(), _limited():
                warnings.simplefilter("error")
                answer = call()
        except HexciteError as error:
            self.counts["refused"] += 1
            try:
                line = one_line(error)
            except AssertionError as odd:
                self.defect(seed, f"message {odd}")
            else:
                if place not in line:
                    self.defect(seed, f"the message does not name {place}: {line}")
            return None
        except Hang:
            self.counts["hung"] += 1
            self.defect(seed, f"took more than {HANG:g} s")
            return None
        except Exception:
            self.counts["broke"] += 1
            self.defect(seed, traceback.format_exc(limit=-4))
            return None
        self.counts["answered"] += 1
        return answer

    def defect(self, seed: int, words: str) -> None:
        """Notes a defect, and prints it: a night may be stopped before its end."""
        self.defects.append(f"{self.what}, seed {seed}: {words}")
        print(self.defects[-1], file=sys.stderr, flush=True)

    def row(self) -> list[str]:
        """The row of a table of figures."""
        outcomes = ", ".join(f"{count} {name}" for name, count in sorted(self.counts.items()))
        return [f"{self.tried} damaged {self.what} ({outcomes}): defects", str(len(self.defects)), "0"]


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise Hang

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, HANG)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def tallied(what: str, seeds: range, one: Callable[[int, Tally], None]) -> Tally:
    """The tally of a kind of input; `one` tries one seed."""
    tally = Tally(what)
    for seed in seeds:
        one(seed, tally)
        if tally.tried % PROGRESS == 0:
            print(*tally.row(), file=sys.stderr, flush=True)
    return tally
