"""Continuous detection against Tight Inclusion, safe steps, intersections."""

from __future__ import annotations

import numpy as np
import pytest

from stark import InvalidMesh
from stark import _core as core

ipctk = pytest.importorskip("ipctk")


def random_motions(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Stencils of size one, motions of 1e-2 to 10, a third of them with a large common part."""
    x0 = rng.uniform(-1, 1, (n, 4, 3))
    motion = rng.uniform(-1, 1, (n, 4, 3)) * 10.0 ** rng.uniform(-2, 1, (n, 1, 1))
    motion[::3] += rng.uniform(-5, 5, (len(motion[::3]), 1, 3))
    return x0, x0 + motion


def tight_inclusion(
    kind: str, x0: np.ndarray, x1: np.ndarray, separation: float, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Whether and when Tight Inclusion sees an impact; its separation is that of boxes, sqrt(3) larger."""
    ccd = ipctk.TightInclusionCCD(tolerance, 10_000_000, conservative_rescaling=1.0)
    results = [getattr(ccd, kind + "_ccd")(*a, *b, separation) for a, b in zip(x0, x1, strict=True)]
    return np.array([r[0] for r in results]), np.array([r[1] for r in results])


@pytest.mark.parametrize("kind", ["point_triangle", "edge_edge"])
@pytest.mark.parametrize("separation", [0.0, 1e-3])
def test_steps_are_never_later_than_tight_inclusion_and_seldom_half(kind: str, separation: float) -> None:
    x0, x1 = random_motions(np.random.default_rng(11), 12_000)
    rows = x0.reshape(-1, 12)
    _, squared, _ = getattr(core, "classify_" + kind)(rows)
    # Closer pairs keep half of their distance instead of the separation.
    far = squared > (20 * separation) ** 2
    x0, x1, rows = x0[far], x1[far], rows[far]
    ours = getattr(core, kind + "_ccd")(rows, x1.reshape(-1, 12), separation)
    hit, time = tight_inclusion(kind, x0, x1, separation / np.sqrt(3.0), 1e-6)
    assert hit.sum() > 300
    assert np.all(ours[hit] <= time[hit])
    # Both are lower bounds, ours with a tenth of the time given back.
    assert np.mean(ours[hit] >= 0.5 * time[hit]) > 0.99
    assert np.mean(ours[~hit] == 1.0) > 0.99
    # And not by luck: without the margin the times agree.
    bare = getattr(core, kind + "_ccd")(rows, x1.reshape(-1, 12), separation, time_margin=0.0)
    assert np.mean(bare[hit] >= 0.98 * time[hit]) > 0.95


@pytest.mark.parametrize("kind", ["point_triangle", "edge_edge"])
def test_small_gaps_and_large_motions_against_tight_inclusion(kind: str) -> None:
    """Contact as it is in a simulation: gaps of 1e-6 to 1e-3 of the size, motions up to a million gaps."""
    rng = np.random.default_rng(12)
    n = 3_000
    gap = 10.0 ** rng.uniform(-6, -3, (n, 1))
    x0 = rng.uniform(-1, 1, (n, 4, 3))
    x0[:, :, 2] = 0.0
    if kind == "point_triangle":
        x0[:, 0] = x0[:, 1:].mean(axis=1)
        moving = [0]
    else:
        x0[:, 0], x0[:, 1] = -x0[:, 2] + x0[:, 3], x0[:, 2] - x0[:, 3]
        x0[:, 0, [0, 1]] = x0[:, 0, [1, 0]] * [1, -1]
        x0[:, 1, [0, 1]] = x0[:, 1, [1, 0]] * [1, -1]
        moving = [0, 1]
    x0[:, moving, 2] = gap
    x1 = x0 + rng.uniform(-1, 1, (n, 4, 3)) * gap[:, :, None] * 10.0 ** rng.uniform(0, 6, (n, 1, 1)) * 0.1
    ours = getattr(core, kind + "_ccd")(x0.reshape(-1, 12), x1.reshape(-1, 12))
    hit, time = tight_inclusion(kind, x0, x1, 0.0, 1e-9)
    assert hit.sum() > 300
    assert np.all(ours[hit] <= time[hit])
    assert np.all(ours > 0.0)
    assert np.mean(ours[hit] >= 0.5 * time[hit]) > 0.99


def two_bodies(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    grid, grid_triangles = core.make_grid(1.0, 1.0, 9, 9)
    ball, ball_triangles = core.make_icosphere(0.3, 2)
    vertices = np.concatenate([grid, ball + np.array([0.0, 0.0, 0.32])]) + rng.uniform(
        -0.01, 0.01, (len(grid) + len(ball), 3)
    )
    triangles = np.concatenate([grid_triangles, ball_triangles + len(grid)])
    group = np.repeat(np.array([0, 1], dtype=np.int32), [len(grid), len(ball)])
    return vertices, triangles, group


def test_safe_step_against_ipctk_and_intersections_after_it() -> None:
    rng = np.random.default_rng(14)
    x, triangles, group = two_bodies(rng)
    edges = core.find_edges(triangles)
    scene = core.CollisionScene(group, edges, triangles, threads=2)
    mesh = ipctk.CollisionMesh(x, edges, triangles)
    assert len(scene.find_intersections(x)) == 0
    for size in (0.02, 0.1, 0.5):
        x1 = x + rng.uniform(-size, size, x.shape)
        x1[group == 1] -= [0.0, 0.0, 0.3]
        step, kind, first, second = scene.max_safe_step(x, x1, [1e-6, 1e-6])
        candidates = ipctk.Candidates()
        candidates.build(mesh, x, x1, 1e-6)
        reference = candidates.compute_collision_free_stepsize(
            mesh, x, x1, 0.0, ipctk.TightInclusionCCD(1e-6, 10_000_000, 1.0)
        )
        assert 0.5 * reference < step <= reference
        assert kind in {"point_triangle", "edge_edge"}
        assert first >= 0
        assert second >= 0
        y = x + step * (x1 - x)
        assert len(scene.find_intersections(y)) == 0
        assert not ipctk.has_intersections(mesh, y)
        assert len(scene.find_intersections(x1)) > 0
        assert ipctk.has_intersections(mesh, x1)


def test_bullets_do_not_pass_thin_sheets() -> None:
    rng = np.random.default_rng(15)
    sheet, triangles = core.make_box((1.0, 1.0, 1e-4), 4)
    for _ in range(200):
        start = np.append(rng.uniform(-0.4, 0.4, 2), rng.uniform(0.01, 1.0))
        aim = np.append(rng.uniform(-0.4, 0.4, 2), 0.0)
        x = np.concatenate([sheet, [start]])
        x1 = x.copy()
        x1[-1] += (aim - start) / np.linalg.norm(aim - start) * 1e4 / 30.0
        group = np.append(np.zeros(len(sheet), dtype=np.int32), np.int32(1))
        scene = core.CollisionScene(group, core.find_edges(triangles), triangles, [len(sheet)], [[0, 0]])
        step, kind, first, _ = scene.max_safe_step(x, x1, [1e-6, 1e-6])
        path = step * np.linalg.norm(x1[-1] - start)
        assert 0.89 * np.linalg.norm(aim - start) - 1e-3 < path < np.linalg.norm(aim - start)
        assert kind == "point_triangle"
        assert first == len(sheet)


def test_containment() -> None:
    outer, outer_triangles = core.make_torus(1.0, 0.4)
    inner, inner_triangles = core.make_box((0.1, 0.1, 0.1))
    for shift, expected in (([1.0, 0, 0], 1), ([0.0, 0, 0], 0)):
        x = np.concatenate([outer, inner + shift])
        triangles = np.concatenate([outer_triangles, inner_triangles + len(outer)])
        group = np.repeat(np.array([0, 1], dtype=np.int32), [len(outer), len(inner)])
        scene = core.CollisionScene(group, core.find_edges(triangles), triangles)
        found = scene.find_contained_groups(x)
        assert len(found) == expected
        if expected:
            assert found[0].tolist() == [1, 0, len(outer)]
        assert len(scene.find_intersections(x)) == 0


def test_bad_scenes_are_refused() -> None:
    with pytest.raises(InvalidMesh, match="vertex 5"):
        core.CollisionScene([0, 0, 0], [[0, 5]], [[0, 1, 2]])
    with pytest.raises(InvalidMesh, match="one group"):
        core.CollisionScene([0, 0, 1], [], [[0, 1, 2]])
