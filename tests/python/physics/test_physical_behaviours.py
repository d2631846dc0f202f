"""Behaviours that implementations of this method are known to get wrong, each as small as it can be: damping
that does not depend on the time step, signed folds, limits about every axis, crossing rods, order in time."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from _helpers import G, advance

import stark

_WEIGHTLESS = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("step", [1 / 30, 0.01, 0.001])
def test_a_damper_has_the_force_c_v_at_every_time_step(step: float) -> None:
    """1 kg with 2 N s/m: v = (1 + c h/m)^-n by implicit Euler, exp(-c t/m) = 0.670 after 0.2 s in the
    limit."""
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, position=(1, 0, 0), velocity=(1, 0, 0))
    scene.add_spring(None, body, (0, 0, 0), (1, 0, 0), stiffness=0.0, damping=2.0)
    sim = stark.Simulation(scene, time_step=step, gravity=_WEIGHTLESS, **{"contact.enabled": False})
    advance(sim, 0.2)
    count = round(0.2 / step)
    assert body.velocity[0] == pytest.approx((1.0 + 2.0 * step) ** -count, rel=1e-6)
    assert body.velocity[0] == pytest.approx(np.exp(-0.4), abs=0.4 * step)


def ringing_amplitude(damping: float, step: float) -> float:
    """Largest stretch of a rod-like block in the second half of 0.3 s, after a release from 5 %."""
    scene = stark.Scene()
    mesh = stark.mesh.tet_box((0.2, 0.05, 0.05), (4, 1, 1))
    material = stark.SolidMaterial(
        density=1000.0, youngs_modulus=1e4, poissons_ratio=0.3, strain_damping=damping
    )
    pins = mesh.vertices[:, 0] < mesh.vertices[:, 0].min() + 1e-9
    block = scene.add_solid(mesh, material, pins=pins, initial_positions=mesh.vertices * (1.05, 1.0, 1.0))
    end = mesh.vertices[:, 0] > mesh.vertices[:, 0].max() - 1e-9
    settings: dict[str, Any] = {"contact.enabled": False, "time.integrator": "bdf2"}
    sim = stark.Simulation(scene, time_step=step, gravity=_WEIGHTLESS, **settings)
    largest = 0.0
    for report in sim.run(0.3):
        assert not report.failed
        if report.time > 0.15:
            largest = max(largest, abs((block.positions[end] - mesh.vertices[end])[:, 0].mean()))
    return largest


def test_strain_damping_does_not_depend_on_the_time_step() -> None:
    """With the second-order integrator, whose own damping is small: the amplitude that is left, relative to
    that without damping, is the same for a step of a quarter within 10 %."""
    coarse, fine = (ringing_amplitude(200.0, h) / ringing_amplitude(0.0, h) for h in (4e-3, 1e-3))
    assert 0.1 < fine < 0.8
    assert coarse == pytest.approx(fine, rel=0.1)


@pytest.mark.parametrize("rest_angles", ["flat", "mesh"])
def test_bending_damping_acts_on_flat_and_on_folded_cloth(rest_angles: str) -> None:
    """A strip that swings like a leaf spring; nothing but bending damping differs."""
    speeds = []
    for damping in (0.0, 1e-4):
        scene = stark.Scene()
        mesh = stark.mesh.grid(0.1, 0.02, (10, 2))
        material = stark.materials.cotton.replace(
            bending_stiffness=1e-4, bending_damping=damping, mass_damping=0.0, strain_damping=0.0
        )
        strip = scene.add_cloth(mesh, material, pins=mesh.vertices[:, 0] < -0.039, rest_angles=rest_angles)
        sim = stark.Simulation(scene, time_step=1 / 200, **{"contact.enabled": False})
        advance(sim, 0.1)
        speeds.append(np.abs(strip.velocities[:, 2]).max())
    assert speeds[1] < 0.7 * speeds[0]


def folded(angle: float) -> stark.TriangleMesh:
    """Two triangles with a common edge along y, the right one turned up by ``angle`` [rad]."""
    x, z = 0.1 * np.cos(angle), 0.1 * np.sin(angle)
    return stark.TriangleMesh(
        [(-0.1, 0.05, 0), (0, 0, 0), (0, 0.1, 0), (x, 0.05, z)], np.array([[0, 1, 2], [1, 3, 2]])
    )


def test_a_fold_of_the_opposite_sign_is_not_at_rest() -> None:
    """Rest fold +60 degrees, placed at -60: it swings back through the plane to +60."""
    scene = stark.Scene()
    up, down = folded(np.pi / 3), folded(-np.pi / 3)
    material = stark.materials.cotton.replace(bending_stiffness=1e-3, mass_damping=20.0)
    cloth = scene.add_cloth(up, material, rest_angles="mesh", initial_positions=down.vertices, pins=[0, 1, 2])
    sim = stark.Simulation(scene, time_step=1 / 100, gravity=_WEIGHTLESS, **{"contact.enabled": False})
    first = sim.step()
    assert (
        first.energy["elastic"] > 1e-3 * (2 * np.pi / 3) ** 2 / 2
    )  # a good part of k 3 |e|^2/(2 A) dtheta^2
    advance(sim, 3.0)
    assert np.allclose(cloth.positions[3], up.vertices[3], atol=1e-3)


@pytest.mark.parametrize("axis", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
def test_hinge_limits_hold_about_every_axis(axis: tuple[int, int, int]) -> None:
    """A box spins at 5 rad/s into a stop at 20 degrees."""
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, angular_velocity=5.0 * np.array(axis, dtype=float))
    limit = 20 * stark.deg
    hinge = scene.add_hinge(None, box, anchor=(0, 0, 0), axis=axis, limits=(-limit, limit))
    sim = stark.Simulation(scene, time_step=1 / 100, gravity=_WEIGHTLESS, **{"contact.enabled": False})
    reached = 0.0
    for report in sim.run(0.5):
        assert not report.failed
        reached = max(reached, abs(hinge.angle))
    assert 0.9 * limit < reached < limit + 1e-3


def test_angles_are_measured_over_the_whole_half_turn() -> None:
    """A tilt of 170 degrees is 170 degrees, not NaN and not 10."""
    scene = stark.Scene()
    box = scene.add_box(0.1, motion="scripted", angular_velocity=(1.0, 0.0, 0.0))
    tilt = scene.add_tilt(None, box, anchor=(0, 0, 0), axis=(0, 0, 1))
    sim = stark.Simulation(scene, time_step=1 / 100, gravity=_WEIGHTLESS, **{"contact.enabled": False})
    for degrees in (31, 61, 91, 170):
        advance(sim, degrees * stark.deg)
        assert tilt.angle == pytest.approx(degrees * stark.deg, abs=1e-9)


def heights_at_crossings(upper: np.ndarray, lower: np.ndarray) -> list[float]:
    """How far the upper of two polylines (n, 3) is above the lower one wherever they cross, seen along z
    [m]."""
    heights = []
    for (a, b), (c, d) in itertools.product(itertools.pairwise(upper), itertools.pairwise(lower)):
        matrix = np.column_stack([(b - a)[:2], (c - d)[:2]])
        if abs(np.linalg.det(matrix)) < 1e-15:
            continue
        s, t = np.linalg.solve(matrix, (c - a)[:2])
        if 0.0 <= s < 1.0 and 0.0 <= t < 1.0:
            heights.append((a + s * (b - a) - c - t * (d - c))[2])
    return heights


@pytest.mark.parametrize("speed", [1.0, 5.0, 20.0])
def test_rods_do_not_pass_through_each_other(speed: float) -> None:
    """A rubber rod is thrown across a taut steel wire, in steps of 1/30 s: up to 0.67 m a step."""
    scene = stark.Scene()
    rubber = stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=0.005)
    steel = stark.materials.steel_wire.replace(radius=0.005)
    lower = scene.add_rod(stark.mesh.polyline((-0.5, 0, 0), (0.5, 0, 0), 20), steel, clamps=[0, 20])
    upper = scene.add_rod(
        # They cross inside of segments: where a node is right above the wire, rounding decides on which side.
        stark.mesh.polyline((0.02, -0.49, 0.05), (0.02, 0.51, 0.05), 20),
        rubber,
        velocity=(0, 0, -speed),
    )
    sim = stark.Simulation(scene, time_step=1 / 30)
    assert len(heights_at_crossings(upper.positions, lower.positions)) == 1
    touched = False
    while sim.time * speed < 0.15:
        report = sim.step()
        assert not report.failed, report.message
        touched |= report.contact_count > 0
        heights = heights_at_crossings(upper.positions, lower.positions)
        assert heights and min(heights) > 0.0, heights
    assert touched


def fall_error(integrator: str, step: float) -> float:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    settings: dict[str, Any] = {"time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=step, **settings)
    advance(sim, 0.5)
    return abs(box.position[2] + 0.5 * G * 0.25)


def test_free_fall_is_of_first_and_of_second_order() -> None:
    """Implicit Euler is g h t/2 = 82 mm off after 0.5 s of 1/30 s steps; BDF2 a tenth of it, falling with
    h^2."""
    assert fall_error("implicit_euler", 1 / 30) == pytest.approx(G * 0.5 / 60, rel=1e-6)
    coarse, fine = fall_error("bdf2", 1 / 30), fall_error("bdf2", 1 / 60)
    assert coarse < 0.01
    assert fine < 0.3 * coarse


def test_a_cloth_with_a_contact_distance_above_half_its_mesh_is_named_and_still_steps() -> None:
    """Vertices 6.3 mm apart, as fine as its contact distance of 2.5 mm does not allow: the warning says which
    triangle, and a step takes a few iterations, not minutes."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, 32), contact_distance=2.5e-3)
    with pytest.warns(stark.StarkWarning, match="touches itself at rest"):
        sim = stark.Simulation(scene, time_step=1 / 100)
    for _ in range(3):
        report = sim.step()
        assert not report.failed
        assert report.newton_iterations <= 20
    # It drops as a whole: what its parts push each other stays below a hundredth of its fall in the height.
    height = cloth.positions[:, 2]
    assert height.mean() == pytest.approx(-G * 1e-4 * 6, rel=1e-2)
