"""Polygons of mesh files: the triangles cover what the outline encloses, once, whatever its shape."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import mesh
from stark.mesh.polygons import triangulated

ARROW = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.5, 1.0)]
ANGLE = [(0.1, 0.0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0.0, 0.1), (0.0, 0.0)]
# A comb, which no fan covers.
COMB = [(0, 0), (5, 0), (5, 2), (4, 2), (4, 1), (3, 1), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
# A plate with a hole, cut open along a seam between both outlines, as exporters write it.
RING = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
# A square with corners on its straight edges, two on each.
SQUARE = [(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (3, 3), (2, 3), (1, 3), (0, 3), (0, 2), (0, 1)]


def signed_areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def shoelace(points: np.ndarray) -> float:
    x, y = points.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def cut(outline: Any) -> np.ndarray:
    points = np.pad(np.asarray(outline, dtype=np.float64), ((0, 0), (0, 1)))
    return triangulated(points, [len(points)], np.arange(len(points)), lambda k: f"face {k}")


def assert_covered(outline: Any) -> None:
    """All triangles face as the outline does and have its area together: they cover it once."""
    points = np.asarray(outline, dtype=np.float64)
    triangles = cut(points)
    areas = signed_areas(points, triangles)
    assert len(triangles) == len(points) - 2 and areas.min() > 0.0
    assert areas.sum() == pytest.approx(shoelace(points), rel=1e-12)
    # Edges inside run both ways, those of the outline as it does: nothing opens where corners lie on edges.
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert (count == 1).sum() == len(points) and (count == 2).sum() == len(points) - 3


@pytest.mark.parametrize("shape", [ARROW, ANGLE])
def test_polygons_that_a_fan_covers_need_no_other_library(
    shape: list[tuple[float, float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "manifold3d", None)
    for first in range(len(shape)):
        assert_covered(np.roll(shape, first, axis=0))


@pytest.mark.parametrize("shape", [COMB, RING, SQUARE], ids=["comb", "ring", "square"])
def test_other_polygons_are_clipped(shape: list[tuple[float, float]]) -> None:
    pytest.importorskip("manifold3d")
    for first in range(len(shape)):
        assert_covered(np.roll(shape, first, axis=0))


def test_random_stars() -> None:
    pytest.importorskip("manifold3d")
    random = np.random.default_rng(3)
    for size in (5, 8, 20, 100, 600):
        angles = 2.0 * np.pi * (np.arange(size) + random.uniform(-0.4, 0.4, size)) / size
        radii = random.uniform(0.2, 1.0, size) * 10.0 ** random.integers(-3, 3)
        assert_covered(np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1))


def test_convex_polygons_keep_the_fan_about_their_first_corner(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "manifold3d", None)
    random = np.random.default_rng(4)
    outlines, counts = [], []
    for size in (3, 4, 5, 9, 40, 2000):
        angles = np.linspace(0.0, 2.0 * np.pi, size, endpoint=False) + random.uniform(0.0, 0.5 / size, size)
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        flat = np.stack([np.cos(angles), 0.3 * np.sin(angles), 1e-3 * random.normal(size=size)], axis=1)
        outlines.append(flat @ axes.T + random.normal(size=3))  # hardly planar
        counts.append(size)
    found = triangulated(np.concatenate(outlines), counts, np.arange(sum(counts)), str)
    starts = np.cumsum(counts) - counts
    fans = [
        (start, start + i, start + i + 1)
        for start, n in zip(starts, counts, strict=True)
        for i in range(1, n - 1)
    ]
    assert found.tolist() == [list(map(int, triangle)) for triangle in fans]


def prism(outline: list[tuple[float, float]]) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and polygons of a column of height 0.02 on an outline in a plane that no axis is normal to."""
    n = len(outline)
    flat = np.pad(np.asarray(outline, dtype=np.float64), ((0, 0), (0, 1)))
    turn = stark.rotation(axis=(1.0, 2.0, 3.0), angle=1.0)
    vertices = np.concatenate([flat, flat + np.array([0.0, 0.0, 0.02])]) @ np.asarray(turn).T
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


def obj(vertices: np.ndarray, polygons: list[list[int]]) -> bytes:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += ["f " + " ".join(str(i + 1) for i in polygon) for polygon in polygons]
    return "\n".join(lines).encode()


