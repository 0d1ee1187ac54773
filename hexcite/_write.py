"""From a plan to a program that is proven, or the reason why not."""

import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from cases.base.errors import CaseError, Code, FileProblem, HexciteError, ProgramError, option, whole_sentence
from cases.base.file_reading import read_whole
from cases.base.options import default_of, documented
from cases.base.phrases import phrase, said
from cases.basis import motion_hash
from cases.controller import ControllerName
from cases.readiness import languages_of, readiness
from cases.schema import Case
from hexcite.options import Accept, Ini, Language, LanguageOfFile, Speed
from identification.limits.limit import LimitKind
from identification.motion.curves import PolynomialMotion
from identification.motion.moves import has_steps
from planner.controller_limits import steps_of
from planner.plans.folder import DIGITS
from planner.plans.plan import Plan
from planner.request import Request
from postprocessors.dialects.dialect import Dialect
from postprocessors.program import (
    DIALECTS,
    MOST_PROGRAM,
    Program,
    dialect_of_file,
    leaving_out,
    read_program,
    require_language,
)
from postprocessors.program import dialect as dialect_named
from postprocessors.reading import Reading, Timed
from postprocessors.writing import proven_program

SLOWEST = 0.01  # share of the planned speed; slower, a run of seconds takes half an hour


@documented()
def write(
    plan: Plan,
    dialect: Language = default_of(Language),
    *,
    speed: Speed = default_of(Speed),
    accept: Accept = default_of(Accept),
    file: Path | str | None = None,
    ini: Path | str | None = None,
) -> Program:
    """The plan as a program for a controller, read back and proven; nothing is written to disk.

    >>> hx.write(hx.Plan.load("plan"), "sinumerik").proof.ok
    True

    Args:
        plan: a motion or poses.
        OPTIONS
        file: name of the program; its suffix is one of the dialect's.
        ini: as of `check`.

    Raises:
        FileProblem: the suffix is another language's; the INI file contradicts the case, the message names the line.
        ProgramError: the text, as read back, is not the planned motion, exceeds a limit, or relies on one that nobody
            enforces and that is not accepted.
        HexciteError: the dialect is unknown, or the speed is out of range.
    """
    language = language_of(plan, dialect, file)
    require_language(plan.case, language, f"choose another {option('dialect')}:")
    path = Path(f"{plan.name}{language.suffix}" if file is None else file)
    if path.suffix.lower() not in language.suffixes:
        raise FileProblem(
            place=path,
            problem=f"ends in {path.suffix!r}, by which controllers and check take it for another language than "
            f"{language.name}",
            remedy=f"name a file that ends in {' or '.join(language.suffixes)}",
            code=Code.WRONG_KIND,
        )
    if not SLOWEST <= speed <= 1.0:
        raise HexciteError(
            problem=phrase(
                "speed_outside", "speed {speed} is outside {slowest} to 1", speed=f"{speed:g}", slowest=f"{SLOWEST:g}"
            ),
            remedy=phrase("first_try", "choose 0.1 for a first try"),
            code=Code.OUT_OF_RANGE,
        )
    if isinstance(plan.request, Request) and plan.request.family.of_moves:
        _require_law(plan, language.name)
    header = (
        f"hexcite {version('hexcite')}: excitation for identification of model {plan.model}",
        case_line(plan.case),
        f"plan {plan.name}: {plan.family}, {plan.duration:g} s at speed {speed:g}",
        f"plan hash {plan.fingerprint}",
        *plan.stale,
        language.start,
    )
    accepted = (accept,) if isinstance(accept, str) else accept
    without = plan.without if steps_of(plan.case, language.name) or _follows(plan, language) else ()
    program = proven_program(plan.motion, plan.case, language, path, (*header, *leaving_out(without)), speed, accepted)
    if ini is not None:
        require_ini(program, plan.case, ini)
    return replace(program, remarks=(*program.remarks, *plan.stale))


def _follows(plan: Plan, language: Dialect) -> bool:
    """Whether a plan is a path that the controller follows point by point, whatever its jerk."""
    guarantees = language.guarantees(Reading(language.name, (), 0), plan.case)
    return isinstance(plan.motion, PolynomialMotion) and LimitKind.JERK not in guarantees.enforced


def _require_law(plan: Plan, dialect_name: str) -> None:
    """Refuses moves with steps of acceleration for a controller that limits jerk: none would last as planned."""
    if has_steps(plan.motion) and not steps_of(plan.case, dialect_name):
        place = str(plan.folder or plan.name)
        raise HexciteError(
            place=place,
            problem=f"was made for {plan.settings.made_for or 'a controller'}, which does not limit jerk",
            remedy="moves for "
            f"{dialect_name} satisfy the limits of jerk and last longer: plan with {option('controller', 'for')} "
            f"{dialect_name}, or re-time them with hexcite retime {place} -o NEW",
            code=Code.NOT_SUPPORTED,
        )


