"""The certificate of a result: A4 pages as PDF, with what they state as data inside, and its verification.

The keywords of the file hold what is stated as JSON in Base64, and the SHA-256 of the file with zeros in its place: a
byte that was changed since shows. It is not a signature: who makes a new file makes a new fingerprint.
"""

import base64
import hashlib
import json
import re
import warnings
from collections.abc import Mapping
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from cases.base.atomic import atomic_file
from cases.base.doors import checks
from cases.base.errors import Code, FileProblem, HexciteError, choice, option, printable
from cases.base.file_reading import DAMAGED, MOST_JSON, read_whole
from cases.base.output_places import check_file
from cases.base.provenance import sha256_of
from cases.base.text_formats import json_text
from cases.basis import content_of
from cases.certificate import CertificateOf
from hexcite.reports.certificate_pages import pages_of
from hexcite.texts import LANGUAGES, Language, text
from identification.estimation.fit import COVERAGE_FACTOR
from identification.recording.record import RunOrigin
from identification.results.result import Result
from identification.results.verdicts import accept

FORMAT, VERSION = "hexcite certificate", 1
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
    statement = statements(result, about or result.case.certificate or CertificateOf(), number)
    statement["language"] = language
    content = _pdf(statement)
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
    statement, certified, recordings = _stated_in(place)
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
    return Verification(statement, tuple(lines))


class _Stated(NamedTuple):
    """What a certificate states, with the fingerprints in it."""

    entries: Mapping[str, Any]
    result: str
    recordings: tuple[tuple[Path, str], ...]  # files and fingerprints


def _stated_in(place: Path) -> _Stated:
    """What a certificate states; raises FileProblem where it is none, or was changed since it was issued."""
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
        statement = json.loads(base64.b64decode(match[1]))
        prints = statement["fingerprints"]
        recordings = tuple((Path(entry["file"]), str(entry["sha256"])) for entry in prints["recording"])
        certified = _Stated(statement, str(prints["result"]), recordings)
        json_text(statement)  # no NaN, which is not JSON
        str(Verification(statement, ()))
    except (*DAMAGED, RecursionError) as error:  # anybody can make a file with a fingerprint that is right
        raise FileProblem(
            place=place,
            problem="does not hold what a certificate of hexcite states",
            remedy="ask for the original, or issue it again",
            code=Code.DAMAGED,
        ) from error
    return certified


def _pdf(statement: Mapping[str, Any]) -> bytes:
    """The pages of what is stated, with the data and the fingerprint inside."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_pdf import PdfPages

    data = base64.b64encode(json.dumps(statement, sort_keys=True).encode()).decode()
    title = f"{text('c_title', statement['language'])} {statement['number']}".strip()
    about = {
        "Title": printable(title), "Subject": printable(statement["machine"]["title"]), "Creator": FORMAT,
        "Keywords": f"hexcite:{data} sha256:{_NONE.decode()}",
    }  # fmt: skip
    buffer = BytesIO()
    fonts = rc_context({"pdf.fonttype": 42, "font.family": "DejaVu Sans"})
    with warnings.catch_warnings(), fonts, PdfPages(buffer, metadata=about) as pages:
        # names in scripts that no font of matplotlib has are boxes on the pages, and whole in the data
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        for figure in pages_of(statement, title):
            pages.savefig(figure)
    content = buffer.getvalue()
    match = _EMBEDDED.search(content)
    assert match is not None
    start, end = match.span(2)
    return content[:start] + hashlib.sha256(content).hexdigest().encode() + content[end:]
