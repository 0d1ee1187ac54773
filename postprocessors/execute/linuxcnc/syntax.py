"""LinuxCNC's own interpreter reads a program without running it: the check before anything moves."""

import re
import subprocess
from pathlib import Path

from cases.errors import ExecutionError
from postprocessors.execute.linuxcnc.isolation import SYSTEM_PATH

_COMMENT = re.compile(r"\([^)]*\)|;.*")
_STOP = re.compile(r"M(0*[01]|0*60)(?![0-9.])")


def words(line: str) -> str:
    """A line as the interpreter sees it: without comments and blanks, in capitals."""
    return re.sub(r"\s", "", _COMMENT.sub("", line)).upper()


def check_syntax(program: Path, lines: list[str], folder: Path, time_limit: float) -> None:
    """Reads a program with `rs274 -g`, and refuses stops that wait for an operator, who is not there.

    Args:
        program: the program, for messages.
        lines: its lines.
        folder: for files of the interpreter.
        time_limit: on the wall clock [s].

    Raises:
        ExecutionError: a line waits for an operator; or the interpreter refuses a line or does not come to an end.
    """
    for number, line in enumerate(lines, start=1):
        if _STOP.search(words(line)):
            raise ExecutionError(
                f"{program}, line {number}: {line.strip()!r} waits for an operator; remove M0, M1 and M60"
            )
    refused = _refusal(lines, folder, time_limit, program)
    if refused is None:
        return
    reason, text = refused
    # rs274 gives the text of the line, not its number. Where the text stands on several lines, the program that ends
    # behind the right one is the shortest that is refused for the same reason.
    candidates = [number for number, line in enumerate(lines, start=1) if text and line.strip() == text]
    while len(candidates) > 1:
        head = [*lines[: candidates[0]], "M2"]
        if _refusal(head, folder, time_limit, program) == refused:
            break
        candidates.pop(0)
    place = f", line {candidates[0]}" if candidates else ""
    what = repr(text) if text else "it to its end"
    raise ExecutionError(
        f"{program}{place}: LinuxCNC cannot read {what}: {reason}; correct it, or write the program again with hexcite "
        "post --dialect linuxcnc"
    )


def _refusal(lines: list[str], folder: Path, time_limit: float, program: Path) -> tuple[str, str] | None:
    """Reason and text of the line that the interpreter refuses, None where it accepts the program."""
    copy = folder / "syntax.ngc"
    copy.write_text("\n".join(lines) + "\n", encoding="utf-8")
    try:
        result = subprocess.run(
            ["rs274", "-g", copy.name],
            cwd=folder,
            env={"PATH": SYSTEM_PATH, "HOME": str(folder)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=time_limit,
            text=True,
            errors="replace",
        )
    except subprocess.TimeoutExpired as error:
        raise ExecutionError(
            f"{program}: LinuxCNC's interpreter does not come to an end within {time_limit:g} s; remove endless loops"
        ) from error
    if result.returncode == 0:
        return None
    said = [line.strip() for line in result.stderr.splitlines() if line.strip() not in ("", "executing")]
    return (said[0] if said else f"exit code {result.returncode}"), (said[1] if len(said) > 1 else "")
