"""What the stated tolerances of a machine do to an estimate: a budget of its deviations.

Drawing, gains, alignment, gravity, encoders and clock are not as the case says, by sizes p_j of known deviations. To
first order the estimate is off by B p, where B = A^+ D, and D is how the forces that the model expects at the recorded
drives change with p: its share of the covariance is B diag(var p) B^T. Least squares do not use what is known of p.
"""

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.phrases import enumerated, phrase
from cases.base.units import DEG, MM, Array
from cases.schema import Case
from cases.tolerances import KINDS, Tolerances, kind_of
from identification.estimation.alternatives import Remainder
from identification.finding import Finding, Kind, note
from identification.findings.left_out import STEP, LeftOut, in_channel, structure_of
from identification.machines.hexapod import Hexapod
from identification.machines.serial_chain import SerialChain
from identification.model.parameters import physical_form
from identification.samples.samples import Fitted
from identification.texts import CAUSE

PPM, PERCENT = 1e-6, 1e-2
ROUNDING = 1e-9  # of a variance: less is what differences of its parts leave
SMALL = 0.1  # of a deviation: a part that adds 0.5 % to it is not said
NOISE, MEMORY, SHOWN = "noise", "noise with memory", "seen in residuals"


class Share(NamedTuple):
    """What one tolerance of a case does to a fit."""

    key: str  # such as joints_mm
    biases: Array  # of the values of the fit by one standard deviation of each of its sizes, shape (v, k)
    residuals: Array  # what the fit leaves of the effects of these sizes on the forces, weighted, shape (n, 6, k)

    @property
    def kind(self) -> str:
        """What it is a tolerance of, such as drawing."""
        return kind_of(self.key)

    @property
    def covariance(self) -> Array:
        """What it adds to the covariance of the values of the fit, shape (v, v)."""
        return np.asarray(self.biases @ self.biases.T)


UNITS = {"mm": MM, "deg": DEG, "percent": PERCENT, "ppm": PPM}


def shares_of(left_out: LeftOut, rest: Remainder, basis: Array, tolerances: Tolerances | None) -> tuple[Share, ...]:
    """What each of the tolerances of a case does to a fit.

    Args:
        left_out: the fit with its motion.
        rest: what the fit leaves.
        basis: what was free in the fit, shape (v, free).
        tolerances: those of the case.
    """
    shares = []
    for key, deviation in () if tolerances is None else tolerances.stated():
        size = deviation * UNITS[key.rpartition("_")[2]]
        residuals, inside = rest.without_fit(rest.root @ left_out.weighted(effects_of(left_out, key)))
        shares.append(Share(key, size * (basis @ (rest.half @ inside)), size * residuals))
    return tuple(shares)


def without_tolerances(rest: Remainder, shares: tuple[Share, ...]) -> Remainder:
    """What a fit leaves, less what of it tolerances explain at their sizes.

    Sizes are those that are likely with the residuals and with what is stated: sum (d_j / deviation_j)^2 + chi^2
    is least. So residuals show nothing again that tolerances have counted, and all that is larger than stated.
    """
    columns = np.concatenate([share.residuals for share in shares], axis=2) if shares else np.zeros((0, 6, 0))
    if not columns.shape[2]:
        return rest
    both = ((0, 1), (0, 1))
    noise = float(np.mean(rest.residuals**2))
    scores = np.tensordot(columns, rest.residuals, both)
    sizes = np.linalg.solve(np.tensordot(columns, columns, both) + noise * np.eye(len(scores)), scores)
    return rest._replace(residuals=rest.residuals - columns @ sizes)


def biases_of(left_out: LeftOut, rest: Remainder, basis: Array, key: str) -> Array:
    """By how much a unit of each size that a tolerance is one of puts the values of a fit off, shape (v, k) [SI].

    Arguments are those of `shares_of`; k is 0 where the machine has none of that kind.
    """
    _, inside = rest.without_fit(rest.root @ left_out.weighted(effects_of(left_out, key)))
    return np.asarray(basis @ (rest.half @ inside))


