"""Distances of convex bodies: coal's, and those that anybody can work out."""

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from cases.base.convex import COVERED, MOST_CORNERS, corners_around, least_separation, separation, sharp_edges
from tests.helpers import examples

BOX = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3)])


def geometry(points: np.ndarray) -> coal.CollisionGeometry:
    model, faces = coal.BVHModelOBBRSS(), points[ConvexHull(points).simplices]
    model.beginModel(len(faces), 3 * len(faces))
    for face in faces:
        model.addTriangle(*face)
    model.endModel()
    model.buildConvexHull(True, "Qt")
    return model.convex


def by_coal(one: np.ndarray, other: np.ndarray) -> float:
    """Distance of two hulls; minus the depth where they overlap."""
    place = coal.Transform3s()
    return float(
        coal.distance(geometry(one), place, geometry(other), place, coal.DistanceRequest(), coal.DistanceResult())
    )


@settings(max_examples=examples(150), deadline=None)
@given(st.integers(0, 10**6), st.integers(4, 40), st.integers(4, 40), st.floats(0.02, 1.0))
def test_coal_measures_the_same(seed: int, first: int, second: int, flat: float) -> None:
    """Lower bounds: never above; where bodies overlap they are at most minus the depth."""
    draw = np.random.default_rng(seed)
    one, other = (draw.normal(size=(count, 3)) * [0.2, 0.2 * flat, 0.1] for count in (first, second))
    other = other + draw.normal(size=3) * 0.5
    found, measured = float(separation(one[None], other[None])[0]), by_coal(one, other)
    if measured > 1e-6:
        assert found == pytest.approx(measured, abs=1e-6)
    else:
        assert found <= measured + 1e-6


@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 10**6))
def test_it_does_not_matter_where_and_in_which_order(seed: int) -> None:
    draw = np.random.default_rng(seed)
    one, other = draw.normal(size=(9, 3)), draw.normal(size=(7, 3)) + np.array([9.0, 1.0, 0.0])
    turn, way = Rotation.random(random_state=seed).as_matrix(), draw.normal(size=3)
    apart = separation(one[None], other[None])
    np.testing.assert_allclose(separation(other[None], one[None]), apart, atol=1e-9)
    np.testing.assert_allclose(separation(one[None] @ turn.T + way, other[None] @ turn.T + way), apart, atol=1e-9)


@pytest.mark.parametrize(
    ("other", "distance"),
    [
        (BOX + np.array([0.5, 0.0, 0.0]), 0.3),  # faces that are parallel
        (BOX + np.array([0.5, 0.1, 0.05]), 0.3),
        (BOX + np.array([0.5, 0.8, 0.0]), 0.5),  # edges: 0.3 and 0.4
        (np.tile([[0.1, 0.2, 0.7]], (4, 1)), 0.4),  # a point, four times
        (np.array([[0.3, -9.0, 0.0], [0.3, 9.0, 0.0]]), 0.2),  # a line
        (np.array([[-9.0, -9.0, 0.5], [9.0, -9.0, 0.5], [0.0, 9.0, 0.5]]), 0.2),  # a triangle
        (BOX + np.array([0.2, 0.0, 0.0]), 0.0),  # it touches
    ],
)
def test_distances_that_anybody_can_work_out(other: np.ndarray, distance: float) -> None:
    assert separation(BOX[None], other[None])[0] == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize("way", [0.0, 0.05, 0.19])
def test_bodies_that_overlap_have_no_distance(way: float) -> None:
    """Boxes of 0.2 m that are `way` apart along x overlap by the rest there."""
    assert separation(BOX[None], BOX[None] + [way, 0.0, 0.0])[0] == pytest.approx(way - 0.2, abs=1e-9)


def test_the_instant_where_bodies_are_closest_is_found_exactly() -> None:
    draw, times = np.random.default_rng(2), np.linspace(0.0, 2.0, 3000)
    turns = Rotation.from_rotvec(np.outer(times, [0.5, 1.0, -2.0])).as_matrix()
    one = np.tile(draw.normal(size=(20, 3)), (len(times), 1, 1))
    way = np.outer(1.5 + np.cos(times), [3.0, 2.0, 0.0])
    other = draw.normal(size=(15, 3)) @ turns.transpose(0, 2, 1) + way[:, None]
    every = separation(one, other)
    assert every.min() > 0.0
    known = every - draw.uniform(0.0, 1.0, len(times))
    found = least_separation(one, other, known)
    assert found.min() == pytest.approx(every.min(), abs=1e-9)
    assert np.all(found <= every + 1e-9)
    assert np.all(found >= known)
    enough = every.min() + 0.3
    rough = least_separation(one, other, known, enough)
    assert rough.min() == pytest.approx(every.min(), abs=1e-9)
    assert np.all(rough <= every + 1e-9)
    assert least_separation(one, other, every, every.min()) is every  # nothing is nearer than what will do


@settings(max_examples=examples(25), deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 400), st.sampled_from([1.0, 0.1, 0.0]))
def test_few_corners_cover_all_points(seed: int, count: int, flat: float) -> None:
    points = np.random.default_rng(seed).normal(size=(count, 3)) * [0.2, 0.1, 0.1 * flat]
    corners, radius = corners_around(points)
    assert len(corners) <= MOST_CORNERS
    hull = np.broadcast_to(corners, (count, *corners.shape))
    assert separation(points[:, None], hull).max() <= radius + 1e-9
    assert radius < 0.1


def test_a_box_is_covered_by_its_corners() -> None:
    inner = np.random.default_rng(0).uniform(-1.0, 1.0, (500, 3)) * [0.1, 0.2, 0.3]
    corners, radius = corners_around(np.vstack([inner, BOX]))
    assert radius <= COVERED
    assert len(corners) == 8
    assert len(sharp_edges(BOX)) == 12
