"""How a run is recorded on each controller: channels, rate, file, commands to type, and steps in words."""

from typing import NamedTuple

from cases.recording_format import TRIGGER
from cases.schema import Case

LEAST_RATE = 500.0  # [1/s]
AROUND = 20.0  # [s] beside the excitation: ways there and back, standing, switching


class Recipe(NamedTuple):
    """What to do at a control."""

    steps: tuple[str, ...]  # keys of texts, each with the places below
    places: dict[str, str]
    commands: str  # to type or paste; empty where all is done by hand
    channels: tuple[str, ...]  # the trigger last; in brackets names that the case has of the last recorder


def recipe(case: Case, dialect: str, name: str, seconds: float) -> Recipe:
    """How the run of a program is recorded.

    Args:
        name: of the recording, without a suffix.
        seconds: of the program's motion.
    """
    rate = max(LEAST_RATE, case.recording.rate_Hz or 0.0)
    positions = tuple(f"l{k}_mm" for k in range(1, 7)) if case.chain is None else case.chain.columns
    ours = (*positions, *case.sensor_frame.channels, *(() if dialect == "ros2" else (TRIGGER,)))
    channels = tuple(
        column if (name_there := case.recording.file_name(column)) == column else f"{column} ({name_there})"
        for column in ours
    )
    samples = f"{rate * (seconds + AROUND):.0f}"
    places = {"rate": f"{rate:g}", "seconds": f"{seconds + AROUND:.0f}", "file": f"{name}.csv", "trigger": ""}
    commands = ""
    controller = case.controller
    if dialect == "linuxcnc":
        places["file"] = f"{name}.txt"
        commands = _halsampler(case, len(positions), places["file"], samples)
    elif dialect == "sinumerik":
        places["file"] = f"{name}.xml"
        if controller is not None and controller.sinumerik is not None:
            places["trigger"] = f"$A_OUT[{controller.sinumerik.trigger_output}]"
            traced = controller.sinumerik.trace
            steps = ("rec_trace_session", "rec_trace_armed" if traced else "rec_trace_by_hand", "rec_trace_save")
            return Recipe(steps, places, "", channels)
    elif dialect == "twincat" and controller is not None and controller.twincat is not None:
        places["trigger"] = f"M{controller.twincat.trigger_on_m}, M{controller.twincat.trigger_off_m}"
    elif dialect == "urscript":
        if controller is not None and controller.urscript is not None:
            places["trigger"] = f"{controller.urscript.trigger_output}"
        commands = _rtde(places["file"], rate)
    elif dialect == "ros2":
        names_of_topics = case.recording.ros
        topics = names_of_topics.get("joints", "/joint_states"), names_of_topics.get("wrench", "/ft/wrench_raw")
        places["file"] = name
        commands = f"ros2 bag record {' '.join(topics)} -o {name}"
    return Recipe(STEPS[dialect], places, commands, channels)


STEPS = {
    "linuxcnc": ("rec_hal_load", "rec_hal_forces", "rec_hal_run"),
    "sinumerik": ("rec_trace_session", "rec_trace_by_hand", "rec_trace_save"),
    "twincat": ("rec_scope_channels", "rec_scope_trigger", "rec_scope_export"),
    "urscript": ("rec_rtde_file", "rec_rtde_run", "rec_rtde_raw"),
    "setpoints": ("rec_table_channels", "rec_table_trigger", "rec_table_export"),
    "ros2": ("rec_bag_run", "rec_bag_raw", "rec_bag_stop"),
}
"""Controller -> keys of texts."""


def _halsampler(case: Case, struts: int, file: str, samples: str) -> str:
    forces = len(case.sensor_frame.channels)
    lines = [
        f"loadrt sampler depth=8192 cfg=b{'f' * (struts + forces)}",
        "addf sampler.0 servo-thread",
        "net trigger motion.digital-out-00 => sampler.0.pin.0",
        *(f"net strut-{k + 1} joint.{k}.pos-fb => sampler.0.pin.{k + 1}" for k in range(struts)),
        *(f"net force-{k + 1} YOUR_FORCE_{k + 1} => sampler.0.pin.{struts + k + 1}" for k in range(forces)),
        "",
        f"halsampler -t -n {samples} > {file}",
    ]
    return "\n".join(lines)


_RTDE = (
    ("timestamp", "DOUBLE"), ("actual_q", "VECTOR6D"), ("ft_raw_wrench", "VECTOR6D"),
    ("actual_digital_output_bits", "UINT64"),
)  # fmt: skip
"""What is asked of the robot, and its type there."""


def _rtde(file: str, rate: float) -> str:
    fields = "\n".join(f'    <field name="{name}" type="{kind}"/>' for name, kind in _RTDE)
    recipe_text = f'<?xml version="1.0"?>\n<rtde_config>\n  <recipe key="out">\n{fields}\n  </recipe>\n</rtde_config>'
    run = f"python record.py --host ROBOT --frequency {rate:g} --config record_configuration.xml --output {file}"
    return f"{recipe_text}\n\n{run}"
