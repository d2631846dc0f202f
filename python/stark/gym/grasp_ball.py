"""Grasping a soft ball with a gripper of two fingers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

import stark

from .env import SceneEnv
from .task import Task

Floats = NDArray[np.float64]

#: Radius of the ball [m] and of the shells in it.
RADIUS, SHELLS = 0.03, (0.4, 0.75, 1.0)
#: Fingers: size [m], mass [kg], gap between them when open [m].
FINGER, FINGER_MASS, OPENING = (0.012, 0.03, 0.07), 0.05, 0.10
#: Height of the middle of the fingers above the table at the start [m], and where the hand may go.
HEIGHT, REACH, LOW, HIGH = 0.12, 0.15, 0.038, 0.25
FINGERS = ("left", "right")
#: Largest speed of the hand [m/s], of a finger [m/s] and its force [N].
SPEED, CLOSING, FORCE = 0.2, 0.1, 4.0
#: The goal: height of the middle of the ball above where it rests [m].
LIFT = 0.06


def ball_mesh() -> stark.TetMesh:
    """The ball, coarse."""
    return stark.mesh.tet_ball(RADIUS, 1, SHELLS)


class GraspBallTask(Task):
    """A soft ball lies on a table, below an open gripper; it is to be grasped and lifted."""

    name: str = "grasp_ball"
    action_space: Box = Box(-1.0, 1.0, (4,), np.float32)
    observation_space: Box = Box(-10.0, 10.0, (18,), np.float32)
    control_step: float = 0.05
    until: float = 5.0
    settle: float = 1.5

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene = stark.Scene("grasp_ball")
        scene.default_friction = 0.8
        table = scene.add_box(
            (0.6, 0.6, 0.04), name="table", motion="fixed", position=(0, 0, -0.02), color=(0.62, 0.64, 0.68)
        )
        foam = stark.materials.soft_rubber.replace(density=300.0, youngs_modulus=3e4, poissons_ratio=0.4)
        scene.add_solid(
            ball_mesh(), foam, name="ball", position=(0, 0, RADIUS + 0.001), self_contact=False,
            color=(0.20, 0.62, 0.62),
        )  # fmt: skip
        hand = scene.add_box(
            (0.14, 0.03, 0.02), name="hand", motion="scripted", color=(0.88, 0.89, 0.90),
            position=(0, 0, HEIGHT + 0.5 * FINGER[2] + 0.012),
        )  # fmt: skip
        for name, side in zip(FINGERS, (-1.0, 1.0), strict=True):
            place = (0.5 * side * (OPENING + FINGER[0]), 0.0, HEIGHT)
            finger = scene.add_box(
                FINGER, name=name, mass=FINGER_MASS, position=place, color=(0.28, 0.30, 0.34)
            )
            slider = scene.add_slider(
                hand, finger, anchor=place, axis=(-side, 0, 0), name=f"slide_{name}", limits=(-0.005, 0.045)
            )
            slider.add_motor(0.0, cap=FORCE, delta=0.02, name=f"motor_{name}")
            scene.disable_contact(finger, table)
        scene.disable_contact(hand, table)
        return scene, {"time_step": 0.01, "contact_distance": 0.001, "newton.step_tolerance": 1e-3}

    def start(self, sim: Any, random: np.random.Generator) -> None:
        """The ball up to 3 cm from below the hand."""
        shift = np.array([*random.uniform(-0.03, 0.03, 2), 0.0])
        sim["ball"].positions = sim["ball"].positions + shift

    def act(self, sim: Any, action: Floats) -> None:
        """Moves the hand at the first three numbers times 0.2 m/s; drives the fingers at the fourth times
        0.1 m/s, 1 closes."""
        hand = sim["hand"]
        offset = 0.5 * FINGER[2] + 0.012
        goal = hand.position + SPEED * action[:3] * sim.time_step
        hand.position = np.clip(goal, (-REACH, -REACH, LOW + offset), (REACH, REACH, HIGH + offset))
        for actuator in sim.actuators:
            if actuator.kind == "velocity_motor":
                actuator.target = CLOSING * action[3]

    def observe(self, sim: Any) -> Floats:
        ball, hand = sim["ball"], sim["hand"].position
        x, v = ball.positions.mean(axis=0), ball.velocities.mean(axis=0)
        slides = [joint.displacement for joint in sim.joints]
        rates = [joint.rates["displacement"] for joint in sim.joints]
        grips = [np.linalg.norm(sim.contacts.of("ball", name).forces.sum(axis=0)) for name in FINGERS]
        return np.concatenate([hand, x, v, x - hand, slides, rates, grips])

    def reward(self, sim: Any, action: Floats) -> float:
        """Height of the ball over 6 cm, minus the distance [m] of the middle of the fingers to the ball, 1
        more at the goal."""
        lifted, distance = self._measures(sim)
        return min(lifted, LIFT) / LIFT - distance + float(lifted >= LIFT)

    def done(self, sim: Any) -> bool:
        return self._measures(sim)[0] >= LIFT

    def info(self, sim: Any) -> dict[str, Any]:
        lifted, distance = self._measures(sim)
        return {"lifted": lifted, "distance": distance}

    def _measures(self, sim: Any) -> tuple[float, float]:
        """Height over where it rests, distance between fingers and ball [m]."""
        x = sim["ball"].positions.mean(axis=0)
        between = sim["hand"].position - (0.0, 0.0, 0.5 * FINGER[2] + 0.012)
        return float(x[2] - RADIUS), float(np.linalg.norm(x - between))


class GraspBall(SceneEnv):
    """A soft ball of 6 cm lies on a table below an open gripper of two fingers; grasp it and lift it by 6 cm.

    Action (4,) in [-1, 1]: velocity of the hand along x, y, z, 1 is 0.2 m/s, and of both fingers, 1 closes at
    0.1 m/s with at most 4 N each. The hand stays within 15 cm of the middle and above the table.

    Observation (18,): hand (3) [m], middle of the ball (3) [m], its velocity (3) [m/s], from the hand to the
    ball (3) [m], how far the fingers are closed (2) [m], their rates (2) [m/s], contact forces of the fingers
    on the ball (2) [N].

    Reward: height of the ball over 6 cm (at most 1), minus the distance of the ball to the middle between the
    fingers [m], and 1 at the goal, where the episode ends.

    Start: the ball up to 3 cm in x and y from below the hand. An action every 50 ms, at most 100."""

    def __init__(
        self,
        *,
        settings: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        size: tuple[int, int] = (480, 360),
    ) -> None:
        view = {"camera": (0.25, -0.45, 0.28), "target": (0.0, 0.0, 0.07)}
        super().__init__(GraspBallTask(), settings=settings, render_mode=render_mode, size=size, picture=view)
