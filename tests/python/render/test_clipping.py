"""Cuts by a plane: areas, volumes' sections, values in between."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stark
from stark.render.clipping import Plane, cut_triangles, section


def area(points: np.ndarray, triangles: np.ndarray) -> float:
    x = points[:, :3][triangles]
    return float(0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum())


@pytest.mark.parametrize("height", [-0.31, 0.0, 0.123])
def test_a_box_keeps_what_is_below(height: float) -> None:
    mesh = stark.mesh.box((1.0, 1.0, 1.0), 5)
    data, triangles = cut_triangles(Plane.of((0, 0, height), (0, 0, 2)), mesh.vertices, mesh.triangles)
    assert area(data, triangles) == pytest.approx(1.0 + 4.0 * (0.5 + height))  # bottom and walls
    assert data[triangles][..., 2].max() == pytest.approx(height)


def test_oriented_as_before_and_values_in_between() -> None:
    vertices = np.array([[0.0, 0, 0, 10], [1, 0, 0, 20], [0, 1, 0, 40]])
    for normal in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (-1, -1, 0)):
        data, triangles = cut_triangles(Plane.of((0.25, 0.25, 0), normal), vertices, np.array([[0, 1, 2]]))
        x = data[:, :3][triangles]
        assert (np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])[:, 2] > 0.0).all()
        assert data[:, 3] == pytest.approx(10.0 + 10.0 * data[:, 0] + 30.0 * data[:, 1])


@pytest.mark.parametrize("normal", [(1, 0, 0), (0, 0, -1), (1, 1, 0), (0.3, -0.5, 0.7)])
def test_sections_of_a_cube(normal) -> None:
    mesh = stark.mesh.tet_box((1.0, 1.0, 1.0), (3, 4, 5))
    low, high = mesh.bounds
    plane = Plane.of(0.5 * (low + high) + 1e-3, normal)
    data, triangles = section(plane, np.column_stack([mesh.vertices, mesh.vertices @ [1, 2, 3]]), mesh.tets)
    assert np.abs(plane.heights(data[:, :3])).max() < 1e-12
    assert data[:, 3] == pytest.approx(data[:, :3] @ [1, 2, 3])
    x = data[:, :3][triangles]
    assert (np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) @ plane.normal >= 0.0).all()
    # The oracle: area of the section = change of the volume behind the plane.
    points = np.random.default_rng(2).uniform(low, high, (400_000, 3))
    inside = np.abs(plane.heights(points)) < 0.02
    assert area(data, triangles) == pytest.approx(inside.mean() / 0.04, rel=0.02)
    if normal == (1, 1, 0):
        assert area(data, triangles) == pytest.approx(math.sqrt(2.0), rel=5e-3)


def test_a_plane_needs_a_direction() -> None:
    with pytest.raises(ValueError, match=r"clip: normal = \(0, 0, 0\): must point to the side"):
        Plane.of((0, 0, 0), (0, 0, 0))
