"""The cases in PyBullet: steps of 1/240 s, as its guide recommends, with 50 and 200 iterations of its solver
and without damping of the velocity. Friction of a pair is the product of two coefficients there, so that of
the floor is 1."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet as p
from cases import (
    ABOVE,
    BELOW,
    FRICTION,
    PILE_TIME,
    SLIDE,
    SPIN,
    SPIN_MASS,
    SPIN_SIZE,
    SPIN_TIME,
    leaning,
    of_incline,
    of_pile,
    of_spin,
    pile,
    timed,
)

STEP = 1.0 / 240.0


def world(gravity: tuple[float, float, float], iterations: int) -> None:
    p.resetSimulation()
    p.setGravity(*gravity)
    p.setPhysicsEngineParameter(fixedTimeStep=STEP, numSolverIterations=iterations)
    floor = p.createMultiBody(0.0, p.createCollisionShape(p.GEOM_PLANE))
    p.changeDynamics(floor, -1, lateralFriction=1.0)


def box(size: Any, mass: float, place: Any, yaw: float = 0.0) -> int:
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.5 * s for s in size])
    body = int(p.createMultiBody(mass, shape, -1, list(place), p.getQuaternionFromEuler([0.0, 0.0, yaw])))
    p.changeDynamics(body, -1, lateralFriction=FRICTION, linearDamping=0.0, angularDamping=0.0)
    return body


def incline(iterations: int, share: float) -> dict[str, float]:
    world(leaning(share), iterations)
    body = box((0.1,) * 3, 1.0, (0.0, 0.0, 0.05))
    look = lambda: p.getBasePositionAndOrientation(body)[0][0]  # noqa: E731
    cpu, seen = timed(p.stepSimulation, round(SLIDE / STEP), look)
    return {"cpu_s": cpu / SLIDE} | of_incline(np.array(seen), STEP, share)


def matrix(body: int) -> np.ndarray:
    return np.array(p.getMatrixFromQuaternion(p.getBasePositionAndOrientation(body)[1])).reshape(3, 3)


def free_spin(iterations: int) -> dict[str, float]:
    world((0.0, 0.0, 0.0), iterations)
    body = box(SPIN_SIZE, SPIN_MASS, (0.0, 0.0, 5.0))
    p.resetBaseVelocity(body, [0.0, 0.0, 0.0], list(SPIN))
    cpu, _ = timed(p.stepSimulation, round(SPIN_TIME / STEP))
    return {"cpu_s": cpu / SPIN_TIME} | of_spin(matrix(body), np.array(p.getBaseVelocity(body)[1]))


def rigid_pile_27(iterations: int) -> dict[str, float]:
    world((0.0, 0.0, -9.81), iterations)
    bodies = [box((0.1,) * 3, 1.0, place, yaw) for place, yaw in pile()]
    cpu, _ = timed(p.stepSimulation, round(PILE_TIME / STEP))
    places = np.array([p.getBasePositionAndOrientation(body)[0] for body in bodies])
    return {"cpu_s": cpu / PILE_TIME} | of_pile(places, np.array([matrix(body) for body in bodies]))


def run(case: str) -> list[dict[str, Any]]:
    """Rows of a case; none of the soft cube, whose soft bodies it does not tune to a modulus."""
    if case == "soft_cube":
        return []
    jobs: dict[str, Any] = {"free_spin": free_spin, "rigid_pile_27": rigid_pile_27}
    jobs["incline_below"] = lambda iterations: incline(iterations, BELOW)
    jobs["incline_above"] = lambda iterations: incline(iterations, ABOVE)
    counts = (50,) if case == "free_spin" else (50, 200)
    return [{"settings": f"steps of 1/240 s, {count} iterations"} | jobs[case](count) for count in counts]


p.connect(p.DIRECT)
VERSION = "PyBullet 3.2.7"
