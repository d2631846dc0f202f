"""Tape that is peeled off at different angles, held by an adhesive energy."""

from __future__ import annotations

import numpy as np
from physics._validation import validate

import stark

LENGTH, WIDTH, PEELED = 0.06, 0.004, 0.009  # [m]; the arm that is free at the start
TOUGHNESS, REACH = 10.0, 6e-4  # [J/m^2], [m] at which the adhesive pulls most
SPEED = 0.02  # [m/s] of the line at which it comes off


@stark.energy
def adhesive(
    p: stark.Point,
    place: stark.Vec3,
    area: float = stark.parameter(unit="m^2", above=0.0),
):
    d = p.x - place
    return TOUGHNESS * area * (1 - stark.exp(-(d @ d) / (2 * REACH**2)))


def work_of_peeling(angle: float) -> float:
    """Of the force at the end of the tape, for an area that it comes off [J/m^2]."""
    sheet = stark.mesh.grid(LENGTH, WIDTH, cells=(60, 4))
    X, line = sheet.vertices, PEELED - 0.5 * LENGTH
    ahead = np.maximum(line - X[:, 0], 0.0)  # along the arm
    pull = np.array([-np.cos(angle), 0.0, np.sin(angle)])
    start = np.where((ahead > 0.0)[:, None], [line, 0.0, 0.0] + X * [0, 1, 0] + ahead[:, None] * pull, X)
    tape = stark.ShellMaterial(
        density=0.1,
        thickness=1e-4,
        youngs_modulus=1e8,
        poissons_ratio=0.0,
        bending_stiffness=0.0,
        flexural_rigidity=2e-6,
        mass_damping=5.0,
    )
    scene = stark.Scene()
    strip = scene.add_cloth(
        sheet, tape, initial_positions=start, self_contact=False, pins=X[:, 0] < -0.4999 * LENGTH
    )
    edges = X[sheet.triangles[:, 1:]] - X[sheet.triangles[:, :1]]
    areas = np.bincount(
        sheet.triangles.ravel(), np.repeat(np.linalg.norm(np.cross(*edges.swapaxes(0, 1)), axis=1) / 6.0, 3)
    )
    stuck = ahead == 0.0
    scene.add(adhesive(strip.vertices[stuck], place=X[stuck], area=areas[stuck]))
    way = pull + np.array([1.0, 0.0, 0.0])  # the arm grows as much as the line goes on
    strip.follow(displacement=lambda t: SPEED * t * way)
    sim = stark.Simulation(scene, time_step=0.004, gravity=(0, 0, 0))
    forces = [strip.pin_forces.sum(axis=0) for _ in sim.run(until=1.0)]
    return float(np.mean(forces[len(forces) // 2 :], axis=0) @ way) / WIDTH


def test_peeling_takes_the_toughness_at_any_angle() -> None:
    """F (1 - cos angle) / b = G for a tape that does not stretch [Rivlin 1944]; its stretch keeps a part
    F^2 / (2 b^2 E t) of it [Kendall 1975], 0.02 J/m^2 at 60 degrees."""
    angles = np.radians([60.0, 90.0, 120.0, 150.0])
    validate("peeling.work", [work_of_peeling(angle) for angle in angles])
