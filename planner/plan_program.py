"""From a plan to a program that is proven, or the reason why not."""

import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from cases.basis import motion_hash
from cases.controller import ControllerName
from cases.errors import CaseError, HexciteError, ProgramError
from cases.scaffold import readiness
from cases.schema import Case
from identification.motion import Joined, Trajectory
from identification.trajectories.moves import has_steps
from planner.families.ptp import controlled
from planner.plan_folder import DIGITS
from planner.plans import Plan
from planner.request import Request
from postprocessors.dialects import DIALECTS, Dialect, Program, dialect_of_file, read_program
from postprocessors.dialects import dialect as dialect_named
from postprocessors.writing import proven_program

# Languages in their order: the first that a case can be written in is taken.
USUAL = (
    ControllerName.LINUXCNC,
    ControllerName.SINUMERIK,
    ControllerName.TWINCAT,
    ControllerName.URSCRIPT,
    ControllerName.SETPOINTS,
    ControllerName.ROS2,
)
USUAL_OF_PATHS = (ControllerName.SETPOINTS, ControllerName.ROS2)
LONGER = 1.001  # ratio of durations from which a program that takes longer than its plan says so
SLOWEST = 0.01  # share of the planned speed; slower, a run of seconds takes half an hour


def write(
    plan: Plan,
    dialect: str | None = None,
    *,
    speed: float = 1.0,
    accept: Collection[str] | str = (),
    file: Path | str | None = None,
) -> Program:
    """The plan as a program for a controller, read back and proven; nothing is written to disk.

    Args:
        plan: a motion or poses.
        dialect: the controller's language: one of `DIALECTS`; by default that of the suffix of
            `file`, else that of the controller that the plan was made for, else the first with settings in the case.
        speed: share of the planned speed; 0.1 for a first try.
        accept: limits that the controller does not enforce and that the caller answers for, such as
            `("jerk", "sensor force")`, or one.
        file: name of the program, for messages.

    Raises:
        ProgramError: the text, as read back, is not the planned motion, exceeds a limit, or relies on one that nobody
            enforces and that is not accepted.
        HexciteError: the dialect is unknown, or the speed is out of range.
    """
    language = language_of(plan, dialect, file)
    path = Path(f"{plan.name}{language.suffix}" if file is None else file)
    if not SLOWEST <= speed <= 1.0:
        raise HexciteError(f"speed {speed:g} is outside {SLOWEST:g} to 1; choose 0.1 for a first try")
    remarks: tuple[str, ...] = ()
    if isinstance(plan.request, Request) and plan.request.family.of_moves:
        place = str(plan.folder or plan.name)
        made_for = str(plan.settings.get("made_for", ""))
        remarks = fits_law(place, made_for, plan.motion, language.name, plan.case)
    header = (
        f"hexcite {version('hexcite')}: excitation for identification of model {plan.model}",
        case_line(plan.case),
        f"plan {plan.name}: {plan.family}, {plan.duration:g} s at speed {speed:g}",
        f"plan hash {plan.fingerprint}",
        *plan.stale,
        language.start,
    )
    accepted = (accept,) if isinstance(accept, str) else accept
    program = proven_program(plan.motion, plan.case, language, path, header, speed, accepted)
    planned = plan.motion.duration / speed
    if not isinstance(plan.motion, Joined) and program.proof.excitation > LONGER * planned:
        remarks += (
            f"the excitation lasts {program.proof.excitation:.3f} s instead of {planned:.3f} s: {language.name} needs "
            "blocks of whole controller cycles, and the pieces of this motion last others (change --knots, --duration "
            "or --period of hexcite plan, or --speed)",
        )
    return replace(program, remarks=(*remarks, *plan.stale))


def language_of(plan: Plan, dialect: str | None, file: Path | str | None = None) -> Dialect:
    """The dialect of a name; without one that of a file's suffix, else of the controller that a plan was made for."""
    if dialect is not None:
        return dialect_named(dialect)
    if file is not None:
        return dialect_of_file(str(file))
    path = isinstance(plan.request, Request) and not plan.request.family.of_moves
    return dialect_named(usual_dialect(plan.case, plan.settings, path))


def usual_dialect(case: Case, settings: Mapping[str, Any] | None = None, path: bool = False) -> str:
    """The language of the controller that a plan was made for, else the first whose settings the case has.

    Args:
        path: whether the motion is one path: in a machine's own axes controllers know tables of points alone.
    """
    made_for = (settings or {}).get("made_for")
    if made_for in DIALECTS:
        return str(made_for)
    ready = {command for command, missing in readiness(case).items() if not missing}
    own_axes = path and not case.need_motion("a program")[1].of_pose
    names = USUAL_OF_PATHS if own_axes else USUAL
    return next((name for name in names if f"post --dialect {name}" in ready), ControllerName.LINUXCNC)