def language_of(plan: Plan, dialect: str | None, file: Path | str | None = None) -> Dialect:
    """The dialect of a name; without one that of a file's suffix, else of the controller that a plan was made for."""
    if dialect is not None:
        return dialect_named(dialect)
    if file is not None:
        return dialect_of_file(str(file))
    made_for, steps = plan.settings.made_for, bool(plan.without)
    path = isinstance(plan.request, Request) and not plan.request.family.of_moves
    return DIALECTS[made_for] if made_for in DIALECTS else dialect_named(usual_dialect(plan.case, path, steps))


def usual_dialect(case: Case, path: bool = False, steps: bool = False) -> str:
    """The first language whose settings the case has: of a controller that limits jerk, or steps, as is asked for.

    A path in a machine's own axes is written as a table alone.
    """
    ready = {command for command, missing in readiness(case).items() if not missing}
    own_axes = path and not case.need_motion("a program")[1].of_pose
    names = [name for name, language in DIALECTS.items() if language.same is not None or not own_axes]  # tables have it
    able = [name for name in names if f"post --dialect {name}" in ready]
    fitting = (name for name in able if (steps_of(case, name) > 0.0) is steps)
    possible = [name for name in languages_of(case) if name in names]  # whatever the case still lacks for it
    return next(fitting, [*able, *possible, ControllerName.LINUXCNC][0])


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
    content = b""
    with suppress(FileProblem):  # which the reader tells
        content = read_whole(file, MOST_PROGRAM)
    with naming_another(file, content, case):
        return read_program(file, case, dialect)


@documented()
def check(
    program: Path | str,
    case: Case,
    dialect: LanguageOfFile = default_of(LanguageOfFile),
    *,
    accept: Collection[str] | str | None = None,
    ini: Ini = default_of(Ini),
) -> Program:
    """A program of a file, read back independently of its writer, with its proof.

    >>> checked = hx.check("run.mpf", hx.load_case("hexapod"))
    >>> checked.proof.ok, checked.proof.violations
    (True, ())

    Args:
        OPTIONS
        accept: limits that the controller need not enforce; with them, also none, a program that exceeds a limit or
            relies on others is refused.

    Raises:
        FileProblem: the INI file contradicts the case; the message names the line.
        ProgramError: it cannot be read or understood; with `accept`, it is not proven.
        CaseError: the case lacks what its dialect needs.
    """
    read = read_for(case, Path(program), dialect)
    if ini is not None:
        require_ini(read, case, ini)
    if accept is not None:
        require_proven(read, case, (accept,) if isinstance(accept, str) else accept)
    return read


def require_ini(program: Program, case: Case, ini: Path | str) -> None:
    """Raises HexciteError unless the INI file of a LinuxCNC machine says of it what the case of a program says."""
    from postprocessors.controllers.linuxcnc.machine_ini import require_same_machine  # CasADi

    if program.dialect.name != ControllerName.LINUXCNC:
        raise HexciteError(
            place=program.path,
            problem=f"is not a LinuxCNC program ({program.dialect.name}), which {option('ini')} is about",
            remedy=f"leave {option('ini')} out",
            code=Code.WRONG_KIND,
        )
    require_same_machine(Path(ini), case, any(isinstance(part, Timed) for part in program.reading.stretches))


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
        if other := written_for_another(content, case):
            place = "" if error.said.place == str(file) else error.said.place
            raise ProgramError(
                file=file,
                problem=f"is {other}; {whole_sentence(said(error.said.problem), place, error.said.remedy)}",
                remedy=f"name its own case with {option('case')}",
                code=Code.OTHER_SOURCE,
            ) from error
        raise


def written_for_another(content: bytes, case: Case) -> str | None:
    """Remark on a program whose header names another state of the case; None where it names this one or none."""
    headers = set(_OF_THE_CASE.findall(content))
    if len(headers) != 1:
        return None
    name, machine, settings = (part.decode() for part in headers.pop())
    if name != case.name:
        return f"written for another case, {name}; this is {case.name}"
    if machine != motion_hash(case):
        return f"written for {case.name} with another [machine], [workspace], [limits] or controller.cycle_ms"
    if settings != case.controller_hash:
        return "written with other settings of [controller]: signs and words may mean something else"
    return None
