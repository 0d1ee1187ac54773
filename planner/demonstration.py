"""The whole chain on one case: plan, program, proof, run and identification, beside the simulated machine's truth."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.files import DEMO, check_folder
from cases.schema import Case
from cases.units import as_html
from identification.identify import identify
from identification.model import full_model
from identification.motion import Joined
from identification.outcome import Result
from identification.recording import Recording
from identification.simulate import truth_rows
from planner.execution import best_controller, execute
from planner.families.settings import PointToPoint
from planner.library import planned
from planner.plan_program import usual_dialect, write
from planner.plans import Plan
from planner.request import Request
from postprocessors.dialects import Program, dialect
from postprocessors.execute import ExecutedRun

ACCEPTED = ("jerk", "strut velocity", "strut acceleration", "sensor force")  # no metal moves in a demo
OF_PATHS = ("acceleration", *ACCEPTED)


Done = Callable[[Plan | Program | Recording | Result], None]
"""Function that is called with the value that a step made."""


def accepted(plan: Plan) -> tuple[str, ...]:
    """Limits that the demo answers for where the controller does not enforce them."""
    return ACCEPTED if isinstance(plan.motion, Joined) else OF_PATHS


@dataclass(frozen=True, slots=True, repr=False)
class Demo:
    """Results of the steps."""

    plan: Plan
    program: Program  # program for LinuxCNC, or as a table of set points, proven
    run: ExecutedRun
    result: Result
    truth: tuple[dict[str, Any], ...]  # each parameter beside that of the simulated machine, as `truth_rows` has them

    @property
    def worst(self) -> float:
        """Largest error in reported standard deviations."""
        return float(max(abs(row["error"]) / row["std"] for row in self.truth))

    def __repr__(self) -> str:
        """The plan, the result, and how far it is from the truth."""
        error = f"largest error against the simulated machine: {self.worst:.2g} reported standard deviations"
        return "\n".join([repr(self.plan), repr(self.result), error])

    _repr_html_ = as_html


def demo(
    case: Case,
    folder: Path | str,
    on: str | None = None,
    *,
    seed: int = 0,
    starts: int | None = 1,
    done: Done = lambda value: None,
) -> Demo:
    """Plans, programs, proves, executes and identifies, end to end.

    Args:
        case: case with a simulated machine.
        folder: folder to make: plan, program, recording and result are written there, one after the other.
        on: controller: virtual or linuxcnc; by default LinuxCNC if it is installed and the program is for it.
        seed: seed of the starts and of the sensors' noise.
        starts: number of random starts; one is enough for a demo.
        done: called with the value of each step: plan, program, recording, result.

    Raises:
        HexciteError: a step failed.
    """
    place = Path(folder)
    case.need_simulation("the demo")
    check_folder(place, DEMO, overwrite=True)
    language = dialect(usual_dialect(case))
    controller = on or best_controller(language.name)[0]
    family = PointToPoint(controller=language.name)
    request = Request(family, model=full_model(case), starts=starts, seed=seed, may_be_smooth=True)
    planned(request, case).save(place / "plan", overwrite=True)
    plan = Plan.load(place / "plan", case)
    done(plan)
    file = place / f"excitation{language.suffix}"
    write(plan, language.name, accept=accepted(plan), file=file).save(file, overwrite=True)
    program = Program.load(file, case)
    program.proof.require()
    done(program)
    run, recording = execute(program, case, controller, seed)
    recording.save(place / "recording", overwrite=True)
    done(recording)
    result = identify(Recording.load(place / "recording"), case, full_model(case))
    result.save(place / "result", overwrite=True)
    done(result)
    assert result.estimate is not None
    return Demo(plan, program, run, result, tuple(truth_rows(case, result.estimate)))
