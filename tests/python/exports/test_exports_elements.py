"""Elements of solids and cloths as VTU, read by meshio and PyVista."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

STILL: dict[str, Any] = {
    "gravity": (0, 0, 0),
    "time.integrator": "quasistatic",
    "newton.residual_tolerance": 1e-6,
}
TYPES = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron27": 27}


def stretched() -> tuple[stark.Simulation, dict[str, stark.Solid]]:
    """A bar of each type of element, pulled to 1.01 of its length, and a cloth."""
    quadratic, size = stark.mesh.to_quadratic, (0.2, 0.1, 0.1)
    meshes: dict[str, Any] = {
        "tetra": stark.mesh.tet_box(size, (2, 1, 1)),
        "hexahedron": stark.mesh.box_hexahedra(size, (2, 1, 1)),
    }
    meshes |= {"tetra10": quadratic(meshes["tetra"]), "hexahedron27": quadratic(meshes["hexahedron"])}
    rubber = stark.SolidMaterial(density=1000, youngs_modulus=1e6, poissons_ratio=0.0)
    scene = stark.Scene()
    bars = {}
    for k, (kind, mesh) in enumerate(meshes.items()):
        ends = np.abs(np.abs(mesh.vertices[:, 0]) - 0.1) < 1e-9
        bars[kind] = scene.add_solid(mesh, rubber, name=kind, position=(0, k, 0), pins=ends)
        right = np.flatnonzero(mesh.vertices[:, 0] > 0.0999)
        bars[kind].follow(displacement=lambda t: (0.002 * t, 0.0, 0.0), vertices=right)
    scene.add_box(0.1, mass=1.0, position=(0, -3, 0), motion="fixed")
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), position=(0, -1, 0), pins=range(9))
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    return sim, bars


def test_elements_come_back_with_what_is_in_them(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    sim, bars = stretched()
    file = stark.exports.write_elements(tmp_path / "bars.vtu", sim)
    read = meshio.read(file)
    points = np.concatenate([b.positions for b in sim.bodies if not isinstance(b, stark.RigidBody)])
    assert np.array_equal(read.points, points)  # in double precision
    start = 0
    for kind, body in bars.items():
        rows = slice(start, start + len(body.positions))
        assert np.array_equal(read.cells_dict[kind] - start, np.asarray(body.mesh.elements))
        moved = (
            body.positions - body.mesh.vertices - (0.0, body.positions[0, 1] - body.mesh.vertices[0, 1], 0.0)
        )
        np.testing.assert_allclose(read.point_data["displacement"][rows], moved, atol=1e-12)
        tensor = read.point_data["stress_tensor"][rows].reshape(-1, 3, 3)
        np.testing.assert_array_equal(tensor, stark.render.tensor_values(sim, "stress")[kind])
        # Uniaxial: the von Mises stress is that along the bar, E times strain within the square of strains,
        # by which the law contracts across at Poisson's ratio 0, too.
        np.testing.assert_allclose(read.point_data["stress"][rows], 1e4, rtol=0.03)
        np.testing.assert_allclose(read.point_data["strain"][rows], 0.01, rtol=5e-3)
        start += len(body.positions)
    assert len(read.cells_dict["triangle"]) == 8
    owners = [np.unique(block).tolist() for block in read.cell_data["body"]]
    assert owners == [[0], [1], [2], [3], [5]]


def test_pyvista_reads_volumes_of_all_elements(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    sim, _ = stretched()
    grid = pyvista.read(stark.exports.write_elements(tmp_path / "bars_0001.vtu", sim))
    volume = grid.compute_cell_sizes()["Volume"]
    for body in range(4):
        assert volume[grid["body"] == body].sum() == pytest.approx(2e-3 * 1.01, rel=1e-4)


def test_metal_and_lattices_have_all_fields(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    metal = stark.j2_plasticity(
        shear_modulus=1e6, bulk_modulus=2e6, yield_stress=1e4, hardening_modulus=0.0, density=1000.0
    )
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.tet_box(0.1, 1), metal)
    n = len(block.mesh.vertices)
    lattice = stark.mesh.lattice(stark.mesh.sphere(0.05, 2), cells=3)
    ball = scene.add_solid(lattice, position=(0.3, 0, 0))
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    read = meshio.read(stark.exports.write_elements(tmp_path / "two.vtu", sim))
    for name in ("stress", "strain", "plastic_strain", "stress_tensor"):
        assert np.isfinite(read.point_data[name]).all(), name
    assert len(read.cells_dict["hexahedron"]) == len(lattice.elements)
    assert len(read.points) == n + len(ball.positions)


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    sim = stark.Simulation(scene)
    with pytest.raises(stark.InvalidArgument, match="neither solids nor cloths"):
        stark.exports.write_elements(tmp_path / "box.vtu", sim)
    with pytest.raises(stark.InvalidArgument, match=r"box.vtk': must end with .vtu"):
        stark.exports.write_elements(tmp_path / "box.vtk", sim)
