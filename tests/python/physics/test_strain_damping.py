"""A mass on an elastic bar of cloth, a solid or a rod: how fast its vibration dies out, as the guide to
troubleshooting computes it from the strain damping, whose unit differs between the three."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark

LENGTH, MASS, RATIO = 0.2, 1.0, 0.02  # [m], [kg], of critical damping

Bar = tuple[Any, float]
"""A bar along x from -0.1 to 0.1 m, held at the left, and its stiffness [N/m]."""


def cloth(scene: stark.Scene, relaxation: Callable[[float], float]) -> Bar:
    modulus, thickness, width = 1e6, 1e-3, 0.1
    stiffness = modulus * thickness * width / LENGTH
    law = stark.ShellMaterial(
        density=0.01, thickness=thickness, youngs_modulus=modulus, poissons_ratio=0.0, bending_stiffness=0.0,
        strain_damping=modulus * thickness * relaxation(stiffness),
    )  # fmt: skip
    return scene.add_cloth(stark.mesh.grid(LENGTH, width, cells=(8, 4)), law), stiffness


def solid(scene: stark.Scene, relaxation: Callable[[float], float]) -> Bar:
    modulus, side = 1e5, 0.05
    stiffness = modulus * side**2 / LENGTH
    law = stark.SolidMaterial(
        density=1.0,
        youngs_modulus=modulus,
        poissons_ratio=0.0,
        strain_damping=modulus * relaxation(stiffness),
    )
    return scene.add_solid(stark.mesh.box_hexahedra((LENGTH, side, side), (4, 1, 1)), law), stiffness


def rod(scene: stark.Scene, relaxation: Callable[[float], float]) -> Bar:
    modulus, radius = 1e6, 0.005
    stiffness = modulus * np.pi * radius**2 / LENGTH
    law = stark.RodMaterial(
        density=1.0, youngs_modulus=modulus, radius=radius, strain_damping=relaxation(stiffness)
    )
    return scene.add_rod(stark.mesh.polyline((-0.1, 0, 0), (0.1, 0, 0), segments=8), law), stiffness


@pytest.mark.parametrize("kind", [cloth, solid, rod])
def test_vibrations_die_out_at_the_chosen_ratio(kind: Callable[..., Bar]) -> None:
    """With 400 steps a period, bdf2 adds 1e-6 to the ratio. The bars weigh a two-thousandth of the mass or
    less, and the Green strain differs from the strain by a thousandth."""
    scene = stark.Scene()
    bar, stiffness = kind(scene, lambda stiffness: 2.0 * RATIO / np.sqrt(stiffness / MASS))
    x = bar.vertices.rest_positions[:, 0]
    bar.pin(np.flatnonzero(x < -0.0999))
    weight = scene.add_box(0.05, mass=MASS, position=(0.2, 0, 0))
    rail = scene.add_slider(None, weight, anchor=(0.2, 0, 0), axis="x")
    scene.attach(bar.vertices[np.flatnonzero(x > 0.0999)], weight)
    period = 2.0 * np.pi * np.sqrt(MASS / stiffness)
    still = {"time.integrator": "bdf2", "contact.enabled": False}
    sim = stark.Simulation(scene, still, time_step=period / 400, gravity=(0, 0, 0))
    weight.velocity = (2.0 * np.pi / period * 1e-3 * LENGTH, 0.0, 0.0)
    way = np.array([rail.displacement for _ in sim.run(until=2.0 * period)])
    first, second = way[:300].max(), way[300:].max()
    decrement = np.log(first / second)
    assert decrement / np.hypot(2.0 * np.pi, decrement) == pytest.approx(RATIO, rel=1e-3)
