"""Filled sections of closed surfaces: areas against closed forms and volumes, rooms, overlaps, open
surfaces."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stark
from stark.render.caps import cap
from stark.render.clipping import Plane


def area(plane: Plane, points: np.ndarray, triangles: np.ndarray) -> float:
    """All triangles look along the normal and lie in the plane."""
    x = points[triangles]
    along = 0.5 * np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) @ plane.normal
    assert (along >= 0.0).all() and np.abs(plane.heights(points)).max(initial=0.0) < 1e-12
    return float(along.sum())


def cut(mesh: stark.TriangleMesh, plane: Plane) -> float:
    filled = cap(plane, mesh.vertices, mesh.triangles)
    assert filled is not None
    return area(plane, *filled)


def test_sections_of_a_box() -> None:
    mesh = stark.mesh.box((1.0, 2.0, 3.0), 4)
    assert cut(mesh, Plane.of((0.1, 0.2, 0.3), (0, 0, 1))) == pytest.approx(2.0)
    assert cut(mesh, Plane.of((0.1, 0.2, 0.3), (0, -1, 0))) == pytest.approx(3.0)
    assert cut(mesh, Plane.of((0.1, 0.0, 0.0), (1, 0, -1))) == pytest.approx(2.0 * math.sqrt(2.0))
    assert cut(mesh, Plane.of((0.6, 0.0, 0.0), (1, 0, 0))) == 0.0  # misses it


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0.3, -0.5, 0.7), (0.01, 1, 0)])
def test_areas_are_the_change_of_the_volume_behind_the_plane(normal) -> None:
    mesh = stark.mesh.torus(0.3, 0.1)
    height, step = 0.02, 1e-4
    planes = [
        Plane.of(np.array(normal) / np.linalg.norm(normal) * h, normal) for h in (height, height + step)
    ]
    volumes = [_kept_volume(mesh, plane) for plane in planes]
    assert cut(mesh, planes[0]) == pytest.approx((volumes[1] - volumes[0]) / step, rel=5e-3)


def _kept_volume(mesh: stark.TriangleMesh, plane: Plane) -> float:
    """Volume behind the plane by the theorem of Gauss from a point of the plane, where the section counts
    nothing."""
    from stark.render.clipping import cut_triangles

    data, triangles = cut_triangles(plane, mesh.vertices, mesh.triangles)
    x = data[triangles] - plane.offset * plane.normal
    return float(np.einsum("ij,ij->i", x[:, 0], np.cross(x[:, 1], x[:, 2])).sum() / 6.0)


def test_rooms_stay_empty_and_overlaps_are_filled_once() -> None:
    outer, inner = stark.mesh.box((1.0, 1.0, 1.0)), stark.mesh.box((0.5, 0.5, 0.5))
    plane = Plane.of((0, 0, 0.1), (0, 0, 1))
    vertices = np.concatenate([outer.vertices, inner.vertices])
    start = len(outer.vertices)
    room = np.concatenate([outer.triangles, inner.triangles[:, ::-1] + start])
    assert area(plane, *cap(plane, vertices, room)) == pytest.approx(0.75)
    both = np.concatenate([outer.triangles, inner.triangles + start])
    assert area(
        plane, *cap(plane, vertices + np.arange(len(vertices))[:, None] // start * [0.5, 0, 0], both)
    ) == (pytest.approx(1.0 + 0.125))


def test_vertices_that_are_given_twice_count_as_one() -> None:
    mesh = stark.mesh.sphere(0.1, 2)
    loose = mesh.vertices[mesh.triangles].reshape(-1, 3)
    plane = Plane.of((0, 0, 0.02), (0.1, 0.2, 1))
    points, triangles = cap(plane, loose, np.arange(len(loose)).reshape(-1, 3))
    assert area(plane, points, triangles) == pytest.approx(cut(mesh, plane))


def test_open_surfaces_have_no_section() -> None:
    sheet, box = stark.mesh.grid(1.0, 1.0, cells=2), stark.mesh.box((1.0, 1.0, 1.0))
    plane = Plane.of((0, 0, 0), (1, 0, 0))
    assert cap(plane, sheet.vertices, sheet.triangles) is None
    assert cap(plane, box.vertices, box.triangles[1:]) is None
