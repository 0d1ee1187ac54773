"""The whole chain on one case: motions planned, programmed, proven, run, identified, and compared with the truth."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.base.errors import HexciteError
from cases.base.folder_kinds import DEMO
from cases.base.options import default_of, documented
from cases.base.output_places import check_folder
from cases.base.units import as_html
from cases.controller import ControllerName
from cases.schema import Case
from hexcite._run import best_controller, run
from hexcite._write import usual_dialect, write
from hexcite.comparison.comparison import Comparison, compare
from hexcite.options import DemoController, DemoSeed, DemoStarts
from identification.identify import identify
from identification.limits.limit import KINETIC, LimitKind
from identification.machines.of_case import machine_of
from identification.model.model import full_model
from identification.recording.recording import Recording
from identification.results.result import Result
from identification.simulate import truth_rows
from identification.texts import efficiency_text
from planner._plan import plan as motion
from planner.controller_limits import steps_of
from planner.families.settings import FamilySettings, Fourier, Manual, PointToPoint
from planner.options import FAMILY_WORDS, PlanOptions
from planner.plans.plan import Plan
from planner.request import Solver, require_seed, require_starts
from planner.retiming import retime
from postprocessors.dialects.dialect import Dialect
from postprocessors.program import Program, dialect


@dataclass(frozen=True, slots=True)
class Tried:
    """One motion from its plan to the truth."""

    plan: Plan
    program: Program  # proven
    recording: Recording
    result: Result
    truth: tuple[dict[str, Any], ...]  # each parameter beside that of the simulated machine, as `truth_rows` has them

    @property
    def worst(self) -> float:
        """Largest error in reported standard deviations."""
        return float(max(abs(row["error"]) / row["std"] for row in self.truth))


@dataclass(frozen=True, slots=True, repr=False)
class Demo:
    """Results of the steps: of moves, and of a manual motion and a Fourier series beside them."""

    moves: Tried
    others: tuple[Tried, ...]
    comparison: Comparison  # of all of them, after their runs
    left_out: tuple[str, ...]  # motions that this machine or its controllers have no place for, and why
    faster: tuple[str, ...]  # what the paths of the others would be, timed for a controller that does not limit jerk

    @property
    def all(self) -> tuple[Tried, ...]:
        """All motions, the moves last."""
        return (*self.others, self.moves)

    @property
    def plan(self) -> Plan:
        """The plan of the moves."""
        return self.moves.plan

    @property
    def program(self) -> Program:
        """Their program, in the machine's usual dialect, proven."""
        return self.moves.program

    @property
    def recording(self) -> Recording:
        """Their recorded run."""
        return self.moves.recording

    @property
    def result(self) -> Result:
        """Their result."""
        return self.moves.result

    @property
    def truth(self) -> tuple[dict[str, Any], ...]:
        """Their parameters beside the truth."""
        return self.moves.truth

    @property
    def worst(self) -> float:
        """Their largest error in reported standard deviations."""
        return self.moves.worst

    def __repr__(self) -> str:
        """The plan, the result, how far it is from the truth, and which motion is preferred."""
        error = f"largest error against the simulated machine: {self.worst:.2g} reported standard deviations"
        return "\n".join([repr(self.plan), repr(self.result), error, *self.comparison.sentences])

    _repr_html_ = as_html


FOURIER = Fourier(order=3)  # of the paper's D9N


