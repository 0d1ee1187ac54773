"""A share of what `make nightly` tries: damaged input is answered or refused in a line; nothing is wrong unnoticed."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.bench.reliability.folders import tally_of_cases, tally_of_plans, tally_of_recordings, tally_of_results
from tests.bench.reliability.long_texts import READERS, SIZE, reader_of, tally_of_long_texts
from tests.bench.reliability.programs import CASE, DIALECTS
from tests.bench.reliability.recordings import ALONE_AND_IN_PAIRS, KINDS, tally_of_other_files, tally_of_runs
from tests.bench.reliability.stored import tally_of_bags, tally_of_parquet
from tests.bench.reliability.tally import Tally
from tests.bench.reliability.texts import bases, tally_of_texts
from tests.bench.reliability.urdf import tally_of_urdf
from tests.postprocessors.canonical import interpreted_share
from tests.postprocessors.edited import EVERY_DIALECT, changed, moves


@pytest.mark.parametrize("dialect", DIALECTS)
def test_damaged_programs(dialect: str) -> None:
    assert DIALECTS[dialect](range(12)).defects == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tally_of", "count"),
    [
        (tally_of_runs, 4), (tally_of_other_files, 15), (tally_of_cases, 20), (tally_of_results, 5),
        (tally_of_recordings, 5),
    ],
)  # fmt: skip
def test_damaged_recordings_cases_and_results(
    tally_of: Callable[[range, Path], Tally], count: int, tmp_path: Path
) -> None:
    tally = tally_of(range(count), tmp_path)
    assert tally.defects == []
    assert tally.counts["refused"] > 0, "nothing was refused: not a test"
    assert tally.tried == count


@pytest.mark.parametrize("seed", [960133, 960303])
def test_a_run_of_a_few_samples_at_its_end_is_answered_with_a_word(seed: int, tmp_path: Path) -> None:
    """Triggers the wrong way round: no longer filter fits behind the tenth of a second that they leave."""
    tally = tally_of_runs(range(seed, seed + 1), tmp_path)
    assert tally.defects == []
    assert tally.counts["answered with findings"] == 1


@pytest.mark.parametrize(("tally_of", "count"), [(tally_of_bags, 10), (tally_of_parquet, 40), (tally_of_urdf, 20)])
def test_damaged_bags_tables_and_robots(tally_of: Callable[[range, Path], Tally], count: int, tmp_path: Path) -> None:
    """What is answered is read twice: as stated and as proposed, or as an arm and as its case."""
    tally = tally_of(range(count), tmp_path)
    assert tally.defects == []
    assert min(tally.counts["refused"], tally.counts["answered"]) > count // 5, "not a test"


def test_damaged_texts_of_all_formats(tmp_path: Path) -> None:
    """Each base once; what is looked at and then read counts up to five times."""
    tally = tally_of_texts(range(len(bases())), tmp_path)
    assert tally.defects == []
    assert min(tally.counts["refused"], tally.counts["answered"]) > len(bases()) // 4, "not a test"


@pytest.mark.parametrize(
    ("reader", "text"),
    [
        ("mesh", "\n" * SIZE),
        ("INI", f"[AXIS_X]\nMAX_VELOCITY = 1{' ' * SIZE}1\n"),
        ("INI", f"[A{' ' * SIZE}B\n"),
        ("ros2 .py", "#!\n" + 'MESSAGE = r"""\n' * (SIZE // 15)),
        *((f"{how} commas", f"t_s,{'[' * 60_000}\n0,1\n1,2\n") for how in ("look at", "read")),
    ],
)
def test_no_pattern_takes_the_square_of_a_text(reader: str, text: str, tmp_path: Path) -> None:
    """Each of these took minutes to hours."""
    own, tally = reader_of(reader), Tally("long texts")
    file = tmp_path / own.name
    file.write_text(text, encoding="utf-8")
    tally.attempt(0, lambda: own.read(file), "")
    assert tally.defects == []


@pytest.mark.slow
def test_long_texts(tmp_path: Path) -> None:
    tally = tally_of_long_texts(range(2 * len(READERS)), tmp_path)
    assert tally.defects == []
    assert min(tally.counts["refused"], tally.counts["answered"]) > 0, "not a test"


@pytest.mark.slow
def test_damaged_plans(tmp_path: Path) -> None:
    assert tally_of_plans(range(60), tmp_path).defects == []


def test_there_are_fifteen_kinds_of_damage_alone_and_in_pairs() -> None:
    assert (len(KINDS), len(ALONE_AND_IN_PAIRS)) == (15, 15 + 15 * 14 // 2)


@pytest.mark.linuxcnc
def test_linuxcncs_own_interpreter_sees_what_is_dangerous() -> None:
    assert 0.3 < float(interpreted_share(moves("linuxcnc").encode(), CASE)) <= 1.0
    for edit in ("a feed ten times as high", "a height below ground", "a position ten times as far"):
        assert float(interpreted_share(changed(moves("linuxcnc"), *EVERY_DIALECT[edit]).encode(), CASE)) > 1.0
    assert "zero feed rate" in str(interpreted_share(b"G94\nG1 X1\nM2\n", CASE))
