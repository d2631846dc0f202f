"""Planes of symmetry of rods: they hold the slope of the node that lies in them, which rollers leave free."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

STILL: dict[str, Any] = {
    "gravity": (0, 0, 0),
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-9,
}
CANE = stark.RodMaterial(density=500.0, youngs_modulus=1e9, radius=1e-3)
EI = CANE.section["bending_stiffness_1"]


@pytest.mark.parametrize("axis", ["x", "y"])
def test_half_of_a_beam_bends_as_the_whole(axis: str) -> None:
    """F L^3 / (48 E I) of a beam on two supports, half of it with half of the load."""
    length, load, segments = 1.0, 1e-6, 20
    way = np.eye(3)["xy".index(axis)]
    scene = stark.Scene()
    beam = scene.add_rod(np.linspace(-length / 2 * way, 0.0 * way, segments + 1), CANE, pins=[0])
    scene.add_symmetry(beam.vertices[[segments]], axis, name="middle")
    scene.add_rollers(beam.vertices, "y" if axis == "x" else "x")
    scene.add_force(beam.vertices[[segments]], (0.0, 0.0, -load / 2))
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    assert beam.positions[-1, 2] == pytest.approx(-load * length**3 / (48 * EI), rel=2e-3)
    assert [energy.name for energy in scene.energies][:2] == ["middle", "middle slopes"]


def squeezed(segments: int) -> tuple[float, float]:
    """A ring between two forces F, a quarter of it: how much less high and how much wider it is, over
    F R^3 / (E I)."""
    radius, load = 0.1, 1e-4
    angle = np.linspace(0.0, np.pi / 2, segments + 1)
    places = radius * np.column_stack((np.cos(angle), 0.0 * angle, np.sin(angle)))
    scene = stark.Scene()
    ring = scene.add_rod(places, CANE)
    scene.add_symmetry(ring.vertices[[0]], "z")
    scene.add_symmetry(ring.vertices[[segments]], "x")
    scene.add_symmetry(ring.vertices, "y")  # the plane that it lies in
    scene.add_force(ring.vertices[[segments]], (0.0, 0.0, -load / 2))
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    unit = load * radius**3 / EI
    return 2.0 * (radius - ring.positions[-1, 2]) / unit, 2.0 * (ring.positions[0, 0] - radius) / unit


def test_a_quarter_of_a_ring_is_squeezed_as_the_whole() -> None:
    coarse, fine = (np.array(squeezed(segments)) for segments in (15, 30))
    found = (4.0 * fine - coarse) / 3.0
    assert found == pytest.approx([np.pi / 4 - 2 / np.pi, 2 / np.pi - 1 / 2], rel=3e-3)
