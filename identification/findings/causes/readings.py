"""Hypotheses about how a recording was read, which no map of its drives makes: clocks, leaps of joints, poses."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from cases.recording_format import TICKS
from cases.schema import Case
from cases.units import Array
from identification.findings.causes.drives import with_joints
from identification.findings.causes.hypothesis import Edit, Family, Hypothesis
from identification.recording import Recording

SHORTEST, LONGEST = 1e-5, 0.2  # [s] between samples of a recorder
HALF_TURN = np.pi
USUAL_CUTOFF = 0.08  # of the samples a second, where a cut-off that fits another clock means nothing


def of_recording(recording: Recording, case: Case) -> Iterator[Hypothesis]:
    """Hypotheses about how a recording was read."""
    if recording.t is not None and len(recording.t) > 1:
        yield from _clocks(recording, case)
    if case.chain is not None and recording.struts is not None:
        yield from _leaps(recording, case)


def _clocks(recording: Recording, case: Case) -> Iterator[Hypothesis]:
    assert recording.t is not None
    step = float(np.median(np.diff(recording.t)))
    now = TICKS[case.recording.clock_unit]
    seen = {now}
    for unit, tick in TICKS.items():
        ratio = tick / now
        if tick in seen or not SHORTEST <= step * ratio <= LONGEST:
            continue
        seen.add(tick)
        words = f"time stamps are in {unit}, not in {case.recording.clock_unit}"
        edit = _with_clock(unit, step * ratio, ratio)
        yield Hypothesis(family=Family.CLOCK, words=words, edit=edit, recorded=_at_pace(ratio))


def _at_pace(ratio: float) -> Callable[[Recording, Case], Recording | None]:
    def changed(recording: Recording, case: Case) -> Recording | None:
        del case
        if recording.t is None:
            return None
        others = tuple(s if s.t is None else replace(s, t=s.t * ratio) for s in recording.others)
        return replace(recording, t=recording.t * ratio, others=others)

    return changed


def _with_clock(unit: str, step: float, ratio: float) -> Edit:
    """Another unit of the stamps, and a cut-off that fits it where that of the case does not."""

    def edit(case: Case) -> Case:
        form = case.recording
        clock = form.clock.model_copy(update={"unit": unit})
        update: dict[str, object] = {"clock": clock}
        cutoff, highest = form.filter_cutoff_Hz, 0.2 / step
        if cutoff is not None and not 0.02 * highest <= cutoff <= highest:
            scaled = cutoff / ratio
            fitting = scaled if 0.1 * highest <= scaled <= highest else USUAL_CUTOFF / step
            update["filter_cutoff_Hz"] = float(f"{min(fitting, 40.0):.2g}")
        return case.model_copy(update={"recording": form.model_copy(update=update)})

    return edit


def _leaps(recording: Recording, case: Case) -> Iterator[Hypothesis]:
    """Joints that turn, whose readings leap by a turn: as if they had no ends."""
    chain, positions = case.chain, recording.struts
    assert chain is not None
    assert positions is not None
    leaping = [
        k
        for k, joint in enumerate(chain.joints)
        if joint.turns and np.any(np.abs(np.diff(positions[:, k])) > HALF_TURN)
    ]
    if not leaping:
        return

    def changed(recording: Recording, case: Case) -> Recording | None:
        del case
        if recording.struts is None:
            return None
        struts: Array = recording.struts.copy()
        struts[:, leaping] = np.unwrap(struts[:, leaping], axis=0)
        return replace(recording, struts=struts)

    def edit(case: Case) -> Case:
        assert case.chain is not None
        joints = list(case.chain.joints)
        for k in leaping:
            joints[k] = joints[k].model_copy(update={"kind": "continuous", "position_deg": None})
        return with_joints(case, joints)

    names = ", ".join(f"{k + 1} ({chain.joints[k].name})" for k in leaping)
    words = f"readings of joint{'s' if len(leaping) > 1 else ''} {names} leap by 360 deg"
    yield Hypothesis(family=Family.CLOCK, words=words, edit=edit, recorded=changed)
