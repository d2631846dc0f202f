"""Natural curvature of sheets, against closed forms: a strip that curls, a plate that is held flat."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

STATIC: dict[str, Any] = {
    "time_step": 1.0,
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "gravity": (0, 0, 0),
    "newton.acceleration_tolerance": 0.0,
    "newton.residual_tolerance": 1e-6,
}
RIGIDITY, RATIO = 1e-3, 0.3  # [N m]
SHEET = stark.ShellMaterial(
    youngs_modulus=1e7, poissons_ratio=RATIO, density=0.2, thickness=1e-3, flexural_rigidity=RIGIDITY
)


@pytest.mark.parametrize("yields", [False, True])
def test_a_strip_curls_into_an_arc_without_energy(yields: bool) -> None:
    """Towards its normals, by the natural curvature times the length, wherever it lies."""
    length, cells, curvature = 0.2, 20, 15.0
    turn = stark.rotation(axis=(1.0, -2.0, 0.5), angle=0.9)
    grid = stark.mesh.grid(length, 0.03, cells=(cells, 3))
    material = SHEET.replace(bending_yield_moment=1.0) if yields else SHEET  # which is never reached
    scene = stark.Scene()
    strip = scene.add_cloth(grid.rotated(turn), material)
    strip.pin(strip.triangles[len(strip.triangles) // 2])
    along = np.outer(turn[:, 0], turn[:, 0])
    strip.natural_curvature = 0.0 * along
    sim = stark.Simulation(scene, **STATIC)
    for fraction in np.linspace(0.1, 1.0, 10):
        strip.natural_curvature = fraction * curvature * along
        report = sim.step()
        assert not report.failed, report.message
    assert report.energy["elastic"] < 1e-12
    row = np.flatnonzero(np.abs(grid.vertices[:, 1] + 0.015) < 1e-9)
    row = row[np.argsort(grid.vertices[row, 0])]
    edges = np.diff(strip.positions[row], axis=0)
    np.testing.assert_allclose(np.linalg.norm(edges, axis=1), length / cells, rtol=1e-6)
    bends = np.cross(edges[:-1], edges[1:])
    angles = np.arcsin(np.linalg.norm(bends, axis=1) * (cells / length) ** 2)
    np.testing.assert_allclose(angles, curvature * length / cells, rtol=1e-4)
    a, b, c = (grid.vertices[grid.triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    assert (bends @ turn[:, 1] < 0.0).all()  # from x towards z


def test_a_plate_held_flat_stores_what_unbending_costs() -> None:
    """D (1 + nu) k^2 per area of the same curvature k in all directions, on an irregular mesh, too."""
    grid = stark.mesh.grid(0.1, 0.1, cells=6)
    X = np.array(grid.vertices)
    inside = (np.abs(X[:, :2]) < 0.049).all(axis=1)
    X[inside, :2] += np.random.default_rng(1).uniform(-4e-3, 4e-3, (inside.sum(), 2))
    scene = stark.Scene()
    plate = scene.add_cloth(stark.TriangleMesh(X, grid.triangles), SHEET, pins=range(len(X)))
    plate.natural_curvature = 2.0
    assert plate.natural_curvature.shape == (len(grid.triangles),)
    sim = stark.Simulation(scene, **STATIC)
    assert sim.step().energy["elastic"] == pytest.approx(RIGIDITY * (1 + RATIO) * 4.0 * 0.01, rel=1e-9)
    plate.natural_curvature[:] = 0.0  # in place
    report = sim.step()
    assert report.energy["elastic"] < 1e-15
    assert report.energy["placed"] == pytest.approx(-RIGIDITY * (1 + RATIO) * 4.0 * 0.01, rel=1e-9)


def test_documents_and_refusals(tmp_path: Path) -> None:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), SHEET, name="leaf")
    hinges = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), SHEET.replace(flexural_rigidity=0.0))
    with pytest.raises(
        stark.InvalidArgument, match="natural_curvature: needs a material that bends as a plate"
    ):
        hinges.natural_curvature = 1.0
    with pytest.raises(stark.InvalidArgument, match=r"natural_curvature\[0\]: must be symmetric"):
        sheet.natural_curvature = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    sheet.natural_curvature = np.diag([3.0, 0.0, 0.0])
    scene.save(tmp_path / "leaf.json")
    again = stark.load_scene(tmp_path / "leaf.json").bodies["leaf"]
    np.testing.assert_array_equal(again.natural_curvature, sheet.natural_curvature)


def test_triangles_that_face_opposite_sides_are_warned_of() -> None:
    """A strip that should curl up by 0.27 m stayed flat within 0.02 m, and was told that forces are right."""
    grid = stark.mesh.grid(0.1, 0.1, cells=2)
    mixed = grid.triangles.copy()
    mixed[::2] = mixed[::2][:, [0, 2, 1]]
    scene = stark.Scene()
    with pytest.warns(
        stark.StarkWarning, match=r"pressures on faces, natural curvature; stark\.mesh\.oriented"
    ):
        sheet = scene.add_cloth(stark.TriangleMesh(grid.vertices, mixed), SHEET, name="leaf")
    with pytest.warns(stark.StarkWarning, match="'leaf': natural_curvature: bends triangles to opposite"):
        sheet.natural_curvature = 4.0
    turned = stark.mesh.oriented(stark.TriangleMesh(grid.vertices, mixed))
    scene.add_cloth(turned, SHEET).natural_curvature = 4.0  # not this one
