"""Nearly incompressible solids: Cook's membrane against published values, compression, contact, plasticity,
and what is refused."""

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
    "newton.residual_tolerance": 1e-10,
}


@stark.energy
def in_plane(p: stark.Point, stiffness: float = stark.parameter(unit="N/m")):
    """Plane strain: keeps points in their plane z."""
    return 0.5 * stiffness * (p.x[2] - p.X[2]) ** 2


@stark.material
def neo_hookean_of_two(
    F: stark.DeformationGradient,
    shear: float = stark.parameter(unit="Pa", above=0.0),
    bulk: float = stark.parameter(unit="Pa", above=0.0),
):
    """Isochoric Neo-Hookean of the benchmark."""
    J = stark.determinant(F)
    return 0.5 * shear * (stark.trace(F.T @ F) * J ** (-2 / 3) - 3) + 0.5 * bulk * (J - 1) ** 2


def cook(cells: int, quadratic: bool, thickness: float) -> stark.SolidMesh:
    """Cook's membrane, 48 long, from 44 to 16 wide [mm], with one element through the thickness."""
    mesh = stark.mesh.box_hexahedra((1.0, 1.0, thickness), (cells, cells, 1))
    if quadratic:
        mesh = stark.mesh.to_quadratic(mesh)
    x, y, z = mesh.vertices.T + np.array([[0.5], [0.5], [0.0]])
    points = np.stack([48e-3 * x, (44 * x + (44 - 28 * x) * y) * 1e-3, z], axis=1)
    return stark.SolidMesh(points, mesh.elements)


def edge_weights(values: np.ndarray, quadratic: bool) -> np.ndarray:
    """What part of an evenly spread load each of the values along a line carries."""
    places, inverse = np.unique(values.round(9), return_inverse=True)
    n = len(places) - 1
    weights = np.full(n + 1, 1.0 / n)
    weights[[0, -1]] /= 2
    if quadratic:
        weights = np.where(np.arange(n + 1) % 2, 4.0, 2.0) / (3.0 * n)
        weights[[0, -1]] /= 2
    return weights[inverse]


def tip(
    cells: int,
    quadratic: bool,
    formulation: str,
    material: stark.SolidMaterial,
    modulus: float,
    force: float,
    place: float,
    steps: int = 1,
) -> float:
    """Vertical displacement of the right side at the height ``place`` [m], under a force per thickness [N/m].
    Points are kept in their planes by springs much stiffer than the material, ``modulus`` [Pa]."""
    thickness = 5e-3
    mesh = cook(cells, quadratic, thickness)
    scene, X = stark.Scene(), mesh.vertices
    body = scene.add_solid(mesh, material, formulation=formulation, pins=X[:, 0] < 1e-9)
    scene.add(in_plane(body.vertices, stiffness=1e5 * modulus * 48e-3))
    right = np.flatnonzero(X[:, 0] > 48e-3 - 1e-9)
    share = edge_weights(X[right, 1], quadratic) * edge_weights(X[right, 2], quadratic)
    loads = np.zeros((len(right), 3))
    loads[:, 1] = share * force * thickness
    assert loads[:, 1].sum() == pytest.approx(force * thickness)
    load = scene.add_force(body.vertices[right], loads)
    sim = stark.Simulation(scene, **STATIC)
    for step in range(steps):
        load.force = loads * (step + 1) / steps
        report = sim.step()
        assert not report.failed, report
    corner = np.argmin(np.linalg.norm(X - [48e-3, place, -thickness / 2], axis=1))
    assert np.linalg.norm(X[corner] - [48e-3, place, -thickness / 2]) < 1e-9
    return float(sim.bodies[0].positions[corner, 1] - X[corner, 1])


