"""Tractions and pressures on parts of surfaces: even strain, resultants, a thick cylinder, closed ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _load_scenes import advance, by_elements, simulate

import stark

RUBBER = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3, mass_damping=20.0)
STILL: dict[str, Any] = {"gravity": (0, 0, 0), "time.integrator": "quasistatic"}


def solid_meshes() -> dict[str, stark.mesh.Mesh]:
    size, cells = (0.3, 0.2, 0.1), (3, 2, 1)
    return by_elements(stark.mesh.tet_box(size, cells), stark.mesh.box_hexahedra(size, cells))


def faces_where(solid: stark.Solid, mask: np.ndarray) -> stark.Stencils:
    """The faces all of whose vertices are in the mask."""
    return solid.faces[mask[solid.triangles].all(axis=1)]


@pytest.mark.parametrize("what", ["traction", "pressure"])
@pytest.mark.parametrize("kind", list(solid_meshes()))
def test_loads_on_both_ends_strain_a_free_bar_evenly(kind: str, what: str) -> None:
    mesh = solid_meshes()[kind]
    scene = stark.Scene()
    bar = scene.add_solid(mesh, RUBBER)
    for side in (-1.0, 1.0):
        end = faces_where(bar, np.abs(mesh.vertices[:, 0] - 0.15 * side) < 1e-9)
        if what == "traction":
            scene.add_traction(end, (100.0 * side, 0.0, 0.0))
        else:
            scene.add_face_pressure(end, -100.0)
    sim = simulate(scene, 0.02)
    advance(sim, 0.6)
    strain = np.array([1.0, -0.3, -0.3]) * 100.0 / 1e5
    # Finite strains differ from small ones by their square.
    assert np.abs(bar.positions - mesh.vertices * (1.0 + strain)).max() < 2e-3 * 1e-3 * 0.15


@pytest.mark.parametrize("kind", list(solid_meshes()))
def test_resultants_are_area_times_load(kind: str) -> None:
    """On a face that is bent: its area by fine quadrature, its area vector and the moment of that by the sum
    over its border, which share nothing with shape functions."""
    mesh = solid_meshes()[kind]
    x, side = mesh.vertices, mesh.vertices[:, 2] > 0.0499
    plane = np.column_stack((x[:, 0], x[:, 1], x[:, 2] + 0.5 * x[:, 0] * x[:, 1]))
    bent = type(mesh)(plane, mesh.elements)
    scene = stark.Scene()
    block = scene.add_solid(bent, RUBBER, position=(1.0, 0.0, 0.0))
    pull = scene.add_traction(faces_where(block, side), (1.0, 2.0, 3.0))
    push = scene.add_face_pressure(faces_where(block, side), 10.0)
    sim = simulate(scene, 1e-6)
    assert not sim.step().failed
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(-0.15, 0.15, 301), np.linspace(-0.1, 0.1, 201)))
    slope = np.sqrt(1.0 + 0.25 * (u**2 + v**2))
    area = slope.mean() * 0.3 * 0.2
    np.testing.assert_allclose(pull.forces.sum(axis=(0, 1)), area * np.array([1.0, 2.0, 3.0]), rtol=2e-3)
    # The saddle z = xy/2 has the area vector of the flat face.
    np.testing.assert_allclose(push.forces.sum(axis=(0, 1)), (0.0, 0.0, -10.0 * 0.06), atol=1e-6)


@pytest.mark.parametrize("kind", list(solid_meshes()))
def test_on_a_closed_surface_it_is_minus_the_pressure_inside(kind: str) -> None:
    """Also in a step in which the body moves far: the swept volume is the change of that inside."""
    shapes = []
    for load in ("add_pressure", "add_face_pressure"):
        scene = stark.Scene()
        block = scene.add_solid(solid_meshes()[kind], RUBBER)
        getattr(scene, load)(block, 3e4 if load == "add_pressure" else -3e4)
        sim = simulate(scene, 0.05, **{"newton.residual_tolerance": 1e-9})
        advance(sim, 0.2)
        shapes.append(block.positions.copy())
    assert np.abs(shapes[0] - solid_meshes()[kind].vertices).max() > 5e-3
    np.testing.assert_allclose(shapes[0], shapes[1], atol=1e-8)


@pytest.mark.parametrize(
    ("quadratic", "cells", "error"), [(False, (8, 12, 1), 4e-3), (True, (4, 6, 1), 2e-3)]
)
def test_a_quarter_of_a_thick_cylinder_agrees_with_lame(
    quadratic: bool, cells: tuple[int, int, int], error: float
) -> None:
    a, b, E, nu, p = 0.1, 0.2, 2.1e11, 0.3, 1e8
    box = stark.mesh.box_hexahedra(1.0, cells)
    box = stark.mesh.to_quadratic(box) if quadratic else box
    u, v, w = (box.vertices + 0.5).T
    r, angle = a + (b - a) * u, v * np.pi / 2
    mesh = stark.SolidMesh(np.column_stack((r * np.cos(angle), r * np.sin(angle), 0.02 * w)), box.elements)
    scene = stark.Scene()
    metal = stark.SolidMaterial(density=7850, youngs_modulus=E, poissons_ratio=nu)
    tube = scene.add_solid(mesh, metal)
    support = scene.add_rollers(tube.vertices[v < 1e-9], "y")
    scene.add_rollers(tube.vertices[v > 1 - 1e-9], "x")
    scene.add_rollers(tube.vertices[(w < 1e-9) | (w > 1 - 1e-9)], "z")
    load = scene.add_face_pressure(faces_where(tube, u < 1e-9), lambda t: p * t)
    sim = stark.Simulation(scene, time_step=0.5, **STILL)
    sim.run_until(1.0)
    factor = p * a**2 / (b**2 - a**2)
    expected = (1 + nu) / E * ((1 - 2 * nu) * factor * a + factor * b**2 / a)
    assert tube.positions[:, 0][(u < 1e-9) & (v < 1e-9)].mean() - a == pytest.approx(expected, rel=error)
    # What half of the cylinder takes is the pressure on its diameter.
    assert support.forces.sum(axis=(0, 1))[1] == pytest.approx(-p * a * 0.02, rel=2e-3)
    assert load.pressure == p


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_a_block_flies_by_the_pressure_on_one_face(integrator: str) -> None:
    scene = stark.Scene()
    stiff = stark.SolidMaterial(density=1000.0, youngs_modulus=1e7, mass_damping=0.0, strain_damping=1e4)
    block = scene.add_solid(stark.mesh.tet_box(0.1, 2), stiff)
    scene.add_face_pressure(faces_where(block, block.mesh.vertices[:, 0] < -0.0499), 100.0)
    sim = simulate(scene, 0.01, **{"time.integrator": integrator})
    advance(sim, 0.5)
    start = 0.25 * 0.01 if integrator == "bdf2" else 0.0  # docs/integrators.md: it fades in, half a step late
    speed = block.velocities.mean(axis=0)
    assert speed[0] == pytest.approx(100.0 * 0.01 / 1.0 * 0.5, abs=1e-3 + start)
    report = sim.step()
    gained = 100.0 * 0.01 * speed[0] * 0.01
    assert report.energy["external"] == pytest.approx(gained, rel=0.03)


def bent_beam(pressures: list[float]) -> np.ndarray:
    """Mean place of the end of a beam that is pressed on the outer half of its upper side."""
    mesh = stark.mesh.box_hexahedra((1.0, 0.1, 0.05), (40, 2, 2))
    x, _, z = mesh.vertices.T
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000, youngs_modulus=1e7, poissons_ratio=0.3)
    beam = scene.add_solid(mesh, rubber, pins=x < -0.4999)
    load = scene.add_face_pressure(faces_where(beam, (z > 0.0249) & (x > -1e-9)), 0.0)
    sim = stark.Simulation(scene, time_step=1.0, **STILL, **{"newton.residual_tolerance": 1e-6})
    for pressure in pressures:
        load.pressure = pressure
        assert not sim.step().failed
    return beam.positions[x > 0.4999].mean(axis=0)


def test_a_load_in_one_step_ends_where_one_in_many_steps_does() -> None:
    """Pressure at the border of the faces is that of the mean normal of a step; repeated steps forget it."""
    gradual = bent_beam([*np.linspace(40.0, 800.0, 20), 800.0, 800.0, 800.0])
    assert gradual[2] < -0.6
    for count, error in ((1, 0.2), (2, 0.01), (3, 1e-3), (5, 1e-5)):
        assert bent_beam([800.0] * count)[2] == pytest.approx(gradual[2], rel=error)


def test_a_sheet_under_pressure_is_pressed_against_its_normals() -> None:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.4, 0.2, (4, 2)), stark.materials.cotton)
    load = scene.add_face_pressure(sheet, 2.0)
    sim = simulate(scene, 1e-5)
    assert not sim.step().failed
    np.testing.assert_allclose(load.forces.sum(axis=(0, 1)), (0.0, 0.0, -2.0 * 0.08), atol=1e-6)


def test_what_has_no_faces_is_refused() -> None:
    scene = stark.Scene()
    block = scene.add_solid(solid_meshes()["hex8"], RUBBER)
    rod = scene.add_rod(stark.mesh.polyline((1, 0, 0), (2, 0, 0), 3))
    for surface, message in (
        (rod, r"face pressure on .*: must be faces of a cloth or a solid, such as solid\.faces"),
        (block.vertices, "must be faces of a cloth or a solid"),
        (block.faces[[]], "'solid': no faces are selected"),
        (block.faces[:3], "the 3 triangles must be whole faces of elements, each of which is 2 triangles"),
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            scene.add_face_pressure(surface, 1.0)  # type: ignore[arg-type]
    with pytest.raises(stark.InvalidArgument, match=r"traction 'wind'.*no faces"):
        scene.add_traction(block.faces[[]], (0, 0, 1), name="wind")
    with pytest.raises(stark.InvalidArgument, match="traction"):
        scene.add_traction(block.faces, (0, 0, np.nan))


def test_a_pressure_on_faces_of_both_sides_is_refused() -> None:
    """It pushed some triangles and pulled their neighbours: 0.02 m in place of 0.33 m, without a word."""
    grid = stark.mesh.grid(0.1, 0.1, cells=2)
    mixed = grid.triangles.copy()
    mixed[::2] = mixed[::2][:, [0, 2, 1]]
    scene = stark.Scene()
    with pytest.warns(stark.StarkWarning, match="oriented differently"):
        sheet = scene.add_cloth(stark.TriangleMesh(grid.vertices, mixed), name="sail")
    with pytest.raises(
        stark.InvalidArgument, match=r"'sail': its triangles at the edge .* stark\.mesh\.oriented"
    ):
        scene.add_face_pressure(sheet, 1.0)
    scene.add_face_pressure(sheet.faces[::2], 1.0)  # those of one side
    fins = [(0, 1, 2), (1, 0, 3), (0, 1, 4)]  # three at one edge have no common side
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)]
    with pytest.warns(stark.StarkWarning):
        wing = scene.add_cloth(stark.TriangleMesh(0.1 * np.array(corners), fins), position=(0, 0, 1))
    scene.add_face_pressure(wing, 1.0)
