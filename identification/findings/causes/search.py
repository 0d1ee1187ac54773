"""The search for the cause: every hypothesis alone, then two of them at once."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from cases.base.errors import HexciteError
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.findings.causes import channels, drives, geometry, surroundings
from identification.findings.causes.estimated import Sized, refined, settled, sized_of
from identification.findings.causes.explanations import (
    ALIKE,
    CLEAN,
    NEAR,
    Tried,
    explanations,
    families_of,
    is_noise,
    may_be_two,
    may_hide_another,
    most_left,
)
from identification.findings.causes.hypothesis import (
    AS_RECORDED,
    FAMILIES,
    Family,
    Hypothesis,
    Trial,
    case_of,
    mistakes,
    together,
)
from identification.findings.causes.instants import Instants, instants_of
from identification.findings.causes.lateness import late_forces
from identification.findings.causes.leaps import leaps_of
from identification.findings.causes.readings import of_recording
from identification.findings.causes.steps import Following, Step
from identification.findings.causes.trials import closing, moments_about, tried
from identification.model.model import Model
from identification.recording.recording import Recording

SURER = 0.5  # share of `NEAR` up to which two mistakes of which one has a size explain a run
COARSE = 40  # instants by which most trials are left out
COARSE_PAIRS = 24  # the same of two hypotheses at once
KEPT = 60  # trials of each kind that are tried on all instants
PROMISING = 3.0  # times the least residuals on some instants, up to which trials are tried on all
FEWEST = 10  # of them in any case
REFINED = 6  # of those without a size beside one with, that leave least at its first sizes
GREEDY = 4  # hypotheses that leave least, to which every other one is added
READINGS = 4  # of a recording that leave least with any other hypothesis, to which those with a size are added too
RIVALS = 2.0  # times the least residuals, up to which sizes that were not found beside each other are found anew
SETTLING = 4  # times that the sizes of two hypotheses are found anew beside each other, at most
SETTLED = 0.99  # of residuals, above which they are no longer
SIMILAR = 0.1  # by which noise of channels may be changed by what a column of trials does


@dataclass(frozen=True, slots=True)
class Search:
    """What a search found."""

    recorded: Tried | None  # all as recorded; None where nothing can be computed from that
    explanations: tuple[Tried, ...]  # that leave what noise makes, the best first; none where no trial explains the run
    best: Tried | None  # what leaves least of all that was tried
    families: tuple[Family, ...]  # what was tried
    pairs: bool = False  # whether two hypotheses at once were tried too

    @property
    def sound(self) -> bool:
        """Whether the run needs no explanation."""
        return self.recorded is not None and not self.explanations and is_noise(self.recorded)


def search(
    recording: Recording, case: Case, model: Model, fit: Fit | None = None, following: Following | None = None
) -> Search | None:
    """What explains a run, one hypothesis or two; None where nothing can be tried on it.

    Args:
        recording: the run, without the samples that no estimate may use.
        case: the case that it was read with.
        model: model that its forces are compared with.
        fit: the fit to it, where there is one; a run whose residuals are near its noise needs no explanation.
        following: tells where it stands; by default one that begins now.
    """
    following = following or Following()
    if case.setup == "1a":  # nothing moves: offsets explain every run
        return None
    base = _instants(recording, case, model)
    recorded = None if base is None else _alone(base, AS_RECORDED)
    if base is not None and recorded is not None:
        if fit is not None:
            of_fit = float(np.sqrt(np.mean((fit.residuals / base.noise) ** 2)))
            recorded = replace(recorded, residuals=min(of_fit, recorded.residuals))
        if is_noise(recorded):
            return Search(recorded, (), None, ())
    following.at(Step.READINGS)
    readings: list[tuple[Trial, Instants]] = []
    late = None if base is None else late_forces(base, recording, case, hypotheses_of(base).changes)
    for reading in (*of_recording(recording, case), *([] if late is None else [late])):
        instants = _of_reading(reading, recording, case, model)
        if instants is not None:
            readings.append(((reading,), instants))
    if base is None and not readings:
        return None
    families = {reading.family for (reading,), _ in readings}
    worth = PROMISING * most_left(np.inf if recorded is None else recorded.residuals)
    entries = [_alone(instants, trial) for trial, instants in readings]
    if base is not None and recorded is not None:
        following.at(Step.ONE)
        entries += _singles(base, AS_RECORDED, worth)
        entries += _leaps(base, recorded, recording, case, model)
        families |= {hypothesis.family for entry in entries for hypothesis in entry.trial} | _tried_alone(base)
    explained = explanations(entries, recorded)
    pairs = may_hide_another(explained[0]) if explained else may_be_two(entries, recorded)
    if pairs:
        following.at(Step.READ)
        for trial, instants in sorted(readings, key=lambda reading: _promise(reading[1], reading[0]))[:READINGS]:
            entries += _singles(instants, trial, worth)
        if base is not None:
            entries += _pairs(base, entries, worth, following)
        explained = explanations(entries, recorded)
        if explained:
            following.at(Step.SETTLING)
            found = [_settled(entry) for entry in _with_sizes(entries)]
            entries += [*found, *(plain for entry in found for plain in _without_a_size(entry))]
            explained = explanations(entries, recorded, SURER)
    finite = [entry for entry in entries if np.isfinite(entry.residuals)]
    best = min(finite, key=lambda entry: (entry.residuals, mistakes(entry.trial)), default=None)
    return Search(recorded, explained, best, tuple(sorted(families, key=FAMILIES.index)), pairs)


def _with_sizes(found: Sequence[Tried]) -> list[Tried]:
    """Trials of several sizes that leave about as little as the best does, one of each kind, the best first."""
    several = [entry for entry in found if sum(hypothesis.size is not None for hypothesis in entry.trial) > 1]
    several.sort(key=lambda entry: entry.residuals)
    first = {families_of(entry): entry for entry in reversed(several)}
    least = min(entry.residuals for entry in found)
    close = [entry for entry in several if entry is first[families_of(entry)] and entry.residuals < RIVALS * least]
    return close[:GREEDY]


def _settled(entry: Tried) -> Tried:
    """A trial whose sizes are found anew beside each other until that gains no more."""
    instants, coarse = entry.instants, entry.instants.part(COARSE)
    for _ in range(SETTLING):
        before, entry = entry, _alone(instants, settled(instants, coarse, entry.trial))
        if entry.residuals > SETTLED * before.residuals:
            break
    return entry


def _without_a_size(entry: Tried) -> list[Tried]:
    """A trial with what has no size in place of a size of the same kind, where it leaves about as little.

    Two sizes that are found beside each other end near a round value of one of them, such as gravity along an axis.
    """
    instants, tables = entry.instants, hypotheses_of(entry.instants)
    plain = (*tables.changes, *tables.bars, *tables.forces)
    trials = [
        together(*(other for other in entry.trial if other is not sized), hypothesis)
        for sized in entry.trial
        if sized.size is not None
        for hypothesis in plain
        if hypothesis.family is sized.family
    ]
    return [_settled(each) for each in _on_all(instants, trials) if each.residuals < RIVALS * entry.residuals]


def _instants(recording: Recording, case: Case, model: Model) -> Instants | None:
    with suppress(HexciteError):
        return instants_of(recording, case, model)
    return None


def _of_reading(reading: Hypothesis, recording: Recording, case: Case, model: Model) -> Instants | None:
    if reading.recorded is None or (other := reading.recorded(recording, case)) is None:
        return None
    return _instants(other, case_of((reading,), case), model)


def _alone(instants: Instants, trial: Trial) -> Tried:
    outcome = tried(instants, [trial], [AS_RECORDED])
    return Tried(trial, instants, float(outcome.residuals[0, 0]), float(outcome.delays[0, 0]))


def _leaps(instants: Instants, recorded: Tried, recording: Recording, case: Case, model: Model) -> list[Tried]:
    """What leaps within the run, where both parts of it, alone, leave what noise makes."""
    if instants.drives is None and instants.step is not None:  # streams of several clocks are not cut
        return []
    if not np.isfinite(recorded.residuals):
        return []
    leaps = list(leaps_of(instants, recorded.delay, recording, case))
    best = min((leap.residuals for leap, _ in leaps), default=np.inf)
    hypotheses = []
    for leap, hypothesis in leaps:
        if leap.residuals <= ALIKE * best and leap.residuals < NEAR:
            parts = [instants.cut(part) for part in (slice(0, leap.at), slice(leap.at, None))]
            residuals = [_alone(part, AS_RECORDED).residuals for part in parts]
            longer = max(parts, key=lambda part: len(part.rows))
            hypotheses.append(Tried((hypothesis,), longer, max(leap.residuals, *residuals), recorded.delay))
    return hypotheses


class Tables(NamedTuple):
    """Hypotheses without a size, by how they are tried."""

    changes: list[Hypothesis]  # of motion, case or noise
    bars: list[Hypothesis]  # of what the sensors' bars make of the forces
    forces: list[Hypothesis]  # of the recorded forces alone


def hypotheses_of(instants: Instants) -> Tables:
    """All hypotheses without a size about a run."""
    remembered = instants.memory.of_run
    if "tables" not in remembered:
        remembered["tables"] = _tables(instants)
    tables: Tables = remembered["tables"]
    return tables


def _tables(instants: Instants) -> Tables:
    case, every = instants.case, list(channels.of_channels(instants.case))
    every += channels.of_sensor(case)
    if case.chain is not None and instants.drives is not None:
        every += drives.of_joints(case, case.chain)
    if case.hexapod is not None and instants.drives is not None and not instants.posed:
        every += drives.of_struts(case)
        every += geometry.of_machine(case, case.hexapod)
    if instants.turning is None or instants.turning.specific is None:
        every += surroundings.of_surroundings(case)
        every.append(surroundings.of_compensation())
    if case.sensor_frame.has_moments:
        every.append(surroundings.of_axes())
    alone = [_of_forces_alone(hypothesis, instants) for hypothesis in every]
    bars = [] if case.sensor_frame.bars is None else list(geometry.of_bars(case, case.sensor_frame.bars))
    return Tables(
        [h for h, of_forces in zip(every, alone, strict=True) if not of_forces],
        bars,
        [h for h, of_forces in zip(every, alone, strict=True) if of_forces],
    )


def _tried_alone(instants: Instants) -> set[Family]:
    """What the hypotheses without a size are about."""
    return {hypothesis.family for hypotheses in hypotheses_of(instants) for hypothesis in hypotheses}


def _of_forces_alone(hypothesis: Hypothesis, instants: Instants) -> bool:
    """Whether a hypothesis changes forces alone, and leaves the noise of each channel as it is."""
    if hypothesis.channels is None or hypothesis.drives is not None or hypothesis.in_base:
        return False
    noise = np.sqrt(hypothesis.channels**2 @ instants.noise**2)
    return bool(np.all(np.abs(noise / instants.noise - 1.0) < SIMILAR))


def _singles(instants: Instants, prefix: Trial, worth: float) -> list[Tried]:
    """Every hypothesis beside some that are taken for granted, with its size where it has one."""
    tables, coarse = hypotheses_of(instants), instants.part(COARSE)
    rows = [together(*prefix, hypothesis) for hypothesis in (*tables.changes, *tables.bars)]
    best = _best(coarse, closing(coarse, [prefix, *rows]), [AS_RECORDED], worth)
    best += _best(coarse, [prefix], [(hypothesis,) for hypothesis in tables.forces], worth)
    return _on_all(instants, [*best, *_sized(instants, coarse, prefix, worth)])


def _promise(instants: Instants, prefix: Trial) -> float:
    """What some hypotheses leave at some instants with the best of all others that have no size, or alone."""
    tables, coarse = hypotheses_of(instants), instants.part(COARSE)
    rows = [together(*prefix, hypothesis) for hypothesis in (*tables.changes, *tables.bars)]
    residuals = tried(coarse, closing(coarse, [prefix, *rows]), [AS_RECORDED]).residuals
    forces = tried(coarse, [prefix], [(hypothesis,) for hypothesis in tables.forces]).residuals
    return float(min(residuals.min(initial=np.inf), forces.min(initial=np.inf)))


def _sized(instants: Instants, coarse: Instants, prefix: Trial, worth: float) -> list[Trial]:
    """The hypotheses with a size beside others of other families."""
    families_of_prefix = {hypothesis.family for hypothesis in prefix}
    families = [sized for sized in sized_of(coarse, prefix) if sized.family not in families_of_prefix]
    return refined(instants, coarse, families, prefix, worth)


def _pairs(instants: Instants, singles: Sequence[Tried], worth: float, following: Following) -> list[Tried]:
    """Two hypotheses at once: the product of the elementary ones, and each size with those that leave least alone."""
    following.at(Step.TWO)
    tables, coarse = hypotheses_of(instants), instants.part(COARSE_PAIRS)
    rows = [hypothesis for hypothesis in tables.changes if not hypothesis.single]
    columns = [hypothesis for hypothesis in (*tables.bars, *tables.forces) if not hypothesis.single]
    closed = closing(coarse, [(row,) for row in rows])
    best = _best(coarse, closed, [(column,) for column in columns], worth)
    pairs = [together(*pair) for pair in combinations(rows, 2) if _compatible(*pair)]
    best += _best(coarse, closing(coarse, pairs), [AS_RECORDED], worth)
    both = [together(*pair) for pair in combinations(columns, 2) if _compatible(*pair)]
    best += _best(coarse, [AS_RECORDED], both, worth)
    in_base = [hypothesis for hypothesis in rows if hypothesis.in_base]  # in whose axes channels are exchanged
    best += _best(coarse, [together(row, column) for row in in_base for column in columns], [AS_RECORDED], worth)
    on_all = _on_all(instants, best)
    if min((entry.residuals for entry in on_all), default=np.inf) <= CLEAN:
        return on_all
    following.at(Step.SIZES)
    on_all += _on_all(instants, _beside_sizes(instants, coarse, closed, columns, worth))
    if min((entry.residuals for entry in on_all), default=np.inf) <= CLEAN:
        return on_all
    following.at(Step.SEVERAL)
    on_all += _on_all(instants, _beside_several(coarse, closed, tables, worth))
    if min((entry.residuals for entry in on_all), default=np.inf) <= CLEAN:
        return on_all
    of_instants = [entry for entry in singles if entry.instants is instants]
    for entry in sorted(of_instants, key=lambda entry: entry.residuals)[:GREEDY]:
        on_all += _on_all(instants, _sized(instants, coarse, entry.trial, worth))
    return on_all


def _beside_sizes(
    instants: Instants, coarse: Instants, rows: Sequence[Trial], columns: Sequence[Hypothesis], worth: float
) -> list[Trial]:
    """Hypotheses without a size beside those with one, whose first sizes leave least together with them."""
    sized = [each for each in sized_of(coarse, AS_RECORDED) if each.family is not Family.POINT]
    first = [
        (each, start, hypothesis)
        for each in sized
        for start in each.starts
        if (hypothesis := each.make(np.array(start)))
    ]
    of_forces = [entry for entry in first if entry[0].of_channels]
    of_motion = [entry for entry in first if not entry[0].of_channels]
    candidates: list[tuple[float, Sized, tuple[float, ...], Trial]] = []

    def note(residuals: Array, entries: Sequence[tuple[Sized, tuple[float, ...], Hypothesis]], *of: Trial) -> None:
        """Residuals, shape (entries, others)."""
        for k, j in np.argwhere(residuals <= np.sort(residuals, axis=None)[: 4 * REFINED][-1]):
            if np.isfinite(residuals[k, j]) and _compatible(entries[k][2], *of[j]):
                candidates.append((float(residuals[k, j]), *entries[k][:2], of[j]))

    forces = [(column,) for column in columns]
    if of_forces and rows:
        note(tried(coarse, rows, [(hypothesis,) for *_, hypothesis in of_forces]).residuals.T, of_forces, *rows)
    if of_motion and forces:
        note(tried(coarse, [(hypothesis,) for *_, hypothesis in of_motion], forces).residuals, of_motion, *forces)
    if of_forces and forces:
        pairs = [together(hypothesis, column) for *_, hypothesis in of_forces for column in columns]
        note(tried(coarse, [AS_RECORDED], pairs).residuals.reshape(len(of_forces), -1), of_forces, *forces)
    trials: list[Trial] = []
    for _, each, start, others in sorted(candidates, key=lambda entry: entry[0])[:REFINED]:
        trials += refined(instants, coarse, [replace(each, starts=(start,))], others, worth)
    if not coarse.case.sensor_frame.has_moments:
        return trials
    plain = [*rows, *forces]
    abouts = moments_about(coarse, plain)
    for k in sorted(range(len(plain)), key=lambda k: abouts[k].residuals)[:REFINED]:
        others = plain[k]
        of_point = [each for each in sized_of(coarse, others) if each.family is Family.POINT]
        trials += refined(instants, coarse, of_point, others, worth)
    return trials


def _beside_several(instants: Instants, rows: Sequence[Trial], tables: Tables, worth: float) -> list[Trial]:
    """What exchanges or turns several channels at once, beside one hypothesis without a size."""
    several = [hypothesis for hypothesis in tables.forces if hypothesis.single]
    plain = [hypothesis for hypothesis in (*tables.bars, *tables.forces) if not hypothesis.single]
    both = [together(*pair) for pair in product(plain, several) if _compatible(*pair)]
    trials = _best(instants, rows, [(hypothesis,) for hypothesis in several], worth)
    return [*trials, *_best(instants, [AS_RECORDED], both, worth)]


def _compatible(*hypotheses: Hypothesis) -> bool:
    """Whether hypotheses do not speak of the same thing."""
    for one, other in combinations(hypotheses, 2):
        if one.family is not other.family or one.family in (Family.MACHINE, Family.BARS):
            continue
        if one.family in (Family.CHANNELS, Family.OFFSETS) and not _orders(one, other):
            continue
        if one.family is Family.UNITS and (one.channels is None) != (other.channels is None):
            continue
        return False
    return True


def _orders(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two hypotheses are both about order, or both about signs, or offsets of one joint."""
    if one.channels is not None and other.channels is not None:
        return _is_diagonal(one.channels) == _is_diagonal(other.channels)
    assert one.drives is not None
    assert other.drives is not None
    return bool(np.any((one.drives.offset != 0.0) & (other.drives.offset != 0.0)))


def _is_diagonal(matrix: Array) -> bool:
    return not np.any(matrix - np.diag(np.diagonal(matrix)))


def _best(instants: Instants, rows: Sequence[Trial], columns: Sequence[Trial], worth: float) -> list[Trial]:
    """The trials of a product that leave least, among them those that leave less than is worth while."""
    if not rows or not columns:
        return []
    residuals = tried(instants, rows, columns).residuals
    order = np.argsort(residuals, axis=None)[:KEPT]
    places = [divmod(int(k), len(columns)) for k in order]
    most = min(worth, PROMISING * residuals[places[0]])
    some = [place for k, place in enumerate(places) if k < FEWEST or residuals[place] <= most]
    return [together(*rows[i], *columns[j]) for i, j in some if np.isfinite(residuals[i, j])]


def _on_all(instants: Instants, trials: Sequence[Trial]) -> list[Tried]:
    """Trials on all instants."""
    trials = [trial for trial in trials if trial]
    if not trials:
        return []
    outcome = tried(instants, trials, [AS_RECORDED])
    return [
        Tried(trial, instants, float(residuals), float(delay))
        for trial, residuals, delay in zip(trials, outcome.residuals[:, 0], outcome.delays[:, 0], strict=True)
    ]
