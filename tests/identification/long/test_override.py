"""The recorded feed override of runs that are evaluated in blocks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from identification.identify import identify
from identification.long.feed import MOST_TOLD, LongFeed
from identification.long.streaming import identify_long
from identification.recording import Recording, read_recording
from tests.identification.long.long_runs import CASE, RUN, assert_same, written


@pytest.mark.parametrize("trigger", [True, False])
def test_a_recorded_override_is_told_as_in_a_whole_run(trigger: bool, tmp_path: Path) -> None:
    """Stretches within blocks, across their ends, next to each other, and outside the window."""
    override = np.ones(len(RUN.forces))
    override[650:1500], override[1500:1650], override[2900:3000], override[:100] = 0.7, 0.4, 1.2, 0.5
    file = written(tmp_path)
    table = pq.read_table(file).append_column("override_percent", pa.array(100.0 * override))
    pq.write_table(table if trigger else table.drop_columns(["trigger"]), file)
    whole, long = identify(read_recording(file, CASE), CASE), identify_long(file, CASE).estimate
    assert long.told["feed"] == whole.told["feed"]
    assert len(long.told["feed"]["stretches"]) == 3 + (not trigger)
    assert [w for w in long.warnings if "feed" in w] == [w for w in whole.warnings if "feed" in w]
    assert_same(long, whole)


def test_of_ever_changing_feed_the_first_stretches_are_told_and_the_others_counted() -> None:
    feed, rows = LongFeed(), np.arange(3000)
    override = np.where(rows % 2, 1.0, 0.5)
    for start in range(0, 3000, 700):
        part = slice(start, start + 700)
        block = Recording("run", rows[part] / 1e3, None, None, np.zeros((len(rows[part]), 6)), None)
        feed.add(replace(block, override=override[part]))
    (sentence,), told = feed.told()
    assert len(told["feed"]["stretches"]) == MOST_TOLD
    assert told["feed"]["more"] == 1500 - MOST_TOLD
    assert f"and {1500 - 3} more stretches" in sentence
