"""The certificate of a result: A4 pages as PDF, with what they state as data inside, and its verification.

The keywords of the file hold what is stated as JSON in Base64, and the SHA-256 of the file with zeros in its place: a
byte that was changed since shows. It is not a signature: who makes a new file makes a new fingerprint.
"""

import base64
import hashlib
import json
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from cases.base.atomic import atomic_file
from cases.base.doors import checks
from cases.base.errors import Code, FileProblem, HexciteError, choice, option
from cases.base.file_reading import DAMAGED, MOST_JSON, read_whole
from cases.base.output_places import check_file
from cases.base.provenance import sha256_of
from cases.base.text_formats import json_text
from cases.basis import content_of
from cases.certificate import CertificateOf
from hexcite.texts import LANGUAGES, Language, answers, text
from hexcite.texts.by_code import parameter, plain
from hexcite.texts.certificate import WEIGHTS
from identification.estimation.fit import COVERAGE_FACTOR
from identification.recording.record import RunOrigin
from identification.results.result import Result
from identification.results.verdicts import accept
from identification.texts import legible, parameter_words, std_text, value_text

FORMAT, VERSION = "hexcite certificate", 1
WIDTH, HEIGHT = 8.27, 11.69  # A4 [inch]
_EMBEDDED = re.compile(rb"hexcite:([A-Za-z0-9+/=]+) sha256:([0-9a-f]{64})")
_NONE = b"0" * 64


@checks
def certificate(
    result: Result,
    file: Path | str,
    about: CertificateOf | None = None,
    number: str = "",
    overwrite: bool = False,
    language: Language = "en",
) -> None:
    """Writes the certificate of a result, one PDF file of A4 pages.

    >>> result = hx.Result.load("empty-result")
    >>> hx.certificate(result, "calibration.pdf", number="2026-01")
    >>> hx.verify_certificate("calibration.pdf", result).stated["number"]
    '2026-01'

    Args:
        result: the result.
        file: file to write.
        about: laboratory, operator, serial numbers and conditions; `[certificate]` of the case unless given.
        number: number of the certificate.
        overwrite: whether a file that stands there is replaced.
        language: `en` or `de`; what has German words in no table is quoted in English.

    Raises:
        HexciteError: there is no such language.
        FileProblem: it stands there, or cannot be written.
    """
    place = Path(file)
    check_file(place, (".pdf",), overwrite=overwrite)
    if language not in LANGUAGES:
        raise HexciteError(
            place=option("language"),
            problem=f"{language!r} is not a language of certificates",
            remedy=choice(language, LANGUAGES, "choose from"),
            code=Code.UNKNOWN,
        )
    stated = statements(result, about or result.case.certificate or CertificateOf(), number)
    stated["language"] = language
    content = _pdf(stated)
    with atomic_file(place) as part:
        part.write_bytes(content)


def statements(result: Result, about: CertificateOf, number: str) -> dict[str, Any]:
    """What a certificate states, as JSON."""
    record, case = result.record, result.case
    run = record.run or RunOrigin()
    verdict = accept(result)
    budget = result.budget
    counted = list(next(iter(budget.values()))) if budget else ["noise", "noise with memory", "seen in residuals"]
    return {
        "format": FORMAT,
        "version": VERSION,
        "number": number,
        "issued": datetime.now().astimezone().isoformat(timespec="seconds"),
        "laboratory": about.laboratory or "",
        "operator": about.operator or "",
        "conditions": about.conditions or "",
        "machine": {"case": case.name, "title": case.heading, "setup": case.setup},
        "serial_numbers": dict(about.serial_numbers or {}),
        "recorded": record.recorded_at or "",
        "simulated": bool(run.simulated),
        "program": run.program or "",
        "method": {
            "model": record.model,
            "weights": record.weights,
            "samples": record.samples,
            "standstills": record.delay_s is None,
            "rank": record.rank,
            "condition": record.condition,
            "s0": record.s0,
            "known": dict(record.known or {}),
            "priors": list(record.priors or {}),
        },
        "parameters": {
            name: {"value": p.value, "U": p.expanded, "unit": p.unit} for name, p in result.parameters.items()
        },
        "coverage_factor": COVERAGE_FACTOR,
        "counted": counted,
        "not_counted": list(result.not_counted),
        "verdict": verdict.to_json(),
        "warnings": list(result.warnings),
        "phrases": [f.phrase for f in result.findings if f.severity == "warning" and f.sentence],
        "fingerprints": {
            "case": record.case_hash,
            "plan": record.plan_hash or "",
            "program": run.program_hash or "",
            "recording": [dict(entry) for entry in record.inputs],
            "result": content_of(record.to_json()),
        },
        "versions": dict(record.versions),
    }


