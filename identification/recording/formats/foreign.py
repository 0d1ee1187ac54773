"""Files that are not tables of text: what their first bytes say they are, and how to get a table from each."""

from typing import NamedTuple

from cases.base.errors import Code, RecordingError


class Kind(NamedTuple):
    """A kind of file that is known by its first bytes."""

    name: str  # with its article
    remedy: str  # how to get a table that can be read
    marks: tuple[bytes, ...]
    at: int = 0  # where the mark stands


_UNPACK = "unpack it and give the file in it"
_SHEET = "save the sheet as CSV, with a header line of names"
_BAG = "let its name end in .mcap or .db3, or give the bag's folder"
_KINDS = (
    Kind("a workbook of Excel or an archive (ZIP)", f"{_SHEET}; unpack an archive", (b"PK\x03\x04", b"PK\x05\x06")),
    Kind("an old workbook of Excel, or another file of Office", _SHEET, (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",)),
    Kind(
        "a MATLAB file", "export it as CSV (writetable) or Parquet (parquetwrite)",
        (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file"),
    ),
    Kind(
        "an HDF5 file, as MATLAB 7.3 and h5py write", "export its data sets as the columns of a CSV or Parquet file",
        (b"\x89HDF\r\n\x1a\n",),
    ),
    Kind("a TDMS file of LabVIEW", "export it as CSV in LabVIEW or DIAdem, or as LVM", (b"TDSm", b"TDSh")),
    Kind("an MDF file (MF4)", "export it as CSV or Parquet, with asammdf for example", (b"MDF     ", b"UnFinMF ")),
    Kind("an array of NumPy", "save it with numpy.savetxt, with names in a header", (b"\x93NUMPY",)),
    Kind("a file of imc FAMOS", "export it as CSV", (b"|CF,",)),
    Kind("a bag of ROS 1", "let its name end in .bag", (b"#ROSBAG V",)),
    Kind("an MCAP file of a ROS 2 bag", _BAG, (b"\x89MCAP0\r\n",)),
    Kind("a database of SQLite, perhaps of a ROS 2 bag", _BAG, (b"SQLite format 3\0",)),
    Kind("a Feather or Arrow file", "write it as Parquet", (b"ARROW1\0\0", b"FEA1\0\0\0\0")),
    Kind("a pickle of Python", "write the table as CSV or Parquet", (b"\x80\x03", b"\x80\x04", b"\x80\x05")),
    Kind("compressed with bzip2", _UNPACK, tuple(b"BZh%d1AY&SY" % level for level in range(1, 10))),
    Kind("compressed with xz", _UNPACK, (b"\xfd7zXZ\0",)),
    Kind("compressed with zstd", _UNPACK, (b"\x28\xb5\x2f\xfd",)),
    Kind("compressed with gzip twice", _UNPACK, (b"\x1f\x8b",)),
    Kind("an archive of 7-Zip", _UNPACK, (b"7z\xbc\xaf\x27\x1c",)),
    Kind("an archive of RAR", _UNPACK, (b"Rar!\x1a\x07",)),
    Kind("an archive (tar)", _UNPACK, (b"ustar",), 257),
    Kind("a PDF document", "export the recording as CSV or Parquet", (b"%PDF-",)),
    Kind("a picture", "export the recording as CSV or Parquet", (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"II*\0")),
    Kind("a program", "give the recording as CSV or Parquet", (b"\x7fELF", b"MZ\x90\0")),
    Kind("text in UTF-32", "save it as UTF-8", (b"\xff\xfe\0\0", b"\0\0\xfe\xff")),
    Kind("a web page, as some programs write a workbook", _SHEET, (b"<!DOCTYPE html", b"<!doctype html", b"<html")),
)  # fmt: skip
_LONGEST = 512


def require_text(file: object, data: bytes) -> None:
    """Raises RecordingError where the first bytes are those of a file that is not text, with what to do."""
    start = data[:_LONGEST]
    kind = next((k for k in _KINDS if start[k.at :].startswith(k.marks)), None)
    if kind is not None:
        raise RecordingError(place=str(file), problem=f"is {kind.name}", remedy=kind.remedy, code=Code.WRONG_KIND)
