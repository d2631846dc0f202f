"""Bending of plates: the same on most meshes, and heavy strips against the elastica (V09, V10)."""

from __future__ import annotations

import numpy as np
import pytest
from _validation import validate

import stark


def alternating(cells: int, size: float = 1.0) -> stark.TriangleMesh:
    """A square of size x size whose cells have diagonals in turn."""
    grid = stark.mesh.grid(size, size, cells)
    corner = np.arange(cells * (cells + 1)).reshape(cells, cells + 1)[:, :-1].ravel()
    a, b, c, d = corner, corner + 1, corner + cells + 1, corner + cells + 2
    odd = ((corner // (cells + 1) + corner % (cells + 1)) % 2).astype(bool)
    first = np.where(odd[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(odd[:, None], np.column_stack([b, d, c]), np.column_stack([a, d, c]))
    return stark.TriangleMesh(grid.vertices, np.concatenate([first, second]))


def irregular(cells: int, size: float = 1.0) -> stark.TriangleMesh:
    """A grid with inner vertices moved by up to a quarter of a cell."""
    grid = stark.mesh.grid(size, size, cells)
    x = grid.vertices.copy()
    inside = (np.abs(x[:, :2]) < 0.499 * size).all(axis=1)
    x[inside, :2] += np.random.default_rng(5).uniform(-0.25, 0.25, (inside.sum(), 2)) * size / cells
    return stark.TriangleMesh(x, grid.triangles)


def equilateral(cells: int) -> stark.TriangleMesh:
    grid = stark.mesh.grid(1.0, 1.0, cells)
    shear = np.array([[1.0, 0.5, 0.0], [0.0, np.sqrt(0.75), 0.0], [0.0, 0.0, 1.0]])
    return stark.TriangleMesh(grid.vertices @ shear.T, grid.triangles)


MESHES = {
    "grid": lambda: stark.mesh.grid(1.0, 1.0, 16),
    "alternating": lambda: alternating(16),
    "equilateral": lambda: equilateral(16),
    "irregular": lambda: irregular(16),
}


def rolled_energy(mesh: stark.TriangleMesh, degrees: float, radius: float = 20.0) -> float:
    """Bending energy of a plate of unit rigidity rolled on a cylinder, over D kappa^2 A / 2."""
    direction = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    along = mesh.vertices @ direction
    rolled = mesh.vertices - np.outer(along, direction) + np.outer(radius * np.sin(along / radius), direction)
    rolled[:, 2] = radius * (1.0 - np.cos(along / radius))
    material = stark.ShellMaterial(flexural_rigidity=1.0, youngs_modulus=1e-6, poissons_ratio=0.3)
    scene = stark.Scene()
    cloth = scene.add_cloth(mesh, material, initial_positions=rolled)
    cloth.pin(np.arange(len(rolled)))
    sim = stark.Simulation(scene, **{"contact.enabled": False})
    x = mesh.vertices[mesh.triangles]
    area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum()
    return float(sim.step().energy["elastic"] / (0.5 * area / radius**2))


@pytest.mark.filterwarnings("ignore:.*inner vertices have four triangles")
@pytest.mark.parametrize("name", MESHES)
def test_a_rolled_plate_has_the_energy_of_a_plate_in_every_direction(name: str) -> None:
    energies = [rolled_energy(MESHES[name](), degrees) for degrees in (0.0, 22.5, 45.0, 67.5)]
    validate(f"V09.{name}", energies)


def heavy_strip(gamma: float, cells: int, irregular_mesh: bool = False) -> float:
    """Drop over reach of the end of a strip clamped level, rho_A g L^3 / D = gamma."""
    length, rho = 0.2, 0.2
    rigidity = rho * 9.81 * length**3 / gamma
    cell = length / cells
    mesh = stark.mesh.grid(length + cell, 6 * cell, (cells + 1, 6))
    x = mesh.vertices - [mesh.vertices[:, 0].min() + cell, 0.0, 0.0]
    if irregular_mesh:
        inside = (x[:, 0] > 0.5 * cell) & (x[:, 0] < length - 0.5 * cell) & (np.abs(x[:, 1]) < 2.5 * cell)
        x[inside, :2] += np.random.default_rng(2).uniform(-0.2, 0.2, (inside.sum(), 2)) * cell
    # E t = 200 N/m: its own weight, 0.4 N/m, stretches it by 0.2 % at most.
    material = stark.ShellMaterial(
        density=rho, youngs_modulus=200.0 / 1e-3, poissons_ratio=0.0, flexural_rigidity=rigidity,
        mass_damping=5.0,
    )  # fmt: skip
    scene = stark.Scene()
    strip = scene.add_cloth(stark.TriangleMesh(x, mesh.triangles), material)
    strip.pin(x[:, 0] < 1e-9)
    sim = stark.Simulation(scene, time_step=0.02, **{"contact.enabled": False})
    for report in sim.run(6.0):
        assert not report.failed
        if sim.time > 1.0 and np.abs(sim.bodies[0].velocities).max() < 2e-5:
            break
    end = sim.bodies[0].positions[np.isclose(x[:, 0], length)].mean(axis=0)
    return float(-end[2] / end[0])


@pytest.mark.slow
@pytest.mark.parametrize("gamma", [5, 20, 50])
def test_a_heavy_strip_hangs_as_the_elastica(gamma: int) -> None:
    """The clamp is felt over half a cell: an error of first order, which the two meshes show."""
    coarse, fine = heavy_strip(gamma, 24), heavy_strip(gamma, 48)
    validate(f"V10.gamma_{gamma}", fine)
    validate(f"V10.gamma_{gamma}_extrapolated", 2.0 * fine - coarse)


@pytest.mark.slow
def test_the_shape_of_a_heavy_strip_does_not_depend_on_the_mesh() -> None:
    validate("V10.mesh", heavy_strip(20, 32, irregular_mesh=True) / heavy_strip(20, 32))


def supported_plate(mesh: stark.TriangleMesh) -> float:
    """Deflection of the middle of a plate that rests on its edges under an even load, over that in
    theory, 0.00406235 q a^4/D at Poisson's ratio 0.3 [Timoshenko, Woinowsky-Krieger 1959, table 8]."""

    @stark.energy
    def support(p: stark.Point, k: float) -> stark.symbolic.Scalar:
        return 0.5 * k * (p.x[2] - p.x0[2]) ** 2

    @stark.energy
    def place(p: stark.Point, k: float) -> stark.symbolic.Scalar:
        return 0.5 * k * ((p.x[0] - p.x0[0]) ** 2 + (p.x[1] - p.x0[1]) ** 2)

    scene = stark.Scene()
    plate = stark.ShellMaterial(density=1.0, youngs_modulus=1e5, poissons_ratio=0.3, flexural_rigidity=1.0)
    sheet = scene.add_cloth(mesh, plate)
    edge = np.flatnonzero((np.abs(mesh.vertices[:, :2]) > 0.499).any(axis=1))
    scene.add(support(sheet.vertices[edge], k=1e8))
    scene.add(place(sheet.vertices, k=1e-3))
    settings = {
        "time.integrator": "quasistatic",
        "newton.acceleration_tolerance": 1e-6,
        "contact.enabled": False,
    }
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 1e-2), **settings)
    report = sim.step()
    assert not report.failed, report.message
    middle = np.argmin(np.linalg.norm(mesh.vertices, axis=1))
    return float(sheet.positions[middle, 2] / 1e-2 / 0.00406235)


def test_a_supported_plate_bends_as_far_as_a_plate() -> None:
    assert supported_plate(stark.mesh.grid(1.0, 1.0, 16)) == pytest.approx(1.0, abs=0.015)
    assert supported_plate(irregular(16)) == pytest.approx(1.0, abs=0.05)


def test_plates_with_diagonals_in_turn_are_too_soft_and_warn() -> None:
    """They are consistent, but every other vertex may leave the surface at little cost."""
    with pytest.warns(stark.StarkWarning, match="112 of 225 inner vertices have four triangles"):
        softer = supported_plate(alternating(16))
    assert 1.6 < softer < 1.9


@pytest.mark.parametrize(
    "mesh", [stark.mesh.grid(1.0, 1.0, 8), irregular(8), equilateral(8), stark.mesh.sphere(0.5, 2)]
)
def test_other_plates_do_not_warn(mesh: stark.TriangleMesh, recwarn: pytest.WarningsRecorder) -> None:
    stark.Scene().add_cloth(mesh, stark.materials.pet)
    assert not recwarn.list