def effects_of(of: LeftOut, key: str) -> Array:
    """How the forces change with each size that a tolerance is one of, shape (n, 6, k) [SI]; k is 0 where none is."""
    none, read = np.zeros((len(of.t), 6, 0)), of.expected + of.beyond
    effects: Array | None = None
    if key == "joints_mm":
        effects = np.concatenate([none, *_of_joints(of)], axis=2)
    elif key == "bars_mm" and of.bars is not None:
        effects = _of_bars(of, *of.bars)
    elif key.startswith("joint_zeros") and of.by_drives is not None and not of.motion.of_pose:
        effects = of.by_drives[0][:, :, np.array(of.names.turns) == key.endswith("deg")]
    elif key == "links_mm" and of.by_drives is not None and isinstance(of.motion.machine, SerialChain):
        effects = of.by_links(of.motion.machine)
    elif key.startswith("sensor") and of.bars is None:
        effects = of.by_place if key.endswith("mm") else of.by_axes
    elif key == "gain_percent":
        effects = np.concatenate([in_channel(read[:, k], k) for k in range(6)], axis=2)
    elif key == "common_gain_percent":
        effects = read[:, :, None]
    elif key.startswith("gravity"):
        effects = of.by_gravity[1][:, :, 1:] if key.endswith("deg") else of.by_gravity[1][:, :, :1]
    elif key == "encoder_scale_ppm" and of.by_drives is not None:
        effects = of.by_scales
    elif key == "clock_ppm" and of.moves:
        effects = of.by_clock[:, :, None]
    return none if effects is None else effects


def turns_of(of: LeftOut, key: str) -> Array:
    """By how much {P} is turned against where the case has it in {B}, about axes of {B}, by each of those sizes.

    Shape (n, 3, k); k is 0 where a tolerance turns nothing.
    """
    count = len(of.t)
    if key == "sensor_deg" and of.bars is None:
        return of.turn
    drives, machine = of.motion.drives, of.motion.machine
    if drives is None or machine is None or key not in _TURNING or (of.motion.of_pose and key.startswith("joint_z")):
        return np.zeros((count, 3, 0))
    place, still = drives[0], np.zeros_like(drives[0])
    near = of.load.pose if machine.of_pose else None

    def turned(change: Array) -> Array:
        pose = machine.kinematics(place + STEP * change, still, still, near).pose
        after = Rotation.from_euler("xyz", pose[:, 3:])
        return np.asarray((after * Rotation.from_matrix(of.turn).inv()).as_rotvec() / STEP)

    each = np.stack([turned(np.broadcast_to(axis, place.shape)) for axis in np.eye(place.shape[1])], axis=2)
    if key == "encoder_scale_ppm":
        return np.asarray(each * (place - place.mean(axis=0))[:, None])
    if key != "joints_mm":
        return np.asarray(each[:, :, np.array(of.names.turns) == key.endswith("deg")])
    assert isinstance(machine, Hexapod)
    columns = []
    for ring, joint, axis in itertools.product(("base", "platform"), range(6), range(3)):
        rings = {"base": machine.base, "platform": machine.platform}
        ways = np.zeros((6, 3))
        ways[joint, axis] = STEP
        longer = of.strut_motion(**(rings | {ring: rings[ring] + ways}))[0] - of.by_struts[0]
        columns.append(-np.einsum("nik,nk->ni", each, longer / STEP))  # struts of these lengths seem shorter
    return np.stack(columns, axis=2)


_TURNING = frozenset({"joints_mm", "joint_zeros_deg", "joint_zeros_mm", "encoder_scale_ppm"})


