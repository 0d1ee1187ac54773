"""The whole chain on one case: plan, program, proof, run and identification, beside the simulated machine's truth."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.controller import ControllerName
from cases.files import DEMO, check_folder
from cases.schema import Case
from cases.units import as_html
from identification.identify import identify
from identification.limit import KINETIC, LimitKind
from identification.model import full_model
from identification.outcome import Result
from identification.precision import efficiency_text
from identification.recording import Recording
from identification.simulate import truth_rows
from planner.execution import best_controller, run
from planner.families.ptp import steps_of
from planner.families.settings import PointToPoint
from planner.library import plan as motion
from planner.plan_program import usual_dialect, write
from planner.plans import Plan
from postprocessors.dialects import Program, dialect


@dataclass(frozen=True, slots=True, repr=False)
class Demo:
    """Results of the steps."""

    plan: Plan
    program: Program  # in the machine's usual dialect, proven
    recording: Recording
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
    starts: int = 1,
    progress: Callable[[str], None] = lambda line: None,
) -> Demo:
    """Plan, program, proof, run and identification, end to end.

    Args:
        case: case with a simulated machine.
        folder: folder to make: plan, program, recording and result are written there, one after the other.
        on: controller: virtual, or linuxcnc, for which moves are planned without jerk; by default virtual, with the
            first program of the case that keeps all limits.
        seed: seed of the starts and of the sensors' noise.
        starts: number of random starts; one is enough for a demo.
        progress: shows a line as each step ends.

    Raises:
        HexciteError: a step failed.
    """
    place = Path(folder)
    case.need_simulation("the demo")
    check_folder(place, DEMO, overwrite=True)
    # All limits are kept unless a real controller is asked for that cannot keep them.
    language = dialect(ControllerName.LINUXCNC if on == ControllerName.LINUXCNC else usual_dialect(case))
    best, reason = best_controller(language.name) if steps_of(case, language.name) else (ControllerName.VIRTUAL, "")
    steps = steps_of(case, language.name) > 0.0
    family = PointToPoint(controller=language.name, without=LimitKind.JERK if steps else None)
    motion(case, family, starts=starts, seed=seed).save(place / "plan", overwrite=True)
    plan = Plan.load(place / "plan", case)
    worth = plan.of_motion[1]
    progress(
        f"plan: {plan.family} of {plan.duration:.3g} s for {language.name}{', without jerk' if steps else ''}, "
        f"D-efficiency {worth.d_efficiency:.3f} against the bound ({worth.bound.label}), found in {plan.solve_s:.0f} s"
    )
    program = write(plan, language.name, accept=KINETIC, file=place / f"excitation{language.suffix}")  # no metal moves
    program.save(program.path, overwrite=True)
    progress(f"post: {program.reading.blocks} blocks, {program.proof.duration:.2f} s with approach and return")
    progress(f"check: the text read back, independently of its writer: {program.proof.verdict}")
    recording = run(program, case, on or best, seed=seed)
    recording.save(place / "recording", overwrite=True)
    record = recording.record
    where = "as asked" if on is not None else reason or f"in place of {program.proof.controller}"
    progress(
        f"run: on {record['controller']} ({where}), {record['executed_s']:.3f} s of "
        f"{record['planned_s']:.3f} s planned, {record['path_error_mm']:.3f} mm from the path, D-efficiency "
        f"{efficiency_text(record['d_efficiency'])} as executed"
    )
    result = identify(Recording.load(place / "recording"), case, full_model(case))
    result.save(place / "result", overwrite=True)
    data = result.record
    progress(f"identify: {len(data.parameters)} parameters from {data.samples} samples, s0 {data.s0:.3g} N")
    assert result.estimate is not None
    return Demo(plan, program, recording, result, tuple(truth_rows(case, result.estimate)))