class Verification(NamedTuple):
    """What the verification of a certificate found."""

    stated: Mapping[str, Any]  # what it states
    lines: tuple[tuple[str, str], ...]  # what was compared, and how it compares

    def __repr__(self) -> str:
        """A line for each comparison."""
        first = f"the file is as it was issued on {self.stated['issued']}"
        return "\n".join([first, *(f"{what}: {how}" for what, how in self.lines)])


@checks
def verify_certificate(file: Path | str, result: Result | None = None) -> Verification:
    """Whether a certificate is as it was issued, and agrees with a result and the recordings that are still there.

    >>> result = hx.Result.load("loaded-result")
    >>> hx.certificate(result, "loaded.pdf")
    >>> hx.verify_certificate("loaded.pdf", result)
    the file is as it was issued on ...
    result loaded-result/result.json: the one that is certified
    recording ...recording.csv: the one that is certified

    Args:
        file: the certificate.
        result: result that it has to be of.

    Raises:
        FileProblem: no certificate, changed since it was issued, or of another result or recording.
    """
    place = Path(file)
    try:
        content = read_whole(place, MOST_JSON)
    except FileProblem as error:
        raise FileProblem(
            place=place, problem=error.problem, remedy="name a certificate, a PDF file", code=Code.UNREADABLE
        ) from error
    match = _EMBEDDED.search(content)
    if match is None:
        raise FileProblem(
            place=place,
            problem="is not a certificate of hexcite",
            remedy="name one that hexcite certificate wrote",
            code=Code.WRONG_KIND,
        )
    start, end = match.span(2)
    if hashlib.sha256(content[:start] + _NONE + content[end:]).hexdigest().encode() != match[2]:
        raise FileProblem(
            place=place,
            problem="was changed since it was issued",
            remedy="ask for the original, or issue it again",
            code=Code.CHANGED,
        )
    try:
        stated = json.loads(base64.b64decode(match[1]))
        certified = str(stated["fingerprints"]["result"])
        recordings = [(Path(entry["file"]), str(entry["sha256"])) for entry in stated["fingerprints"]["recording"]]
        json_text(stated)  # no NaN, which is not JSON
        str(Verification(stated, ()))
    except (*DAMAGED, RecursionError) as error:  # anybody can make a file with a fingerprint that is right
        raise FileProblem(
            place=place,
            problem="does not hold what a certificate of hexcite states",
            remedy="ask for the original, or issue it again",
            code=Code.DAMAGED,
        ) from error
    lines = list[tuple[str, str]]()
    if result is not None:
        if content_of(result.record.to_json()) != certified:
            raise FileProblem(
                place=place,
                problem=f"is of another result than {result.source}",
                remedy="name the result that it is of",
                code=Code.OTHER_SOURCE,
            )
        lines.append((f"result {result.source}", "the one that is certified"))
    for recording, fingerprint in recordings:
        if not recording.is_file():
            lines.append((f"recording {recording}", "is not here, not compared"))
        elif sha256_of(recording) != fingerprint:
            raise FileProblem(
                place=recording,
                problem=f"is not the recording of {place}",
                remedy="restore the recording",
                code=Code.OTHER_SOURCE,
            )
        else:
            lines.append((f"recording {recording}", "the one that is certified"))
    return Verification(stated, tuple(lines))