def test_cooks_membrane_of_small_strain() -> None:
    """The plane strain version with lambda = 0.75e4, G = 0.375, nu = 0.499975, under a load of 1. The
    converged displacement is 16.4326 (P. Krysl, by Richardson's extrapolation from refined meshes)."""
    shear, lame, scale = 0.375, 0.75e4, 1e9  # stiffer by 1e9, so that strains are small
    nu = lame / (2 * (lame + shear))
    young = 2 * shear * (1 + nu) * scale
    material, exact = stark.SolidMaterial(youngs_modulus=young, poissons_ratio=nu, density=1.0), 16.432584

    def of(cells: int, quadratic: bool, formulation: str) -> float:
        """In two dimensions the displacement does not depend on the size of the membrane."""
        return tip(cells, quadratic, formulation, material, young, 1.0, 52e-3) * scale

    assert of(8, False, "mean_dilatation") == pytest.approx(exact, rel=0.05)
    assert of(16, False, "mean_dilatation") == pytest.approx(exact, rel=0.02)
    assert of(4, True, "mean_dilatation") == pytest.approx(exact, rel=0.005)
    assert of(8, True, "mean_dilatation") == pytest.approx(exact, rel=0.002)
    assert of(8, False, "displacement") < 0.5 * exact  # locks
    assert of(4, True, "displacement") < 0.9 * exact


def test_cooks_membrane_of_rubber() -> None:
    """Neo-Hookean with G = 80.1938 MPa at Poisson's ratio 0.499, under 6.25 MPa: quadrilaterals with F-bar
    give 6.746 mm with 10 a side, 6.891 mm with 30, without 2.841 mm and 4.703 mm (benchmark of OpenGeoSys,
    after de Souza Neto et al. 1996 and Elguedj et al. 2008)."""
    rubber = neo_hookean_of_two(shear=80.1938e6, bulk=240.565e6 / (3 * (1 - 2 * 0.499)), density=1.0)

    def of(cells: int, quadratic: bool, formulation: str) -> float:
        return tip(cells, quadratic, formulation, rubber, 240e6, 6.25e6 * 16e-3, 60e-3, steps=2)

    assert of(10, False, "displacement") == pytest.approx(2.841e-3, rel=2e-3)  # the same elements
    assert of(10, False, "mean_dilatation") == pytest.approx(
        6.746e-3, rel=0.01
    )  # F-bar is not quite the same
    assert of(30, False, "mean_dilatation") == pytest.approx(6.891e-3, rel=1e-3)
    assert of(8, True, "mean_dilatation") == pytest.approx(6.91e-3, rel=5e-3)


@pytest.mark.parametrize("quadratic", [False, True])
def test_compression_changes_the_volume_by_the_bulk_modulus(quadratic: bool) -> None:
    """dV/V = tr(sigma)/(3 K) for a block between pins that move; uniaxial strain, exact for small strains."""
    nu, young = 0.499, 1e6
    mesh = stark.mesh.box_hexahedra(0.1, 2)
    mesh = stark.mesh.to_quadratic(mesh) if quadratic else mesh
    scene = stark.Scene()
    material = stark.SolidMaterial(youngs_modulus=young, poissons_ratio=nu, density=1000.0)
    X = mesh.vertices
    body = scene.add_solid(mesh, material, formulation="mean_dilatation", pins=np.abs(X[:, 2]) > 0.0499)
    sim = stark.Simulation(scene, **STATIC)
    strain = 1e-4
    body.pin_targets = X[body.pins] * [1, 1, 1 - strain]
    assert not sim.step().failed
    x = body.positions
    assert abs(stark.SolidMesh(x, mesh.elements).volume / mesh.volume - 1) < 2e-5  # nearly as before
    # All around in contact with pins: uniaxial strain.
    scene = stark.Scene()
    body = scene.add_solid(
        mesh, material, formulation="mean_dilatation", pins=(np.abs(X) > 0.0499).any(axis=1)
    )
    sim = stark.Simulation(scene, **STATIC)
    body.pin_targets = X[body.pins] * [1, 1, 1 - strain]
    assert not sim.step().failed
    assert np.abs(body.positions - X * [1, 1, 1 - strain]).max() < 1e-12
    bulk, shear = young / (3 * (1 - 2 * nu)), young / (2 * (1 + nu))
    energy = sim.step().energy["elastic"] / mesh.volume  # half of stress times strain
    assert 2 * energy / strain**2 == pytest.approx(bulk + 4 / 3 * shear, rel=1e-3)


