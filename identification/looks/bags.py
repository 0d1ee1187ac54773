"""The look at a bag of ROS: topics, rates, frames, channels, and which of them are read."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cases.base.phrases import phrase
from cases.schema import Case
from identification.looks.look import Column, Look
from identification.looks.trial import sentences_of, trial_of
from identification.recording.formats.names.families import words_of
from identification.recording.formats.names.meaning import meaning_of
from identification.recording.formats.proposal import CUTOFF_HZ, LAYOUT, stated_of
from identification.recording.formats.reasons import NO_REASON, Why, because
from identification.recording.formats.ros.bags import Topic
from identification.recording.formats.ros.frames import is_stated, problem_of
from identification.recording.formats.ros.topics import BagTopic, bag_topics
from identification.recording.formats.table import listed

_MEANT: dict[Topic, str] = {"joints": "positions of the joints", "wrench": "readings of the force/torque sensor"}


def look_at_bags(bags: Sequence[Path], case: Case | None) -> Look:
    """The look at bags of one run: topics, rates, frames, channels, and which of them are read."""
    topics = bag_topics(bags)
    settings: dict[str, Any] = {"filter_cutoff_Hz": CUTOFF_HZ}
    settings |= {} if case is None else {k: v for k, v in stated_of(case.recording).items() if k not in LAYOUT}
    doubts: list[str] = []
    ros = dict(settings.pop("ros", {}))
    chosen: dict[Topic, BagTopic] = {}
    for what, channels_of_kind in _MEANT.items():
        possible = [topic for topic in topics if topic.what == what and topic.messages]
        named = next((topic for topic in possible if topic.name == ros.get(what)), None)
        if what in ros and named is None:
            doubts.append(f"recording.ros.{what} of the case is {ros.pop(what)}, which the bag does not have")
        best = named or min(possible, key=lambda topic: _rank_of_topic(topic, ros.get("frame")), default=None)
        if best is None:
            doubts.append(f"no topic of {channels_of_kind}; record one")
            continue
        chosen[what] = best
        if len(possible) > 1 and named is None:
            ros[what] = best.name
            doubts.append(
                f"several topics of {channels_of_kind}: {listed([t.name for t in possible])}; {best.name} is proposed"
            )
        if not best.stamped and "time" not in ros:
            ros["time"] = "receipt"
            doubts.append(f"{best.name}: its headers have no stamps of use; the bag's own times, of receipt, are taken")
    if ros:
        settings["ros"] = ros
    if "wrench" in chosen:
        doubts += _about_frames(chosen["wrench"], ros.get("frame"))
    settings.pop("columns", None)
    if case is None:
        doubts.append(phrase("name_the_robot", "name the robot, for the order of its joints"))
    elif case.chain is not None and "joints" in chosen:
        joints = dict(zip(case.chain.columns, case.chain.names, strict=True)) | case.recording.columns
        names = chosen["joints"].channels
        has_all_joints = {*case.chain.names} <= {
            *names
        }  # then columns of the case are those of another file, if there are any
        if has_all_joints or all(joints[ours] in names for ours in case.chain.columns):
            settings |= {"columns": case.recording.columns} if case.recording.columns else {}
        else:
            places = meaning_of(names, case).places
            renamed = {ours: names[places[ours]] for ours in case.chain.columns if ours in places}
            settings |= {"columns": renamed} if renamed else {}
    columns = tuple(c for topic in chosen.values() for c in _channels(topic, case, settings))
    trial = trial_of(bags, settings, case)
    odd = sentences_of(trial.problem, [*doubts, *trial.doubts])
    unchanged = case is not None and trial.form == case.recording
    rows = sum(topic.messages for topic in chosen.values())
    repairs = tuple(each for each in trial.repairs if each not in odd)
    return Look(bags[0], rows, columns, settings, odd, trial.problem, unchanged, topics, repairs=repairs)


def _rank_of_topic(topic: BagTopic, frame: str | None) -> tuple[bool, bool, bool, str]:
    """Order in which topics are chosen: those of the stated frame, and of names that say neither filtered nor
    compensated.
    """
    from identification.recording.formats.names import vocabulary as say

    words = words_of(topic.name)
    elsewhere = frame is not None and not all(is_stated(own, frame) for own in topic.frames)
    plain = say.FILTERED.among(words) or not say.RAW.among(words)
    return elsewhere, say.NOT_OF_A_SENSOR.among(words), plain, topic.name


def _about_frames(topic: BagTopic, stated: str | None) -> Iterator[str]:
    """Sentences on the frames of a wrench, where the case states one or does not."""
    for frame in topic.frames:
        if problem := problem_of(frame, stated):
            yield f"{topic.name}: {'; '.join(problem)}"
    if len(topic.frames) > 1:
        yield f"{topic.name}: its messages are in several frames, {listed(topic.frames)}"


def _channels(topic: BagTopic, case: Case | None, settings: Mapping[str, Any]) -> Iterator[Column]:
    """The channels of a topic as columns."""
    from cases.recording_format import WRENCH
    from identification.recording.formats.ros.bags import AXES

    assert topic.values is not None
    assert topic.t is not None
    ours: dict[str, str] = dict(zip(AXES, WRENCH, strict=True))
    if topic.what == "joints":
        chain = None if case is None else case.chain
        names = {} if chain is None else dict(zip(chain.columns, chain.names, strict=True))
        is_complete = {*names.values()} <= {*topic.channels}
        ours = {
            theirs: column for column, theirs in (names if is_complete else names | settings.get("columns", {})).items()
        }
    reason = because(Why.JOINTS_OF if topic.what == "joints" else Why.WRENCH_OF, topic=topic.name)
    for name, values in zip(topic.channels, topic.values.T, strict=True):
        unit = "rad" if topic.what == "joints" else "N" if name.startswith("force") else "Nm"
        if topic.what == "joints" and ours.get(name, "").endswith("_mm"):
            unit = "m"
        present = np.isfinite(values)
        why, why_unit = (reason, because(Why.MESSAGES)) if name in ours else (NO_REASON, NO_REASON)
        yield Column(name, ours.get(name), unit, False, values[present], topic.t[present], why, why_unit)
