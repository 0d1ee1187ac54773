"""Data and page in one folder, which appears whole."""

from pathlib import Path
from typing import TYPE_CHECKING

from cases.files import FolderKind, atomic_folder
from planner.reports.page import render
from planner.reports.report import figures, page

if TYPE_CHECKING:
    from planner.reports.report import Shown


def save_with_page(value: "Shown", kind: FolderKind, folder: Path, overwrite: bool, plots: bool) -> None:
    """Writes a value with its page report.html and, where asked for, figures for papers in plots/.

    Raises:
        FileProblem: the folder is somebody's, or cannot be written.
    """
    with atomic_folder(folder, kind, overwrite) as part:
        value.write(part)
        (part / "report.html").write_text(render(page(value)), encoding="utf-8")
        if plots:
            figures(value, part / "plots")
