"""Text is read however it is stored, with the same run; what is not text is named, with the way to a table."""

import gzip
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from identification.looks.looking import look
from identification.recording.formats import content
from identification.recording.recording import read
from tests.helpers import refused_at
from tests.identification.recording.formats.runs import HEXAPOD, Truth, csv, written

RUN = Truth()
TEXT = csv(RUN.numbers())
STORED = {
    "UTF-8 with its mark": TEXT.encode("utf-8-sig"),
    "UTF-16 of Windows": TEXT.replace("\n", "\r\n").encode("utf-16"),
    "UTF-16, the large byte first": b"\xfe\xff" + TEXT.encode("utf-16-be"),
    "lines as on a Macintosh": TEXT.replace("\n", "\r").encode("utf-8-sig"),
    "lines as on a Macintosh, UTF-16 in gzip": gzip.compress(TEXT.replace("\n", "\r").encode("utf-16")),
    "gzip": gzip.compress(TEXT.encode()),
    "gzip in two parts": gzip.compress(TEXT[:900].encode()) + gzip.compress(TEXT[900:].encode()),
    "UTF-16 in gzip": gzip.compress(TEXT.encode("utf-16")),
}


@pytest.mark.parametrize("how", STORED)
def test_the_run_is_the_same_however_its_text_is_stored(how: str, tmp_path: Path) -> None:
    file = written(tmp_path, STORED[how])
    recording = read(file, HEXAPOD)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    assert look(file, HEXAPOD).reads


def test_a_place_in_stored_text_is_its_line(tmp_path: Path) -> None:
    lines = TEXT.splitlines()
    lines[7] = lines[7].replace(",", ",x", 1)
    file = written(tmp_path, gzip.compress("\n".join(lines).encode("utf-16")), "run.csv.gz")
    with pytest.raises(RecordingError, match=r"run.csv.gz, line 8, l1_mm: 'x.*' is not a number"):
        read(file, HEXAPOD)


def _workbook() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("xl/worksheets/sheet1.xml", "<worksheet/>")
    return stream.getvalue()


def _array() -> bytes:
    stream = io.BytesIO()
    np.save(stream, RUN.forces)
    return stream.getvalue()


FOREIGN = {
    "MATLAB": (b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(200), r"MATLAB file; export it as CSV .*Parquet"),
    "HDF5": (b"\x89HDF\r\n\x1a\n" + bytes(200), r"HDF5 file.*; export"),
    "TDMS": (b"TDSm\x0e\0\0\0i\x12" + bytes(200), r"TDMS file of LabVIEW; export"),
    "MDF": (b"MDF     4.10    asammdf " + bytes(200), r"MDF file .*; export"),
    "a workbook": (_workbook(), r"workbook of Excel.*; save the sheet as CSV"),
    "an old workbook": (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(200), r"old workbook .*; save the sheet as CSV"),
    "an array": (_array(), r"array of NumPy; .*savetxt"),
    "a bag of ROS 1": (b"#ROSBAG V2.0\n" + bytes(200), r"bag of ROS 1|rosbags"),
    "xz": (b"\xfd7zXZ\0" + bytes(200), r"compressed with xz; unpack it"),
    "gzip, cut off": (gzip.compress(TEXT.encode())[:-30], r"gzip file that is cut off; copy it again"),
    "gzip, damaged": (b"\x1f\x8b" + bytes(200), r"damaged gzip file; copy it again"),
    "MATLAB in gzip": (gzip.compress(b"MATLAB 5.0 MAT-file" + bytes(200)), r"MATLAB file; export"),
}


@pytest.mark.parametrize("what", FOREIGN)
def test_what_is_not_text_is_named_by_the_reader_and_by_look(what: str, tmp_path: Path) -> None:
    data, message = FOREIGN[what]
    file = written(tmp_path, data, "run.dat")
    for call in (lambda: read(file, HEXAPOD), lambda: look(file, HEXAPOD)):
        with refused_at(file, message):
            call()


def test_a_small_file_that_unpacks_to_more_than_the_memory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path, gzip.compress(TEXT.encode() + b"\n" * 50_000_000), "run.csv.gz")
    monkeypatch.setattr(content, "free_memory", lambda: 40_000_000)
    with pytest.raises(RecordingError, match=r"more than 0.01 GB of text, a quarter of the free memory; cut the run"):
        read(file, HEXAPOD)
