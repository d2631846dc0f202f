"""The cases in Stark: default settings, a time step for each kind of motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from benchmarks.peers import cases

import stark
import stark.scenes


def incline(share: float) -> dict[str, Any]:
    step = 0.01
    scene = stark.Scene()
    scene.default_friction = cases.FRICTION
    scene.add_box((10.0, 1.0, 0.1), position=(4.0, 0.0, -0.05), motion="fixed", name="floor")
    box = scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, 0.05 + 2e-4))
    gravity = cases.leaning(share)
    sim = stark.Simulation(scene, time_step=step, gravity=gravity, contact_distance=1e-4, threads=1)
    count = round(cases.SLIDE / step)
    cpu, seen = cases.timed(sim.step, count, lambda: float(box.position[0]))
    found = cases.of_incline(np.array(seen), step, share)
    return {"settings": "steps of 10 ms", "cpu_s": cpu / cases.SLIDE} | found


def free_spin() -> dict[str, Any]:
    step = 0.01
    scene = stark.Scene()
    box = scene.add_box(cases.SPIN_SIZE, mass=cases.SPIN_MASS, angular_velocity=cases.SPIN)
    sim = stark.Simulation(scene, time_step=step, gravity=(0.0, 0.0, 0.0), threads=1)
    cpu, _ = cases.timed(sim.step, round(cases.SPIN_TIME / step))
    found = cases.of_spin(np.asarray(box.rotation), np.asarray(box.angular_velocity))
    return {"settings": "steps of 10 ms", "cpu_s": cpu / cases.SPIN_TIME} | found


def rigid_pile_27(contact_distance: float = 1e-3, frequency: int = 30) -> dict[str, Any]:
    """With the contact distance [m] of each body, and so many steps a second."""
    file = stark.scenes.load("rigid_pile_27")
    scene, settings = file.build()
    settings |= {"contact_distance": contact_distance, "time_step": 1.0 / frequency}
    sim = stark.Simulation(scene, **settings, threads=1)
    cpu, _ = cases.timed(sim.step, round(cases.PILE_TIME * frequency))
    cubes = [body for body in sim.bodies if body.name != "floor"]
    places, turns = (
        np.array([np.asarray(getattr(b, key)) for b in cubes]) for key in ("position", "rotation")
    )
    found = cases.of_pile(places, turns)
    words = f"contact distance {1e3 * contact_distance:g} mm, steps of 1/{frequency} s"
    return {"settings": words, "cpu_s": cpu / cases.PILE_TIME} | found


def soft_cube(mesh: Any, words: str) -> dict[str, Any]:
    step = 0.01
    scene = stark.Scene()
    scene.default_friction = cases.FRICTION
    scene.add_floor(2.0)
    law = stark.SolidMaterial(
        density=cases.DENSITY, youngs_modulus=cases.YOUNG, poissons_ratio=cases.POISSON, strain_damping=500.0
    )
    body = scene.add_solid(mesh, law, position=(0.0, 0.0, 0.5 * cases.CUBE + 1e-3))
    sim = stark.Simulation(scene, time_step=step, contact_distance=5e-4, threads=1)
    cpu, _ = cases.timed(sim.step, round(cases.SETTLE / step))
    z = mesh.vertices[:, 2]
    top, foot = (np.abs(z - side * 0.5 * cases.CUBE) < 1e-9 for side in (1, -1))
    height = float(body.positions[top, 2].mean() - body.positions[foot, 2].mean())
    words = f"{words}, {3 * len(z):,} unknowns, steps of 10 ms"
    return {"settings": words, "cpu_s": cpu / cases.SETTLE} | cases.of_cube(height)


def soft_cubes() -> list[dict[str, Any]]:
    """Tetrahedra as many as the flex has nodes, few hexahedra, and what all are compared with."""
    size = cases.CUBE
    meshes = {
        "linear tetrahedra": stark.mesh.tet_box(size, cells=cases.CELLS),
        "linear tetrahedra, 2 x 2 x 2 cells": stark.mesh.tet_box(size, cells=2),
        "quadratic hexahedra, 2 x 2 x 2": stark.mesh.to_quadratic(stark.mesh.box_hexahedra(size, 2)),
        "quadratic hexahedra, 5 x 5 x 5, the reference": stark.mesh.to_quadratic(
            stark.mesh.box_hexahedra(size, 5)
        ),
    }
    return [soft_cube(mesh, words) for words, mesh in meshes.items()]


def run(case: str) -> list[dict[str, Any]]:
    """Rows of a case."""
    if case.startswith("incline"):
        return [incline(cases.BELOW if case.endswith("below") else cases.ABOVE)]
    if case == "soft_cube":
        return soft_cubes()
    if case == "rigid_pile_27":
        return [rigid_pile_27(), rigid_pile_27(1e-4), rigid_pile_27(2e-5, 60)]
    return [free_spin()]


VERSION = f"Stark {stark.__version__}"
