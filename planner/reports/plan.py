"""The page of a plan: what it promises, the machine along it, how close it comes to each limit, what it tells when."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.files import provenance
from cases.schema import Case
from cases.units import MM, payload_words
from identification.criteria import analyse, reference_scaling
from identification.estimation.fit import PoseField
from identification.limit import Status
from identification.limit_proof import load_shares
from identification.limited_quantities import strut_motion
from identification.model import RIGID, Model, identification_model
from identification.motion import Motion, Trajectory, sample
from identification.overload import SHARE
from identification.parameters import nominal_parameters, physical_form
from identification.symbolic import over_samples
from planner.deviations import Beside, beside_manual
from planner.found import bound_by
from planner.plans import Plan
from planner.precision import legible, parameter_words, std_text
from planner.reports.charts import Chart, plain, thinned
from planner.reports.figures import COLOURS, GREY, identifiability_items, limits_plot, motion_items
from planner.reports.machine import moving_machine
from planner.reports.page import Answers, Item, Note, Page, Plot, Section, Table, Tiles
from planner.search.ipopt import solver_text

Array = NDArray[np.float64]

DRAWN_RATE = 500.0  # [1/s]
INFORMATION_RATE = 100.0  # [1/s] of the figures of information: its mean needs no more


def plan_page(plan: Plan) -> Page:
    """The page of `hexcite plan`."""
    case, (request, worth) = plan.case, plan.of_motion
    model = identification_model(case, request.model)
    motion = sample(plan.motion, DRAWN_RATE)
    settings = {k: v for k, v in worth.settings.items() if not isinstance(v, list | dict)}
    inputs = [
        ("case", f"{case.name} (hash {case.hash})"),
        ("family", plan.family),
        *((k, str(v)) for k, v in settings.items()),
        ("criterion", request.criterion),
        ("model", str(request.model)),
        ("mounted", request.mounted),
        ("targets", ", ".join(request.targets) or "none"),
        ("seed", str(request.seed)),
        *provenance([])["versions"].items(),
    ]
    origin = "made by hand" if not request.family.optimised else f"optimised for criterion {request.criterion}"
    if (method := settings.get("retimed_with")) is not None:
        origin += f", re-timed with {method}"
    return Page(
        title=f"Plan: {case.title}",
        lead=f"A {plan.family} excitation of {plan.motion.duration:.2f} s, {origin}, to identify model {request.model} "
        f"with {request.mounted} mounted; every limit is proven at 10 kHz. It moves from rest {_ends(plan)}.",
        inputs=tuple(inputs),
        warnings=_warnings(plan),
        sections=(
            Section(
                "What the plan promises",
                (
                    _headline(plan),
                    _verdicts(plan),
                    *_deviations(plan, model, beside_manual(plan)),
                    *_notes(plan),
                ),
            ),
            *pictured(case, plan.motion),
            Section("How close it comes to each limit", (limits_plot(plan.limits), _bound_by(plan))),
            Section("The motion and its limits", motion_items(case, motion)),
            *([Section("Struts", _struts(case, motion))] if case.hexapod is not None else []),
            Section("Predicted sensor forces", _forces(case, motion, request.payload)),
            Section("Information of the motion", _information(plan, model)),
            Section("How the plan was found", starts_items(plan.to_json())),
        ),
    )


def _warnings(plan: Plan) -> tuple[str, ...]:
    worth = plan.of_motion[1]
    words = list(worth.weaknesses)
    if worth.search.interrupted:
        words.insert(0, "The search was stopped by Ctrl-C: this is the best of what was found until then.")
    if not worth.bound.certified and plan.case.chain is None:
        words.append(
            "The bound behind the D-efficiency is an estimate, for its proof ran out of time: hexcite bound "
            f"{plan.case.name} --model {plan.model} with a longer --time-limit proves it."
        )
    return tuple(words)


def _notes(plan: Plan) -> tuple[Item, ...]:
    notes = [f"{note[0].upper()}{note[1:]}." for note in plan.of_motion[1].notes]
    if plan.case.chain is not None:
        notes.append(
            "D-efficiency is an estimate here, perhaps too large: the most information that a chain of joints can have "
            "is searched for, not proven."
        )
    return tuple(map(Note, notes))


def _ends(plan: Plan) -> str:
    first, last = map(plan.case.words, plan.motion.at([0.0, plan.motion.duration]).pose)
    return f"at {first} and back there" if first == last else f"at {first} to rest at {last}"


def _headline(plan: Plan) -> Tiles:
    worth = plan.of_motion[1]
    kind = "certified" if worth.bound.certified else "an estimate"
    tiles = [
        (f"{plan.motion.duration:.2f} s", "duration, from rest to rest"),
        (f"{worth.d_efficiency:.3f}", f"D-efficiency against the box bound ({kind})"),
        (f"{worth.condition:.3g}", "condition in reference scaling"),
        (f"{plan.limits.worst_ratio * 100:.1f} %", "most that is used of any limit"),
    ]
    if worth.d_efficiency_tight is not None and worth.tight is not None:
        kind = "certified" if worth.tight.certified else "an estimate"
        tight = (
            f"{worth.d_efficiency_tight:.3f}",
            f"D-efficiency against motions of limited jerk from rest to rest ({kind})",
        )
        tiles.insert(2, tight)
    return Tiles(tuple(tiles))


def _verdicts(plan: Plan) -> Answers:
    """Whether the motion keeps all limits, and whether a controller that limits jerk can follow it."""
    steps = [c.name for c in plan.limits.checks if c.status is Status.STEPS]
    proven = [c for c in plan.limits.checks if c.status is Status.PROVEN]
    most = max(proven, key=lambda c: c.ratio)
    used = f"{len(proven)} limits are proven; most used is {most.name} with {100 * most.ratio:.1f} %"
    jerk = f"accelerations step in {', '.join(steps)}: for controllers without a jerk limit" if steps else "proven too"
    return Answers(
        (
            (all(c.kept for c in proven), "Is the motion inside the limits?", used),
            (not steps, "Is its jerk inside the limits?", jerk),
        )
    )


def _deviations(plan: Plan, model: Model, manual: Beside | str) -> tuple[Item, ...]:
    """Predicted standard deviations, beside those of the hand-made motion at equal time."""
    worth = plan.of_motion[1]
    noise_text = " and noise of the accelerations as the case states it" if worth.shaken else ""
    if (field := PoseField.of(plan.case.sensors)) is not None:
        noise_text += f" and errors of {field.words} that depend on the pose"
    noise, rate = f"{plan.assumed_noise:g} N{noise_text}", plan.case.recording.rate_Hz
    note = f"Predicted for white force noise of {noise} at {rate:g} Hz, weights {worth.weights}."
    columns = ["parameter", "predicted std"]
    other = None
    if plan.of_motion[0].family.optimised:
        if isinstance(manual, Beside):
            other = manual.at_equal_time(plan.motion.duration)
            columns += ["hand-made, equal time" if manual.averaging else "hand-made", "times smaller"]
            note += f" The hand-made motion of the case takes {manual.duration:.2f} s; its deviations are those of " + (
                "as much measuring time as the plan's, repeated or broken off." if manual.averaging else "one run."
            )
        else:
            note += f" {manual[0].upper()}{manual[1:]}."
    rows = []
    for p in physical_form(model).parameters:
        scale, unit = legible(p.unit)
        std = plan.predicted_std[p.name]
        row = [parameter_words(p.name), std_text(std * scale)]
        if other is not None:
            row += [std_text(other[p.name] * scale), f"{other[p.name] / std:.2f}"]
        rows.append((*row, unit))
    return (Table((*columns, "unit"), tuple(rows)), Note(note))


def _bound_by(plan: Plan) -> Note:
    names = bound_by(plan.limits)
    return Note(f"What shapes the motion: {', '.join(names)}." if names else "No limit is used up.")


def _lines(x: Array, values: Array, names: list[str], unit: str, limits: tuple[float, ...], height: int) -> Chart:
    """Six lines over time, with the limits that they share."""
    figure = Chart()
    for k, name in enumerate(names):
        thin_x, thin_y = thinned(x, values[:, k])
        figure.add_scatter(x=thin_x, y=thin_y, name=plain(name), line={"color": COLOURS[k], "width": 1.3})
    for limit in limits:
        figure.add_hline(y=limit, line={"color": GREY, "dash": "dash", "width": 1})
    figure.update_xaxes(title="time [s]")
    figure.update_yaxes(title=unit)
    return figure.update_layout(height=height)


def pictured(case: Case, motion: Trajectory) -> tuple[Section, ...]:
    """The machine along a motion; of a chain there is no picture yet."""
    if case.hexapod is None:
        return ()
    picture = moving_machine(case, motion, "Drag to turn, wheel to zoom.")
    return (Section("The machine along the plan", (picture,)),)


def _struts(case: Case, motion: Motion) -> tuple[Item, ...]:
    machine, workspace, limits = case.need_machine("the page of a plan")
    box = limits.motion
    length, velocity, acceleration = strut_motion(motion, machine)
    low = max(box.strut_length[0], workspace.strut_length[0]) / MM
    high = min(box.strut_length[1], workspace.strut_length[1]) / MM
    v, a = box.strut_velocity_m_s, box.strut_acceleration_m_s2
    names = [f"strut {k}" for k in range(1, 7)]
    panels = (
        ("strut-lengths", length / MM, "length [mm]", (low, high)),
        ("strut-velocities", velocity, "velocity [m/s]", (-v, v)),
        ("strut-accelerations", acceleration, "acceleration [m/s²]", (-a, a)),
    )
    return tuple(
        Plot(
            n,
            _lines(motion.t, values, names, unit, of, 280),
            f"Strut {unit.split(' [')[0]} over time; dashed: its limits.",
        )
        for n, values, unit, of in panels
    )


def _forces(case: Case, motion: Motion, payload: int) -> tuple[Item, ...]:
    """Forces with what is mounted, and how much of the range each number of payloads would use."""
    model = identification_model(case, RIGID)
    matrices = over_samples(model.coordinate_regressor, motion.pose, motion.rates, motion.accelerations)[0]
    forces = matrices @ nominal_parameters(model, case.body(payload))
    of = case.sensors.range_N
    limits = () if of is None or np.abs(forces).max() < SHARE * of / 4 else (-SHARE * of, SHARE * of)
    columns = case.sensor_frame.channels
    unit = f"force [{', '.join(dict.fromkeys(c.rsplit('_', 1)[-1].replace('Nm', 'N m') for c in columns))}]"
    words = f"With {payload_words(payload)}, offsets and compensation apart."
    plot = Plot("sensor-forces", _lines(motion.t, forces, list(columns), unit, limits, 340), words)
    shares = load_shares(motion, case)
    if of is None or not len(shares):
        return (plot, Note("The case names no range of its sensors: nothing limits these forces."))
    rows = tuple((str(k), f"{100 * share:.1f} %") for k, share in enumerate(shares))
    ends = f"{of:g} N" if (moments := case.sensors.range_Nm) is None else f"{of:g} N and {moments:g} N m"
    table = Table(("payloads mounted", f"used of {100 * SHARE:.0f} % of the range of {ends}"), rows, left=0)
    return (plot, table)


def _matrices(plan: Plan, model: Model) -> Array:
    """Scaled regressors along the motion, shape (n, 6, u)."""
    motion = plan.motion.at(_instants(plan.motion))
    matrices = over_samples(model.coordinate_regressor, motion.pose, motion.rates, motion.accelerations)[0]
    return np.asarray(matrices * reference_scaling(plan.case, model))


def _instants(motion: Trajectory) -> Array:
    count = max(200, int(motion.duration * INFORMATION_RATE))
    return (np.arange(count) + 0.5) * motion.duration / count


def _information(plan: Plan, model: Model) -> tuple[Item, ...]:
    """What each parameter costs, its deviation if all others were known and as one of all, and what is determined."""
    matrices = _matrices(plan, model)
    stacked = matrices.reshape(-1, matrices.shape[2])
    information = stacked.T @ stacked / len(matrices)
    alone = 1.0 / np.sqrt(np.diag(information))
    together = np.sqrt(np.diag(np.linalg.inv(information)))
    names = [plain(name) for name in model.names]
    figure = Chart()
    figure.add("bar", x=names, y=together, name="with all others unknown", marker={"color": COLOURS[0]})
    figure.add("bar", x=names, y=alone, name="if all others were known", marker={"color": COLOURS[5]})
    figure.update_xaxes(tickangle=-60)
    figure.update_yaxes(title="std of one sample, scaled")
    words = "In reference scaling, for a noise of 1. The gap is what it costs that the others are unknown too."
    costs = Plot("information", figure.update_layout(height=360, barmode="group"), words)
    return (costs, _progress(plan, matrices), *identifiability_items(analyse(matrices, model.names)))


def _progress(plan: Plan, matrices: Array) -> Plot:
    """How the information grows while the motion runs: the D-criterion of what was gathered so far."""
    per_sample = np.einsum("nki,nkj->nij", matrices, matrices)
    steps = np.unique(np.linspace(len(matrices) // 20, len(matrices) - 1, 60).astype(int))
    gathered = np.cumsum(per_sample, axis=0)[steps]
    sign, logdet = np.linalg.slogdet(gathered)
    whole = logdet[-1]
    share = np.where(sign > 0, np.exp(np.minimum(0.0, (logdet - whole) / matrices.shape[2])), 0.0)
    t = _instants(plan.motion)[steps]
    figure = Chart()
    figure.add_scatter(x=t, y=100 * share, line={"color": COLOURS[0], "width": 2}, name="gathered")
    figure.add_scatter(
        x=[0.0, plan.motion.duration],
        y=[0.0, 100.0],
        line={"color": GREY, "dash": "dash", "width": 1},
        name="at an even pace",
    )
    figure.update_traces(mode="lines")
    figure.update_xaxes(title="time [s]", range=[0.0, plan.motion.duration])
    figure.update_yaxes(title="information gathered [%]", range=[0, 105])
    words = "(det F)^(1/u) of all that was measured until then, as a share of the whole motion's."
    return Plot("progress", figure.update_layout(height=300), words)


def starts_items(plan: dict[str, Any]) -> tuple[Item, ...]:
    """Starts of a search, and the bound that its result is measured by; of the JSON of a plan."""
    bound = plan["bound"]
    words = f"Log det of the mean information in reference scaling; bound {bound['logdet']:.3f} ({bound['method']})."
    if not plan["starts"]:
        source = plan["settings"].get("retimed_from")
        origin = "Made by hand, nothing was searched" if source is None else f"Re-timed from {source}"
        return (Note(f"{origin}. {words}"),)
    columns = ("seed", "how far", "log det at start", "log det at end", "iterations", "time", "solver")
    rows = tuple(
        (str(s["seed"]), "refined" if s["refined"] else "explored", _logdet(s["start_logdet"]),
         f"{s['logdet']:.3f}", str(s["iterations"]),
         f"{s['seconds']:.1f} s", solver_text(s["solver"]))
        for s in plan["starts"]
    )  # fmt: skip
    failed = tuple(Note(f"Start {f['seed']} led nowhere: {f['reason']}.") for f in plan["failed_starts"])
    return (Table(columns, rows, left=2), *failed, Note(words))


def _logdet(value: float | None) -> str:
    return "singular" if value is None else f"{value:.3f}"
