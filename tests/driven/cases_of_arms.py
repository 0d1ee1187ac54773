"""Cases of the arms, begun from their URDF as a user does it: what identification needs alone, and what plans need."""

import re
from pathlib import Path

import numpy as np

from hexcite._new_arm import new_arm
from tests.driven.arms import Arm, Load

OUTPUT = 3  # standard digital output of the trigger


def evaluating(arm: Arm, folder: Path) -> Path:
    """A case that can identify and no more: the URDF, and that the sensor reads what the load does to it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(arm.urdf())
    file = new_arm(arm.name, folder / "robot.urdf", "tool0", folder, "ft")
    file.write_text(file.read_text().replace('# sense = "load_on_sensor"', 'sense = "load_on_sensor"'))
    return file


def planning(arm: Arm, guess: Load, folder: Path, urscript: bool) -> Path:
    """A case that is filled in from top to bottom, with a guess of the load."""
    file = evaluating(arm, folder)
    text = file.read_text()
    block = text[text.index("# [[limits") : text.index("# What plans leave free")]
    text = text.replace(block, re.sub(r"^# ", "", block, flags=re.MULTILINE))
    homes = iter(np.degrees(arm.home))
    text = re.sub(r"# home_deg = .*", lambda _: f"home_deg = {float(next(homes))!r}", text)
    box = float(np.degrees(arm.box))
    text = re.sub(r"position_deg = \[-10.0, 10.0\] .*", f"position_deg = [{-box!r}, {box!r}]", text)
    text = re.sub(r"acceleration_rad_s2 = 0.0 .*", "acceleration_rad_s2 = 4.0", text)
    text = re.sub(r"jerk_rad_s3 = 0.0 .*", "jerk_rad_s3 = 60.0", text)
    text = re.sub(r"# force_noise_N = .*", "force_noise_N = 0.3", text)
    text = re.sub(r"# moment_noise_Nm = .*", "moment_noise_Nm = 0.008", text)
    text = text.replace('weights = "per_unit"', 'weights = "stated"').replace("# rate_Hz = 500.0", "rate_Hz = 500.0")
    if urscript:
        text = re.sub(r"# (\[controller.urscript\]|program_name|trigger_output)", r"\1", text)
        text = re.sub(r"(trigger_output) = \d", rf"\1 = {OUTPUT}", text)
    xx, xy, xz, yy, yz, zz = guess.inertia
    text = text.replace("# [nominal]", "[nominal]").replace("# mass_kg = 0.0", f"mass_kg = {guess.mass}")
    centre = [1e3 * v for v in guess.centre]
    text = text.replace("# centre_of_gravity_mm = [0.0, 0.0, 0.0]", f"centre_of_gravity_mm = {centre}")
    text = re.sub(r"# inertia_kg_m2 = \[0.*", f"inertia_kg_m2 = {[xx, xy, xz, yy, yz, zz]}", text)
    file.write_text(text)
    return file