def _pdf(stated: Mapping[str, Any]) -> bytes:
    """The pages of what is stated, with the data and the fingerprint inside."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_pdf import PdfPages

    data = base64.b64encode(json.dumps(stated, sort_keys=True).encode()).decode()
    title = f"{text('c_title', stated['language'])} {stated['number']}".strip()
    about = {
        "Title": title, "Subject": stated["machine"]["title"], "Creator": FORMAT,
        "Keywords": f"hexcite:{data} sha256:{_NONE.decode()}",
    }  # fmt: skip
    buffer = BytesIO()
    with rc_context({"pdf.fonttype": 42, "font.family": "DejaVu Sans"}), PdfPages(buffer, metadata=about) as pages:
        for figure in _pages(stated, title):
            pages.savefig(figure)
    content = buffer.getvalue()
    match = _EMBEDDED.search(content)
    assert match is not None
    start, end = match.span(2)
    return content[:start] + hashlib.sha256(content).hexdigest().encode() + content[end:]


LEFT, RIGHT, TOP, BOTTOM = 0.09, 0.93, 0.945, 0.06  # shares of a page
LINE = 0.0137  # height of a line of text, share of a page
CHARACTERS = 116  # in a line of small text


class _Sheet:
    """Pages that text is written on from top to bottom; a new one where a page is full."""

    def __init__(self) -> None:
        from matplotlib.figure import Figure

        self._figure: Any = Figure
        self.figures, self.y = list[Any](), 0.0
        self.begin()

    def begin(self) -> None:
        """Begins a page."""
        self.figures.append(self._figure(figsize=(WIDTH, HEIGHT)))
        self.y = TOP

    def need(self, lines: float) -> None:
        """Begins a page where so many lines have no place left."""
        if self.y - lines * LINE < BOTTOM:
            self.begin()

    def put(
        self, cells: Sequence[tuple[float, str]], size: float = 8.0, weight: str = "normal", ends: bool = False
    ) -> None:
        """Writes cells of a line, each at its place from left to right; with `ends`, all but the first end there."""
        for k, (x, words) in enumerate(cells):
            align = "right" if ends and k else "left"
            self.figures[-1].text(
                x, self.y, words.replace("$", r"\$"), fontsize=size, weight=weight, ha=align, va="top"
            )
        self.y -= LINE * max(1.0, size / 8.5)

    def rule(self) -> None:
        """Draws a line across."""
        from matplotlib.lines import Line2D

        at = self.y + 0.15 * LINE
        self.figures[-1].add_artist(Line2D([LEFT, RIGHT], [at, at], color="0.6", linewidth=0.6))
        self.y -= 0.25 * LINE

    def heading(self, text: str) -> None:
        """Writes a heading that stays with what follows."""
        self.need(5)
        self.y -= 0.6 * LINE
        self.put([(LEFT, text)], 9.5, "bold")
        self.rule()

    def fact(self, name: str, value: str) -> None:
        """Writes a name with its value, which may take several lines; nothing where there is no value."""
        if not value:
            return
        for k, line in enumerate(textwrap.wrap(value, 84, break_long_words=True) or [""]):
            self.need(1)
            self.put([*([(LEFT, name)] if k == 0 else []), (LEFT + 0.2, line)])

    def paragraph(self, text: str) -> None:
        """Writes a sentence or several."""
        for line in textwrap.wrap(text, CHARACTERS, break_long_words=True):
            self.need(1)
            self.put([(LEFT, line)])


def _pages(stated: Mapping[str, Any], title: str) -> Iterator[Any]:
    """Figures of the pages."""
    sheet, machine, prints = _Sheet(), stated["machine"], stated["fingerprints"]
    language: Language = stated["language"]
    english = language == "en"

    def say(key: str, **places: Any) -> str:
        return text(f"c_{key}", language, **places)

    def cause(kind: str) -> str:
        return kind if english else answers.CAUSES.get(kind, kind)

    verdict, method = stated["verdict"], stated["method"]
    sheet.put([(LEFT, title)], 15.0, "bold")
    sheet.put([(LEFT, machine["title"])], 10.0)
    sheet.y -= 0.5 * LINE
    words_of = {passed: text("pass" if passed else "fail", language) for passed in (True, False)}
    sheet.put([(LEFT, say("verdict", word=words_of[verdict["passed"]]))], 11.0, "bold")
    if stated["simulated"]:
        sheet.put([(LEFT, say("simulated"))], 9.0, "bold")
    sheet.heading(say("object"))
    for key, value in (
        ("issued_by", stated["laboratory"]), ("operator", stated["operator"]), ("issued", stated["issued"]),
        ("recorded", say("by_file", date=stated["recorded"]) if stated["recorded"] else ""),
        ("machine", say("of_setup", case=machine["case"], setup=machine["setup"])),
        ("serial", ", ".join(f"{part} {number}" for part, number in stated["serial_numbers"].items())),
        ("conditions", stated["conditions"]), ("program", stated["program"]),
    ):  # fmt: skip
        sheet.fact(say(key), value)
    sheet.heading(say("method"))
    known = [say("known", name=name, value=value) for name, value in method["known"].items()]
    known += [say("prior", name=name) for name in method["priors"]]
    of = say("of_standstills" if method["standstills"] else "of_samples")
    figures = {key: method[key] for key in ("model", "samples", "rank", "condition", "s0")}
    weights = say(f"weights_{method['weights']}") if method["weights"] in WEIGHTS else method["weights"]
    sheet.paragraph(say("by", of=of, weights=weights, more="".join(f"; {each}" for each in known), **figures))
    sheet.heading(say("parameters", k=stated["coverage_factor"]))
    ends = (LEFT, LEFT + 0.55, LEFT + 0.7)
    heads = (text("parameter", language), text("value", language), "U")
    sheet.put([*zip(ends, heads, strict=True)], 7.5, "bold", ends=True)
    for name, of_name in stated["parameters"].items():
        scale, unit = legible(of_name["unit"])
        value, expanded = of_name["value"] * scale, of_name["U"] * scale
        sheet.need(1)
        exact = expanded <= 1e-9 * abs(value)
        texts = (
            (f"{value:.6g}", text("given", language)) if exact else (value_text(value, expanded), std_text(expanded))
        )
        cells = [(LEFT, parameter_words(name) if english else parameter(name)), *zip(ends[1:], texts, strict=True)]
        sheet.put(cells, ends=True)
        sheet.y += LINE
        sheet.put([(ends[2] + 0.015, unit)])
    sheet.y -= 0.4 * LINE
    sheet.paragraph(say("counts", what=", ".join(map(cause, stated["counted"]))))
    if stated["not_counted"]:
        sheet.paragraph(say("counts_not", what=", ".join(map(cause, stated["not_counted"]))))
    sheet.heading(say("verdicts"))
    for check in verdict["checks"]:
        sheet.need(1)
        bound = "at_least" if "at_least" in check else "at_most"
        limit = text(bound, language, limit=f"{check[bound]:.3g}")
        judged = check["check"]
        if not english and check["code"] in answers.CHECKS:
            judged = answers.CHECKS[check["code"]].format(of=parameter(str(check.get("of", ""))))
        words = [words_of[check["passed"]], judged, f"{check['value']:.3g}", limit, check["unit"]]
        first = LEFT + (0.07 if english else 0.15)
        sheet.put(list(zip((LEFT, first, LEFT + 0.57, LEFT + 0.65, LEFT + 0.79), words, strict=True)))
    phrases = verdict.get("not_judged_phrases") or [None] * len(verdict["not_judged"])  # earlier ones have none
    for reason, entries in zip(verdict["not_judged"], phrases, strict=True):
        sheet.paragraph(say("not_judged", reason=reason if english else plain(entries, reason)))
    if stated["warnings"]:
        sheet.heading(say("warnings"))
        for warning, phrase in zip(stated["warnings"], stated["phrases"], strict=True):
            sheet.paragraph(f"- {warning if english else plain(phrase, warning)}")
    sheet.need(7 + 2 * len(prints["recording"]))
    sheet.heading(say("chain"))
    chain = [(key, prints[key]) for key in ("case", "plan", "program")]
    chain += [("recording", f"{entry['file']}  SHA-256 {entry['sha256']}") for entry in prints["recording"]]
    for key, value in (*chain, ("result", prints["result"])):
        sheet.fact(say(key), value)
    sheet.fact(say("versions"), ", ".join(f"{name} {version}" for name, version in stated["versions"].items()))
    sheet.y -= 0.4 * LINE
    sheet.paragraph(say("verify"))
    for k, figure in enumerate(sheet.figures, 1):
        figure.text(RIGHT, 0.035, say("page", k=k, count=len(sheet.figures)), fontsize=7.5, ha="right")
        figure.text(LEFT, 0.035, f"{title}, {stated['issued']}", fontsize=7.5)
        yield figure
