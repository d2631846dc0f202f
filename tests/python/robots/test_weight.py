"""Efforts that carry the weight of a robot are slopes of its potential energy, in whatever frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import GRAVITY, Floats, random_urdf

import stark
from stark.robots import kinematics
from stark.robots.kinematics import Placement
from stark.robots.weight import Weight

STEP = 1e-6  # of finite differences [rad, m]


@pytest.mark.parametrize("seed", range(3))
def test_efforts_are_slopes_of_the_potential_energy(seed: int, tmp_path: Path) -> None:
    file = tmp_path / "tree.urdf"
    file.write_text(random_urdf(seed))
    robot = stark.robots.read(file)
    q = np.random.default_rng(seed).uniform(-1.0, 1.0, len(robot.coordinates))

    def energy(q: Floats) -> float:
        frames = kinematics.placements(robot, q)
        return -sum(
            link.inertia.mass * GRAVITY @ frames[name].at(link.inertia.center, np.eye(3)).position
            for name, link in robot.links.items()
            if link.inertia is not None
        )

    slopes = [(energy(q + STEP * e) - energy(q - STEP * e)) / (2.0 * STEP) for e in np.eye(len(q))]
    efforts = Weight(robot).efforts_at(kinematics.placements(robot, q), GRAVITY)
    np.testing.assert_allclose(efforts, slopes, atol=1e-7 * np.abs(slopes).max())


def test_frames_that_move_with_links_do_as_well(tmp_path: Path) -> None:
    file = tmp_path / "tree.urdf"
    file.write_text(random_urdf(3))
    robot = stark.robots.read(file)
    random = np.random.default_rng(3)
    frames = kinematics.placements(robot, random.uniform(-1.0, 1.0, len(robot.coordinates)))
    offsets = {
        name: Placement(random.normal(size=3), stark.rotation(axis=random.normal(size=3), angle=0.7))
        for name in robot.links
    }
    turned = {name: frames[name].rotation @ offsets[name].rotation.T for name in robot.links}
    positions = [frames[name].position - turned[name] @ offsets[name].position for name in robot.links]
    efforts = Weight(robot, offsets).efforts(np.array(positions), np.array(list(turned.values())), GRAVITY)
    np.testing.assert_allclose(efforts, Weight(robot).efforts_at(frames, GRAVITY), atol=1e-12)
