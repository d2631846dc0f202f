"""Energies written in Python: physics against closed forms, mixtures of bodies, determinism, resuming."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from _scenes import NO_GRAVITY, anchor, cloth_masses, sheet, sheet_and_box, spring, tie

import stark

H = 1.0 / 100.0


@stark.energy
def magnet(p: stark.Point, center: stark.Vec3, strength: float = stark.parameter(1e-3, unit="J m", min=0.0)):
    """Attraction towards a moving centre."""
    return -strength / stark.norm(p.x - center)


def test_energies_are_pickled_by_name() -> None:
    """As functions are: what another process gets finds them in their module."""
    assert pickle.loads(pickle.dumps(magnet)) is magnet

    @stark.energy
    def inner(p: stark.Point) -> stark.symbolic.Real:
        return p.x[2]

    with pytest.raises((pickle.PicklingError, AttributeError), match="inner"):
        pickle.dumps(inner)


def test_an_energy_that_is_bound_and_not_added_is_said() -> None:
    scene, cloth = sheet()
    used = magnet(cloth.vertices, center=(0, 0, 1))
    scene.add(used)
    magnet(cloth.vertices, center=(0, 0, 1)).check()
    magnet.benchmark(cloth.vertices, center=(0, 0, 1))
    other = stark.Scene()
    magnet(other.add_sphere(0.1, mass=1.0).vertices, center=(0, 0, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Simulation(scene)
    forgotten = magnet(cloth.vertices[:3], center=(0, 0, 1))
    with pytest.warns(
        stark.StarkWarning, match="energy magnet on 3 elements was bound and not added"
    ) as told:
        stark.Simulation(scene)
    assert told[0].filename == __file__ and len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Simulation(scene)  # once
    scene.add(forgotten)
    with pytest.warns(stark.StarkWarning, match=r"magnet on .* write scene\.add"):
        stark.Simulation(other)


def test_forces_of_a_magnet_are_those_of_the_closed_form() -> None:
    scene, cloth = sheet()
    center = np.array([0.0, 0.1, 0.3])
    pull = scene.add(magnet(cloth.vertices, center=center, strength=2e-3))
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    d = center - cloth.positions
    r = np.linalg.norm(d, axis=1, keepdims=True)
    np.testing.assert_allclose(pull.energies, -2e-3 / r[:, 0], rtol=1e-13)
    np.testing.assert_allclose(pull.forces[:, 0], 2e-3 * d / r**3, rtol=1e-12)
    assert pull.energy == pytest.approx(pull.energies.sum())


def test_an_implicit_step_of_a_spring_pendulum_is_the_root_of_its_equation() -> None:
    # A rigid box far from everything, hung by its centre: m (x - x0) / h^2 = m g - k (x - a).
    scene = stark.Scene()
    box = scene.add_box(size=0.1, position=(0.3, 0.0, 0.0), mass=0.5, name="box")
    scene.add(anchor(box.points((0.0, 0.0, 0.0)), target=(0.0, 0.0, 0.4), stiffness=30.0))
    sim = stark.Simulation(scene, time_step=H, **{"newton.residual_tolerance": 1e-12})
    sim.step()
    m, k, g = 0.5, 30.0, np.array([0.0, 0.0, -9.81])
    x0, a = np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.0, 0.4])
    expected = (m / H**2 * x0 + m * g + k * a) / (m / H**2 + k)
    # A residual of 1e-12 N over m / h^2 = 5000 N/m is far below the rounding of the positions.
    np.testing.assert_allclose(box.position, expected, rtol=0.0, atol=1e-14)


def test_a_chain_of_springs_hangs_as_its_closed_form_says() -> None:
    # n equal masses on n springs below a fixed point: spring i carries the weight of those below it.
    scene = stark.Scene()
    n, mass, k, length = 4, 0.1, 200.0, 0.2
    boxes = [
        scene.add_box(size=0.02, position=(0.0, 0.0, -length * (i + 1)), mass=mass, linear_damping=20.0)
        for i in range(n)
    ]
    centers = [box.points((0.0, 0.0, 0.0)) for box in boxes]
    above = [stark.world_points((0.0, 0.0, 0.0)), *centers[:-1]]
    for a, b in zip(above, centers, strict=True):

        @stark.energy
        def link(s: stark.Stencil[2], k: float, rest: float):
            return 0.5 * k * (stark.norm(s[1].x - s[0].x) - rest) ** 2

        scene.add(link((a, b), k=k, rest=length))
    sim = stark.Simulation(scene, time_step=0.05, **{"newton.residual_tolerance": 1e-9})
    sim.run_until(20.0)
    heights = np.array([box.position[2] for box in boxes])
    stretches = mass * 9.81 * np.arange(n, 0, -1) / k
    # The motion decays like exp(-t / 2 s) or faster: what is left after 20 s is below a micrometre.
    np.testing.assert_allclose(heights, -np.cumsum(length + stretches), rtol=0.0, atol=1e-6)


def test_energies_between_cloth_and_rigid_body_conserve_momentum() -> None:
    # Free vertices without mass damping: nothing but the ties and internal forces acts.
    scene, cloth, box = sheet_and_box(material=stark.materials.cotton.replace(mass_damping=0.0))
    corners = box.points([[0.04, 0.04, 0.04], [-0.04, -0.04, 0.04]])
    ties = scene.add(tie(cloth.vertices[[6, 18]], corners, stiffness=3.0))
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY, **{"newton.residual_tolerance": 1e-10})
    masses = cloth_masses(cloth)
    largest = 0.0
    for _ in range(10):
        sim.step()
        p_box = box.mass * box.velocity
        p_cloth = (masses[:, None] * cloth.velocities).sum(axis=0)
        largest = max(largest, float(np.abs(p_box).max()))
        # Ten steps with residuals of 1e-10 N on 26 blocks, times h, are 2e-10 N s.
        np.testing.assert_allclose(p_box + p_cloth, 0.0, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(ties.forces.sum(axis=1), 0.0, atol=1e-15)
    assert largest > 1e-3


def test_time_time_step_and_velocities() -> None:
    @stark.energy
    def drag(p: stark.Point, c: float, t: stark.Time, h: stark.TimeStep):
        # Rayleigh's dissipation as an incremental potential; its force is -c t v.
        return 0.5 * c * t * h * (p.v @ p.v)

    scene, cloth = sheet(2, velocity=(1.0, 0.0, 0.0))
    pull = scene.add(drag(cloth.vertices, c=1e-3))
    sim = stark.Simulation(scene, time_step=H, **NO_GRAVITY)
    for step in (1, 2):
        sim.step()
        np.testing.assert_allclose(
            pull.forces[:, 0], -1e-3 * step * H * cloth.velocities, rtol=1e-9, atol=1e-18
        )


def test_rest_and_initial_positions() -> None:
    @stark.energy
    def places(p: stark.Point):
        return p.x @ (p.X + 10.0 * p.x0)

    scene, cloth = sheet(2, position=(0.0, 0.0, 1.0))
    e = scene.add(places(cloth.vertices))
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    X = cloth.mesh.vertices
    np.testing.assert_allclose(
        e.forces[:, 0], -(X + 10.0 * (X + np.array([0.0, 0.0, 1.0]))), rtol=1e-14, atol=1e-14
    )


def test_shared_and_per_element_values_give_the_same_bits() -> None:
    results = []
    for stiffness in (20.0, np.full(56, 20.0)):
        scene, cloth = sheet(4)
        assert len(cloth.edges) == 56
        scene.add(spring(cloth.edges, stiffness=stiffness))
        scene.add(anchor(cloth.vertices[0], target=(0.0, 0.0, 0.2)))
        sim = stark.Simulation(scene, time_step=H)
        sim.run_until(0.05)
        results.append(cloth.positions)
    np.testing.assert_array_equal(*results)


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    hashes = []
    for threads in (1, 2, 3):
        scene, cloth, box = sheet_and_box(12)
        scene.add(spring(cloth.edges, stiffness=np.linspace(1.0, 9.0, len(cloth.edges))))
        scene.add(tie(cloth.vertices, box.points((0.0, 0.0, 0.04)), stiffness=0.05))
        settings = {"threads": threads, "execution.oversubscribe": True}
        sim = stark.Simulation(scene, time_step=H, **settings)
        sim.run_until(0.1)
        hashes.append(sim._core.state_hash)
    assert len(set(hashes)) == 1


def test_a_new_simulation_goes_on_from_a_state_with_the_same_bits() -> None:
    def make() -> tuple[stark.Simulation, stark.Energy]:
        scene, cloth = sheet(6)
        return (pull := scene.add(magnet(cloth.vertices, center=(0.0, 0.0, 0.3)))) and (
            stark.Simulation(scene, time_step=H),
            pull,
        )

    first, pull = make()
    first.run_until(0.05)
    pull.center = (0.1, 0.0, 0.3)
    saved = first.state
    first.run_until(0.1)
    second, pull = make()
    pull.center = (0.1, 0.0, 0.3)
    second.state = saved
    second.run_until(0.1)
    assert first._core.state_hash == second._core.state_hash


def test_formulas_compose() -> None:
    @stark.energy
    def twice(e: stark.Edge, stiffness: float):
        return spring(e, stiffness) + spring(e, stiffness)

    scene, cloth = sheet(2)
    edges = cloth.edges
    one, two = scene.add(spring(edges, stiffness=4.0)), scene.add(twice(edges, stiffness=2.0))
    scene.add(anchor(cloth.vertices[0], target=(0.0, 0.0, 1.0)))
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    np.testing.assert_allclose(one.forces, two.forces, rtol=1e-13, atol=1e-16)


def test_stencils_of_several_bodies_and_of_index_arrays() -> None:
    @stark.energy
    def spread(s: stark.Stencil[3]):
        center = (s[0].x + s[1].x + s[2].x) / 3.0
        return sum(stark.squared_norm(p.x - center) for p in s)

    scene, cloth, box = sheet_and_box()
    mixed = scene.add(spread((cloth.vertices[:2], box.points((0.0, 0.0, 0.04)), (0.0, 0.0, 0.5))))
    plain = scene.add(spread(stark.stencils(cloth, [[0, 1, 2], [3, 4, 5]])))
    assert (mixed.element_count, plain.element_count) == (2, 2)
    sim = stark.Simulation(scene, time_step=H)
    sim.step()
    x, p = cloth.positions[:2], box.position + box.rotation @ [0.0, 0.0, 0.04]
    points = np.stack([x, [p, p], [[0.0, 0.0, 0.5]] * 2], axis=1)
    center = points.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(mixed.forces, -2.0 * (points - center), rtol=1e-12)


def test_an_energy_of_eight_points() -> None:
    @stark.energy
    def lump(s: stark.Stencil[8], k: float):
        center = sum((p.x for p in s.points[1:]), s[0].x) / 8.0
        return 0.5 * k * sum(stark.squared_norm(p.x - center) for p in s)

    scene, cloth = sheet(2)
    e = scene.add(lump(stark.stencils(cloth, [range(8)]), k=1.0))
    sim = stark.Simulation(scene, time_step=H)
    assert not sim.step().failed
    x = cloth.positions[:8]
    np.testing.assert_allclose(e.forces[0], x.mean(axis=0) - x, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("definition", ["annotations as text", "plain"])
def test_annotations_may_be_text(definition: str) -> None:
    k = 2.0
    source = "from __future__ import annotations\n" if definition != "plain" else ""
    source += "@stark.energy\ndef f(p: stark.Point, k: float = 1.0):\n    return k * (p.x @ p.x)\n"
    names: dict = {"stark": stark}
    exec(source, names)
    scene, cloth = sheet(2)
    assert scene.add(names["f"](cloth.vertices, k=k)).k == k


@pytest.mark.alone
def test_definition_to_first_solve_is_fast() -> None:
    """The aim is 50 ms, and a few milliseconds are usual; the bound leaves room for a loaded machine."""
    scene, cloth = sheet(2)
    best = float("inf")
    for _ in range(5):
        begin = time.perf_counter()

        @stark.energy
        def bend(h: stark.Hinge, k: float = stark.parameter(1e-3, unit="J")):
            return 0.5 * k * (h.angle - h.rest_angle) ** 2 * h.rest_weight

        scene.add(bend(cloth.hinges))
        stark.Simulation(scene, time_step=H).step()
        best = min(best, time.perf_counter() - begin)
    assert best < 0.25


def test_no_compiler_is_needed(tmp_path: Path) -> None:
    """In a process whose PATH has no programs at all."""
    script = """
