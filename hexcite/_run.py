"""Runs a program on a controller, simulates the sensors for what was really executed, and rates the run."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, HexciteError, ProgramError, choice, option
from cases.base.options import default_of, documented
from cases.base.phrases import phrase
from cases.base.units import MM
from cases.basis import motion_hash
from cases.controller import ControllerName
from cases.schema import Case
from hexcite._write import plan_of_program, read_for, require_ini, require_proven, written_for_another
from hexcite.options import Controller, Disturbed, Ini, NoiseSeed, Weights
from identification.estimation.criteria import executed_information, reference_scaling
from identification.limits.limit import LimitKind
from identification.limits.proof import CHUNK, everything
from identification.machines.executed import Execution, executed_motion, path_error
from identification.machines.of_case import machine_of
from identification.model.model import full_model, identification_model
from identification.motion.motion import Joined, Trajectory
from identification.recording.record import Executed, Payload, RunOrigin, RunRecord
from identification.recording.recording import Recording
from identification.simulate import UNDISTURBED, Circumstances, circumstances, simulate_recording
from identification.stretches import windows
from planner.bounds.bound import Bound, information_limit
from planner.noise import mean_information
from planner.request import require_seed
from postprocessors.controllers.executed_run import ExecutedRun, moving_windows, stood
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing, run_linuxcnc
from postprocessors.controllers.virtual import run_virtual
from postprocessors.program import Program
from postprocessors.proof.guarantees import Guarantees
from postprocessors.proof.homing import motions, planned_excitation

CONTROLLERS = (ControllerName.VIRTUAL, ControllerName.LINUXCNC)
NOTICEABLE = 0.01  # share of a run from which a remark says so
MEASURED = LimitKind.VELOCITY, LimitKind.ACCELERATION, LimitKind.STRUT_VELOCITY, LimitKind.STRUT_ACCELERATION


def best_controller(dialect: str = ControllerName.LINUXCNC) -> tuple[ControllerName, str]:
    """The real controller if it is installed and runs programs of a dialect, else the virtual one, with the reason."""
    if dialect != ControllerName.LINUXCNC:
        return ControllerName.VIRTUAL, "no real controller here runs such programs"
    reason = linuxcnc_missing()
    if reason is not None:
        return ControllerName.VIRTUAL, reason
    return ControllerName.LINUXCNC, "LinuxCNC is installed"


def require_controller(on: str) -> None:
    """Raises HexciteError unless `on` names a controller that can run here."""
    if on not in CONTROLLERS:
        raise HexciteError(problem=f"controller {on!r} is unknown", remedy=choice(on, CONTROLLERS), code=Code.UNKNOWN)
    if on == ControllerName.LINUXCNC and (missing := linuxcnc_missing()) is not None:
        raise HexciteError(problem=missing, code=Code.NOT_INSTALLED)


def execute(
    program: Program, case: Case, on: str, seed: int, around: Circumstances = UNDISTURBED
) -> tuple[ExecutedRun, Recording]:
    """The run of a program, as `carried_out`, and a recording whose measurements are simulated."""
    case.need_simulation("a run")
    run = carried_out(program, case, on)
    planned: Trajectory
    if program.reading.measures_at_poses:
        planned = Joined(tuple(motion for _, motion in motions(program.reading, program.guarantees)))
        poses = program.reading.measured_poses
        seconds, off = stood(run, poses, program.path)
        quality = Quality(seconds, off / MM)
    else:
        poses = np.zeros((0, 0))
        planned = planned_excitation(program.reading, program.guarantees)
        quality = _quality(case, planned, run)
    recording = simulate_recording(case, run.execution, run.trigger, seed, around=around)
    peaks = executed_peaks(run.execution, case)
    other = written_for_another(program.content, case)
    executed = Executed(
        controller=run.controller,
        executed_s=quality.seconds,
        planned_s=planned.duration,
        path_error_mm=quality.path_error_mm,
        d_efficiency=quality.d_efficiency,
        d_efficiency_planned=quality.d_efficiency_planned,
        peaks_of_limit={str(kind): share for kind, share in peaks.items()},
        exceeded=tuple(exceeded(peaks, program.guarantees, run.real)),
        remark="; ".join(text for text in (other and f"the program was {other}", run.remark) if text),
    )
    disturbances = around.disturbances
    record = RunRecord.of_case(
        case,
        origin=_origin(program, case, run, around, seed, quality),
        executed=executed,
        poses_m_rad=tuple(map(tuple, poses.tolist())),
        trigger_windows_s=tuple(map(tuple, run.trigger.tolist())),
        controller_hash=case.controller_hash,
        controller_real=run.real,
        simulated_parts="sensors and encoders; the motion is what the controller executed",
        disturbances=None if disturbances is None else disturbances.model_dump(mode="json"),
        samples=len(recording.forces),
        units="SI with the unit in each column name",
    )
    return run, replace(recording, case=case, record=record)


class Quality(NamedTuple):
    """How a program was executed."""

    seconds: float  # that the excitation took
    path_error_mm: float
    d_efficiency_planned: float | None = None  # of the motion as programmed; None at poses
    d_efficiency: float | None = None  # as executed, behind the filter of the evaluation


def executed_peaks(execution: Execution, case: Case) -> dict[LimitKind, float]:
    """Largest share of each limit of velocities and accelerations over the whole run, at `execution.extremes`.

    There, between two cycles of a controller that interpolates by cubic splines, are the largest accelerations.
    """
    instants = execution.extremes
    worst: dict[LimitKind, float] = {}
    for first in range(0, len(instants), CHUNK):
        for quantity in everything(executed_motion(execution, instants[first : first + CHUNK]), case, False):
            if quantity.of.kind.family in MEASURED:
                worst[quantity.of.kind] = max(worst.get(quantity.of.kind, 0.0), float(quantity.ratio.max()))
    return worst


def exceeded(peaks: Mapping[LimitKind, float], guarantees: Guarantees, real: bool) -> list[str]:
    """Sentences on limits that the executing controller exceeded, the `real` one or one that stands in for it."""
    over = {kind for kind, share in peaks.items() if share > 1.01}
    if not real:  # it keeps these itself, as the case says, and takes longer than the built-in one
        over -= {kind for kind in over if kind.family in guarantees.enforced}
    words = "know what the drives bear before a real machine runs this"
    return (
        [f"EXCEEDED BY THE CONTROLLER, which does not enforce them: {', '.join(sorted(over))}; {words}"] if over else []
    )


def carried_out(program: Program, case: Case, on: str) -> ExecutedRun:
    """Proves a program and runs it.

    Raises:
        HexciteError: unknown controller, a program that is not proven, a run that failed: the reason in one line.
    """
    require_controller(on)
    require_proven(program, case)
    if on == ControllerName.VIRTUAL:
        run = run_virtual(program.reading, replace(program.guarantees, case=case))
    else:
        run = _on_linuxcnc(program, case, program.reading.measures_at_poses)
    if not len(run.trigger):
        raise HexciteError(
            place=program.path,
            problem=phrase(
                "trigger_never_on", "the trigger never came on while {controller} ran it", controller=run.controller
            ),
            remedy=phrase("report_this", "report this"),
            code=Code.RUN_FAILED,
        )
    return run


def _on_linuxcnc(read: Program, case: Case, at_poses: bool) -> ExecutedRun:
    if read.dialect.name != ControllerName.LINUXCNC:
        raise HexciteError(
            place=read.path,
            problem=phrase("not_linuxcnc", "is not a LinuxCNC program ({dialect})", dialect=read.dialect.name),
            remedy=phrase("run_virtual", "run it with {on} virtual", on=option("on")),
            code=Code.WRONG_KIND,
        )
    log = run_linuxcnc(read, case)
    remark = ""
    if log.left_out > NOTICEABLE * len(log.lines):
        remark = f"{log.left_out * log.period:.2f} s of standstill removed, which only this computer's clock caused"
    execution = Execution.of_log(machine_of(case), log.period, log.drives)
    on = windows(log.trigger, log.period)
    measured = on if at_poses else moving_windows(log.trigger, log.drives, log.period)
    return ExecutedRun(log.controller, execution, measured, real=True, remark=remark)


def _quality(case: Case, planned: Trajectory, run: ExecutedRun) -> Quality:
    """How a moving excitation was executed."""
    model = identification_model(case, full_model(case))
    scaling, bound = reference_scaling(case, model), information_limit(case, model)
    cutoff = case.recording.filter_cutoff_Hz
    if cutoff is None:
        case.missing("recording.filter_cutoff_Hz", "the rating of a run")
    after = executed_information(model, scaling, run.execution, run.trigger, cutoff)
    return Quality(
        run.excitation,
        path_error(planned, run.execution, run.trigger) / MM,
        _efficiency(bound, mean_information(model, scaling, planned)),
        _efficiency(bound, after),
    )


def _efficiency(bound: Bound, information: np.ndarray) -> float:
    sign, logdet = np.linalg.slogdet(information)
    return bound.efficiency(float(logdet)) if sign > 0 else 0.0


@documented()
def run(
    program: Program | Path | str,
    case: Case,
    on: Controller = default_of(Controller),
    *,
    seed: NoiseSeed = default_of(NoiseSeed),
    payload: Weights = default_of(Weights),
    disturbed: Disturbed = default_of(Disturbed),
    ini: Ini = default_of(Ini),
) -> Recording:
    """The recording of a program's run: sensors and encoders are simulated for what the controller really executed.

    Its `executed` has the figures of the run, such as `path_error_mm`, `d_efficiency`, `peaks_of_limit`, `exceeded`.

    >>> recording = hx.run("run.mpf", hx.load_case("hexapod"))
    >>> recording.executed.exceeded
    ()

    Args:
        program: program, or its file.
        case: case with a simulated machine.
        OPTIONS

    Raises:
        FileProblem: the INI file contradicts the case; the message names the line.
        HexciteError: unknown controller, a program that is not proven, a run that failed: the reason in one line.
    """
    require_seed(seed)
    require_controller(on)
    around = circumstances(case, payload, disturbed)
    read = program if isinstance(program, Program) else read_for(case, Path(program))
    if motion_hash(read.case) != motion_hash(case):
        raise ProgramError(
            file=read.path,
            problem=phrase(
                "proven_for_other",
                "is proven for case {other}, whose machine or limits are others than those of {case}",
                other=read.case.name,
                case=case.name,
            ),
            remedy=phrase("own_case", "give the program's own case, or write the plan for this one"),
            code=Code.OTHER_SOURCE,
        )
    if ini is not None:
        require_ini(read, case, ini)
    return execute(read, case, on, seed, around)[1]


def _origin(
    program: Program, case: Case, run: ExecutedRun, around: Circumstances, seed: int, quality: Quality
) -> RunOrigin:
    """Program, controller and machine of a run."""
    return RunOrigin(
        simulated=True,
        controller=run.controller,
        program=str(program.path.resolve()),
        program_hash=hashlib.sha256(program.content).hexdigest()[:16],
        plan_hash=plan_of_program(program.content),
        seed=seed,
        payload=Payload(weights=len(around.weights), mass_kg=around.load),
        simulation_source=case.need_simulation("a recording").source,
        path_error_mm=quality.path_error_mm,
    )
