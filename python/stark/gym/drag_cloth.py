"""Dragging a cloth to a target."""

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

#: Edge of the cloth [m] and its cells, mass per area of cotton.
SIZE, CELLS = 0.2, 12
#: Largest speed of the hand [m/s], where it may go: x and y within, z from, to [m].
SPEED, REACH, LOW, HIGH = 0.3, 0.5, 0.004, 0.15
#: The goal: distance of the middle of the cloth to the target [m].
NEAR = 0.02


class DragClothTask(Task):
    """A cotton cloth of 0.2 m lies on a table; a hand holds one of its corners and drags it, so that its
    middle comes to a target."""

    name: str = "drag_cloth"
    action_space: Box = Box(-1.0, 1.0, (3,), np.float32)
    observation_space: Box = Box(-2.0, 2.0, (23,), np.float32)
    control_step: float = 0.05
    until: float = 5.0
    settle: float = 0.1

    def __init__(self) -> None:
        self.target: Floats = np.zeros(2)

    def build(self) -> tuple[Any, dict[str, Any]]:
        scene = stark.Scene("drag_cloth")
        scene.default_friction = 0.3
        table = scene.add_box(
            (1.6, 1.6, 0.04), name="table", motion="fixed", position=(0, 0, -0.02), color=(0.62, 0.64, 0.68)
        )
        cloth = scene.add_cloth(
            stark.mesh.grid(SIZE, SIZE, CELLS), stark.materials.cotton, name="cloth",
            position=(0, 0, 0.003), pins=[0, 1, CELLS + 1], color=(0.80, 0.36, 0.30),
        )  # fmt: skip
        mark = scene.add_cylinder(
            NEAR, 0.001, name="target", motion="scripted", position=(0, 0, 0.001), color=(0.20, 0.62, 0.62)
        )
        scene.disable_contact(mark, cloth)
        scene.disable_contact(mark, table)
        return scene, {"time_step": 1 / 60, "contact_distance": 0.002, "newton.step_tolerance": 3e-3}

    def start(self, sim: Any, random: np.random.Generator) -> None:
        """The cloth turned by any angle and shifted by up to 5 cm, the target 15 to 30 cm from its middle."""
        cloth = sim["cloth"]
        turn = stark.rotation(axis="z", angle=random.uniform(-np.pi, np.pi))
        shift = np.array([*random.uniform(-0.05, 0.05, 2), 0.0])
        cloth.positions = cloth.positions @ turn.T + shift
        angle, distance = random.uniform(-np.pi, np.pi), random.uniform(0.15, 0.30)
        self.target = shift[:2] + distance * np.array([np.cos(angle), np.sin(angle)])
        sim["target"].position = (*self.target, 0.001)

    def act(self, sim: Any, action: Floats) -> None:
        """Moves the corner at action times 0.3 m/s, within the space above the table."""
        cloth = sim["cloth"]
        targets = cloth.pin_targets
        hand = targets[0]
        goal = hand + SPEED * action * sim.time_step
        goal = np.clip(goal, (-REACH, -REACH, LOW), (REACH, REACH, HIGH))
        cloth.pin_targets = targets + (goal - hand)

    def observe(self, sim: Any) -> Floats:
        cloth = sim["cloth"]
        x, v = cloth.positions, cloth.velocities
        corners = x[[0, CELLS, CELLS * (CELLS + 1), (CELLS + 1) ** 2 - 1]]
        middle = x.mean(axis=0)
        return np.concatenate([x[0], middle, v.mean(axis=0), corners.reshape(-1), self.target - middle[:2]])

    def reward(self, sim: Any, action: Floats) -> float:
        """Minus the distance [m] of the middle of the cloth to the target, 1 more where it is near."""
        distance = self.distance(sim)
        return -distance + float(distance < NEAR)

    def done(self, sim: Any) -> bool:
        return self.distance(sim) < NEAR

    def info(self, sim: Any) -> dict[str, Any]:
        return {"distance": self.distance(sim)}

    def distance(self, sim: Any) -> float:
        """Of the middle of the cloth to the target, seen from above [m]."""
        return float(np.linalg.norm(sim["cloth"].positions.mean(axis=0)[:2] - self.target))


class DragCloth(SceneEnv):
    """A cotton cloth of 0.2 m lies on a table; drag it by a corner until its middle is within 2 cm of a
    target.

    Action (3,) in [-1, 1]: velocity of the corner along x, y, z, 1 is 0.3 m/s. It stays within 0.5 m of the
    middle of the table and 4 mm to 15 cm above it.

    Observation (23,): corner that is held (3) [m], middle of the cloth (3) [m], its velocity (3) [m/s], the
    four corners (12) [m], from the middle to the target along x and y (2) [m].

    Reward: minus the distance of the middle to the target [m], and 1 at the goal, where the episode ends.

    Start: the cloth turned by any angle and shifted by up to 5 cm, the target 15 to 30 cm away. An action
    every 50 ms, at most 100."""

    def __init__(
        self,
        *,
        settings: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        size: tuple[int, int] = (480, 360),
    ) -> None:
        view = {"camera": (0.35, -0.55, 0.5), "target": (0.0, 0.0, 0.0), "opacity": {"cloth": 0.75}}
        super().__init__(DragClothTask(), settings=settings, render_mode=render_mode, size=size, picture=view)
