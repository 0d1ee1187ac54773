"""The stage Program: the text of a program, and what its proof says."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from hexcite.page.actions.common import Context
from hexcite.page.actions.program import without_settings
from hexcite.page.how_to_record import Recipe, recipe
from hexcite.page.jobs import Job
from hexcite.page.machine_inis import inis
from hexcite.page.stages import FORMS, Made, Program, Workspace
from hexcite.page.views.common import BOUND, Query, beginning, chosen_plan, limits
from hexcite.page.words import Words
from identification.limits.limit import NAMED, Limit, Status


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Program shows of a machine, for its template."""
    plan = chosen_plan(there.plans, query.get("plan"))
    own = [p for p in there.programs if plan is not None and p.plan == plan.name]
    program = next((p for p in own if p.name == query.get("program")), own[0] if own else None)
    content, cut = beginning(context.root / program.name) if program is not None else ("", False)
    last = context.jobs.latest(context.machine.key, "post", plan.name) if plan is not None else None
    refused = last is not None and last.state == "failed"
    exceeded = (last.answer or {}).get("violations", []) if refused and last is not None else []
    written = last.answer if last is not None and last.state == "done" else None
    kinds = _answerable(last, plan) if refused and last is not None and plan is not None else []
    return {
        "plans": there.plans,
        "chosen": plan,
        "programs": there.programs,
        "program": program,
        "lines": _lines(
            context.words, content, last.answer if last is not None and last.state == "done" else None, program
        ),
        "cut": cut,
        "dialects": context.machine.dialects,
        "without_settings": without_settings(context),
        "inis": inis(context.root) if "linuxcnc" in context.machine.dialects else None,
        "ini": query.get("ini", ""),
        "forms": [form for dialect in context.machine.dialects for form in FORMS.get(dialect, ())],
        "preferred": query.get("dialect") or _dialect_of(last) or ("" if plan is None else _preferred(plan, context)),
        "recipe": None if _is_slow(content) else _recipe(context, plan, program, content),
        "home": _home(context),
        "steps": _steps(program, _is_slow(content)),
        "refused": refused,
        "exceeded": exceeded[:20],
        "answerable": [(kind.replace(" ", "-"), context.words.limit(kind)) for kind in kinds],
        "written": written,
        "verdict": "" if written is None else verdict(context.words, written),
        "relied": () if written is None else relied_on(context.words, written),
        "remarks": () if written is None else context.words.clauses(written.get("remarks"), written.get("phrases")),
        "limits": [] if written is None else limits(context.words, written.get("limits", {})),
    }


_SPEED = re.compile(r" s at speed ([0-9.]+)")
_DURATION = re.compile(r" duration ([0-9.]+) s, excitation ")
"""What the header of a program says of it, where its language has comments."""


def _answerable(refused: Job, plan: Made) -> list[str]:
    """Limits that one may answer for: those that a refusal names, else all of the plan's."""
    phrases = refused.refused.get("phrases") if isinstance(refused.refused, Mapping) else None
    problem = (phrases or {}).get("problem", {})
    limits = problem.get("values", {}).get("limits", {}) if problem.get("code") == "nobody_enforces" else {}
    parts = limits.get("values", {}).get("parts", [limits])
    named = [str(part["values"]["name"]) for part in parts if part.get("code") == NAMED]
    return named or sorted(plan.record.get("limits", {}))


def _dialect_of(job: Job | None) -> str:
    """The controller that a program was written for last; empty where there is none."""
    command = () if job is None else job.command
    return command[command.index("--dialect") + 1] if "--dialect" in command else ""


def verdict(words: Words, answer: Mapping[str, Any]) -> Markup:
    """The proof of a program in one line, in the language of the page."""
    if words.language == "en":
        return words.quoted(answer["verdict"])
    relied = [str(kind) for kind in answer.get("relies_on", ())]
    enforced: dict[str, None] = {}
    beyond: dict[str, None] = {}
    for name, check in answer.get("limits", {}).items():
        family = str(Limit.named(name).kind.family)
        if check.get("status") == Status.ENFORCED and family not in relied:
            enforced[family] = None
        if check.get("status") == Status.NOT_ENFORCED and float(check["ratio"]) > 1.0:
            beyond[family] = None
    parts = [
        (key, [words.limit(kind) for kind in kinds])
        for key, kinds in (
            ("verdict_without", answer.get("without", ())),
            ("verdict_enforces", enforced),
            ("verdict_nobody", [kind for kind in relied if kind not in beyond]),
            ("verdict_beyond", beyond),
        )
    ]
    sentences = [words.say(key, what=", ".join(kinds), dialect=answer["dialect"]) for key, kinds in parts if kinds]
    return escape(" ".join([words.say("proven"), *sentences]))


