"""A certificate states what a result says, on A4 pages, and shows when it was changed."""

import base64
import hashlib
import os
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
from pypdf import PdfReader

import hexcite as hx
from cases.base.errors import FileProblem, HexciteError
from cases.base.phrases import phrase
from cases.base.provenance import sha256_of
from cases.certificate import CertificateOf
from identification.finding import Kind, warning
from identification.results.result import Result
from identification.texts import value_text
from tests.damaged.runs import SOUND, STATED, Moves, machine, recorded
from tests.helpers import refused_at

ABOUT = CertificateOf(operator="A. Müller", serial_numbers={"machine": "HX-7"}, conditions="$22.5 °C$, warm")

ODD = (
    warning(Kind.CLOCK, phrase("large_delay", "delay of {delay} ms: do the streams match?", delay="12.0")),
    warning(Kind.CASE, "something without a code"),
)


@pytest.fixture(scope="module")
def result() -> Result:
    of = machine("hexapod")
    return hx.identify(recorded(of, Moves(of, 1, 4.0), 1, STATED, SOUND), of.case)


def test_its_pages_state_what_the_result_says(result: Result, tmp_path: Path) -> None:
    hx.certificate(result, tmp_path / "c.pdf", ABOUT, "2026-17")
    pages = PdfReader(tmp_path / "c.pdf").pages
    text = "\n".join(page.extract_text() for page in pages)
    mass = result["m"]
    for words in (
        "2026-17", "A. Müller", "machine HX-7", "$22.5 °C$", "PASS", value_text(mass.value, mass.expanded),
        "does NOT count tolerances of: drawing, gains", result.record.case_hash, f"page 1 of {len(pages)}",
    ):  # fmt: skip
        assert words in text, words
    assert all(abs(float(page.mediabox.height) / float(page.mediabox.width) - 297 / 210) < 2e-3 for page in pages)
    stated = hx.verify_certificate(tmp_path / "c.pdf", result).stated
    assert stated["parameters"]["m"] == {"value": mass.value, "U": 2.0 * mass.reported, "unit": "kg"}
    assert stated["verdict"]["not_judged"]


def test_it_is_german_where_that_is_asked_for(result: Result, tmp_path: Path) -> None:
    noisy = replace(result, record=result.record.replaced(findings=(*result.findings, *ODD)))
    hx.certificate(noisy, tmp_path / "c.pdf", ABOUT, "7", language="de")
    text = "\n".join(page.extract_text() for page in PdfReader(tmp_path / "c.pdf").pages)
    for words in (
        "Kalibrierzertifikat 7", "Bearbeiter", "BESTANDEN", "U enthält KEINE Toleranzen von: Zeichnung",
        "Masse (m)", "- Verzögerung von 12.0 ms", "“something without a code”", "Seite 1 von",
    ):  # fmt: skip
        assert words in text, words
    own = {"Calibration", "Verdict", "Operator", "PASS", "Warnings", "Recording", "at most", "does NOT", "mass (m)"}
    assert not [words for words in own if words in text]
    assert hx.verify_certificate(tmp_path / "c.pdf", noisy).stated["language"] == "de"
    with pytest.raises(HexciteError, match="'fr' is not a language"):
        hx.certificate(result, tmp_path / "f.pdf", language=cast(Any, "fr"))


def test_names_that_steer_a_terminal_or_that_no_font_has_are_written_without_a_warning(
    result: Result, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    hx.certificate(result, tmp_path / "c.pdf", ABOUT, "7\x1b[31m\u202e六足")
    assert capfd.readouterr() == ("", "")
    text = "\n".join(page.extract_text() for page in PdfReader(tmp_path / "c.pdf").pages)
    assert r"7\x1b[31m\u202e" in text
    assert not {"\x1b", "\u202e"} & {*text}


def test_any_change_of_the_file_shows(result: Result, tmp_path: Path) -> None:
    place, changed = tmp_path / "c.pdf", tmp_path / "changed.pdf"
    hx.certificate(result, place)
    content = place.read_bytes()
    for at in (100, len(content) // 2, content.index(b"hexcite:") + 50, len(content) - 3):
        changed.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
        with pytest.raises(FileProblem, match=r"changed since it was issued|not a certificate"):
            hx.verify_certificate(changed)
    changed.write_bytes(content + b"more")
    with pytest.raises(FileProblem, match="changed since"):
        hx.verify_certificate(changed)
    changed.write_text("no certificate")
    with pytest.raises(FileProblem, match="not a certificate"):
        hx.verify_certificate(changed)
    with pytest.raises(FileProblem, match="overwrite"):
        hx.certificate(result, place)


@pytest.mark.parametrize(
    "stated",
    ["[" * 100_000, "[]", "3", "{}", '{"issued": 1, "fingerprints": {"result": 1, "recording": [{"file": 1}]}}',
     '{"issued": NaN, "fingerprints": {"result": "a", "recording": []}}', "no JSON"],
)  # fmt: skip
def test_a_forged_file_with_a_right_fingerprint_is_refused(stated: str, tmp_path: Path) -> None:
    embedded = b"hexcite:" + base64.b64encode(stated.encode())
    own = hashlib.sha256(embedded + b" sha256:" + b"0" * 64).hexdigest().encode()
    forged = tmp_path / "c.pdf"
    forged.write_bytes(embedded + b" sha256:" + own)
    with refused_at(forged, "does not hold what a certificate", FileProblem):
        hx.verify_certificate(forged)


def test_a_pipe_is_not_a_certificate(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "c.pdf")
    with pytest.raises(FileProblem, match=r"a pipe or device.*name a certificate"):
        hx.verify_certificate(tmp_path / "c.pdf")


def test_another_result_or_recording_shows(result: Result, tmp_path: Path) -> None:
    run = tmp_path / "run.csv"
    run.write_text("1,2,3")
    inputs = ({"file": str(run), "sha256": sha256_of(run)},)
    of_file = replace(result, record=result.record.replaced(inputs=inputs))
    hx.certificate(of_file, tmp_path / "c.pdf")
    assert any("one that is certified" in how for _, how in hx.verify_certificate(tmp_path / "c.pdf", of_file).lines)
    with pytest.raises(FileProblem, match="another result"):
        hx.verify_certificate(tmp_path / "c.pdf", result)
    run.write_text("1,2,4")
    with pytest.raises(FileProblem, match="not the recording"):
        hx.verify_certificate(tmp_path / "c.pdf")
    run.unlink()
    assert any("not here" in how for _, how in hx.verify_certificate(tmp_path / "c.pdf").lines)


@pytest.mark.repeats
def test_many_parameters_take_more_pages_and_none_is_lost(result: Result, tmp_path: Path) -> None:
    many = {f"{name}_{k}": value for k in range(6) for name, value in result.parameters.items()}
    hx.certificate(replace(result, record=result.record.replaced(parameters=many)), tmp_path / "c.pdf")
    pages = PdfReader(tmp_path / "c.pdf").pages
    text = "\n".join(page.extract_text() for page in pages)
    assert len(pages) > 1
    assert all(name in text for name in many)
