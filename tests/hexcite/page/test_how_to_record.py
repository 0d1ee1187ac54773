"""How a run is recorded on each controller: what stands on the page fits the case and the program."""

import re

import pytest

import hexcite as hx
from hexcite.page.how_to_record import STEPS, recipe
from hexcite.texts import LANGUAGES, text

MACHINES = {
    "linuxcnc": "strut_sensors", "sinumerik": "hexapod", "twincat": "hexapod", "setpoints": "five_axis_table",
    "urscript": "ur10_wrist", "ros2": "ur10_wrist",
}  # fmt: skip


@pytest.mark.parametrize("dialect", STEPS)
def test_every_controller_has_steps_in_both_languages(dialect: str):
    """Each with its places filled: no braces are left."""
    made = recipe(hx.load_case(MACHINES[dialect]), dialect, "run", 12.0)
    for language in LANGUAGES:
        for step in made.steps:
            assert not re.search(r"[{}]", text(step, language, **made.places))
    assert float(made.places["rate"]) >= 500.0
    assert float(made.places["seconds"]) > 12.0


def test_the_sampler_of_linuxcnc_has_a_pin_for_each_channel():
    """One bit and twelve floats, in the order in which the file is read; samples for the motion and around it."""
    made = recipe(hx.load_case("strut_sensors"), "linuxcnc", "run", 12.0)
    assert re.search(r"cfg=bf{12}$", made.commands, re.MULTILINE)
    pins = [int(pin) for pin in re.findall(r"sampler\.0\.pin\.(\d+)", made.commands)]
    assert pins == list(range(13))
    count = int(re.search(r"halsampler -t -n (\d+) > run\.txt", made.commands)[1])
    assert count >= 12.0 * float(made.places["rate"])


def test_channels_are_named_as_the_case_reads_them():
    case = hx.load_case("hexapod")
    own = case.model_copy(update={"recording": case.recording.model_copy(update={"columns": {"f1_N": "Kraft 1"}})})
    made = recipe(own, "twincat", "run", 12.0)
    assert "f1_N (Kraft 1)" in made.channels
    assert made.channels[-1] == "trigger"
    assert "M100" in text("rec_scope_trigger", "en", **made.places)


def test_a_trace_that_the_program_starts_is_armed_and_else_started_by_hand():
    case = hx.load_case("hexapod")
    traced = case.controller.sinumerik.model_copy(update={"trace": True})
    own = case.model_copy(update={"controller": case.controller.model_copy(update={"sinumerik": traced})})
    assert "rec_trace_by_hand" in recipe(case, "sinumerik", "run", 12.0).steps
    assert "rec_trace_armed" in recipe(own, "sinumerik", "run", 12.0).steps


def test_a_robot_records_the_raw_wrench_at_its_rate():
    made = recipe(hx.load_case("ur10_wrist"), "urscript", "run", 12.0)
    assert "ft_raw_wrench" in made.commands
    assert "--frequency 500 " in made.commands
    assert "actual_TCP_force" not in made.commands
