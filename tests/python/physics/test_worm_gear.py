"""A worm with one thread and its wheel, from meshes that touch in points: ratio, torque, back-driving and
self-locking by the formulas of the inclined plane."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

MODULE, TEETH, RADIUS, PRESSURE = 4e-3, 20, 0.02, 20.0 * stark.deg  # RADIUS of the worm
LEAD = np.pi * MODULE
WHEEL = 0.5 * MODULE * TEETH
PLAY = 1e-4  # [m]
SLOPE = np.arctan(LEAD / (2.0 * np.pi * RADIUS))
Floats = np.ndarray[Any, np.dtype[np.float64]]


def closed(rows: Floats, ring: list[int], ends: Floats) -> stark.TriangleMesh:
    """The surface of rows (m, k, 3) of vertices, each joined to the next one, between fans about two points.
    `ring` are the vertices of a row around, counted on along the rows, which may overlap."""
    rings, size = rows.shape[:2]
    first = np.array(ring)
    triangles = []
    for r in range(rings - 1):
        low, high = first + r * size, first + (r + 1) * size
        for a, b, c, d in zip(low[:-1], low[1:], high[1:], high[:-1], strict=True):
            if max(c, d) < rings * size:
                triangles += [(a, b, c), (a, c, d)]
    mesh = np.array(triangles)
    edges = np.vstack([mesh[:, [0, 1]], mesh[:, [1, 2]], mesh[:, [2, 0]]])
    present = {(int(a), int(b)) for a, b in edges}
    center = rings * size
    open_edges = [(b, a) for a, b in present if (b, a) not in present]
    at_start = {v for v in range(center) if v < center / 2}
    fans = [(center + (a not in at_start), a, b) for a, b in open_edges]
    made = stark.TriangleMesh(np.vstack([rows.reshape(-1, 3), ends]), np.vstack([mesh, fans]))
    return made if made.volume > 0.0 else stark.TriangleMesh(made.vertices, made.triangles[:, ::-1])


def worm(turns: int = 4, segments: int = 48) -> stark.TriangleMesh:
    """About x; its thread is a trapezium."""
    middle = 0.25 * LEAD - 0.5 * PLAY
    crest, root = middle - MODULE * np.tan(PRESSURE), middle + 1.25 * MODULE * np.tan(PRESSURE)
    low, high = RADIUS - 1.25 * MODULE, RADIUS + MODULE
    along = np.array([-root, -0.5 * (root + crest), -crest, crest, 0.5 * (root + crest), root])
    radius = np.array([low, 0.5 * (low + high), high, high, 0.5 * (low + high), low])
    turn = np.arange(turns * segments + 1) / segments
    angle = 2.0 * np.pi * turn[:, None] + 0.0 * along
    x = along + LEAD * (turn[:, None] - 0.5 * turns)
    rows = np.stack([x, radius * np.cos(angle), radius * np.sin(angle)], axis=2)
    ends = np.array([[x[: segments + 1, 0].mean(), 0, 0], [x[-segments - 1 :, -1].mean(), 0, 0]])
    return closed(rows, [*range(len(along)), segments * len(along)], ends)


def wheel(width: float = 0.012) -> stark.TriangleMesh:
    """About y; involute teeth that lean like the thread."""
    base, tip, root = WHEEL * np.cos(PRESSURE), WHEEL + MODULE, WHEEL - 1.25 * MODULE
    radii = np.linspace(base, tip, 4)
    roll = np.arccos(np.minimum(base / radii, 1.0))
    half = 0.5 * np.pi / TEETH - 0.5 * PLAY / WHEEL + np.tan(PRESSURE) - PRESSURE - (np.tan(roll) - roll)
    radius = np.r_[root, radii, radii[::-1], root]
    flank = np.r_[-half[0] - 0.01, -half, half[::-1], half[0] + 0.01]
    around = (2.0 * np.pi * np.arange(TEETH)[:, None] / TEETH + flank).ravel()
    y = np.linspace(-0.5 * width, 0.5 * width, 5)[:, None]
    angle = around + y * np.tan(SLOPE) / WHEEL
    out = np.tile(radius, TEETH)
    rows = np.stack([out * np.sin(angle), y + 0.0 * angle, out * np.cos(angle)], axis=2)
    return closed(rows, [*range(len(out)), 0], np.array([[0, -0.5 * width, 0], [0, 0.5 * width, 0]]))


def pair(friction: float) -> tuple[stark.Scene, Any, Any]:
    """Light parts that carry a load in a few points: the automatic stiffness is too low for them."""
    scene = stark.Scene()
    scene.default_friction = friction
    options = {"contact_distance": 2e-5, "contact_stiffness": 1e7}
    above = (0, 0, RADIUS + WHEEL)
    upright = stark.rotation(axis="x", angle=0.5 * np.pi)
    screw = scene.add_rigid(worm(), mass=0.2, position=above, rotation=upright, name="worm", **options)
    gear = scene.add_rigid(wheel(), mass=0.5, name="wheel", **options)
    drive = scene.add_hinge(None, screw, anchor=above, axis="x")
    return scene, drive, scene.add_hinge(None, gear, anchor=(0, 0, 0), axis="y")


def angle_of_friction(friction: float) -> float:
    return float(np.arctan(friction / np.cos(np.arctan(np.tan(PRESSURE) * np.cos(SLOPE)))))


def test_a_worm_lifts_a_load() -> None:
    scene, drive, driven = pair(0.05)
    load = 1.0
    driven.add_effort(load)
    motor = drive.add_motor(10.0, cap=5.0, delta=0.05)
    sim = stark.Simulation(scene, time_step=2e-3, gravity=(0, 0, 0))
    turns, torques = [], []
    for report in sim.run(until=0.35):
        assert report.rejected_steps == 0
        if report.time > 0.04:
            turns.append((drive.angle, driven.angle))
            torques.append(motor.torque)
    ratio = np.polyfit(*np.transpose(turns)[::-1], 1)[0]
    assert ratio == pytest.approx(-TEETH, rel=0.02)  # half a turn of the worm: facets of 7.5 degrees
    expected = load / WHEEL * RADIUS * np.tan(SLOPE + angle_of_friction(0.05))
    assert np.mean(torques) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("friction", [0.05, 0.12])
def test_friction_decides_whether_the_wheel_drives_the_worm(friction: float) -> None:
    scene, drive, driven = pair(friction)
    driven.add_effort(5.0)
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0))
    sim.run_until(0.06)
    excess = np.tan(SLOPE - angle_of_friction(friction))
    inertia = float(np.asarray(scene["worm"].inertia)[0, 0])
    if excess > 0.0:
        rate = 5.0 / WHEEL * RADIUS * excess / inertia * 0.06
        assert drive.rates["angle"] == pytest.approx(-rate, rel=0.1)
    else:
        before = drive.angle
        sim.run_until(0.3)
        assert abs(drive.angle - before) < 5e-4 and abs(drive.rates["angle"]) < 1e-6
