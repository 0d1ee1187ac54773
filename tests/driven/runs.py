"""Arms that are driven by programs that hexcite wrote, and what was identified from their recordings."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import hexcite as hx
from tests.driven import controllers, recorders
from tests.driven.arms import ARMS, LOADS, Arm, Load
from tests.driven.cases_of_arms import OUTPUT, evaluating, planning
from tests.driven.plant import Course, Drives, drive

GUESS = Load(1.5, (0.0, 0.0, 0.07), (0.006, 0.0, 0.0, 0.006, 0.0, 0.003))


@dataclass(frozen=True)
class Driven:
    """An arm that ran a program of its own, and a case that can identify its load and no more."""

    arm: Arm
    load: Load
    folder: Path
    course: Course
    run: controllers.Run  # what its controller made of the program

    @property
    def kinds(self) -> tuple[str, ...]:
        """Recorders that the arm has."""
        return ("bag", "csv", "rtde") if self.run.switched else ("bag", "csv")

    def again(self, seed: int) -> "Driven":
        """The arm of another day, which runs the same program with other drives and other friction."""
        drives = Drives.drawn(len(self.arm.joints), seed)
        return replace(self, course=drive(self.arm, self.load, self.run.at, self.run.duration + 0.5, drives))

    @property
    def truth(self) -> dict[str, float]:
        """The load, and the sensor's offsets, by the names of the parameters [SI]."""
        xx, xy, xz, yy, yz, zz = self.load.inertia
        x, y, z = self.load.centre
        body = {"m": self.load.mass, "xC": x, "yC": y, "zC": z}
        body |= {"IC11": xx, "IC12": xy, "IC13": xz, "IC22": yy, "IC23": yz, "IC33": zz}
        return body | {f"f_q0_{k}": float(v) for k, v in enumerate(recorders.OFFSETS, 1)}

    def case_of(self, kind: str, recording: Path) -> hx.Case:
        """The case that reads such recordings, completed by `look` where the file does not say all itself."""
        file = self.folder / kind / f"{self.arm.name}.toml"
        if not file.is_file():
            evaluating(self.arm, file.parent).rename(file)
            if kind == "rtde":  # what look asks for: which of the outputs it is, no file says
                text = file.read_text()
                file.write_text(text.replace("[recording]\n", f"[recording]\ntrigger = {{ bit = {OUTPUT} }}\n", 1))
            if kind != "bag":
                hx.look(recording, hx.load_case(str(file))).write(file)
        return hx.load_case(str(file))

    def recorded(self, kind: str, seed: int) -> Path:
        """What a recorder stores of the course."""
        file = self.folder / f"{kind}_{seed}"
        if kind == "bag":
            return recorders.bag(file, self.course, seed, self.arm.names)
        if kind == "csv":
            return recorders.table(file.with_suffix(".csv"), self.course, seed)
        return recorders.rtde(file.with_suffix(".txt"), self.course, seed, self.run.switched, OUTPUT)

    def identified(self, kind: str, seed: int) -> hx.Result:
        """What is identified from it, from the URDF and the recording alone."""
        recording = self.recorded(kind, seed)
        case = self.case_of(kind, recording)
        return hx.identify(hx.Recording.load(recording, case), case)

    def deviations(self, result: hx.Result) -> dict[str, float]:
        """Errors of the parameters, as multiples of their reported deviations."""
        return {n: (result[n].value - v) / result[n].reported for n, v in self.truth.items()}


def written(name: str, folder: Path) -> str:
    """The program of an arm that is planned for, from a guess of its load."""
    urscript = len(ARMS[name].joints) == 6
    case = hx.load_case(str(planning(ARMS[name], GUESS, folder / "planning", urscript)))
    motion = hx.PointToPoint(moves=14, **({"controller": "urscript", "without": "jerk"} if urscript else {}))
    plan = hx.plan(case, motion, 10.0, starts=1, workers=1)
    return hx.write(plan, "urscript" if urscript else "ros2").text


def driven_by(text: str, name: str, folder: Path) -> Driven:
    """An arm whose program is read by another interpreter and followed by its drives."""
    arm, load = ARMS[name], LOADS[name]
    standing = np.array(arm.home)
    if len(arm.joints) == 6:
        run = controllers.urscript(text, standing, OUTPUT)
    else:
        run = controllers.joint_trajectory(text, arm.names, standing)
    return Driven(arm, load, folder, drive(arm, load, run.at, run.duration + 0.5), run)


def driven(name: str, folder: Path) -> Driven:
    """An arm that is planned for and runs what was written."""
    return driven_by(written(name, folder), name, folder)
