"""The pages of a plan: of a motion, its limits and what it determines; of poses, where they are."""

from typing import Any

import numpy as np
from markupsafe import Markup

from cases.errors import HexciteError
from cases.files import provenance
from identification.criteria import analyse, reference_scaling
from identification.limit import Status
from identification.model import Model, identification_model
from identification.motion import sample
from identification.parameters import physical_form
from planner.families.manual import manual_motion, sequence_file
from planner.noise import mean_information, standing_model
from planner.plan_figures import bound_by, worst_std
from planner.plans import Plan
from planner.pose_criteria import pose_regressors
from planner.poses.planned_poses import candidates_of
from planner.poses.space import places
from planner.precision import SolverStatus, legible, parameter_words, std_text
from planner.reports.figures import identifiability_blocks, limits_chart, motion_blocks
from planner.reports.machine import force_blocks, information_blocks, pictured, posing_machine, strut_charts
from planner.reports.page import COLOURS, GREY, Chart, answers, note, page, section, table, tiles
from planner.request import PoseRequest

DRAWN_RATE = 500.0  # [1/s]


def plan_page(plan: Plan) -> str:
    """The page of `hexcite plan`."""
    case, (request, _) = plan.case, plan.of_motion
    model = identification_model(case, request.model)
    motion = sample(plan.motion, DRAWN_RATE)
    settings = {k: v for k, v in plan.settings.items() if not isinstance(v, list | dict)}
    inputs = [
        ("case", f"{case.name} (hash {case.hash})"),
        ("family", plan.family),
        *((k, str(v)) for k, v in settings.items()),
        ("criterion", request.criterion),
        ("model", str(request.model)),
        ("mounted", request.mounted),
        ("seed", str(request.seed)),
        *provenance([])["versions"].items(),
    ]
    names = bound_by(plan.limits)
    shaped = f"What shapes the motion: {', '.join(names)}." if names else "No limit is used up."
    origin = "made by hand" if not request.family.optimised else f"optimised for criterion {request.criterion}"
    if (method := settings.get("retimed_with")) is not None:
        origin += f", re-timed with {method}"
    notes = [f"{text[0].upper()}{text[1:]}." for text in plan.of_motion[1].notes]
    if case.chain is not None:
        notes.append(
            "D-efficiency is an estimate here, perhaps too large: the most information that a chain of joints can have "
            "is searched for, not proven."
        )
    first, last = map(case.words, plan.motion.at([0.0, plan.motion.duration]).pose)
    ends = f"at {first} and back there" if first == last else f"at {first} to rest at {last}"
    return page(
        f"Plan: {case.title}",
        f"A {plan.family} excitation of {plan.motion.duration:.2f} s, {origin}, to identify model {request.model} "
        f"with {request.mounted} mounted; every limit is proven at 10 kHz. It moves from rest {ends}.",
        inputs,
        _warnings(plan),
        section(
            "What the plan promises", _headline(plan), _verdicts(plan), *_deviations(plan, model), *map(note, notes)
        ),
        *pictured(case, plan.motion),
        section("How close it comes to each limit", limits_chart(plan.limits), note(shaped)),
        section("The motion and its limits", *motion_blocks(case, motion)),
        *([section("Struts", *strut_charts(case, motion))] if case.hexapod is not None else []),
        section("Predicted sensor forces", *force_blocks(case, motion, request.payload)),
        section("Information of the motion", *information_blocks(plan.case, plan.motion, model)),
        section("How the plan was found", *starts_blocks(plan.to_json())),
    )


def _warnings(plan: Plan) -> tuple[str, ...]:
    worth = plan.of_motion[1]
    words = list(worth.weaknesses)
    if plan.interrupted:
        words.insert(0, "The search was stopped by Ctrl-C: this is the best of what was found until then.")
    if not worth.bound.certified and plan.case.chain is None:
        words.append(
            "The bound behind the D-efficiency is an estimate, for its proof ran out of time: hexcite bound "
            f"{plan.case.name} --model {plan.model} with a longer --time-limit proves it."
        )
    return tuple(words)


