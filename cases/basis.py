"""What of a case an artefact was computed from: saved in the artefact, compared when the artefact is used again."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.base.errors import CaseError, Code, FileProblem, option
from cases.base.phrases import NOTHING, enumerated, phrase, said
from cases.schema import Case, fingerprint, load_case
from cases.tables import built_in_cases

COMPUTED_FROM = "computed_from"  # key of plan.json, recording.json and result.json
CONTENT = "content"  # key of the fingerprint of all other entries of plan.json and result.json
_MACHINE = ("setup", "gravity_m_s2", "sensor_frame", "machine")
_MOTION = ("setup", "machine", "workspace", "limits", "controller.cycle_ms")
_BOUND = (*_MACHINE, "workspace", "limits", "controller.cycle_ms")
_PLAN = (*_BOUND, "sensors", "nominal", "payloads")
_RESULT = (*_MACHINE, "sensors", "recording", "tolerances", "bounds")
_OF_PLANS = ("sensors.pose_error_N", "sensors.pose_error_length_mm")  # results find them, and do without them
# A plan states the rate that its predictions assume; what is handed to a robot is computed when it is.
_NOT_COMPUTED_WITH = (
    "recording.rate_Hz", "machine.chain.flange", "machine.chain.tcp", "sensor_frame.transducer.flange",
    "sensor_frame.transducer.tcp",
)  # fmt: skip
_SHOWN = 60  # characters of a value


def plan_basis(case: Case, payload: int = 0, poses: bool = False) -> dict[str, Any]:
    """Values behind a plan by dotted key; `payload` weights are mounted on the body, `poses`: it is a plan of poses."""
    keys = (*_PLAN, *(["poses"] if poses else []))
    if case.sensors.force_noise_N is None:  # predictions take that of the simulated machine
        keys = (*keys, "simulation.force_noise_N")
    if case.sensors.range_N is None and not payload:
        keys = tuple(key for key in keys if key != "payloads")
    return values(case, keys)


def recording_basis(case: Case) -> dict[str, Any]:
    """Values behind a recording by dotted key: the machine that was measured."""
    return values(case, _MACHINE)


def result_basis(case: Case) -> dict[str, Any]:
    """Values behind a result by dotted key: machine and its tolerances, sensors, gravity, how the run was read."""
    return {name: value for name, value in values(case, _RESULT).items() if name not in _OF_PLANS}


def study_basis(case: Case) -> dict[str, Any]:
    """Values behind a study by dotted key: of plans, their runs and identifications."""
    rate = {"recording.rate_Hz": case.recording.rate_Hz}  # predictions assume it
    return values(case, (*_PLAN, "recording", "simulation")) | rate


def motion_hash(case: Case) -> str:
    """Fingerprint of what programs are proven against: setup, machine, workspace, limits and the control cycle."""
    return fingerprint(values(case, _MOTION))


def bound_hash(case: Case) -> str:
    """Fingerprint of what a bound of the information depends on."""
    return fingerprint(values(case, _BOUND))


def content_of(data: Mapping[str, Any]) -> str:
    """Fingerprint of the entries of an artefact but itself and the place of its case, which may be moved."""
    return fingerprint({key: value for key, value in data.items() if key not in (CONTENT, "case_file")})


def values(case: Case, keys: Sequence[str]) -> dict[str, Any]:
    """Leaves of the case below some keys; defaults that are stated and sources in words do not count."""
    leaves = dict(_leaves("", case.model_dump(mode="json", exclude_defaults=True)))
    return {
        name: value
        for name, value in leaves.items()
        if any(name == key or name.startswith((f"{key}.", f"{key}[")) for key in keys)
        and not any(name == key or name.startswith(f"{key}.") for key in _NOT_COMPUTED_WITH)
        and not name.endswith(".source")
    }


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(f"{name}.{key}" if name else key, inner)
    elif isinstance(value, list) and any(isinstance(entry, Mapping) for entry in value):
        for k, entry in enumerate(value):
            yield from _leaves(f"{name}[{k + 1}]", entry)
    else:
        yield name, value


def case_of(file: Path, about: Mapping[str, Any], again: str) -> Case:
    """The case that an artefact's file names; `again` says how to make one anew. Raises CaseError or FileProblem."""
    name = about.get("case_file", about.get("case"))
    if not isinstance(name, str) or not name:
        raise FileProblem(
            place=file,
            problem="names no case",
            remedy=f"{again}, or name it with {option('case')}",
            code=Code.MISSING,
        )
    if name not in built_in_cases() and not Path(name).exists():
        raise CaseError(
            file=file,
            key="case_file",
            problem=f"{name}: no such case",
            remedy=f"name the case file with {option('case')}",
            code=Code.UNKNOWN,
        )
    return load_case(name)


