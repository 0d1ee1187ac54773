"""A damaged file, read as its case says and as `look` proposes: what is read is sound, what is proposed works."""

from pathlib import Path

import numpy as np

from cases.recording_format import RecordingFormat
from cases.schema import Case
from identification.looks.looking import look
from identification.recording.recording import Recording, read
from tests.bench.reliability.tally import Tally


def as_stated(file: Path, case: Case, how: str, seed: int, tally: Tally, place: Path | None = None) -> None:
    """Reads a file as its case says; its refusal must name `place`, which is the file unless given."""
    recording = tally.attempt(seed, lambda: read(file, case), str(place or file))
    _require_sound(recording, f"{how}, as stated", seed, tally)


def as_proposed(file: Path, case: Case, how: str, seed: int, tally: Tally, place: Path | None = None) -> None:
    """Looks at a file, and reads it with what is proposed where that is said to read."""
    seen = tally.attempt(seed, lambda: look(file, case), str(place or file))
    if seen is None or not seen.reads:
        return
    own = case.model_copy(update={"recording": RecordingFormat.model_validate(dict(seen.settings))})
    refused = tally.counts["refused"]
    recording = tally.attempt(seed, lambda: read(file, own), str(place or file))
    if tally.counts["refused"] > refused:
        tally.defect(seed, f"{how}: look proposes what is refused")
    _require_sound(recording, f"{how}, as proposed", seed, tally)


def _require_sound(recording: Recording | None, how: str, seed: int, tally: Tally) -> None:
    for stream in () if recording is None else (recording, *recording.others):
        runs = stream.t is None or bool(np.all(np.diff(stream.t) > 0))  # None: averages at standstills
        if not (runs and all(np.isfinite(array).all() for array in stream.channels.values())):
            tally.defect(seed, f"{how}: a stream that is not finite, or whose clock does not run")
