"""Dirty surfaces come out closed, with the volume of what was scanned."""

from __future__ import annotations

import time

import numpy as np
import pytest
from mesh._scans import animal, scan

import stark
from stark.mesh import MeshReport, TriangleMesh
from stark.mesh.cleaning import border_loops, pieces


def test_a_scan_becomes_a_closed_surface_of_the_same_volume() -> None:
    report = MeshReport()
    surface = stark.mesh.cleaned(scan(4), report=report)
    whole = animal(4)
    assert surface.is_closed
    # Holes are filled flat: a cap of base radius 0.03 m over curvature radii of 0.1 m is 2 % of the volume.
    assert abs(surface.volume - whole.volume) < 0.03 * whole.volume
    assert report.count("pieces") >= 6 and report.count("double") == 50 and report.count("filled") > 5
    assert report.count("turned") > 50 and report.count("merged") > 100
    assert "holes, the longest border" in str(report)


def test_a_clean_surface_stays_as_it_is() -> None:
    box, report = stark.mesh.box((1, 2, 3), 3), MeshReport()
    found = stark.mesh.cleaned(box, report=report)
    assert len(found.triangles) == len(box.triangles) and abs(found.volume - 6.0) < 1e-12
    assert report.changes == [] and str(report) == "mesh\n  nothing was changed"


def test_inside_out_surfaces_are_turned_as_a_whole() -> None:
    report = MeshReport()
    found = stark.mesh.cleaned(stark.mesh.sphere(1.0, 2).flipped(), report=report)
    assert found.volume > 4.0 and report.count("turned") == len(found.triangles)


def test_a_hole_is_filled_flat() -> None:
    box = stark.mesh.box(1.0, 4)
    centers = box.vertices[box.triangles].mean(axis=1)
    lid = (centers[:, 2] > 0.49) & (np.abs(centers[:, :2]) < 0.25).all(axis=1)
    assert lid.sum() == 8
    found = stark.mesh.cleaned(TriangleMesh(box.vertices, box.triangles[~lid]))
    assert found.is_closed and abs(found.volume - 1.0) < 1e-12
    loops = border_loops(box.triangles[~lid])
    assert [len(loop) for loop in loops] == [8]
    opened = stark.mesh.cleaned(TriangleMesh(box.vertices, box.triangles[~lid]), fill_holes=False)
    assert not opened.is_closed


def test_holes_that_meet_in_a_point_are_two() -> None:
    grid = stark.mesh.grid(1.0, 1.0, 6)
    centers = grid.vertices[grid.triangles].mean(axis=1)[:, :2] * 6.0
    one = (np.abs(centers - 0.5) < 0.5).all(axis=1)
    other = (np.abs(centers + 0.5) < 0.5).all(axis=1)
    loops = border_loops(grid.triangles[~(one | other)])
    assert sorted(len(loop) for loop in loops) == [4, 4, 24]


def test_pieces_are_told_apart_and_small_ones_dropped() -> None:
    balls = [stark.mesh.sphere(r, 2).translated((3.0 * k, 0, 0)) for k, r in enumerate((1.0, 0.5, 0.05))]
    three = stark.mesh.joined(balls)
    assert len(np.unique(pieces(three.triangles))) == 3
    assert len(np.unique(pieces(stark.mesh.cleaned(three).triangles))) == 2
    assert len(stark.mesh.cleaned(three, smallest_piece=0.0).triangles) == len(three.triangles)


def test_triangles_at_crowded_edges_go() -> None:
    box = stark.mesh.box(1.0, 2)
    fin = TriangleMesh(
        np.concatenate([box.vertices, [[0, 0, 2.0]]]),
        np.concatenate([box.triangles, [[*box.triangles[0][:2], len(box.vertices)]]]),
    )
    report = MeshReport()
    found = stark.mesh.cleaned(fin, report=report)
    assert found.is_closed and report.count("crowded") == 3 and abs(found.volume - 1.0) < 0.05


def test_what_cannot_be_a_surface_is_refused() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    middle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    across = np.stack(
        [np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], axis=1
    )
    vertices = np.concatenate([middle - 0.3 * across, middle + 0.3 * across])
    k = np.arange(23)
    strip = [
        *np.column_stack([k, k + 1, k + 24]),
        *np.column_stack([k + 1, k + 25, k + 24]),
        (23, 24, 47),
        (24, 0, 47),
    ]
    with pytest.raises(stark.InvalidMesh, match="must be two-sided; cut it"):
        stark.mesh.cleaned(TriangleMesh(vertices, np.array(strip)))
    with pytest.raises(stark.InvalidMesh, match="has 0 triangles"):
        stark.mesh.cleaned(TriangleMesh(vertices, np.empty((0, 3), dtype=int)))
    with pytest.raises(stark.InvalidArgument, match=r"tolerance = 2: must be in \[0, 1\)"):
        stark.mesh.cleaned(stark.mesh.box(1.0), tolerance=2)
    with pytest.raises(stark.InvalidMesh, match="joined: got no surface"):
        stark.mesh.joined([])
    with pytest.raises(
        stark.InvalidMesh, match=r"joined: got TriangleMesh: must be a list of surfaces, joined\("
    ):
        stark.mesh.joined(stark.mesh.box(0.1))
    vertices[0, 0] = np.nan
    with pytest.raises(stark.InvalidMesh, match="a vertex is not finite"):
        stark.mesh.cleaned(TriangleMesh(vertices, np.array(strip)))


def test_a_long_border_is_one_loop_found_in_linear_time() -> None:
    strip = stark.mesh.grid(10.0, 0.01, cells=(20_000, 1))
    begin = time.process_time()
    (loop,) = border_loops(strip.triangles)
    assert len(loop) == 40_002
    assert time.process_time() - begin < 4.0  # 0.1 s; 13 s where each vertex is looked for in the chain
