"""Settings of plans come back from plan.json as they were, by the key that each kind has alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.limits.limit import LimitKind
from planner.families.plan_settings import (
    AverageSettings,
    FourierSettings,
    MoveSettings,
    PlanSettings,
    RetimedSettings,
    SequenceSettings,
    SplineSettings,
    settings_of,
)

KINDS = (FourierSettings, MoveSettings, SplineSettings, SequenceSettings, RetimedSettings, AverageSettings)
SETTINGS = st.sampled_from(KINDS).flatmap(st.from_type)


@given(settings=SETTINGS)
def test_settings_come_back_from_their_entries(settings: PlanSettings) -> None:
    assert settings_of(settings.to_json()) == settings


def test_what_is_usual_is_no_entry() -> None:
    assert FourierSettings(order=5, period_s=2.0, repeats=6).to_json() == {"order": 5, "period_s": 2.0, "repeats": 6}
    steps = MoveSettings(moves=8, duration_s=4.0, made_for="linuxcnc", without=LimitKind.JERK)
    assert steps.to_json() == {"moves": 8, "duration_s": 4.0, "made_for": "linuxcnc", "without": "jerk"}


@pytest.mark.parametrize(
    "entries",
    [
        None,
        [],
        {},
        {"made_for": "linuxcnc"},
        {"order": 5},
        {"order": 5, "period_s": "2", "repeats": 6},
        {"moves": 8, "duration_s": 4.0, "without": "velocity"},
        {"moves": 8, "knots": 4, "duration_s": 4.0},
    ],
)
def test_entries_of_no_kind_or_of_two_are_refused(entries: object) -> None:
    with pytest.raises(ValueError, match=r"(?i)settings"):
        settings_of(entries)