import shutil, stark
assert not any(shutil.which(tool) for tool in ("gcc", "g++", "cc", "c++", "clang", "clang++", "as", "ld"))
@stark.energy
def spring(e: stark.Edge, k: float):
    return 0.5 * k * (e.length - e.rest_length) ** 2
scene = stark.Scene()
cloth = scene.add_cloth(stark.mesh.grid(0.4, 0.4, cells=2))
e = scene.add(spring(cloth.edges, k=5.0))
assert not stark.Simulation(scene, time_step=0.01).step().failed
print("done", spring.statistics.backend)
"""
    file = tmp_path / "no_compiler.py"
    file.write_text(script)
    root = Path(stark.__file__).resolve().parents[1]
    done = subprocess.run(
        [sys.executable, str(file)],
        env={"PATH": str(tmp_path), "PYTHONPATH": str(root), "HOME": os.environ.get("HOME", "")},
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("done")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["no_compiler.py"]  # and nothing was written


def test_a_vertex_may_be_in_an_element_twice() -> None:
    """A quadratic energy takes one Newton iteration; with half of the stiffness between both places it took
    70."""

    @stark.energy
    def bend(s: stark.Stencil[3], k: float = 50.0):
        d = s[0].x - 2.0 * s[1].x + s[2].x
        return 0.5 * k * (d @ d)

    scene = stark.Scene()
    limp = stark.ShellMaterial(density=1.0, youngs_modulus=1e-6, bending_stiffness=0.0)
    mesh = stark.mesh.grid(0.1, 0.1, cells=1)
    sheet = scene.add_cloth(mesh, limp, self_contact=False)
    scene.add(bend(stark.stencils(sheet, [[0, 1, 0]])))
    h = 0.01
    sim = stark.Simulation(scene, time_step=h, gravity=(0, 0, 0))
    report = sim.step()
    assert report.newton_iterations == 1

    # d = 2 (x0 - x1): a spring of stiffness 4 k between two lumped masses, one step of implicit Euler.
    corners = mesh.vertices[mesh.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    mass = np.zeros(4)
    np.add.at(mass, mesh.triangles, areas[:, None] / 3.0)
    system = np.diag(mass[:2]) / h**2 + 200.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    expected = np.linalg.solve(system, mass[:2, None] / h**2 * mesh.vertices[:2])
    np.testing.assert_allclose(sheet.positions[:2], expected, atol=1e-8)