def relied_on(words: Words, answer: Mapping[str, Any]) -> list[str]:
    """What a proof relies on the controller's own settings for, in sentences; none where it needs nothing of them."""
    checks = answer.get("limits", {})
    enforced = [name for name, check in checks.items() if check.get("status") == Status.ENFORCED]
    more = [
        f"{words.limit_at(name, str(checks[name].get('at', name)))} {100.0 * float(checks[name]['ratio']):.1f} %"
        for name in enforced
        if float(checks[name]["ratio"]) > 1.0
    ]
    sentences = [words.say("verdict_settings")] if enforced else []
    return sentences + ([words.say("verdict_more", what=", ".join(more))] if more else [])


_WITHOUT_OVERRIDE = frozenset({".csv", ".script", *FORMS["ros2"]})
"""Suffixes of programs of which no feed override or feed hold is promised."""


def _is_slow(content: str) -> bool:
    """Whether a program says that it is one to be watched, at a share of the planned speed."""
    speed = _SPEED.search(content)
    return speed is not None and float(speed[1]) < 1.0


def _steps(program: Program | None, slow: bool) -> tuple[str, ...]:
    """What is done at the machine, as keys of texts."""
    without = program is not None and Path(program.name).suffix.lower() in _WITHOUT_OVERRIDE
    hold = "step_stop" if without else "step_override"
    if slow:
        return "step_home", hold, "step_watch"
    return "step_home", hold, "step_slow", "step_record", "step_run", "step_bring"


def _home(context: Context) -> str:
    case = context.machine.case
    return "" if case is None or case.limits is None else case.words(case.need_motion("home")[0])


def _recipe(context: Context, plan: Made | None, program: Program | None, content: str) -> Recipe | None:
    """How the run of a program is recorded on its controller."""
    from postprocessors.program import DIALECTS

    case = context.machine.case
    if case is None or plan is None or program is None:
        return None
    suffix = Path(program.name).suffix.lower()
    dialect = next((name for name, language in DIALECTS.items() if suffix in language.suffixes), None)
    if dialect is None:
        return None
    duration = _DURATION.search(content)
    seconds = float(plan.record["duration_s"] if duration is None else duration[1])
    return recipe(case, dialect, f"{Path(program.name).stem}-recording", seconds)


def _lines(
    words: Words, content: str, answer: Mapping[str, Any] | None, program: Program | None
) -> list[tuple[int, str, str, bool]]:
    """Lines of a program: number, text, the worst limit there in words, and whether it is used to its end."""
    worst: dict[int, Mapping[str, Any]] = {}
    if answer is not None and program is not None and Path(str(answer.get("program"))).name == program.name:
        worst = {each["line"]: each for each in answer.get("lines", ())}
    rows = []
    for number, line in enumerate(content.splitlines(), 1):
        of = worst.get(number)
        worst_words = ""
        if of is not None:
            worst_words = f"{words.limit_of(of['limit'])} {100.0 * of['ratio']:.0f} %, {words.status(of['status'])}"
        rows.append((number, line, worst_words, of is not None and of["ratio"] >= BOUND))
    return rows


def _preferred(plan: Made, context: Context) -> str:
    """The controller that a plan was made for, else the first that limits jerk as the plan does."""
    settings = plan.record.get("settings") or {}
    made_for = str(settings.get("made_for") or "")
    steps = bool(plan.record.get("without") or settings.get("without"))
    order = ("linuxcnc", "urscript") if steps else ("sinumerik", "twincat", "ros2", "setpoints")
    ready = context.machine.dialects
    return made_for if made_for in ready else next((name for name in order if name in ready), "")
