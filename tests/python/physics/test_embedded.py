"""Surfaces in lattices as bodies: patch test, mass, bending, free motion, contact, everything that looks at
surfaces, the same bits."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from _helpers import G, Judge
from mesh._scans import animal

import stark
from stark.mesh import EmbeddedMesh, lattice
from stark.render.fields import field_values

STATIC = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-12,
    "newton.acceleration_tolerance": 1e-9,
}
RUBBER = stark.materials.soft_rubber.replace(youngs_modulus=5e4, density=1000.0, mass_damping=0.0)


def ball(order: int = 1, cells: int = 5, subdivisions: int = 3) -> EmbeddedMesh:
    return lattice(stark.mesh.sphere(0.1, subdivisions), cells=cells, order=order)


@pytest.mark.parametrize("order", [1, 2])
def test_affine_motion_of_cut_cells_strains_all_evenly(order: int) -> None:
    """Nodes of cells that are cut are held at an affine map: the others come to it from elsewhere, so does
    the surface, stress is uniform, and the energy is that of the volume inside."""
    mesh = ball(order, 6)
    F = np.array([[1.06, 0.04, 0.0], [0.0, 0.97, 0.03], [0.02, 0.0, 1.02]])
    cut = np.unique(mesh.elements[mesh.filling[:, 0] < 1.0])
    start = mesh.vertices @ F.T
    inner = np.setdiff1d(np.arange(mesh.node_count), cut)
    assert len(inner) > 0
    start[inner] += np.random.default_rng(0).normal(scale=1e-3, size=(len(inner), 3))

    def strained(
        given: object, positions: np.ndarray, pins: np.ndarray
    ) -> tuple[stark.Simulation, stark.Solid]:
        scene = stark.Scene()
        body = scene.add_solid(given, RUBBER, initial_positions=positions, pins=pins)
        sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
        assert not sim.step().failed
        return sim, body

    sim, body = strained(mesh, start, cut)
    np.testing.assert_allclose(body.positions, mesh.vertices @ F.T, atol=1e-9)
    stress = field_values(sim, "stress")[body.name]
    assert np.ptp(stress) < 1e-5 * stress.max()
    block = stark.mesh.box_hexahedra(0.1, 1)
    of_block, _ = strained(block, block.vertices @ F.T, np.arange(8))
    energy = of_block.step().energy["elastic"] / block.volume * mesh.volume
    assert sim.step().energy["elastic"] == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize(("order", "cells", "mean", "single"), [(1, 6, 0.002, 0.03), (2, 3, 0.004, 0.1)])
def test_pressure_swells_cut_cells_evenly(order: int, cells: int, mean: float, single: float) -> None:
    """Of a ball by p / 3 K in all directions, K the bulk modulus; the surface is a polyhedron and what is
    inside comes from samples."""
    modulus, nu, pressure = 1e5, 0.3, 100.0
    mesh = lattice(stark.mesh.sphere(0.1, 4), cells=cells, order=order, split=False)
    scene = stark.Scene()
    body = scene.add_solid(mesh, stark.SolidMaterial(youngs_modulus=modulus, poissons_ratio=nu, density=1e3))
    scene.add_pressure(body, pressure)
    sim = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC)
    assert not sim.step().failed
    rest = mesh.vertices[mesh.node_count :]
    moved = body.surface_positions - rest
    moved -= moved.mean(axis=0)
    swelling = (moved * rest).sum(axis=1) / (rest**2).sum(axis=1) / (pressure * (1.0 - 2.0 * nu) / modulus)
    assert swelling.mean() == pytest.approx(1.0, abs=mean)
    assert np.abs(swelling - 1.0).max() < single


def beam_tip(cell: float, order: int) -> float:
    """Tip of a cantilever of 1 x 0.1 x 0.1 m whose section is turned against the lattice, over that of a beam
    that bends and shears."""
    length, width, modulus, density, g = 1.0, 0.1, 1e7, 1000.0, 0.02
    surface = stark.mesh.box((length, width, width)).rotated(stark.rotation(axis="x", angle=0.4))
    mesh = lattice(surface, cell_size=cell, order=order)
    scene = stark.Scene()
    body = scene.add_solid(
        mesh,
        stark.SolidMaterial(youngs_modulus=modulus, poissons_ratio=1e-6, density=density),
        pins=np.flatnonzero(mesh.vertices[: mesh.node_count, 0] < -0.4999 * length),
    )
    sim = stark.Simulation(scene, gravity=(0.0, 0.0, -g), **STATIC)
    assert not sim.step().failed
    load, inertia = density * g * width**2, width**4 / 12
    exact = load * length**4 / (8 * modulus * inertia) + load * length**2 / 2 / (
        5 / 6 * modulus / 2 * width**2
    )
    end = mesh.vertices[:, 0] > 0.4999 * length
    end[: mesh.node_count] = False
    return float((mesh.vertices - body.positions)[end, 2].mean()) / exact


def test_a_beam_across_the_lattice_bends_as_one_with_quadratic_cells() -> None:
    coarse, fine = beam_tip(0.1, 2), beam_tip(0.05, 2)
    assert coarse == pytest.approx(1.0, abs=0.03)  # four cells around the middle, each filled by a third
    assert fine == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(("part", "least", "most"), [(0.5, 1.0, 1.08), (0.2, 0.95, 1.1), (0.1, 1.2, 1.6)])
def test_plates_thinner_than_cells_are_too_stiff_as_the_guide_says(
    part: float, least: float, most: float
) -> None:
    """docs/meshes.md, Lattices: a strip of 1 x 0.2 m across cells of 0.1 m."""
    length, width, thickness, modulus = 1.0, 0.2, 0.1 * part, 1e7
    turn = stark.rotation(axis="x", angle=0.4)
    surface = stark.mesh.box((length, width, thickness)).rotated(turn)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh = lattice(surface, cell_size=0.1, order=2)
    rigidity = modulus * thickness**2 / 12  # over the thickness, as the load is
    pull = 0.02 * 8 * rigidity / (1000.0 * length**3)
    scene = stark.Scene()
    held = np.flatnonzero(mesh.vertices[: mesh.node_count, 0] < -0.4999 * length)
    rubber = stark.SolidMaterial(youngs_modulus=modulus, poissons_ratio=1e-6, density=1000.0)
    body = scene.add_solid(mesh, rubber, pins=held)
    sim = stark.Simulation(scene, gravity=turn @ (0.0, 0.0, -pull), **STATIC)
    assert not sim.step().failed
    end = mesh.vertices[:, 0] > 0.4999 * length
    end[: mesh.node_count] = False
    sunk = ((mesh.vertices - body.positions)[end] @ turn[:, 2]).mean()
    assert least < 0.02 * length / sunk < most


@pytest.mark.slow
def test_a_beam_across_the_lattice_converges_with_trilinear_cells() -> None:
    """Shear locking of trilinear cells falls with the square of their size."""
    errors = [abs(beam_tip(cell, 1) - 1.0) for cell in (0.04, 0.02, 0.0125)]
    assert errors[1] < 0.4 * errors[0] and errors[2] < 0.55 * errors[1], errors
    assert errors[2] < 0.05


@pytest.mark.parametrize("order", [1, 2])
def test_mass_falls_freely_and_keeps_its_momenta(order: int) -> None:
    surface = animal(3)
    mesh = lattice(surface, cells=6 if order == 1 else 3, order=order)
    mass = RUBBER.density * surface.volume
    scene = stark.Scene()
    scene.add_solid(mesh, RUBBER, velocity=(0.3, 0.0, 1.0))
    sim = stark.Simulation(scene, time_step=0.01, **{"newton.acceleration_tolerance": 1e-9})
    exact = mass * np.array([0.3, 0.0, 1.0 - G * 0.1])
    np.testing.assert_allclose(sim.run_until(0.1).momentum, exact, atol=1e-7 * mass)

    scene = stark.Scene()
    scene.add_solid(mesh, RUBBER, angular_velocity=(1.0, 2.0, 3.0))
    sim = stark.Simulation(
        scene, gravity=(0, 0, 0), time_step=1e-3, **{"newton.acceleration_tolerance": 1e-9}
    )
    first = sim.step().angular_momentum
    np.testing.assert_allclose(sim.run_until(0.05).angular_momentum, first, atol=1e-3 * np.linalg.norm(first))


@pytest.mark.parametrize("order", [1, 2])
def test_a_body_that_rests_pushes_with_its_weight(order: int) -> None:
    mesh = ball(order, 5 if order == 1 else 2)
    scene = stark.Scene()
    scene.add_floor()
    body = scene.add_solid(mesh, RUBBER.replace(mass_damping=10.0), position=(0.0, 0.0, 0.1015))
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
    sim.run_until(0.8)
    weight = RUBBER.density * mesh.volume * G
    assert body.contact_force[2] == pytest.approx(weight, rel=2e-3)
    forces = body.contact_forces
    assert forces.shape == mesh.vertices.shape and not forces[: mesh.node_count].any()
    assert forces[:, 2].sum() == pytest.approx(weight, rel=2e-3)
    assert 0.0 < body.surface_positions[:, 2].min() < 2e-3


def test_friction_holds_and_lets_go() -> None:
    def slid(coefficient: float) -> float:
        scene = stark.Scene()
        slope = stark.rotation(axis="y", angle=20 * stark.deg)
        scene.add_box((2.0, 1.0, 0.1), motion="fixed", rotation=slope, position=slope @ [0.0, 0.0, -0.05])
        scene.default_friction = coefficient
        mesh = lattice(stark.mesh.box((0.2, 0.15, 0.1)), cell_size=0.06)
        body = scene.add_solid(mesh, RUBBER, rotation=slope, position=slope @ [0.0, 0.0, 0.0512])
        sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
        sim.run_until(0.2)
        start = body.surface_positions.mean(axis=0)
        sim.run_until(0.6)
        return float((body.surface_positions.mean(axis=0) - start) @ slope[:, 0])

    assert abs(slid(0.5)) < 1e-4  # tan 20 deg = 0.364
    low = slid(0.2)
    # Accelerated by g (sin - mu cos) from about the beginning.
    assert low == pytest.approx(0.5 * G * (np.sin(0.349) - 0.2 * np.cos(0.349)) * (0.6**2 - 0.2**2), rel=0.1)


@pytest.mark.parametrize("order", [1, 2])
def test_a_drop_is_free_of_intersections_and_the_same_on_any_number_of_threads(order: int) -> None:
    def run(threads: int, judged: bool) -> np.ndarray:
        scene = stark.Scene()
        scene.default_friction = 0.4
        scene.add_floor()
        scene.add_box(0.08, position=(0.02, 0.0, 0.045), density=300.0)
        body = scene.add_solid(
            lattice(animal(3), cells=6 if order == 1 else 3, order=order),
            RUBBER,
            position=(0, 0, 0.23),
            velocity=(0, 0, -2.0),
        )
        sim = stark.Simulation(scene, time_step=0.01, threads=threads)
        judge = Judge(sim) if judged else None
        for report in sim.run(until=0.12):
            assert not report.failed, report.message
            if judge is not None:
                assert not judge.intersects()
        return body.positions

    alone = run(1, judged=True)
    assert np.array_equal(alone, run(2, judged=False))


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_files_go_on_with_the_same_bits(tmp_path: Path, integrator: str) -> None:
    def scene_of() -> stark.Scene:
        scene = stark.Scene()
        scene.add_floor()
        mesh = ball(cells=3, subdivisions=2)
        scene.add_solid(mesh, RUBBER, name="ball", position=(0, 0, 0.11), velocity=(0.5, 0, 0), pins=[0, 1])
        scene.add_solid(mesh, RUBBER, position=(0, 0, 0.33))
        return scene

    scene = scene_of()
    sim = stark.Simulation(scene, time_step=0.01, **{"time.integrator": integrator})
    sim.run_until(0.05)
    sim.save(tmp_path / "half.npz")
    sim.run_until(0.08)
    scene.save(tmp_path / "scene.json")
    for again in (scene_of(), stark.load_scene(tmp_path / "scene.json")):
        other = stark.Simulation(again, time_step=0.01, **{"time.integrator": integrator})
        other.load(tmp_path / "half.npz")
        other.run_until(0.08)
        assert other.state.hash == sim.state.hash
    changed = stark.Scene()
    changed.add_floor()
    changed.add_solid(ball(cells=4, subdivisions=2), RUBBER, name="ball", position=(0, 0, 0.11), pins=[0, 1])
    changed.add_solid(ball(cells=3, subdivisions=2), RUBBER, position=(0, 0, 0.33))
    with pytest.raises(stark.Error):
        stark.Simulation(changed, time_step=0.01, **{"time.integrator": integrator}).load(
            tmp_path / "half.npz"
        )


def test_surfaces_carry_energies_attachments_and_joints() -> None:
    """A force of one newton on a vertex of the surface for a tenth of a second is 0.1 N s; a glued weight and
    a joint on a patch hold."""
    mesh = ball()
    top = mesh.node_count + int(mesh.vertices[mesh.node_count :, 2].argmax())

    @stark.energy
    def pull(p: stark.Point, force: stark.Vec3) -> stark.Scalar:
        return -(p.x @ force)

    scene = stark.Scene()
    body = scene.add_solid(mesh, RUBBER)
    scene.add(pull(body.vertices[[top]], force=(0.0, 1.0, 0.0)))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=0.01)
    np.testing.assert_allclose(sim.run_until(0.1).momentum, [0.0, 0.1, 0.0], atol=1e-5)

    scene = stark.Scene()
    body = scene.add_solid(mesh, RUBBER, pins=np.flatnonzero(mesh.vertices[: mesh.node_count, 2] > 0.099))
    low = np.argsort(mesh.vertices[:, 2] + 1.0 * (np.arange(len(mesh.vertices)) < mesh.node_count))[:3]
    load = scene.add_box(0.03, mass=0.2, position=(0.0, 0.0, -0.125))
    scene.attach(body.vertices[low], load)
    triangle = mesh.triangles[np.abs(mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] - 0.1).argmin()]
    arm = scene.add_box(0.02, mass=0.05, position=(0.13, 0.0, 0.0))
    scene.add_ball(body.frame(triangle), arm, anchor=mesh.vertices[triangle].mean(axis=0))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.3)
    assert not sim.step().failed
    held = arm.position + arm.rotation @ (mesh.vertices[triangle].mean(axis=0) - (0.13, 0.0, 0.0))
    assert np.linalg.norm(body.positions[triangle].mean(axis=0) - held) < 1e-4
    assert load.position[2] < -0.125 and load.position[2] > -0.2


def test_placing_and_velocities_are_those_of_the_nodes() -> None:
    mesh = ball()
    scene = stark.Scene()
    body = scene.add_solid(mesh, RUBBER)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=0.01)
    F = np.diag([1.0, 1.1, 0.9])
    placed = mesh.vertices @ F
    placed[mesh.node_count :] = 0.0  # follows, whatever is given
    body.positions = placed
    np.testing.assert_allclose(body.positions, mesh.vertices @ F, atol=1e-14)
    body.velocities = (1.0, 0.0, 0.0)
    np.testing.assert_allclose(body.velocities, np.tile((1.0, 0.0, 0.0), (len(mesh.vertices), 1)), atol=1e-14)
    sim.step()
    assert body.velocities[mesh.node_count :].mean(axis=0)[0] == pytest.approx(1.0, rel=1e-3)


def test_held_nodes_carry_the_surface_along() -> None:
    mesh = ball()
    scene = stark.Scene()
    body = scene.add_solid(mesh, RUBBER, pins=np.arange(mesh.node_count))
    sim = stark.Simulation(scene, time_step=0.01)
    shift = np.array([0.05, 0.0, 0.0])
    body.pin_targets = mesh.vertices[: mesh.node_count] + shift
    sim.step()
    np.testing.assert_allclose(body.positions, mesh.vertices + shift, atol=1e-14)


def test_what_a_lattice_cannot_is_named() -> None:
    mesh = ball()
    scene = stark.Scene()
    body = scene.add_solid(mesh, RUBBER, name="ball")
    with pytest.raises(stark.InvalidArgument, match="is embedded and follows the nodes of its cell"):
        body.pin([len(mesh.vertices) - 1])
    body.pin(mesh.nodes_around([len(mesh.vertices) - 1]))
    with pytest.raises(stark.InvalidArgument, match="its surface is embedded"):
        body.add_skin(stark.materials.cotton)
    with pytest.raises(stark.InvalidArgument, match="its elements have 8 nodes"):
        _ = body.tetrahedra


def test_recordings_are_certified_and_drawn(tmp_path: Path) -> None:
    from stark import scenes
    from stark.verify import verify

    scene_file = tmp_path / "falling.py"
    scene_file.write_text(
        "import stark\n"
        "until = 0.05\n"
        "def build():\n"
        "    scene = stark.Scene()\n"
        "    scene.add_floor()\n"
        "    mesh = stark.mesh.lattice(stark.mesh.sphere(0.05, 2), cells=3)\n"
        "    scene.add_solid(mesh, name='ball', position=(0, 0, 0.053), velocity=(0, 0, -1.0))\n"
        "    return scene\n"
    )
    result = scenes.run(scene_file, out=tmp_path / "run", certify=True, replay=True, picture=True)
    assert result.status == "ok" or result.exit_code == 0, result.message
    assert verify(tmp_path / "run").verdict == "certified"