def _headline(plan: Plan) -> Markup:
    worth = plan.of_motion[1]
    figures = [
        (f"{plan.motion.duration:.2f} s", "duration, from rest to rest"),
        (f"{worth.d_efficiency:.3f}", f"D-efficiency against the box bound ({worth.bound.label})"),
        (f"{worth.condition:.3g}", "condition in reference scaling"),
        (f"{plan.limits.worst_ratio * 100:.1f} %", "most that is used of any limit"),
    ]
    return tiles(*figures)


def _verdicts(plan: Plan) -> Markup:
    """Whether the motion satisfies all limits, and whether a controller that limits jerk can follow it."""
    steps = [c.name for c in plan.limits.checks if c.status is Status.STEPS]
    proven = [c for c in plan.limits.checks if c.status is Status.PROVEN]
    most = max(proven, key=lambda c: c.ratio)
    used = f"{len(proven)} limits are proven; most used is {most.name} with {100 * most.ratio:.1f} %"
    jerk = f"accelerations step in {', '.join(steps)}: for controllers without a jerk limit" if steps else "proven too"
    return answers(
        (all(c.kept for c in proven), "Is the motion inside the limits?", used),
        (not steps, "Is its jerk inside the limits?", jerk),
    )


def beside_manual(plan: Plan) -> tuple[dict[str, float], float, bool] | str:
    """The hand-made motion of the plan's case with the plan's model, noise and payload; or why there is none.

    Returns:
        Predicted standard deviation of each physical parameter [SI], for as much measuring time as the plan's where
        errors average out, else of one run; its duration [s]; whether they average out.
    """
    try:
        case = plan.case
        model = identification_model(case, plan.model)
        motion = manual_motion(case, sequence_file(case))
        scaling = reference_scaling(case, model)
        information = mean_information(model, scaling, motion)
        if np.linalg.matrix_rank(information) < len(scaling):
            return "the hand-made motion of this case does not determine all parameters of the model"
        worst = worst_std(case, model, scaling, motion, plan.payloads)
        averaging = case.sensors.pose_error_N is None
        times = float(np.sqrt(motion.duration / plan.duration)) if averaging else 1.0
        return {name: std * times for name, (std, _) in worst.items()}, motion.duration, averaging
    except HexciteError as error:
        return f"there is no hand-made motion to compare with: {error.typed}"


def assumed_words(plan: Plan) -> str:
    """What predicted standard deviations assume: noise, rate, payloads and weights."""
    request, worth = plan.of_motion
    words = f"{plan.assumed_noise:g} N white force noise"
    if worth.noise_of_accelerations:
        words += " and noise of the accelerations as the case states it"
    if (field := plan.case.sensors.pose_field) is not None:
        words += f", {field.words} that depend on the pose"
    most = "the largest with " if len(plan.payloads) > 1 else ""
    return f"{words}, {plan.assumed_rate:g} Hz, {most}{request.mounted}, weights {worth.weights}"


def _deviations(plan: Plan, model: Model) -> tuple[Markup, ...]:
    """Predicted standard deviations, beside those of the hand-made motion at equal time."""
    words = f"Predicted for {assumed_words(plan)}."
    columns = ["parameter", "predicted std"]
    other = None
    if plan.of_motion[0].family.optimised:
        manual = beside_manual(plan)
        if isinstance(manual, str):
            words += f" {manual[0].upper()}{manual[1:]}."
        else:
            other, seconds, averaging = manual
            columns += ["hand-made, equal time" if averaging else "hand-made", "times smaller"]
            words += f" The hand-made motion of the case takes {seconds:.2f} s; its deviations are those of " + (
                "as much measuring time as the plan's, repeated or broken off." if averaging else "one run."
            )
    rows = []
    for p in physical_form(model).parameters:
        scale, unit = legible(p.unit)
        std = plan.predicted_std[p.name]
        row = [parameter_words(p.name), std_text(std * scale)]
        if other is not None:
            row += [std_text(other[p.name] * scale), f"{other[p.name] / std:.2f}"]
        rows.append((*row, unit))
    return (table((*columns, "unit"), rows), note(words))


