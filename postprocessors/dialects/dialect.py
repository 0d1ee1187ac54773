"""A controller's language as a value: how its programs are written and read, and what its controller promises."""

from collections.abc import Callable
from dataclasses import dataclass

from cases.controller import ControllerName
from cases.schema import Case
from postprocessors.blocks import Blocks
from postprocessors.proof.guarantees import Guarantees
from postprocessors.reading import Reading


def _as_it_is(program: Blocks, case: Case) -> Blocks:
    return program


def _in_its_only_form(content: bytes, suffix: str, case: Case) -> bytes:
    return content


@dataclass(frozen=True, slots=True)
class Dialect:
    """A controller's language, and the functions that write and read it."""

    name: ControllerName  # name on the command line
    suffixes: tuple[str, ...]  # suffixes of its files, in lower case, the usual one first
    # program and case -> content of the file; raises CaseError where the case lacks what it needs, HexciteError for a
    # block that it cannot express
    write: Callable[[Blocks, Case], bytes]
    # content, name for messages, case -> its reading; shares no code with `write`; raises ProgramError with line at
    # anything that it does not understand, CaseError as `write`
    read: Callable[[bytes, str, Case], Reading]
    # guarantees of the controller when it runs a program that was read
    guarantees: Callable[[Reading, Case], Guarantees]
    # raises ProgramError where a reading is not the program; None where blocks read back one by one
    same: Callable[[Blocks, Reading, Case], None] | None = None
    # program and case -> the program in the blocks that this dialect is set up to use
    prepare: Callable[[Blocks, Case], Blocks] = _as_it_is
    # content as it is written, suffix of a file in lower case and case -> content in the form of that suffix
    form: Callable[[bytes, str, Case], bytes] = _in_its_only_form
    # first motion of the machine, for the program's header
    start: str = "the program stops unless the machine stands at home"

    @property
    def suffix(self) -> str:
        """The usual suffix."""
        return self.suffixes[0]
