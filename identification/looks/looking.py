"""A look at files of unknown format: what their columns are likely to mean, proposed and tried."""

from collections.abc import Sequence
from pathlib import Path

from cases.base.errors import Code, RecordingError
from cases.schema import Case
from identification.looks.bags import look_at_bags
from identification.looks.look import Look
from identification.looks.tables import look_at_tables, says_how
from identification.looks.trial import refusal_of
from identification.recording.formats.reading import is_bag, recording_of


def look(files: Path | str | Sequence[Path | str], case: Case | None = None) -> Look:
    """What a file of unknown format is likely to be, or the files of one run.

    >>> seen = hx.look("empty/recording.csv", hx.load_case("hexapod"))
    >>> seen.problem, seen.rows > 1_000
    (None, True)

    Args:
        files: text, Parquet, bags of ROS 1 or ROS 2, or the folder of a run.
        case: the machine that it was recorded on, with what it states of its recordings; without one, units and
            completeness follow from the names alone.

    Raises:
        RecordingError: a file cannot be read, or holds no table of numbers.
    """
    places = [recording_of(Path(file)) for file in ([files] if isinstance(files, Path | str) else files)]
    if not places:
        raise RecordingError(problem="no recording is named", remedy="give the files of one run", code=Code.MISSING)
    if all(map(is_bag, places)):
        return look_at_bags(places, case)
    if bag := next((place for place in places if is_bag(place)), None):
        raise RecordingError(
            place=bag,
            problem="is a bag, which is looked at without files of another kind",
            remedy="look at it by itself",
            code=Code.NOT_SUPPORTED,
        )
    refusal = None if case is None or not says_how(case) else refusal_of(places, case)
    return look_at_tables(places, case, refusal)