def falling(threads: int = 1, law: stark.SolidMaterial | None = None) -> stark.Simulation:
    scene = stark.Scene()
    scene.default_friction = 0.4
    scene.add_floor(1.0)
    rubber = law or stark.SolidMaterial(
        youngs_modulus=5e5, poissons_ratio=0.499, density=1000.0, strain_damping=100.0
    )
    mesh = stark.mesh.box_hexahedra(0.1, 3)
    scene.add_solid(
        mesh, rubber, formulation="mean_dilatation", name="block", position=(0, 0, 0.09),
        rotation=stark.rotation(vector=(0.3, 0.2, 0.0)), velocity=(0.5, 0, 0),
    )  # fmt: skip
    return stark.Simulation(scene, time_step=0.01, **{"execution.threads": threads})


def test_rubber_drops_slides_and_keeps_its_volume(tmp_path: Path) -> None:
    """Contact and friction; the same bits on two threads and after a checkpoint."""
    sim, other = falling(), falling(threads=2)
    for step in range(30):
        if step == 15:
            sim.save(tmp_path / "half")
        report = sim.step()
        assert not report.failed
        other.step()
    body = sim["block"]
    volume = stark.SolidMesh(body.positions, body.mesh.elements).volume
    assert volume == pytest.approx(1e-3, rel=3e-3)
    assert body.positions[:, 2].min() > 0.0 and body.velocities[:, 0].mean() < 0.4
    assert other.state.hash == sim.state.hash
    resumed = falling()
    resumed.load(tmp_path / "half")
    for _ in range(15):
        resumed.step()
    assert resumed.state.hash == sim.state.hash


def test_metal_yields_without_locking() -> None:
    """Plastic flow keeps volumes: elements that lock carry more than the law allows."""

    def force(formulation: str) -> float:
        metal = stark.j2_plasticity(
            shear_modulus=8e10, bulk_modulus=1.7e11, yield_stress=2e8, hardening_modulus=1e8, density=7800.0
        )
        mesh = stark.mesh.box_hexahedra((0.1, 0.1, 0.02), (4, 4, 1))
        X, scene = mesh.vertices, stark.Scene()
        body = scene.add_solid(mesh, metal, formulation=formulation, pins=np.abs(X[:, 0]) > 0.0499)
        scene.add(in_plane(body.vertices, stiffness=1e14))
        sim = stark.Simulation(scene, **STATIC)
        targets, work = X[body.pins], 0.0
        for strain in (0.01, 0.02, 0.03):
            body.pin_targets = targets * [1 + strain, 1, 1]
            report = sim.step()
            assert not report.failed
            work = report.energy["external"]
        return work / (0.01 * 0.1)  # [N], of the last step

    assert force("mean_dilatation") < 0.98 * force("displacement")


def test_refused() -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match="formulation = mean_dilatation with linear tetrahedra"):
        scene.add_solid(stark.mesh.tet_box(0.1, 2), formulation="mean_dilatation")
    with pytest.raises(stark.InvalidArgument, match="formulation"):
        scene.add_solid(stark.mesh.box_hexahedra(0.1, 2), formulation="b_bar")
    assert len(scene) == 0


def test_documents_hold_the_formulation(tmp_path: Path) -> None:
    scene = falling()._scene
    scene.save(tmp_path / "scene.json")
    loaded = stark.load_scene(tmp_path / "scene.json")
    sim, other = stark.Simulation(loaded, time_step=0.01), falling()
    for _ in range(3):
        sim.step()
        other.step()
    assert sim.state.hash == other.state.hash
