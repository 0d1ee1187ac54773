"""The table `[recording]` of a run from what is proposed for each of its files, and what a person should complete."""

import re
from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Any

from cases.base.phrases import Phrase, phrase
from cases.recording_format import (
    CLOCK,
    TRIGGER,
)
from identification.recording.formats.proposal import LAYOUT, Proposal


def missing_parts(places: Container[str], of_run: Container[str], settings: Mapping[str, Any]) -> Iterator[Phrase]:
    """Sentences on what a person should complete in a file.

    Args:
        places: what the file has, by our names.
        of_run: what all files of the run have.
        settings: `[recording]` of the run.
    """
    if CLOCK not in places and "period_ms" not in settings.get("clock", {}):
        yield phrase(
            "no_clock_there",
            "no clock: each row is taken for an averaged standstill; of a motion state recording.clock.period_ms",
        )
    elif TRIGGER not in of_run and "trigger" not in settings:
        yield phrase("no_trigger_there", "no trigger: the whole motion is evaluated, the ways from and to home too")


_OF_A_FILE = LAYOUT | {"columns", "units", "clock", "orientation", "scale", "offset", "trigger"}
"""Keys of `[recording]` that may differ between the files of a run."""


def proposal_of_run(proposals: Sequence[tuple[str, Proposal]]) -> dict[str, Any]:
    """`[recording]` of a run from that of each of its files, by name: one table where they agree, else one for each.

    Samples are counted by those of the forces.
    """
    settings_of_files = [{key: value for key, value in of.settings.items() if key in _OF_A_FILE} for _, of in proposals]
    by_forces = sorted(proposals, key=lambda named: named[1].has_forces)
    common = {key: value for _, of in by_forces for key, value in of.settings.items()}
    machine = {key: value for key, value in common.items() if key not in _OF_A_FILE}
    if "filter_cutoff_Hz" in machine:
        machine["filter_cutoff_Hz"] = min(of.settings["filter_cutoff_Hz"] for _, of in proposals)
    alike = all({**table, "columns": None} == {**settings_of_files[0], "columns": None} for table in settings_of_files)
    columns: dict[str, str] = {}
    for table in settings_of_files:
        alike &= all(columns.get(ours, theirs) == theirs for ours, theirs in table.get("columns", {}).items())
        columns |= table.get("columns", {})
    if alike and len({*columns.values()}) == len(columns):
        return {**settings_of_files[0], **machine, **({"columns": columns} if columns else {})}
    patterns = [re.sub(r"\d+", "*", name) for name, _ in proposals]
    distinct = len({*patterns}) == len(patterns)
    matches = patterns if distinct else [name for name, _ in proposals]
    files = [{"match": match, **table} for match, table in zip(matches, settings_of_files, strict=True)]
    return {**machine, "files": files}
