"""Masses of the nodes of solids of all elements and of lattices, against closed forms, against what the core
reports, and through certificates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark.recording import Recorder
from stark.recording.element_masses import solid_masses
from stark.verify import verify

DENSITY = 800.0  # [kg/m^3]


def distorted(mesh: Any) -> Any:
    """Corners moved by smooth amounts, no element with parallel faces."""
    X = np.asarray(mesh.vertices)
    bent = X + 0.15 * np.column_stack([X[:, 1] * X[:, 2], X[:, 0] * X[:, 2], X[:, 0] * X[:, 1]]) / 0.1
    return stark.mesh.SolidMesh(bent, mesh.elements)


def lattice(order: int) -> Any:
    ball = stark.mesh.sphere(0.07, 3).translated((0.003, -0.004, 0.006))
    return stark.mesh.lattice(ball, cell_size=0.03 if order == 1 else 0.05, order=order)


MESHES = {
    "hexahedra": lambda: distorted(stark.mesh.box_hexahedra(0.1, 2)),
    "quadratic hexahedra": lambda: distorted(stark.mesh.to_quadratic(stark.mesh.box_hexahedra(0.1, 2))),
    "quadratic tetrahedra": lambda: stark.mesh.to_quadratic(stark.mesh.tet_box(0.1, 2)),
    "tetrahedra": lambda: stark.mesh.tet_box(0.1, 2),
    "lattice": lambda: lattice(1),
    "quadratic lattice": lambda: lattice(2),
}


def test_a_cube_has_its_mass_at_corners_edges_faces_and_centre() -> None:
    """Of 27 nodes the shares along an axis, from the squares of its shape functions, are 1/6, 2/3, 1/6."""
    one = stark.mesh.to_quadratic(stark.mesh.box_hexahedra(0.1, 1))
    masses = solid_masses(one, np.asarray(DENSITY)) / (DENSITY * 1e-3)
    middle = (np.abs(np.asarray(one.vertices)) < 1e-9).sum(axis=1)  # axes along which a node is in the middle
    np.testing.assert_allclose(masses, (1 / 6) ** (3 - middle) * (2 / 3) ** middle, rtol=1e-12)
    corners = solid_masses(stark.mesh.box_hexahedra(0.1, 1), np.asarray(DENSITY))
    np.testing.assert_allclose(corners, DENSITY * 1e-3 / 8, rtol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_lattices_have_mass_and_centre_of_what_is_inside(order: int) -> None:
    mesh = lattice(order)
    masses = solid_masses(mesh, np.asarray(DENSITY))
    assert masses.sum() == pytest.approx(DENSITY * mesh.surface().volume, rel=1e-9)
    assert not masses[mesh.node_count :].any()
    center = masses @ mesh.vertices / masses.sum()
    np.testing.assert_allclose(center, (0.003, -0.004, 0.006), atol=2e-4)


def thrown(mesh: Any, folder: Path) -> Any:
    """Certificate of a soft body that flies, spins and wobbles."""
    scene = stark.Scene()
    soft = stark.SolidMaterial(density=DENSITY, youngs_modulus=2e4, poissons_ratio=0.3)
    body = scene.add_solid(mesh, soft, velocity=(0.3, 0.0, 1.0), angular_velocity=(2.0, -1.0, 3.0))
    sim = stark.Simulation(scene, time_step=0.01)
    assert solid_masses(body.mesh, np.asarray(DENSITY)).sum() == pytest.approx(body.mass, rel=1e-9)
    with Recorder(folder, sim, certify=True) as recorder:
        recorder.record(sim)
        recorder.record_state(sim)
        for _ in range(5):
            recorder.report(sim.step())
            recorder.record_state(sim)
        recorder.record(sim)
    return verify(folder)


@pytest.mark.parametrize("kind", MESHES)
def test_certificates_check_energy_and_momentum_of_solids(kind: str, tmp_path: Path) -> None:
    certificate = thrown(MESHES[kind](), tmp_path / "run")
    for claim in ("reported_energies", "reported_momentum"):
        assert certificate[claim].status == "verified", certificate[claim].detail


def test_certificates_notice_other_masses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundredth more in the upper half of a lattice."""

    def other(body: Any) -> Any:
        masses = solid_masses(body.mesh, np.asarray(DENSITY))
        return np.where(body.mesh.vertices[:, 2] > 0.0, 1.01 * masses, masses)

    monkeypatch.setattr("stark.recording.states.point_masses", other)
    certificate = thrown(MESHES["lattice"](), tmp_path / "run")
    for claim in ("reported_energies", "reported_momentum"):
        assert certificate[claim].status == "violated", certificate[claim].detail