@documented()
def demo(
    case: Case,
    folder: Path | str,
    on: DemoController = default_of(DemoController),
    *,
    seed: DemoSeed = default_of(DemoSeed),
    starts: DemoStarts = default_of(DemoStarts),
    overwrite: bool = False,
    progress: Callable[[str], None] = lambda line: None,
) -> Demo:
    """Plan, program, proof, run, identification and comparison, end to end.

    A manual motion (where the case has one), a Fourier series and moves go the same way, and are compared as planned,
    as run, and with the truth.

    >>> demo = hx.demo(hx.load_case("five_axis_table"), "demo")
    >>> demo
    Plan for five_axis_table: moves, 12.00 s, criterion D, model 6
    ...
    mass (m) = 17.39... +- 0.000... kg
    ...
    largest error against the simulated machine: ... reported standard deviations
    ...

    Args:
        case: case with a simulated machine.
        folder: folder to make: plan, program, recording and result of the moves are written there, one after the other,
            those of the other motions in folders of their own.
        OPTIONS
        overwrite: whether to replace an earlier demo that stands there.
        progress: shows a line as each step ends.

    Raises:
        FileProblem: the folder is taken, or cannot be written.
        HexciteError: a step failed.
    """
    place = Path(folder)
    case.need_simulation("the demo")
    require_starts(starts)  # before the first motion, which needs none, is written
    require_seed(seed)
    check_folder(place, DEMO, overwrite=overwrite)
    # All limits are kept unless a real controller is asked for that cannot keep them.
    real = on == ControllerName.LINUXCNC
    language = dialect(ControllerName.LINUXCNC if real else usual_dialect(case))
    best, reason = best_controller(language.name) if steps_of(case, language.name) else (ControllerName.VIRTUAL, "")
    steps = steps_of(case, language.name) > 0.0
    where = "as asked" if on is not None else reason or f"in place of {language.name}"
    way = _Way(case, on or best, where, seed, starts, progress)
    for_paths = language if real else dialect(usual_dialect(case, path=True))
    families: list[tuple[FamilySettings, Dialect]] = [(FOURIER, for_paths)]
    if machine_of(case).of_pose:
        families.insert(0, (Manual(), language))
    others, left_out = [], []
    for family, language_of_family in families:
        try:
            others.append(way.gone(family, language_of_family, place / family.name))
        except HexciteError as error:
            left_out.append(f"{family.name}: {error}")
            progress(f"{family.name}: left out, {error}")
    moves = way.gone(PointToPoint(controller=language.name, without=LimitKind.JERK if steps else None), language, place)
    results = [place / each.plan.family / "result" for each in others]
    faster = tuple(without_jerk(each.plan) for each in others)
    for sentence in faster:
        progress(f"retime: {sentence}")
    comparison = compare([*results, place / "result"], case)
    for sentence in comparison.sentences:
        progress(f"compare: {sentence}")
    return Demo(moves, tuple(others), comparison, tuple(left_out), faster)


def without_jerk(plan: Plan) -> str:
    """What the path of a plan is worth as fast as toppra times it, for a controller that does not limit jerk."""
    before = f"{plan.duration:.3g} s, D-efficiency {plan.of_motion[1].d_efficiency:.3f}"
    words, limited = FAMILY_WORDS[plan.family], plan.case.need_motion("a demo")[1].limits_jerk
    try:
        timed = retime(plan, "toppra", LimitKind.JERK if limited else None)
    except HexciteError as error:
        return f"{words}: not timed by toppra: {error}"
    return (
        f"{words} timed by toppra, for a controller that does not limit jerk: {timed.duration:.3g} s, "
        f"D-efficiency {timed.of_motion[1].d_efficiency:.3f} ({before} with its own time)"
    )


@dataclass(frozen=True, slots=True)
class _Way:
    """How every motion of a demo goes from its plan to the truth."""

    case: Case
    on: str  # controller
    where: str  # why that one
    seed: int
    starts: int
    progress: Callable[[str], None]

    def gone(self, family: FamilySettings, language: Dialect, place: Path) -> Tried:
        """One motion, planned, programmed, proven, run and identified in a folder."""
        case, progress, searched = self.case, self.progress, family.optimised
        settings: PlanOptions = {"starts": self.starts, "seed": self.seed} if searched else {}
        if family is FOURIER:
            settings["solver"] = Solver.ACTIVE_SET  # converges sooner than others from a single start
        motion(case, family, **settings).save(place / "plan", overwrite=True)
        plan = Plan.load(place / "plan", case)
        worth = plan.of_motion[1]
        without = ", without jerk" if plan.without else ""
        progress(
            f"plan: {FAMILY_WORDS[plan.family]} of {plan.duration:.3g} s for {language.name}{without}, D-efficiency "
            f"{worth.d_efficiency:.3f} against the bound ({worth.bound.label}), found in {plan.solve_s:.0f} s"
        )
        file = place / f"excitation{language.suffix}"
        program = write(plan, language.name, accept=KINETIC, file=file)  # no metal moves
        program.save(program.path, overwrite=True)
        progress(f"post: {program.reading.blocks} blocks, {program.proof.duration:.2f} s with approach and return")
        progress(f"check: the text read back, independently of its writer: {program.proof.verdict}")
        recording = run(program, case, self.on, seed=self.seed)
        recording.save(place / "recording", overwrite=True)
        executed = recording.executed
        assert executed.d_efficiency is not None  # it moves
        progress(
            f"run: on {executed.controller} ({self.where}), {executed.executed_s:.3f} s of "
            f"{executed.planned_s:.3f} s planned, {executed.path_error_mm:.3f} mm from the path, D-efficiency "
            f"{efficiency_text(executed.d_efficiency)} as executed"
        )
        result = identify(Recording.load(place / "recording"), case, full_model(case))
        result.save(place / "result", overwrite=True)
        data = result.record
        progress(f"identify: {len(data.parameters)} parameters from {data.samples} samples, s0 {data.s0:.3g} N")
        assert result.estimate is not None
        return Tried(plan, program, recording, result, tuple(truth_rows(case, result.estimate)))
