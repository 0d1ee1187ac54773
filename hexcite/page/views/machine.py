"""The start page and the stage Machine: values of the case, its drawings, its check."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from cases.base.errors import CaseError, HexciteError
from cases.base.phrases import enumerated
from cases.schema import Case
from cases.tables import tables_of
from cases.urdf import TOOL0, read_links
from hexcite.page import drawing, joint_table, values
from hexcite.page.actions.common import Context
from hexcite.page.actions.machine import given_values
from hexcite.page.forms import Fields
from hexcite.page.jobs import Job
from hexcite.page.machine_at_home import chain_in, near, scene_of, scene_of_links, sensor_angles, sliders
from hexcite.page.refusals import Refused
from hexcite.page.stages import Machine, Workspace, case_key, case_of
from hexcite.page.views.common import Query
from hexcite.page.words import Words
from hexcite.reports.page import script_json

_SENSOR = re.compile(r"(?:^|_)(?:fts?\d*|force|torque|wrench|sensor)(?:_|\d|$)")  # names of a sensor's link


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Machine shows of a machine, for its template."""
    machine = context.machine
    content = machine.file.read_text(encoding="utf-8", errors="replace")
    check = context.jobs.latest(machine.key, "case", "check")
    if check is not None and check.over and check.finished < machine.file.stat().st_mtime:
        check = None  # of other values than those that stand there now
    sections = _sections(content, *case_key(machine))
    joints, others = joint_table.cut_out(sections)
    data = _tables(content)
    chain = chain_in(data)
    remarks = _said(context.words, values.remarks(machine.case, data))
    return {
        "saved": query.get("saved") == "1",
        "digest": values.digest(content),
        "sections": others,
        "joint_table": joints,
        "given": {},
        "refused": {},
        "examples": sum(entry.mark == "example" for section in sections for entry in section.entries),
        "untouched": machine.own and not any(e.mark == "mine" for section in sections for e in section.entries),
        **_lacking(machine, sections),
        "checked": check.answer if check is not None else None,
        "remarks": remarks,
        "checked_remarks": _others(context.words, check, remarks),
        "homes": () if chain is None else sliders(chain),
        "angles": () if chain is None else sensor_angles(chain),
        **drawn(machine.case, data),
    }


def _said(words: Words, remarks: Sequence[values.Remark]) -> tuple[values.Remark, ...]:
    """Remarks in the language of the page."""
    return tuple(each._replace(sentence=words.quoted(each.sentence)) for each in remarks)


def _others(words: Words, check: Job | None, remarks: Sequence[values.Remark]) -> list[Markup]:
    """What a check remarks besides: what the stage shows anyway, and values of the example, which are marked, go."""
    answer = (check.answer if check is not None else None) or {}
    codes = ("tables_of_template", "keys_of_template")
    phrases = [each for each in answer.get("phrases", ()) if each.get("code") not in codes]
    pairs = zip(answer.get("remarks", ()), answer.get("phrases", ()), strict=False)
    sentences = [sentence for sentence, each in pairs if each.get("code") not in codes]
    return [each for each in words.clauses(sentences, phrases) if each not in {other.sentence for other in remarks}]


def _lacking(machine: Machine, sections: Sequence[values.Section]) -> dict[str, Any]:
    """Keys that the stage Plan misses in a case of one's own, and where they can be stated on the page."""
    lacks = machine.lacks("plan") if machine.own else ()
    names = [section.name for section in sections]
    jointed = any(name.startswith("machine.chain.joints") for name in names)

    def nearest(key: str) -> str:
        """The table of a key, else the first one inside or around it."""
        table = key.rpartition(".")[0]
        if key.startswith(("machine.chain.joints.", "limits.motion")) and jointed:
            return joint_table.NAME
        inside = [name for name in names if name == key or name.startswith((f"{key}.", f"{key}[", f"{table}["))]
        around = sorted((name for name in names if name and f"{table}.".startswith(f"{name}.")), key=len)
        return next(iter([*inside, *around[::-1]]), "")

    return {"lacks": lacks, "anchors": {key: f"t.{nearest(key)}" for key in lacks}}


@lru_cache(8)
def _sections(content: str, file: str, time_ns: int, size: int) -> tuple[values.Section, ...]:
    """The values of a case file, computed once for each content that it has."""
    try:
        case = case_of(file, time_ns, size)
    except HexciteError:
        case = None
    return values.sections(content, case)


def _tables(content: str) -> dict[str, Any]:
    try:
        return tomllib.loads(content)
    except tomllib.TOMLDecodeError:
        return {}


def drawn(case: Case | None, data: Mapping[str, Any], problem: str = "") -> dict[str, Any]:
    """The drawings of a case, or of its chain where the case is not complete yet; or why there are none."""
    chain = chain_in(data) if case is None else case.chain
    values: dict[str, Any] = {"views": None, "scene": "", "near": (), "why": problem, "converted": ()}
    values |= {"refused_json": "", "typed_remarks": ()}
    try:
        if chain is not None:
            values["views"] = drawing.chain_views(chain)
        elif case is not None:
            values["views"] = drawing.views(case)
        if (scene := scene_of(case, chain)) is not None:
            values["scene"] = Markup(script_json(scene.to_json()))
            values["near"] = near(case, chain)
    except HexciteError as error:
        values["why"] = enumerated("semicolon", error.sentences)
    return values


def preview(context: Context, fields: Fields) -> dict[str, Any]:
    """The drawings of a case with values that are not written yet."""
    content = context.machine.file.read_text(encoding="utf-8")
    try:
        data, converted, refused = values.changed(content, given := given_values(fields))
    except Refused as error:
        return drawn(None, {}, context.words.refused(error))
    problem: str = ""
    said = context.words.refused_fields(refused)
    try:
        case = tables_of(Case, Path(context.machine.argument), data)
    except CaseError as error:
        case, at_fields = None, values.at_fields(data, error, given)
        said = context.words.refused_fields(at_fields.fields) | said
        problem = Markup("; ").join(map(context.words.refused, at_fields.others))
    except HexciteError as error:
        case, problem = None, enumerated("semicolon", error.sentences)
    remarks = _said(context.words, values.remarks(case, data))
    seen = {"converted": converted, "refused_json": Markup(script_json({**said})), "typed_remarks": remarks}
    return {**drawn(case, data, problem), **seen}


def urdf(file: Path) -> dict[str, Any]:
    """The links of a URDF file in 3-D, and the one that probably carries the sensor."""
    try:
        links = read_links(file)
    except HexciteError as error:
        return {"name": file.name, "problem": enumerated("semicolon", error.sentences), "links": ()}
    stem = re.sub(r"[^a-z0-9]+", "_", file.stem.lower()).strip("_")
    most = max(link.moved_by for link in links)
    moved = [link for link in links if link.moved_by == most]
    sensors = [link for link in moved if _SENSOR.search(link.name.lower())]
    tools = [link for link in moved if link.name.endswith(TOOL0)] or [link for link in moved if link not in sensors]
    return {
        "name": file.name,
        "problem": "",
        "links": sorted(links, key=lambda link: -link.moved_by),
        "flange": (tools or moved)[-1].name,
        "sensor": sensors[0].name if sensors else "",
        "proposed": stem if stem[:1].isalpha() else f"robot_{stem}".rstrip("_"),
        "scene": Markup(script_json(scene_of_links(links).to_json())),
    }
