"""A program may take days; its proof takes the instants that its moves need, not those that its duration holds."""

import pytest

from cases.schema import Case
from identification.motion.motion import Motion
from tests.postprocessors.programs import HEAD, proof, timed, typed

MOST = 1_000_000  # instants; some seconds


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stops a computation that asks for too many instants."""
    instants, check = 0, Motion.__post_init__

    def counting(self: Motion) -> None:
        nonlocal instants
        instants += len(self.t)
        assert instants <= MOST, "the number of instants follows the duration"
        check(self)

    monkeypatch.setattr(Motion, "__post_init__", counting)


@pytest.mark.usefixtures("counted")
@pytest.mark.parametrize(
    ("body", "seconds"),
    [
        ("G1 X5 F0.003", 100_000),
        ("G4 P100000", 100_000),
        (timed([f"G1 X{0.02 * k:.2f} F240" for k in range(1, 4_005)]), 1001),
    ],
)
def test_a_day_at_the_slowest_feed_is_proven_like_a_second(body: str, seconds: float, hexapod_case: Case):
    assert proof(typed(body), hexapod_case).duration == pytest.approx(seconds, rel=1e-5)


@pytest.mark.usefixtures("counted")
def test_a_pose_out_of_this_world_is_refused_at_once(hexapod_case: Case):
    result = proof(typed("G1 X900000 F1", head=HEAD), hexapod_case)
    assert result.violations[0].name.startswith(("workspace", "strut length", "singularity"))
