"""A strip of two metals that is heated: it bends to an arc, and nothing touches."""

from __future__ import annotations

import numpy as np
import pytest

import stark


def test_a_bimetal_strip_bends_to_its_arc() -> None:
    """Curvature 3/2 (a_1 - a_2) dT / h of two layers of equal thickness and modulus; Timoshenko, Analysis of
    bi-metal thermostats (1925)."""
    length, height, warmer = 0.1, 0.002, 100.0
    mesh = stark.mesh.to_quadratic(stark.mesh.box_hexahedra((length, 0.005, height), (20, 1, 2)))
    upper = mesh.vertices[mesh.elements].mean(axis=1)[:, 2] > 0.0
    metal = stark.SolidMaterial(
        density=7800,
        youngs_modulus=2e11,
        poissons_ratio=0.0,
        thermal_expansion=np.where(upper, 24e-6, 12e-6),
    )
    scene = stark.Scene()
    strip = scene.add_solid(mesh, metal)
    x, y, z = mesh.vertices.T
    clamped = abs(x - x.min()) < 1e-9
    scene.add_rollers(strip.vertices[clamped], "x")
    scene.add_rollers(strip.vertices[abs(y - y.min()) < 1e-9], "y")
    scene.add_rollers(strip.vertices[clamped & (abs(z) < 1e-9)], "z")
    strip.temperature = 0.0
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), **{"time.integrator": "quasistatic"})
    assert not sim.step().caveats  # edges that graze each other by rounding had friction that never settled
    strip.temperature = warmer
    assert not sim.step().failed
    curvature = 1.5 * 12e-6 * warmer / height
    tip = strip.positions[abs(x - x.max()) < 1e-9][:, 2].mean()
    assert tip == pytest.approx((np.cos(curvature * length) - 1.0) / curvature, rel=1e-3)


def test_what_comes_too_late_says_what_to_do() -> None:
    scene = stark.Scene()
    metal = stark.SolidMaterial(density=7800, youngs_modulus=1e9, poissons_ratio=0.3, thermal_expansion=1e-5)
    strip = scene.add_solid(stark.mesh.tet_box(0.1, 1), metal, name="strip")
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.warns(stark.StarkWarning, match="assign temperature once before you create"):
        strip.temperature = 10.0
    assert sim.time == 0.0