def changes_since(about: Mapping[str, Any], now: Mapping[str, Any], case_hash: str) -> list[str]:
    """What the case had when an artefact was computed and has no longer: key, old value, new value."""
    then = about.get(COMPUTED_FROM)
    if not isinstance(then, Mapping):
        unnamed = phrase("something_changed", "something (it says no more than a fingerprint)")
        return [] if about.get("case_hash") == case_hash else [unnamed]
    return [
        phrase(
            "was_is",
            "{name} was {before}, is {now}",
            name=name,
            before=_shown(then.get(name)),
            now=_shown(now.get(name)),
        )
        for name in differing(then, now)
    ]


def differing(then: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Dotted keys of values that count and are not the same.

    How recordings are written does not count where `now` names the columns of another recorder's files: what was read
    from a file of the one stays what it is.
    """
    # Of a list of tables that an artefact does not depend on nothing is saved.
    names = [name for name in dict.fromkeys((*then, *now)) if then.get(name) != now.get(name)]
    one, other = _columns(then), _columns(now)
    if (one or other) and 2 * len(one & other) < max(1, min(len(one), len(other))):
        names = [name for name in names if not name.startswith("recording.") or name.startswith(_OF_THE_RUN)]
    return names


_OF_THE_RUN = ("recording.filter_cutoff_Hz", "recording.drives", "recording.accelerometer")
"""Keys of `[recording]` that say something of the machine or the evaluation, and not how a file is written."""
_COLUMN = re.compile(r"recording(\.files\[\d+\])?\.(columns\..+|trigger\.column)")


def _columns(values_by_key: Mapping[str, Any]) -> set[Any]:
    """Names of columns of files among values of a case."""
    return {value for name, value in values_by_key.items() if _COLUMN.fullmatch(name)}


def require_unchanged(
    file: Path, about: Mapping[str, Any], now: Mapping[str, Any], case: Case, stale: bool, again: str
) -> tuple[str, ...]:
    """What to write into everything that is made of an artefact: what it says itself, and what has changed since.

    `now` are the values of the case today by dotted key; `again` says what makes such an artefact anew. Raises
    FileProblem where the case has changed, and `stale` is not set.
    """
    changes = changes_since(about, now, case.hash)
    earlier = about.get("stale", [])
    if not isinstance(earlier, list) or not all(isinstance(sentence, str) for sentence in earlier):
        raise FileProblem(
            place=file,
            problem=f"stale is {_shown(earlier)}, not a list of sentences",
            remedy=again,
            code=Code.DAMAGED,
        )
    if not changes:
        return tuple(earlier)
    name = about.get("case_file", case.name)
    more = phrase("more_of_them", " ({count} more)", count=len(changes) - 1) if len(changes) > 1 else NOTHING
    if not stale:
        alike = 2 * len(changes) < len(now)  # else it is another machine
        same = case.origin in ("", name)
        differs = (
            phrase("changed_since", "has changed since")
            if same
            else phrase("differs_from", "differs from {origin}", origin=case.origin)
        )
        other = (
            phrase("restore_case", "restore the case")
            if same
            else phrase("name_own_case", "name its own case with {case}", case=option("case"))
        )
        at_own_risk = phrase("at_own_risk", "go on at your own risk with {stale}", stale=option("stale"))
        raise FileProblem(
            place=file,
            problem=phrase(
                "case_changed",
                "case {case} {differs}: {change}{more}",
                case=name,
                differs=differs,
                change=changes[0],
                more=more,
            ),
            remedy=enumerated("comma_or", [said(again), other, *([at_own_risk] if alike else ())]),
            code=Code.STALE,
        )
    return (*earlier, f"stale: {file} is of case {case.name} before {'; '.join(changes)}")


def _shown(value: Any) -> str:
    if value is None:
        return phrase("not_stated", "not stated")
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}.."