def _of_joints(of: LeftOut) -> Iterator[Array]:
    """Of each coordinate of the joints of base and platform: then struts seem to have other lengths."""
    machine = of.motion.machine
    if not isinstance(machine, Hexapod) or of.by_drives is None:
        return
    for ring, joint, axis in itertools.product(("base", "platform"), range(6), range(3)):
        ways = np.zeros((6, 3))
        ways[joint, axis] = 1.0
        yield of.by_joints(machine, ring, ways)


def _of_bars(of: LeftOut, lower: Array, upper: Array) -> Array:
    """Of each coordinate of the ends of the bars."""
    into, columns = of.into_channels[0], []
    for end, joint, axis in np.ndindex(2, 6, 3):
        moved = [lower.copy(), upper.copy()]
        moved[end][joint, axis] += STEP
        change = (structure_of(*moved) - structure_of(lower, upper)) / STEP
        columns.append(-(of.of_load + of.beyond) @ (into @ change).T)
    return np.stack(columns, axis=2)


def budget_findings(before: Fitted, allowed: Fitted, shares: tuple[Share, ...] | None, case: Case) -> list[Finding]:
    """What deviations do not count, and the budget of each parameter where tolerances are stated.

    A budget has standard deviations by their causes, whose squares add up to that of the reported deviation.

    Args:
        before: the fit by its noise alone.
        allowed: the fit with deviations that allow for all that its residuals show, and for tolerances.
        shares: what tolerances add to its covariance; None where they cannot be carried through.
        case: case of the recording.
    """
    if shares is None:
        not_done = phrase(
            "tolerances_not_counted",
            "no tolerance of [tolerances] is counted: that is not done with a prior, nor where no drive says the "
            "motion",
        )
        kinds = list(dict.fromkeys(KINDS[key] for key in case.tolerable))
        return [note(Kind.NOISE, not_done if case.tolerances is not None else "", not_counted=kinds)]
    findings = [note(Kind.NOISE, "", not_counted=case.not_counted)] if case.not_counted else []
    if not shares:
        return findings
    model, parameters = before.samples.model, slice(len(before.samples.model.names))
    form, u = physical_form(model), before.fit.values[parameters]

    def variances(covariance: Array) -> Array:
        return np.diag(form.of(u, covariance[parameters, parameters])[1]).clip(0.0)

    white, robust = variances(before.fit.covariance), variances(before.fit.covariance_robust)
    total = np.maximum(white, variances(allowed.fit.covariance_robust))
    by_kind: dict[str, Array] = {}
    for share in shares:
        by_kind[share.kind] = by_kind.get(share.kind, 0.0) + variances(share.covariance)
    by_tolerances = np.sum(list(by_kind.values()), axis=0)
    memory = np.maximum(robust - white, 0.0)
    by_residuals = np.maximum(variances(allowed.fit.covariance_robust) - robust - by_tolerances, 0.0)
    by_residuals = np.where(by_residuals > ROUNDING * total, by_residuals, 0.0)
    parts = {
        NOISE: np.maximum(total - memory - by_residuals - by_tolerances, 0.0),
        MEMORY: memory,
        SHOWN: by_residuals,
    } | by_kind
    rows = {
        p.name: {kind: float(np.sqrt(variance[k])) for kind, variance in parts.items()}
        for k, p in enumerate(form.parameters)
    }
    first = next(iter(rows))
    largest = sorted(rows[first], key=lambda kind: -rows[first][kind])
    unit = form.parameters[0].unit
    named = [
        phrase("part_of", "{kind} {size}", kind=phrase(CAUSE, "{name}", name=kind), size=f"{rows[first][kind]:.2g}")
        for kind in largest
        if rows[first][kind] > 0.1 * total[0] ** 0.5
    ]
    sentence = phrase(
        "deviation_parts",
        "the deviation of {name} has parts [{unit}]: {parts}",
        name=first,
        unit=unit,
        parts=enumerated("comma", named),
    )
    return [*findings, note(Kind.NOISE, sentence, budget=rows)]
