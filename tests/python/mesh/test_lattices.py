"""Surfaces in lattices: what is made, its volume, its files, errors; scans."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from mesh._scans import animal, scan

import stark
from stark.mesh import EmbeddedMesh, MeshReport, TriangleMesh, lattice


def tilted_box() -> TriangleMesh:
    """Twelve triangles, parallel to nothing."""
    return stark.mesh.box((0.2, 0.12, 0.08)).rotated(stark.rotation(axis=(1, 2, 3), angle=0.7))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("surface", [stark.mesh.sphere(0.1, 3), tilted_box(), stark.mesh.torus(0.1, 0.04)])
def test_volume_is_that_of_the_surface_and_vertices_are_carried_exactly(
    surface: TriangleMesh, order: int
) -> None:
    report = MeshReport()
    mesh = lattice(surface, cells=7, order=order, report=report)
    assert mesh.volume == pytest.approx(surface.volume, rel=1e-9)
    shown = mesh.surface()
    assert shown.is_closed and shown.volume == pytest.approx(surface.volume, rel=1e-9)
    assert mesh.elements.shape[1] == (8 if order == 1 else 27) and mesh.elements.max() == mesh.node_count - 1
    assert ((mesh.filling[:, 0] > 0.0) & (mesh.filling[:, 0] <= 1.0)).all()
    moved = mesh.vertices @ [[1.1, 0.2, 0.0], [0.0, 0.9, 0.1], [0.3, 0.0, 1.0]] + [1.0, 2.0, 3.0]
    np.testing.assert_allclose(mesh.carried(moved[: mesh.node_count]), moved, atol=1e-14)
    assert report.count("lattice") == len(mesh.elements)
    assert "cells along the shortest side" in str(report) and "m^3 inside of the surface" in str(report)


@pytest.mark.parametrize("order", [1, 2])
def test_the_centre_of_mass_is_right_within_a_fiftieth_of_a_cell(order: int) -> None:
    """docs/meshes.md: from samples in each cell."""
    torus = stark.mesh.torus(0.1, 0.04)  # about the origin
    for cells in (3, 5):
        body, apart = lattice(torus, cells=cells, order=order), []
        for axis in np.eye(3):
            scene = stark.Scene()
            soft = scene.add_solid(body)
            report = stark.Simulation(scene, time_step=1e-6, gravity=-axis).step()
            apart.append(report.energy["gravity"] / soft.mass)
        assert 1e-5 < np.linalg.norm(apart) < 0.02 * 0.28 / cells


def test_long_edges_are_split_conformally() -> None:
    box = tilted_box()
    mesh = lattice(box, cell_size=0.03)
    shown = mesh.surface()
    edges = np.linalg.norm(np.diff(shown.vertices[shown.triangles[:, [0, 1, 2, 0]]], axis=1), axis=2)
    assert edges.max() <= 0.03 * (1 + 1e-9)
    assert shown.is_closed and shown.area == pytest.approx(box.area)
    assert len(lattice(box, cell_size=0.03, split=False).triangles) == 12


def test_cells_are_along_the_longest_side_and_only_where_the_body_is() -> None:
    mesh = lattice(stark.mesh.box((0.4, 0.2, 0.1)), cells=8)
    assert len(mesh.elements) == 8 * 4 * 2 and (mesh.filling[:, 0] == 1.0).all()
    ring = lattice(stark.mesh.torus(0.2, 0.02, 24, 8), cell_size=0.02)
    middle = np.linalg.norm(ring.vertices[: ring.node_count, :2], axis=1)
    assert middle.min() > 0.15  # nothing in the hole


@pytest.mark.parametrize("turned", [0.0, np.pi / 2, np.pi, -np.pi / 2])
def test_faces_on_faces_of_cells_fill_no_cells_beyond(turned: float) -> None:
    """A step of whole cells, whichever way it looks: no layer of cells that its vertices only touch."""
    base, block = stark.mesh.box((0.8, 0.4, 0.3)), stark.mesh.box((0.3, 0.4, 0.5))
    step = stark.mesh.joined([base, block.translated((-0.25, 0.0, 0.4))])
    for axis in ("x", "y", "z"):
        mesh = lattice(step.rotated(stark.rotation(axis=axis, angle=turned)), cell_size=0.1)
        assert len(mesh.elements) == 8 * 4 * 3 + 3 * 4 * 5 and (mesh.filling[:, 0] == 1.0).all()


def test_what_overlaps_is_filled_once() -> None:
    """Also where little does: the surface encloses it twice."""
    for overlap in (0.3, 0.05, 0.02):
        pair = stark.mesh.joined([stark.mesh.box(1.0), stark.mesh.box(1.0).translated((1.0 - overlap, 0, 0))])
        assert pair.volume == pytest.approx(2.0)
        report = MeshReport()
        mesh = lattice(pair, cell_size=0.19, report=report)
        assert mesh.volume == pytest.approx(2.0 - overlap, abs=4e-3)
        assert "by samples; its triangles enclose 2 m^3, what overlaps more than once" in str(report)


@pytest.mark.parametrize("order", [1, 2])
def test_what_is_much_thinner_than_a_cell_weighs_what_it_does(order: int) -> None:
    plate = stark.mesh.box((1.0, 1.0, 5e-4))
    for angle in (0.0, 0.7):
        turned = plate.rotated(stark.rotation(axis=(1, 2, 3), angle=angle))
        with pytest.warns(
            stark.StarkWarning,
            match="0.0005 m thick in the mean .*, 0.005 of a cell: must be 0.(4|125)",
        ):
            mesh = lattice(turned, cell_size=0.1, order=order)
        assert mesh.volume == pytest.approx(plate.volume, rel=1e-9)
    with pytest.raises(stark.InvalidMesh, match="is much thinner than a cell, use smaller cells"):
        lattice(stark.mesh.box((1.0, 1.0, 1e-5)), cell_size=0.1, order=order)


@pytest.mark.parametrize(
    ("size", "order", "warns"),
    [
        ((0.5, 0.5, 0.03), 1, True),  # a plate of three tenths of a cell
        ((0.5, 0.5, 0.03), 2, False),
        ((0.5, 0.5, 0.01), 2, True),
        ((0.5, 0.05, 0.05), 1, True),  # a beam of half a cell
        ((0.5, 0.06, 0.06), 2, False),
        ((0.1, 0.1, 0.1), 1, False),  # nothing slender
    ],
)
def test_what_bends_too_stiffly_in_its_cells_is_warned_of(
    size: tuple[float, float, float], order: int, warns: bool
) -> None:
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        lattice(stark.mesh.box(size), cell_size=0.1, order=order)
    assert len(said) == int(warns)
    assert all("use cells of" in str(w.message) for w in said)


def test_holes_leave_an_inside() -> None:
    ball = stark.mesh.sphere(0.1, 4)
    open_ball = stark.mesh.compact(
        TriangleMesh(ball.vertices, ball.triangles[ball.vertices[ball.triangles[:, 0], 2] < 0.095])
    )
    report = MeshReport()
    mesh = lattice(open_ball, cells=10, report=report)
    assert mesh.volume == pytest.approx(ball.volume, rel=0.02)
    assert "by samples" in str(report) and "open" in str(report)


def test_meshes_are_moved_and_kept_in_files(tmp_path: Path) -> None:
    mesh = lattice(stark.mesh.sphere(0.1, 2), cells=4, order=2)
    half = mesh.scaled(0.5).translated((1.0, 0.0, 0.0)).rotated(stark.rotation(axis="z", angle=1.0))
    assert isinstance(half, EmbeddedMesh) and half.volume == pytest.approx(mesh.volume / 8)
    mesh.save(tmp_path / "ball.npz")
    again = stark.mesh.load(tmp_path / "ball.npz")
    assert isinstance(again, EmbeddedMesh)
    for name, array in mesh.__dict__.items():
        assert np.array_equal(getattr(again, name), array), name
    assert "in 64 cells" in repr(again) or "cells" in repr(again)


def test_nodes_around_vertices() -> None:
    mesh = lattice(stark.mesh.box((0.4, 0.2, 0.1)), cells=4)
    end = np.flatnonzero(mesh.vertices[:, 0] > 0.1999)
    nodes = mesh.nodes_around(end)
    assert (nodes < mesh.node_count).all()
    assert mesh.vertices[nodes, 0].min() == pytest.approx(0.1)  # of the last layer of cells
    assert np.array_equal(nodes, mesh.nodes_around(mesh.vertices[:, 0] > 0.1999))
    with pytest.raises(stark.InvalidArgument, match="nodes_around: vertices: must be indices in"):
        mesh.nodes_around([len(mesh.vertices)])


@pytest.mark.parametrize(
    ("surface", "options", "error", "message"),
    [
        (stark.mesh.box(1.0), {}, stark.InvalidArgument, "give one of cells"),
        (stark.mesh.box(1.0), {"cells": 2, "cell_size": 0.1}, stark.InvalidArgument, "give one of cells"),
        (stark.mesh.box(1.0), {"cells": 0}, stark.InvalidArgument, "cells = 0"),
        (stark.mesh.box(1.0), {"cell_size": float("nan")}, stark.InvalidArgument, "cell_size = nan"),
        (stark.mesh.box(1.0), {"cell_size": 30.0}, stark.InvalidArgument, "at most twice the longest side"),
        (stark.mesh.box(1.0), {"cells": 2, "order": 3}, stark.InvalidArgument, "order = 3: must be 1"),
        (stark.mesh.box(1.0), {"cells": 300, "split": False}, stark.InvalidArgument, "at most 2000000"),
        (stark.mesh.box(1.0).flipped(), {"cells": 2}, stark.InvalidMesh, "oriented inwards"),
        (stark.mesh.grid(1.0, 1.0, cells=2), {"cells": 2}, stark.InvalidMesh, "nowhere above 0.5"),
        (
            ([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]]),
            {"cells": 2},
            stark.InvalidMesh,
            "not finite",
        ),
        (([[0.0, 0, 0]], np.empty((0, 3), int)), {"cells": 2}, stark.InvalidMesh, "0 triangles"),
        (stark.mesh.tet_box(1.0, 1), {"cells": 2}, stark.InvalidMesh, "got a TetMesh"),
    ],
)
def test_what_makes_no_body_is_named(
    surface: object, options: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        lattice(surface, **options)


def test_wrong_arrays_are_refused() -> None:
    mesh = lattice(stark.mesh.sphere(0.1, 2), cells=4)
    parts = {name: np.array(array) for name, array in mesh.__dict__.items()}
    for name, value, message in [
        ("filling", parts["filling"][:-1], "filling: got the shape"),
        ("cells", np.zeros(0, dtype=int), "cells: 0 of"),
        ("cells", parts["cells"] - 1000, r"cells: one of them is -\d+: must be in \[0, "),
        ("cells", parts["cells"] + len(parts["elements"]), r"cells: one of them is \d+: must be in \[0, "),
        ("elements", parts["elements"][:, :4], "elements have 4 nodes: must have 8 or 27"),
    ]:
        with pytest.raises(stark.InvalidMesh, match=message):
            EmbeddedMesh(**{**parts, name: value})
    scene = stark.Scene()
    for name, change, message in [
        ("filling", lambda a: a * 2.0, "is filled by a part of"),
        ("cells", lambda a: a * 0, "is outside of its element 0"),
        ("triangles", lambda a: a * 0 + np.arange(3), "a node: must refer to embedded vertices"),
        ("elements", lambda a: a + len(parts["cells"]), "which is embedded: must refer to nodes|Jacobian"),
    ]:
        wrong = EmbeddedMesh(**{**parts, name: change(parts[name])})
        with pytest.raises(stark.InvalidMesh, match=message):
            scene.add_solid(wrong)
    assert len(scene.bodies) == 0
    with pytest.raises(stark.InvalidMesh, match="to_quadratic: got an EmbeddedMesh"):
        stark.mesh.to_quadratic(mesh)
    with pytest.raises(stark.InvalidMesh, match="compact: got an EmbeddedMesh"):
        stark.mesh.compact(mesh)


def test_a_scan_becomes_a_lattice_the_same_at_every_call() -> None:
    pytest.importorskip("fast_simplification")
    said: list[tuple[str, float]] = []
    found = stark.mesh.lattice_from_scan(
        scan(4), cell_size=0.03, progress=lambda what, share: said.append((what, share))
    )
    assert found.mesh.volume == pytest.approx(animal(4).volume, rel=0.05)
    assert found.surface.is_closed and "cells of 0.03 m" in str(found.report)
    assert [share for _, share in said] == sorted(share for _, share in said) and said[-1] == ("done", 1.0)
    again = stark.mesh.lattice_from_scan(scan(4), cell_size=0.03)
    assert all(np.array_equal(getattr(again.mesh, n), a) for n, a in found.mesh.__dict__.items())
    with pytest.raises(stark.InvalidArgument, match="lattice_from_scan: cell_size = 0 m"):
        stark.mesh.lattice_from_scan(scan(3), cell_size=0)


@pytest.mark.slow
def test_a_scan_of_seventy_thousand_triangles_falls_in_a_lattice_within_a_minute_of_cpu() -> None:
    pytest.importorskip("fast_simplification")
    dirty = scan(6)
    assert 65_000 < len(dirty.triangles) < 82_000
    start = time.process_time()
    found = stark.mesh.lattice_from_scan(dirty, cell_size=0.02)
    scene = stark.Scene()
    scene.add_floor(1.0)
    body = scene.add_solid(found.mesh, stark.materials.soft_rubber, position=(0, 0, 0.2))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.25)
    assert body.surface_positions[:, 2].min() > 0.0 and body.surface_positions[:, 2].mean() < 0.15
    assert time.process_time() - start < 60.0


@pytest.mark.parametrize("cells", [4, 6])
def test_a_triquadratic_lattice_hangs_as_a_trilinear_one(cells: int) -> None:
    """Cells of which next to nothing is filled: their quadratic motions had next to no stiffness."""
    ball, sags = stark.mesh.sphere(0.1, 3), []
    for order in (1, 2):
        scene, mesh = stark.Scene(), stark.mesh.lattice(ball, cells=cells, order=order)
        top = np.flatnonzero(ball.vertices[:, 2] > 0.08)
        rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3)
        body = scene.add_solid(mesh, rubber, pins=mesh.nodes_around(mesh.node_count + top))
        sim = stark.Simulation(scene, settings={"time.integrator": "quasistatic"})
        start = body.surface_positions.copy()
        report = sim.step()
        assert not report.failed, report.message
        assert report.newton_iterations < 8
        sags.append((start - body.surface_positions)[:, 2].max())
    assert sags[1] == pytest.approx(sags[0], rel=0.04)


def test_orders_of_numpy_and_odd_values() -> None:
    cube = stark.mesh.box(0.1)
    assert lattice(cube, cells=2, order=np.int64(2)).elements.shape[1] == 27
    for order in (np.zeros(3), [], "2", True, 3):
        with pytest.raises(stark.InvalidArgument, match=r"order = .*must be 1"):
            lattice(cube, cells=2, order=order)  # type: ignore[arg-type]
    with pytest.raises(stark.InvalidArgument, match=r"report = \[\]: must be a stark.mesh.MeshReport"):
        lattice(cube, cells=2, report=[])  # type: ignore[arg-type]
