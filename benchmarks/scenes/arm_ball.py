"""An arm of seven joints with a gripper squeezes a soft ball, lifts it and carries it aside; steps of 10 ms.

Needs the extra ``robots``. The arm is benchmarks/scenes/arm_ball.urdf. Servos with gravity compensation
follow a path of the hand, the fingers close with a given force; friction holds the ball.

    stark bench benchmarks/scenes/arm_ball.py [--option subdivisions=1] --rule scene
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import stark

until: float = 1.5  # [s]
options: dict[str, Any] = {"subdivisions": 2}  # of the ball: 1,467 unknowns with it
ARM = [f"joint{k}" for k in range(1, 8)]
STIFFNESS, DAMPING = (3e3, 3e3, 2e3, 2e3, 1e3, 600.0, 200.0), (60.0, 60.0, 40.0, 40.0, 15.0, 8.0, 3.0)
RADIUS, FRICTION, GRIP = 0.03, 0.8, 8.0  # of the ball [m], [1], of both fingers together [N]
BALL = stark.SolidMaterial(density=600.0, youngs_modulus=2e4, poissons_ratio=0.4, strain_damping=40.0)
OPEN, CLOSING, RING = 0.04, 0.1, (0.016, 0.004)  # of a finger [m], [m/s], that the ball lies on, radii [m]
#: Where the grip is when [s]: at the ball, lifted, carried aside [m].
TIMES = (0.0, 0.5, 0.9, 1.3)
PLACES = ((0.45, 0.0, 0.12), (0.45, 0.0, 0.12), (0.45, 0.0, 0.27), (0.40, 0.20, 0.27))
CLOSES = 0.05  # [s]
DOWN = np.diag([1.0, -1.0, -1.0])
knots: dict[str, np.ndarray] = {}  # times (k,) and q of the arm (k, 7)


def settings() -> dict[str, object]:
    return {"time_step": 0.01, "contact_distance": 0.0005, "contact.stick_velocity": 5e-4}


def build() -> stark.Scene:
    scene = stark.Scene()
    scene.default_friction = FRICTION
    scene.add_floor(2.0)
    file = Path(__file__).with_suffix(".urdf")
    knots["times"], knots["q"] = path_of_joints(stark.Scene().add_robot(file))
    start = dict(zip(ARM, knots["q"][0], strict=True)) | {"left_slide": OPEN}
    robot = scene.add_robot(file, q=start, self_contact=False)
    robot.add_servos(ARM, stiffness=STIFFNESS, damping=DAMPING, gravity_compensation=True)
    robot.add_servos("left_slide", stiffness=4000.0, damping=40.0, cap=GRIP)
    ball = stark.mesh.tet_ball(RADIUS, options["subdivisions"])
    scene.add_solid(ball, BALL, name="ball", position=PLACES[0])
    # It lies on a ring: on a plane a ball of triangles would tip over to the next one, and roll away.
    top = PLACES[0][2] - np.sqrt((RADIUS + RING[1] + 0.0005) ** 2 - RING[0] ** 2)
    scene.add_rigid(
        stark.mesh.torus(*RING), name="ring", motion="fixed", position=(*PLACES[0][:2], float(top))
    )
    return scene


def path_of_joints(robot: stark.robots.Robot) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and q of the arm (k, 7) that lead the grip along smooth straight lines, pointing down."""
    q = np.array([0.0, 0.7, 0.0, 1.9, 0.0, 0.54, 0.0, 0.0])  # elbow up, hand down
    times, rows = [], []
    for t0, t1, p0, p1 in zip(TIMES[:-1], TIMES[1:], PLACES[:-1], PLACES[1:], strict=True):
        for s in np.linspace(0.0, 1.0, 9):
            place = np.asarray(p0) + s * s * (3.0 - 2.0 * s) * (np.asarray(p1) - np.asarray(p0))
            q = robot.inverse_kinematics("grip", place, DOWN, joints=ARM, start=q).q
            times.append(t0 + s * (t1 - t0))
            rows.append(q[:7])
    return np.array(times), np.array(rows)


def drive(sim: Any) -> None:
    (robot,) = sim.robots
    arm, fingers = robot.drives
    time = sim.time + sim.time_step
    arm.target = [np.interp(time, knots["times"], column) for column in knots["q"].T]
    fingers.target = max(0.0, OPEN - CLOSING * max(0.0, time - CLOSES))


def observables(sim: Any) -> dict[str, float]:
    """Place of the ball and in the grip [m], normal forces of the fingers and what they carry, weight [N]."""
    (robot,) = sim.robots
    ball, grip = sim["ball"], robot.links["grip"]
    middle = ball.positions.mean(axis=0)
    slipped = grip.rotation.T @ (middle - grip.position)
    forces = [sim.contacts.of("ball", f"arm.{side}_finger").forces.sum(axis=0) for side in ("left", "right")]
    normals = [abs(float(force @ grip.rotation[:, 1])) for force in forces]
    return {
        **dict(zip(("ball_x", "ball_y", "ball_z"), map(float, middle), strict=True)),
        "slip": float(np.linalg.norm(slipped)),
        "grip_left": normals[0],
        "grip_right": normals[1],
        "carried": float(sum(force[2] for force in forces)),
        "weight": 9.81 * float(ball.mass),
        "path_error": float(np.abs(robot.q[:7] - knots["q"][-1]).max()),
    }
