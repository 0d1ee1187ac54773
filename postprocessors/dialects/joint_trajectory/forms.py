"""Forms of a joint trajectory: YAML for `ros2 topic pub`, JSON for programs, and a script that sends it.

The script needs ROS 2 alone. It compares where the robot stands with the first point, and sends nothing from elsewhere.
"""

import json
import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cases.base.errors import Code, ProgramError
from cases.base.units import DEG, MM
from cases.chain import Chain
from cases.controller import Ros2
from cases.schema import Case

if TYPE_CHECKING:
    from jinja2 import Environment

YAML, JSON, SCRIPT = (".yaml", ".yml"), ".json", ".py"
STANDS = 0.1  # deg or mm by which a joint may be off where the trajectory begins: actual positions are hundredths off
_BEGIN, _END = b'\nMESSAGE = r"""\n', b'\n"""\n'  # of the message in a script
_KEY = re.compile(r"(?<![\w\"'])(positions|velocities|accelerations|time_from_start|sec|nanosec):")


class Embedded(NamedTuple):
    """The message in a file."""

    text: str  # JSON
    line: int  # in which it begins, counted from 1


def in_form(content: bytes, suffix: str, case: Case) -> bytes:
    """A message in YAML, as it is written, in the form of a suffix."""
    if suffix not in (JSON, SCRIPT):
        return content
    chain, _ = case.need_chain("a joint trajectory")
    lines = content.decode("ascii").splitlines()
    header = [line for line in lines if line.startswith("#")]
    rows = [_KEY.sub(r'"\1":', line[2:]) for line in lines if line[:2] in ("- ", "  ")]
    points = ["{" + ", ".join(rows[k : k + 4]) + "}" for k in range(0, len(rows), 4)]
    message = f'{{"joint_names": {json.dumps(chain.names)}, "points": [\n' + ",\n".join(points) + "\n]}\n"
    return message.encode("ascii") if suffix == JSON else _script(header, message, chain, settings_of(case))


def settings_of(case: Case) -> Ros2:
    """How the case says that the controller is set up; its defaults where it does not."""
    return case.need_controller("a joint trajectory").ros2 or Ros2()


def embedded(content: bytes, file: str, case: Case) -> Embedded | None:
    """The message of a JSON file or a script; None of YAML. Raises ProgramError where a script was changed."""
    if content.lstrip()[:1] == b"{":
        return Embedded(content.decode("utf-8", "replace"), 1)
    if not content.startswith(b"#!"):
        return None
    before, begin, rest = content.partition(_BEGIN)
    message, end, _ = rest.partition(_END)
    remedy = "write it again with hexcite post, and change the case, not the script"
    if not begin or not end:
        raise ProgramError(file=file, line=1, problem="a script without its message", remedy=remedy, code=Code.DAMAGED)
    # The second line states the encoding: a comment there could state one in which comments hold statements.
    header = [line for line in content.decode("utf-8", "replace").splitlines()[2:] if line.startswith("#")]
    text = message.decode("utf-8", "replace") + "\n"
    chain, _ = case.need_chain("a joint trajectory")
    script = _script(header, text, chain, settings_of(case))
    if script != content:
        theirs, ours = content.splitlines(), script.splitlines()
        line = next((k for k, (a, b) in enumerate(zip(theirs, ours, strict=False)) if a != b), len(ours))
        problem = "this script is not the one that goes with the case: it was changed, or controller.ros2 was"
        raise ProgramError(file=file, line=line + 1, column=0, problem=problem, remedy=remedy, code=Code.CHANGED)
    return Embedded(text, before.count(b"\n") + 3)


def points_of(message: Embedded, file: str, case: Case) -> list[tuple[int, dict[str, Any]]]:
    """Lines and entries of the points of a message; raises ProgramError where it is not such a message."""

    def refused(problem: str, remedy: str, line: int = message.line) -> ProgramError:
        return ProgramError(file=file, line=line, problem=problem, remedy=remedy, code=Code.SYNTAX)

    def distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len({key for key, _ in pairs}) < len(pairs):
            raise refused("a key stands twice in one object", "leave one")
        return dict(pairs)

    def no_number(text: str) -> Any:
        raise refused(f"{text} is not a number", "write one")

    try:
        data = json.loads(message.text, object_pairs_hook=distinct, parse_constant=no_number)
    except (ValueError, RecursionError) as error:
        line = message.line + getattr(error, "lineno", 1) - 1
        raise refused(f"is not JSON ({error})", "write it again with hexcite post", line) from None
    chain, _ = case.need_chain("a joint trajectory")
    if not isinstance(data, dict) or data.get("joint_names") != list(chain.names):
        raise refused(f"`joint_names` must be {json.dumps(chain.names)}, in this order", "correct them")
    if data.keys() - {"header", "joint_names", "points"} or not isinstance(points := data.get("points"), list):
        raise refused("`points` must be a list, beside joint_names and a header alone", "correct it")
    starts = [match.start() for match in re.finditer(r'"positions"\s*:', message.text)]
    if len(starts) != len(points):
        raise refused(f"{len(points)} points have {len(starts)} positions", "state positions of each")
    lines = [message.line + message.text.count("\n", 0, start) for start in starts]
    return list(zip(lines, points, strict=True))


def _script(header: list[str], message: str, chain: Chain, settings: Ros2) -> bytes:
    """The script around a message in JSON, plain ASCII."""
    turns = [joint.turns for joint in chain.joints]
    template = _templates().get_template("send.py.jinja")
    return template.render(
        header=header,
        message=message,
        settings=settings,
        within=[STANDS * (DEG if turn else MM) for turn in turns],
        units=[["deg", DEG] if turn else ["mm", MM] for turn in turns],
        path=_of_joints(settings.path_tolerance_deg, settings.path_tolerance_mm, turns),
        goal=_of_joints(settings.goal_tolerance_deg, settings.goal_tolerance_mm, turns),
    ).encode("ascii", "backslashreplace")


def _of_joints(degrees: float | None, millimetres: float | None, turns: list[bool]) -> list[float]:
    """Tolerances of joints [rad or m]; 0, the controller's own, where none is stated."""
    return [(degrees or 0.0) * DEG if turn else (millimetres or 0.0) * MM for turn in turns]


@cache
def _templates() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # YAML does not need it

    here = Path(__file__).parent
    return Environment(
        loader=FileSystemLoader(here), undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True
    )
