"""A search for a cause says what it tries, and how long that may take."""

import logging
from dataclasses import replace

import numpy as np
import pytest

import hexcite as hx
from hexcite.texts import LANGUAGES, text
from identification.findings.causes.steps import SEARCHING, Standing, Step
from tests.damaged.runs import SOUND, STATED, Moves, machine, recorded

EXPECTED: dict[int, list[Step]] = {
    0: [],
    1: [Step.READINGS, Step.ONE, Step.WHOLE],
    3: [Step.READINGS, Step.ONE, Step.READ, Step.TWO],
}
"""The first steps of a run, by the number of mistakes in it."""


@pytest.mark.parametrize("mistakes", EXPECTED)
def test_steps_come_in_their_order_and_end_with_what_explains_the_run(
    caplog: pytest.LogCaptureFixture, mistakes: int
) -> None:
    of = machine("ur10_wrist")
    run = recorded(of, Moves(of, 1, 4.0), 1, STATED, SOUND)
    forces = np.array(run.forces)
    if mistakes:
        forces = forces[:, [1, 0, 2, 3, 4, 5]]
    if mistakes == 3:
        forces = forces[:, [0, 1, 3, 2, 5, 4]] * [1.0, -1.3, 1.0, 1.0, 0.7, 1.0]
    with caplog.at_level(logging.INFO, logger=SEARCHING.name):
        try:
            hx.identify(replace(run, forces=forces), of.case)
        except hx.HexciteError:
            assert mistakes
    found: list[Standing] = [vars(record)["standing"] for record in caplog.records if record.name == SEARCHING.name]
    steps = [each.step for each in found]
    assert steps[: len(EXPECTED[mistakes])] == EXPECTED[mistakes]
    assert sorted(set(steps), key=list(Step).index) == steps
    assert all((each.left is None) is (each.step is Step.READINGS) for each in found)
    assert all(each.left is None or each.left > 0.0 for each in found)


def test_every_step_has_words_on_the_page() -> None:
    for step in Step:
        assert text(f"step_{step.name.lower()}", "en") == step.words
        assert text(f"step_{step.name.lower()}", LANGUAGES[1]) != step.words
