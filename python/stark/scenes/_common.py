"""What several packaged scenes share: comparison settings, observables, and the parametrised scenes
themselves."""

from __future__ import annotations

from typing import Any

import numpy as np

import stark

#: The step of the comparison scenes [s].
BENCH_STEP = 1.0 / 30.0


def bench_settings(contact_distance: float | None = None, **more: Any) -> dict[str, Any]:
    """Settings of the comparison: implicit Euler at 1/30 s; a step ends as soon as the residual is below
    1e-6 N s (over the step: 3e-5 N) or the largest velocity correction is below 1e-3 m/s.
    Friction is lagged: refreshed once in a step, as by what it is compared with. ``contact_distance`` per
    body [m]."""
    settings: dict[str, Any] = {
        "time_step": BENCH_STEP,
        "newton.termination": "any",
        "newton.acceleration_tolerance": 0.0,
        "newton.residual_tolerance": 1e-6 / BENCH_STEP,
        "newton.step_tolerance": 1e-3,
        "contact.friction_updates": 1,
    }
    if contact_distance is not None:
        settings["contact_distance"] = contact_distance
    return {**settings, **more}


def bench_cotton() -> stark.ShellMaterial:
    """Cotton with the strain limit as published, without hardening, and without damping of the bending of
    flat sheets, which has no effect there."""
    return stark.materials.cotton.replace(strain_limit_hardening=0.0, bending_damping=0.0)


def heights(positions: np.ndarray) -> dict[str, float]:
    """Lowest, mean and highest z [m] of points (n, 3)."""
    z = np.asarray(positions)[:, 2]
    return {"z_min": float(z.min()), "z_mean": float(z.mean()), "z_max": float(z.max())}


def spinning_box(cells: int, friction: float = 0.0) -> stark.Scene:
    """A cotton cloth of 0.4 m lies on a scripted cube of 0.08 m. Without friction it slides off in the end:
    the pose of equilibrium is unstable, and 3 mm beside it grow to a fall within 7 s."""
    scene = stark.Scene()
    scene.default_friction = friction
    scene.add_cloth(stark.mesh.grid(0.4, 0.4, cells=cells), bench_cotton(), name="cloth")
    scene.add_box(0.08, name="box", position=(0.0, 0.0, -0.08), motion="scripted")
    return scene


def turn_box(sim: Any) -> None:
    """Turns the box by 90 deg/s about z: sets its pose for the end of the coming step."""
    angle = 90.0 * stark.deg * (sim.time + sim.time_step)
    sim["box"].rotation = stark.rotation(axis="z", angle=angle)


def spinning_box_observables(sim: Any) -> dict[str, float]:
    points = sim["cloth"].positions
    return {**heights(points), "radius_max": float(np.hypot(points[:, 0], points[:, 1]).max())}


def no_nans(run: Any, name: str) -> np.ndarray:
    """Final positions of a body of a recording, after the check that they are finite."""
    positions: np.ndarray = run.positions(name, -1)
    assert np.isfinite(positions).all(), f"{name} has positions that are not finite"
    return positions
