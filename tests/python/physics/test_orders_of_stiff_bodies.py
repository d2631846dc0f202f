"""Order of BDF2 for stiff bodies that are driven smoothly: rods and plates that curl, a box at the end of a
rod. Steps are longer than the periods of their stiffest modes. Orders are those of the largest differences,
over four instants, of runs with steps h, h/2 and h/4: at one instant the error may change its sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _validation import validate

import stark

UNTIL, PARTS = 0.24, 4  # [s]
STEPS = (0.002, 0.001, 0.0005)  # [s]
Observed = Callable[[], np.ndarray]


def rise(t: float) -> float:
    """From 0 to 1 in the run, with three derivatives that are zero at the start."""
    return float(np.sin(0.5 * np.pi * t / UNTIL) ** 4)


def rod(scene: stark.Scene, youngs_modulus: float) -> Any:
    material = stark.RodMaterial(density=1000.0, youngs_modulus=youngs_modulus, radius=0.005)
    line = stark.mesh.polyline((0, 0, 0), (0.5, 0, 0), 8)
    return scene.add_rod(line, material, clamps=[0], self_contact=False)


def rod_curls(scene: stark.Scene) -> Observed:
    body = rod(scene, 1e9)
    body.natural_curvature = lambda t: (2.0 * rise(t), 0.7 * rise(t))  # [1/m]
    return lambda: np.concatenate([body.positions, body.frames[:, :, 2]])


def plate_curls(scene: stark.Scene) -> Observed:
    mesh = stark.mesh.grid(0.5, 0.5 / 3, cells=(6, 2))
    material = stark.ShellMaterial(
        density=5.0,
        thickness=0.005,
        youngs_modulus=1e8,
        poissons_ratio=0.3,
        flexural_rigidity=1e8 * 0.005**3 / 12,
    )
    clamp = np.flatnonzero(mesh.vertices[:, 0] < -0.16)
    body = scene.add_cloth(mesh, material, pins=clamp, self_contact=False)
    body.natural_curvature = lambda t: 2.0 * rise(t)
    return lambda: body.positions


def rod_with_box(scene: stark.Scene) -> Observed:
    body = rod(scene, 1e8)
    box = scene.add_box(0.05, mass=0.1, position=(0.53, 0, 0))
    scene.disable_contact(body, box)
    scene.add_fixed(body.frame(8), box)
    push = scene.add_force(box, (0, 0, 0))
    push.force = lambda t: (0.0, 2.5 * rise(t), 5.0 * rise(t))  # [N]
    return lambda: np.concatenate([body.positions, [box.position], box.rotation])


def run(build: Callable[[stark.Scene], Observed], step: float) -> np.ndarray:
    scene = stark.Scene()
    observe = build(scene)
    settings: dict[str, Any] = {"time.integrator": "bdf2", "newton.acceleration_tolerance": 1e-5}
    joints = {"joints.length_tolerance": 1e-10, "joints.angle_tolerance": 1e-10}
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings, **joints)
    seen = []
    for part in range(PARTS):
        for report in sim.run(until=UNTIL * (part + 1) / PARTS):
            assert report.status == "accepted", report.message
        seen.append(observe().ravel())
    return np.concatenate(seen)


@pytest.mark.parametrize("build", [rod_curls, plate_curls, rod_with_box])
def test_bdf2_has_its_order_for_stiff_bodies(build: Callable[[stark.Scene], Observed]) -> None:
    first, second, third = (run(build, step) for step in STEPS)
    order = np.log2(abs(first - second).max() / abs(second - third).max())
    validate(f"time.stiff_{build.__name__}", order)
