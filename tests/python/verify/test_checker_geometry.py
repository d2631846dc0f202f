"""The checker's geometry against other programs and against exact arithmetic."""

from __future__ import annotations

import ipctk
import numpy as np
import pytest

from stark.verify.boxes import BoxTree, group_table, overlapping_pairs
from stark.verify.distances import Kind, closest, lower_bound
from stark.verify.paths import blocked_pairs
from stark.verify.predicates import orientation_signs, segments_meet_triangles

RNG = np.random.default_rng(7)


def _stencils(count: int) -> np.ndarray:
    """Four points, many of them flat, parallel, on a lattice, or with coinciding points."""
    x = RNG.normal(size=(count, 4, 3))
    x[count // 2 :] = np.round(2.0 * x[count // 2 :]) / 2.0
    x[count // 4 : count // 2, :, 2] = x[count // 4 : count // 2, :1, 2]
    return x


@pytest.mark.parametrize("count", [0, 1, 2, 7, 300])
def test_overlapping_boxes_are_those_of_all_pairs(count: int) -> None:
    low = RNG.random((count, 3))
    low[: count // 2] = np.round(8.0 * low[: count // 2]) / 8.0  # many touch
    high = low + np.where(RNG.random((count, 1)) < 0.05, 0.8, 0.125)
    group = RNG.integers(0, 4, count)
    allowed = RNG.random((4, 4)) < 0.6
    allowed |= allowed.T
    tree = BoxTree(low, high, group, 4)
    touch = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2) & allowed[group][:, group]
    expected = {(i, j) for i, j in np.argwhere(touch) if i < j}
    pairs = list(zip(*overlapping_pairs(tree, tree, group_table(allowed)), strict=True))
    assert {tuple(sorted(pair)) for pair in pairs} == expected
    assert len(pairs) == len(expected)
    half = count // 3
    other = BoxTree(low[:half], high[:half], group[:half], 4)
    found = set(zip(*overlapping_pairs(tree, other, group_table(allowed)), strict=True))
    assert found == {(i, j) for i, j in np.argwhere(touch[:, :half])} | {
        (i, i) for i in range(half) if allowed[group[i], group[i]]
    }


@pytest.mark.parametrize("kind", list(Kind))
def test_distances_are_those_of_another_program(kind: Kind) -> None:
    x = _stencils(2000)
    other = ipctk.point_triangle_distance if kind == Kind.POINT_TRIANGLE else ipctk.edge_edge_distance
    distance, direction = closest(kind, x)
    bound = lower_bound(kind, x, direction)
    for k, points in enumerate(x):
        corners = points[1:] if kind == Kind.POINT_TRIANGLE else points[:2]
        sides = corners - np.roll(corners, 1, axis=0)
        if min(np.linalg.norm(np.cross(sides[0], sides[-1])), np.linalg.norm(points[2] - points[3])) < 1e-9:
            continue  # the other program wants proper primitives
        if kind == Kind.EDGE_EDGE and np.linalg.norm(points[0] - points[1]) < 1e-9:
            continue
        assert distance[k] == pytest.approx(np.sqrt(other(*points)), rel=1e-9, abs=1e-12)
        assert bound[k] <= distance[k] + 1e-15
        assert bound[k] == pytest.approx(distance[k], rel=1e-6, abs=1e-12)
    # A wrong direction only makes the bound smaller.
    turned = np.roll(direction, 1, axis=0)
    assert (lower_bound(kind, x, turned) <= distance * (1.0 + 1e-14) + 1e-15).all()


def test_orientations_are_certain_or_zero() -> None:
    points = _stencils(3000)
    signs = orientation_signs(*points.transpose(1, 0, 2))
    exact = np.sign(np.linalg.det(points[:, :3] - points[:, 3:]))
    sure = np.abs(np.linalg.det(points[:, :3] - points[:, 3:])) > 1e-9
    assert (signs[sure] == exact[sure]).all()
    flat = points.copy()
    flat[..., 2] = 0.1
    assert (orientation_signs(*flat.transpose(1, 0, 2)) == 0).all()


def test_segments_meet_triangles_as_in_another_program() -> None:
    x = RNG.normal(size=(4000, 5, 3))
    meets = segments_meet_triangles(*x.transpose(1, 0, 2))
    assert 0.02 < meets.mean() < 0.5
    for points, found in zip(x, meets, strict=True):
        assert bool(ipctk.is_edge_intersecting_triangle(*points)) == found


@pytest.mark.parametrize(
    ("segment", "meets"),
    [
        (((0.25, 0.25, -1.0), (0.25, 0.25, 1.0)), True),
        (((0.25, 0.25, 0.0), (0.25, 0.25, 1.0)), True),  # an end in the triangle
        (((0.25, 0.25, 5e-324), (0.25, 0.25, 1.0)), False),  # the smallest double above it
        (((0.5, 0.5, -1.0), (0.5, 0.5, 1.0)), True),  # through an edge
        (((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), True),  # through a corner
        (((0.5, 0.5 + 2.0**-52, -1.0), (0.5, 0.5 + 2.0**-52, 1.0)), False),  # just outside of an edge
        (((-1.0, 0.25, 0.0), (2.0, 0.25, 0.0)), True),  # in the plane, across
        (((0.2, 0.2, 0.0), (0.3, 0.3, 0.0)), True),  # in the plane, inside
        (((-1.0, 1.5, 0.0), (2.0, 1.5, 0.0)), False),  # in the plane, beside
        (((1.0, 0.0, 0.0), (2.0, 0.0, 0.0)), True),  # on the line of an edge, end on a corner
        (((1.0 + 2.0**-52, 0.0, 0.0), (2.0, 0.0, 0.0)), False),
    ],
)
def test_touching_counts_exactly(segment: tuple[tuple[float, ...], ...], meets: bool) -> None:
    corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
    for order in ([0, 1, 2], [1, 2, 0], [2, 1, 0]):
        points = [np.array([p]) for p in (*segment, *corners[order])]
        assert segments_meet_triangles(*points)[0] == meets
        points[0], points[1] = points[1], points[0]
        assert segments_meet_triangles(*points)[0] == meets


def test_a_triangle_without_area_is_a_segment() -> None:
    corners = [np.array([p]) for p in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0))]
    across = np.array([[0.5, -1.0, 0.0]]), np.array([[0.5, 1.0, 0.0]])
    beside = np.array([[1.5, -1.0, 0.0]]), np.array([[1.5, 1.0, 0.0]])
    assert segments_meet_triangles(*across, *corners)[0]
    assert not segments_meet_triangles(*beside, *corners)[0]


@pytest.mark.parametrize("kind", list(Kind))
def test_clear_paths_are_clear_in_another_program(kind: Kind) -> None:
    """Nothing is called clear in which tight inclusion finds an impact, and little is left undecided."""
    random = np.random.default_rng(7)  # its own: the same cases whatever has run before
    x0 = random.normal(size=(3000, 4, 3))
    x1 = x0 + 0.7 * random.normal(size=x0.shape)
    blocked, times = blocked_pairs(kind, x0, x1)
    ccd = ipctk.TightInclusionCCD()
    search = ccd.point_triangle_ccd if kind == Kind.POINT_TRIANGLE else ccd.edge_edge_ccd
    is_blocked = np.zeros(len(x0), dtype=bool)
    is_blocked[blocked] = True
    undecided = 0
    for k in range(len(x0)):
        hits, impact = search(*x0[k], *x1[k])
        assert is_blocked[k] or not hits
        undecided += bool(is_blocked[k] and not hits)
        if is_blocked[k] and hits:
            # Tight inclusion stops up to a fifth of the distance before the impact.
            assert times[np.searchsorted(blocked, k)] == pytest.approx(impact, rel=0.3, abs=1e-3)
    assert 100 < len(blocked) < 1500
    assert undecided <= 3


def test_sliding_along_a_surface_is_clear() -> None:
    """A gap of a nanometre over a path of a metre."""
    triangle = [(-9.0, -9.0, 0.0), (9.0, -9.0, 0.0), (0.0, 9.0, 0.0)]
    start = np.array([[(0.0, 0.0, 1e-9), *triangle]])
    end = np.array([[(1.0, 0.3, 1e-9), *triangle]])
    assert not len(blocked_pairs(Kind.POINT_TRIANGLE, start, end)[0])
    end[0, 0, 2] = -1e-9
    assert len(blocked_pairs(Kind.POINT_TRIANGLE, start, end)[0])


def test_parallel_edges_are_as_far_apart_as_their_lines() -> None:
    """Diagonals of neighbours in a grid, as a step left them: their common normal is 3e-36 of rounding, in
    their plane."""
    x = np.array(
        [
            [-0.012183093438250856, -0.012335108110861106, -0.011550866713934932],
            [3.4892264837958676e-05, -0.00011712240777228952, -0.01155086671393493],
            [3.489226483795802e-05, -0.012335108110861104, -0.01155086671393493],
            [0.012252877967926776, -0.00011712240777228779, -0.011550866713934928],
        ]
    )
    distance, direction = closest(Kind.EDGE_EDGE, x[None])
    assert distance[0] == pytest.approx(np.sqrt(0.5) * (x[2, 0] - x[0, 0]), rel=1e-9)
    assert lower_bound(Kind.EDGE_EDGE, x[None], direction)[0] == pytest.approx(distance[0], rel=1e-9)