def fits_law(plan: str, made_for: str | None, motion: Trajectory, dialect_name: str, case: Case) -> tuple[str, ...]:
    """Remarks on moves that the controller of a dialect times by another law than they were planned with.

    Raises:
        HexciteError: the moves have steps of acceleration, and the controller limits jerk: none would last as planned.
        CaseError: the case has no settings of this controller.
    """
    steps = bool(controlled(case, dialect_name)[1])
    if has_steps(motion) and not steps:
        raise HexciteError(
            plan,
            f"was made for {made_for or 'a controller'}, which does not limit jerk; moves for {dialect_name} "
            f"satisfy the limits of jerk and last longer: plan with --for {dialect_name}, or re-time the moves with "
            f"hexcite retime {plan} -o NEW",
        )
    if steps and not has_steps(motion):
        return (
            f"planned with limited jerk; {dialect_name} does not limit it and makes trapezoids of the moves: a plan "
            f"made with --for {dialect_name} carries more information there",
        )
    if made_for not in (None, "", ControllerName.VIRTUAL, dialect_name):
        return (f"made for {made_for}; {dialect_name} times moves by the same law",)
    return ()


_IN_PROGRAM = re.compile(rb"plan hash ([0-9a-f]{%d})" % DIGITS)
_OF_THE_CASE = re.compile(rb"case (\w+), hash ([0-9a-f]{%d}), controller settings ([0-9a-f]{%d})" % (DIGITS, DIGITS))


def plan_of_program(content: bytes) -> str | None:
    """The fingerprint of the plan that a program names; None where it names none, or several."""
    hashes = set(_IN_PROGRAM.findall(content))
    return hashes.pop().decode() if len(hashes) == 1 else None


def case_line(case: Case) -> str:
    """The header line of a program that names its case."""
    return f"case {case.name}, hash {motion_hash(case)}, controller settings {case.controller_hash}"


def read_for(case: Case, file: Path, dialect: str | None = None) -> Program:
    """Reads a program; where one that cannot be read is for another state of the case, the error says so."""
    with naming_another(file, file.read_bytes() if file.is_file() else b"", case):
        return read_program(file, case, dialect)


def check(
    program: Path | str, case: Case, dialect: str | None = None, *, accept: Collection[str] | str | None = None
) -> Program:
    """A program of a file, read back independently of its writer, with its proof.

        checked = hx.check("run.ngc", hx.load_case("hexapod"))
        checked.proof.ok, checked.proof.verdict, checked.proof.violations

    Args:
        dialect: the program's language; by default the one that its suffix names.
        accept: limits that the controller need not enforce; with them, also none, a program that exceeds a limit or
            relies on others is refused.

    Raises:
        ProgramError: it cannot be read or understood; with `accept`, it is not proven.
        CaseError: the case lacks what its dialect needs.
    """
    read = read_for(case, Path(program), dialect)
    if accept is not None:
        require_proven(read, case, (accept,) if isinstance(accept, str) else accept)
    return read


def require_proven(program: Program, case: Case, accept: Collection[str] | None = None) -> None:
    """Raises ProgramError unless a program is proven, with `accept` by limits that are enforced or accepted."""
    with naming_another(program.path, program.content, case):
        program.proof.require() if accept is None else program.proof.require_accepted(accept)


@contextmanager
def naming_another(file: Path, content: bytes, case: Case) -> Iterator[None]:
    """Inside, an error of a program is preceded by the case that its header names where that is another one."""
    try:
        yield
    except (ProgramError, CaseError) as error:
        other = written_for_another(content, case)
        if other is None:
            raise
        if not isinstance(error, ProgramError):
            raise ProgramError(file, 0, 0, f"is {other}; {error.typed}") from error
        problem = f"is {other}; {error.typed.removeprefix(error.place)[2:]}"
        raise ProgramError(error.file, error.line, error.column, problem) from error


def written_for_another(content: bytes, case: Case) -> str | None:
    """Remark on a program whose header names another state of the case; None where it names this one or none."""
    headers = set(_OF_THE_CASE.findall(content))
    if len(headers) != 1:
        return None
    name, machine, settings = (part.decode() for part in headers.pop())
    if name != case.name:
        return f"written for another case, {name}; this is {case.name}"
    if machine != motion_hash(case):
        return f"written for {case.name} with other values in [machine], [workspace] or [limits] than it has now"
    if settings != case.controller_hash:
        return (
            f"written with other settings of [controller] (its header says {settings}, now they are "
            f"{case.controller_hash}): signs and words may mean something else"
        )
    return None
