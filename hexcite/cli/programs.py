"""`hexcite post`, `hexcite check` and `hexcite run`: programs are written, read back and executed."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import hexcite as hx
from cases.base.errors import NotProven, Violation
from cases.base.folder_kinds import RUN
from cases.base.options import default_of
from cases.base.output_places import check_file, check_folder, output_place
from cases.base.phrases import Phrase
from hexcite.cli import console
from hexcite.cli.console import argument, option, out
from hexcite.cli.declared import takes
from hexcite.options import Accept, Controller, Disturbed, Ini, Language, LanguageOfFile, NoiseSeed, Speed, Weights

All = Annotated[bool, option("Show every line that exceeds a limit, the worst first.", "--all")]


@takes()
def post(
    plan: Annotated[Path, argument("Plan folder.")],
    dialect: Language = default_of(Language),
    speed: Speed = default_of(Speed),
    accept: Accept = default_of(Accept),
    case: console.OwnCase = None,
    output: Annotated[Path | None, out("Program to write; by default the plan's name.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    every: All = False,
    ini: Ini = None,
    json: console.Json = False,
) -> None:
    """Write a plan as a program for the machine's controller.

    It is read back and proven before it is written.
    """
    from hexcite._write import language_of

    loaded = hx.Plan.load(plan, None if case is None else hx.load_case(case), stale)
    language = language_of(loaded, dialect, output)
    file = output_place(output, Path(f"{loaded.name}{language.suffix}"), overwrite)
    check_file(file, language.suffixes, [plan, *plan.glob("*")], overwrite)
    with console.status(f"writing and proving {file.name}", json), _told(every, json):
        program = hx.write(
            loaded,
            language.name,
            speed=speed,
            accept=[name for names in accept or () for name in names.split(",")],
            file=file,
            ini=ini,
        )
    program.save(file, overwrite)
    answer = answer_of_program(program)
    notes = (f"note: {remark}" for remark in answer["remarks"])
    console.answered(answer, json, *notes, f"program written: {program.path}, read back", repr(program))


@contextmanager
def _told(every: bool, as_json: bool) -> Iterator[None]:
    """Inside, all limits that a program exceeds are printed where they were asked for, before the error passes on."""
    try:
        yield
    except NotProven as error:
        answer = {"ok": False, "violations": [v.to_json() for v in error.violations]}
        if every or as_json:
            console.answered(answer, as_json, *lines_of(error.violations))
        raise error.listed() if every else error from None


def lines_of(violations: Sequence[Violation]) -> list[str]:
    """Limits that a program exceeds, a line each."""
    return [f"line {v.line}: {v.sentence}" for v in violations]


def answer_of_program(program: "hx.Program") -> dict[str, Any]:
    """The JSON answer of a program that was written."""
    from postprocessors.proof.proof import override_remarks

    proof, remarks = program.proof, [*program.remarks, *override_remarks(program.reading, program.guarantees)]
    return {
        "program": str(program.path),
        "dialect": program.dialect.name,
        "blocks": program.reading.blocks,
        "duration_s": proof.duration,
        "excitation_s": proof.excitation,
        "verdict": proof.verdict,
        "relies_on": list(proof.relies_on),
        "without": list(proof.without),
        "remarks": remarks,
        "phrases": [remark.to_json() if isinstance(remark, Phrase) else None for remark in remarks],
        "limits": proof.limits.to_json(),
        "lines": proof.lines_to_json(),
    }


@takes()
def check(
    program: Annotated[Path, argument("Program file.")],
    case: Annotated[str, option("Built-in name, folder or case file.")],
    dialect: LanguageOfFile = default_of(LanguageOfFile),
    every: All = False,
    ini: Ini = default_of(Ini),
    json: console.Json = False,
) -> None:
    """Read a program back by other code, and prove it."""
    from hexcite._write import require_proven

    loaded = hx.load_case(case)
    with console.status(f"proving {program.name}", json):
        read = hx.check(program, loaded, dialect, ini=ini)
        answer = answer_of_proof(read)
    lines = lines_of(read.proof.exceeded) if every else []
    console.answered(answer, json, *(f"note: {remark}" for remark in answer["remarks"]), *lines, read)
    try:
        require_proven(read, loaded)
    except NotProven as error:
        raise error.listed() if every else error from None


def answer_of_proof(program: "hx.Program") -> dict[str, Any]:
    """The JSON answer of a proof, whether it succeeded or not."""
    from hexcite._write import written_for_another

    proof, other = program.proof, written_for_another(program.content, program.case)
    return {
        "ok": proof.ok,
        "verdict": proof.verdict,
        "relies_on": list(proof.relies_on),
        "without": list(proof.without),
        "violations": [v.to_json() for v in proof.exceeded],
        "duration_s": proof.duration,
        "remarks": [*proof.remarks, *([other] if other else [])],
        "limits": proof.limits.to_json(),
        "lines": proof.lines_to_json(),
    }


@takes()
def run(
    program: Annotated[Path, argument("Program file.")],
    case: Annotated[str, option("Built-in name, folder or case file.")],
    on: Controller = default_of(Controller),
    seed: NoiseSeed = default_of(NoiseSeed),
    payload: Weights = default_of(Weights),
    disturbed: Disturbed = default_of(Disturbed),
    ini: Ini = default_of(Ini),
    output: Annotated[Path | None, out("Folder to write; PROGRAM-recording by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Execute a program and write a recording.

    Sensors and encoders are simulated for the motion that the controller executed.
    """
    from cases.tables import find_case

    folder = output_place(output, Path(f"{program.stem}-recording"), overwrite)
    check_folder(folder, RUN, [program, find_case(case)], overwrite)
    loaded = hx.load_case(case)
    with console.status(f"running {program.name} on {on}", json):
        recording = hx.run(program, loaded, on, seed=seed, payload=payload, disturbed=disturbed, ini=ini)
        recording.save(folder, overwrite)
    console.answered(answer_of_run(recording, folder), json, f"recording written: {folder}", recording)


def answer_of_run(recording: "hx.Recording", folder: Path) -> dict[str, Any]:
    """The JSON answer of a run that was written."""
    record, executed = recording.record, recording.executed
    assert record is not None
    answer = {"recording": str(folder), "duration_s": executed.executed_s, "poses": len(record.poses_m_rad)}
    return {**record.to_json(), **answer, "simulated": True}