def ply(vertices: np.ndarray, polygons: list[list[int]]) -> bytes:
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty double x\n"
        f"property double y\nproperty double z\nelement face {len(polygons)}\n"
        f"property list uchar int vertex_indices\nend_header\n"
    )
    faces = [struct.pack(f"<B{len(polygon)}i", len(polygon), *polygon) for polygon in polygons]
    return head.encode() + np.asarray(vertices, dtype="<f8").tobytes() + b"".join(faces)


WRITERS = {"obj": obj, "ply": ply}


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("shape", [ANGLE, COMB], ids=["angle", "comb"])
def test_columns_have_the_surface_of_their_outline(
    suffix: str, shape: list[tuple[float, float]], tmp_path: Path
) -> None:
    if shape is COMB:
        pytest.importorskip("manifold3d")
    path = tmp_path / f"column.{suffix}"
    path.write_bytes(WRITERS[suffix](*prism(shape)))
    found = mesh.load(path)
    assert isinstance(found, mesh.TriangleMesh) and found.is_closed
    outline = np.asarray(shape, dtype=np.float64)
    around = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1).sum()
    assert found.area == pytest.approx(2.0 * shoelace(outline) + 0.02 * around, rel=1e-9)
    assert found.volume == pytest.approx(0.02 * shoelace(outline), rel=1e-9)


def test_a_rod_falls_through_the_notch_of_an_angle(tmp_path: Path) -> None:
    """The fan about the first corner closes it, with triangles that no outline has."""
    (tmp_path / "angle.obj").write_bytes(obj(*prism(ANGLE)))
    angle = mesh.load(tmp_path / "angle.obj").rotated(np.asarray(stark.rotation(axis=(1, 2, 3), angle=-1.0)))
    angle = angle.rotated(stark.rotation(axis="x", angle=0.5 * np.pi))
    scene = stark.Scene()
    scene.add_rigid(angle, motion="fixed", name="angle")
    rod = scene.add_box((0.01, 0.1, 0.01), mass=0.1, position=(0.05, -0.01, 0.035))
    sim = stark.Simulation(scene, time_step=0.005)
    sim.run_until(0.15)
    assert rod.position[2] - 0.005 == pytest.approx(0.02, abs=2.5e-3)  # the contact distance


@pytest.mark.parametrize("suffix", WRITERS)
def test_polygons_that_cross_themselves_are_named(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"bow.{suffix}"
    vertices = np.array([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0)], dtype=np.float64)
    path.write_bytes(WRITERS[suffix](vertices, [[0, 2, 1], [0, 1, 2, 3], [0, 2, 4, 5]]))
    where = "line 8: face 1" if suffix == "obj" else "face 1"
    with pytest.warns(stark.StarkWarning, match=rf"bow.{suffix}': {where}: the polygon crosses itself or has "
                      r"no area \(2 polygons, this is the first\)"):  # fmt: skip
        found = mesh.load(path)
    assert found.triangles.tolist() == [[0, 2, 1], [0, 1, 2], [0, 2, 3], [0, 2, 4], [0, 4, 5]]


def test_a_pentagram_is_no_polygon() -> None:
    pytest.importorskip("manifold3d")
    angles = 4.0 * np.pi * np.arange(5) / 5
    with pytest.warns(stark.StarkWarning, match="face 0: the polygon crosses itself"):
        cut(np.stack([np.cos(angles), np.sin(angles)], axis=1))


def test_corners_twice_and_values_that_others_refuse_pass_as_before() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, np.nan)], dtype=np.float64)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert triangulated(points, [4], [0, 1, 2, 2], str).tolist() == [[0, 1, 2], [0, 2, 2]]
        assert triangulated(points, [4], [0, 1, 2, 3], str).tolist() == [[0, 1, 2], [0, 2, 3]]
        assert triangulated(points, [4, 2], [0, 1, 2, 9, 0, 1], str).tolist() == [[0, 1, 2], [0, 2, 9]]
        assert triangulated(np.empty((0, 3)), [], [], str).shape == (0, 3)


def test_what_to_install_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "manifold3d", None)
    (tmp_path / "comb.obj").write_bytes(obj(*prism(COMB)))
    with pytest.raises(ImportError, match=r"comb.obj': line 25: face 0: a polygon that is not convex needs "
                       r"manifold3d: pip install 'stark-sim\[mesh\]'"):  # fmt: skip
        mesh.load(tmp_path / "comb.obj")
