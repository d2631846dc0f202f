"""Resting contact: the contact forces carry the weight, read from the energy of the barrier and independent
of the momentum balance; the gap at rest lies within the contact distance, for any mesh of the floor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, advance, barrier_force_over_energy, mean_velocity

import stark

_GAP = 2e-3  # sum of the contact distances of two bodies [m]


def floor_of(scene: stark.Scene, cells: int, turn: float) -> None:
    grid = stark.mesh.grid(1.0, 1.0, cells).rotated(stark.rotation(axis="z", angle=turn * stark.deg))
    scene.add_rigid(grid, motion="fixed", name="floor")


def settled_rigid_box(cells: int, turn: float, mass: float = 1.0, **settings: Any) -> tuple[Any, Any]:
    """The body, bound to its simulation, and the report of the last step."""
    scene = stark.Scene()
    floor_of(scene, cells, turn)
    box = scene.add_box(0.1, mass=mass, name="box", position=(0.03, 0.17, 0.05 + _GAP))
    sim = stark.Simulation(scene, time_step=1 / 60, contact_distance=0.5 * _GAP, **settings)
    report = advance(sim, 1.5)[-1]
    return sim[box], report


@pytest.mark.parametrize("mass", [0.01, 1.0, 100.0])
@pytest.mark.parametrize(("cells", "turn"), [(1, 0.0), (7, 20.0), (30, 20.0)])
def test_barrier_carries_the_weight_of_a_rigid_box(mass: float, cells: int, turn: float) -> None:
    box, report = settled_rigid_box(cells, turn, mass)
    assert np.abs(box.velocity).max() < 1e-4
    gap = box.positions[:, 2].min()
    assert 0.0 < gap < _GAP
    assert report.min_distance == pytest.approx(gap, rel=1e-3)
    if cells == 1:
        # All pairs are equally far apart: the energy of the barrier tells their force, whatever their number.
        # The acceleration tolerance of 0.01 m/s^2 is 1e-3 of the weight.
        force = report.energy["contact"] * barrier_force_over_energy(gap, _GAP)
        assert force == pytest.approx(mass * G, rel=2e-3)


def test_weight_is_carried_to_the_residual_that_is_asked_for() -> None:
    settings = {
        "newton.residual_tolerance": 1e-6,
        "newton.acceleration_tolerance": 0.0,
        "newton.step_tolerance": 0.0,
    }
    box, report = settled_rigid_box(1, 0.0, **settings)
    assert report.residual < 1e-6
    gap = box.positions[:, 2].min()
    force = report.energy["contact"] * barrier_force_over_energy(gap, _GAP)
    # Besides the residual, rest itself: a velocity change of 1e-7 m/s in a step is 6e-6 N.
    assert force == pytest.approx(1.0 * G, abs=1e-5)


def test_height_does_not_depend_on_the_mesh_of_the_floor() -> None:
    heights = [settled_rigid_box(cells, 20.0)[0].position[2] for cells in (1, 3, 10, 30)]
    # Every pair has a barrier of its own: more of them share the weight on a finer floor, within the gap.
    assert np.ptp(heights) < 0.1 * _GAP


def test_gap_of_a_light_and_a_heavy_body() -> None:
    """Stiffness of the barrier follows the mass, so that the gap does not."""
    gaps = [settled_rigid_box(1, 0.0, mass)[0].positions[:, 2].min() for mass in (1e-4, 1.0, 1e4)]
    assert gaps == pytest.approx([gaps[1]] * 3, rel=0.01)


def test_a_light_body_keeps_its_distance_under_a_load_of_any_weight() -> None:
    """A tonne on a cube of 10 g: the barrier grows with the load until it is carried at a tenth of
    the contact distance, or a twelfth to an eighth, where it stays. The light cube does not tip or slide."""
    scene = stark.Scene()
    floor_of(scene, 1, 20.0)
    light = scene.add_box(0.1, mass=0.01, name="light", position=(0.03, 0.17, 0.05 + _GAP))
    scene.add_box(0.1, mass=1000.0, name="heavy", position=(0.03, 0.17, 0.15 + 2.0 * _GAP))
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=0.5 * _GAP)
    report = advance(sim, 1.0)[-1]
    assert 0.08 * _GAP < report.min_distance < 0.13 * _GAP
    assert np.abs(sim[light].position[:2] - (0.03, 0.17)).max() < 0.1 * _GAP  # it may slip while both land
    assert np.abs(sim[light].velocity).max() < 1e-5


@pytest.mark.parametrize("cells", [1, 9])
def test_soft_box_rests_on_contact_forces_of_its_weight(cells: int) -> None:
    size, modulus, density = 0.1, 1e5, 1000.0
    scene = stark.Scene()
    floor_of(scene, cells, 20.0)
    box = scene.add_solid(
        stark.mesh.tet_box(size, 3),
        stark.SolidMaterial(density=density, youngs_modulus=modulus, poissons_ratio=0.3, mass_damping=20.0),
        name="box",
        position=(0.03, 0.17, 0.5 * size + _GAP),
    )
    scene.friction["box", "floor"] = 0.0
    sim = stark.Simulation(scene, time_step=1 / 60, contact_distance=0.5 * _GAP)
    report = advance(sim, 1.5)[-1]
    assert np.abs(box.velocities).max() < 1e-4
    assert abs(mean_velocity(box, density)[2]) < 1e-5
    gap = box.positions[:, 2].min()
    assert 0.0 < gap < _GAP
    assert 0.0 < report.min_distance <= gap * (1.0 + 1e-9)
    # It is compressed by its own weight, by rho g L^2 / 2E. Free to slide on the floor, its sides stay free:
    # what is left is that the pressure below is not spread evenly by the few points of contact, 5 % of the
    # mean.
    top = box.mesh.vertices[:, 2] > 0.499 * size
    bottom = box.mesh.vertices[:, 2] < -0.499 * size
    height = box.positions[top, 2].mean() - box.positions[bottom, 2].mean()
    assert size - height == pytest.approx(density * G * size**2 / (2.0 * modulus), rel=0.05)


def test_momentum_balance_gives_the_contact_force_of_a_stack() -> None:
    """The lower one of two boxes carries the weight of both, by its barrier with the floor."""
    scene = stark.Scene()
    floor_of(scene, 1, 0.0)
    scene.add_box(0.1, mass=1.0, name="lower", position=(0.03, 0.27, 0.05 + _GAP))
    # Turned, so that no edges are parallel, and over the middle, so that all pairs stay equally far apart.
    turned = stark.rotation(axis="z", angle=20.0 * stark.deg)
    scene.add_box(0.05, mass=0.5, name="upper", position=(0.03, 0.27, 0.125 + 2.0 * _GAP), rotation=turned)
    sim = stark.Simulation(scene, time_step=1 / 60, contact_distance=0.5 * _GAP)
    report = advance(sim, 1.5)[-1]
    lower, upper = sim["lower"], sim["upper"]
    gap_below = lower.positions[:, 2].min()
    gap_between = upper.positions[:, 2].min() - lower.positions[:, 2].max()
    # One number for two unknown energies: their forces over their energies are known from the gaps, and the
    # weights fix the forces, so the sum of the energies is predicted.
    predicted = 1.5 * G / barrier_force_over_energy(gap_below, _GAP) + 0.5 * G / barrier_force_over_energy(
        gap_between, _GAP
    )
    assert report.energy["contact"] == pytest.approx(predicted, rel=5e-3)