def starts_blocks(plan: dict[str, Any]) -> tuple[Markup, ...]:
    """Starts of a search, and the bound that its result is measured by; of the JSON of a plan."""
    bound = plan["bound"]
    words = f"Log det of the mean information in reference scaling; bound {bound['logdet']:.3f} ({bound['method']})."
    if not plan["starts"]:
        source = plan["settings"].get("retimed_from")
        origin = "Made by hand, nothing was searched" if source is None else f"Re-timed from {source}"
        return (note(f"{origin}. {words}"),)
    columns = ("seed", "how far", "log det at start", "log det at end", "iterations", "time", "solver")
    rows = []
    for s in plan["starts"]:
        begin = "singular" if s["start_logdet"] is None else f"{s['start_logdet']:.3f}"
        end = (f"{s['logdet']:.3f}", str(s["iterations"]), f"{s['seconds']:.1f} s", SolverStatus(s["solver"]).words)
        rows.append((str(s["seed"]), "refined" if s["refined"] else "explored", begin, *end))
    failed = (note(f"Start {f['seed']} led nowhere: {f['reason']}.") for f in plan["failed_starts"])
    return (table(columns, rows, left=2), *failed, note(words))


def poses_page(plan: Plan) -> str:
    """The page of `hexcite poses`."""
    model = standing_model(plan.case, plan.model)
    found = analyse(pose_regressors(model, plan.poses), model.names)
    about = plan.to_json()
    case, settings = plan.case, about["settings"]
    figures = (
        (str(about["count"]), f"poses of {about['candidates']} candidates"),
        (f"{about['duration_s']:.1f} s", f"measuring time, of it {about['travel_s']:.1f} s of travel"),
        (f"{about['efficiency']:.3f}", "D-efficiency of the best design over the candidates (lower bound)"),
        (f"{about['condition']:.3g}", "condition in reference scaling"),
    )
    words = (
        f"chosen by {about['method']}, criterion {about['criterion']}, for model {about['model']}: {about['remark']}."
    )
    deviations = table(("parameter", "predicted std", "unit"), plan.deviation_rows())
    noise = f"Predicted for averaged forces that scatter by {plan.assumed_noise:.3g} N"
    pictures = []  # of a chain there are none yet
    if case.chain is None:
        picture = posing_machine(case, plan.poses, "In the order of visit.")
        pictures.append(section("The machine in each pose", picture))
    inputs = [("case", f"{case.name} (hash {case.hash})"), *((k, str(v)) for k, v in settings.items())]
    noise_words = note(f"{noise}, independently from pose to pose.")
    return page(
        f"Poses: {case.title}",
        f"{about['count']} poses {words}",
        (*inputs, *provenance([])["versions"].items()),
        (),
        section("What the set promises", tiles(*figures), deviations, noise_words),
        *pictures,
        section("Where the poses are", _places(plan)),
        section("What the poses determine", *identifiability_blocks(found)),
    )


def _places(plan: Plan) -> Chart:
    assert isinstance(plan.request, PoseRequest)
    figure = Chart("places", "Seen from above; several orientations share a place.", "x [mm]", "y [mm]", height=460)
    for poses, name, size, colour in (
        (candidates_of(plan.request, plan.case, plan.poses)[0], "candidates", 5, GREY),
        (plan.poses, "chosen", 10, COLOURS[1]),
    ):
        at = places(plan.case, poses)
        marker = {"size": size, "color": colour}
        figure.add("scatter", x=at[:, 0] * 1e3, y=at[:, 1] * 1e3, mode="markers", name=name, marker=marker)
    figure.axes({"constrain": "domain"}, {"constrain": "domain", "scaleanchor": "x"})
    return figure
