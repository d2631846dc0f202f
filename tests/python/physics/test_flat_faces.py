"""Flat faces of rigid bodies with vertices inside: the torque of friction is that of an even pressure."""

from __future__ import annotations

import numpy as np
import pytest

import stark

_MU, _MASS, _G, _SIDE, _RADIUS = 0.3, 0.2, 9.81, 0.1, 0.05


def lever(mesh: stark.TriangleMesh) -> float:
    """Torque of friction on what spins on a floor, over mu m g: the mean distance from the axis [m]."""
    scene = stark.Scene()
    scene.default_friction = _MU
    scene.add_floor(2.0)
    body = scene.add_rigid(mesh, mass=_MASS, position=(0, 0, 0.0056), angular_velocity=(0.0, 0.0, 20.0))
    sim = stark.Simulation(scene, time_step=0.005, contact_distance=3e-4)
    sim.run_until(0.025)
    start = body.angular_velocity[2]
    sim.run_until(0.125)
    slowing = (start - body.angular_velocity[2]) / 0.1
    return float(slowing * np.asarray(body.inertia)[2, 2] / (_MU * _MASS * _G))


# Mean distance from the centre of a square over its side: (sqrt(2) + ln(1 + sqrt(2))) / 6.
_SQUARE = (np.sqrt(2.0) + np.arcsinh(1.0)) / 6.0


@pytest.mark.parametrize(("cells", "error"), [(2, 0.12), (4, 0.04), (8, 0.012), (16, 0.004)])
def test_a_spinning_plate_meets_the_torque_of_an_even_pressure(cells: int, error: float) -> None:
    found = lever(stark.mesh.box((_SIDE, _SIDE, 0.01), cells)) / (_SQUARE * _SIDE)
    assert 1.0 <= found < 1.0 + error


def test_so_does_a_disc() -> None:
    found = lever(stark.mesh.cylinder(_RADIUS, 0.01, 64))
    assert found == pytest.approx(2.0 / 3.0 * _RADIUS, rel=2e-3)


def test_corners_carry_a_plate_without_vertices_inside() -> None:
    """As docs/friction.md says: 1.85 times the torque of an even pressure."""
    found = lever(stark.mesh.box((_SIDE, _SIDE, 0.01)))
    assert found == pytest.approx(np.sqrt(0.5) * _SIDE, rel=2e-3)


def test_faces_that_are_flat_to_a_nanometre_are_as_flat_ones() -> None:
    mesh = stark.mesh.box((_SIDE, _SIDE, 0.01), 4)
    moved = np.asarray(mesh.vertices) + 1e-9 * np.random.default_rng(0).uniform(
        -1, 1, (len(mesh.vertices), 3)
    )
    assert lever(stark.mesh.TriangleMesh(moved, mesh.triangles)) == pytest.approx(lever(mesh), rel=0.01)
