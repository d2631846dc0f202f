"""Robots in documents: their handles come back, gravity compensation included."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _everything import everything

import stark
from stark.document import DocumentError


def test_the_handle_comes_back(tmp_path: Path) -> None:
    scene = everything()
    again = stark.load_scene(scene.save(tmp_path / "a.json"))
    before, after = scene.robots[0], again.robots[0]
    assert after.name == "robot" and after.coordinates == before.coordinates == ("lift", "slide")
    assert list(after.links) == list(before.links) and str(after.report) == str(before.report)
    assert [body.name for body in after.bodies] == [body.name for body in before.bodies]
    assert after.q.tobytes() == before.q.tobytes()
    assert [d.gravity_compensation for d in after.drives] == [True, False]
    assert len(again.joints) == len(scene.joints)  # nothing is added twice
    assert again.robots[0].links["tool"].pose[0].tobytes() == scene.robots[0].links["tool"].pose[0].tobytes()


def test_it_carries_its_weight_as_before(tmp_path: Path) -> None:
    scene = everything()
    again = stark.load_scene(scene.save(tmp_path / "a.json"))
    sims = [stark.Simulation(each, time_step=0.01) for each in (scene, again)]
    for sim in sims:
        for _ in range(2):
            assert not sim.step().failed
    one, other = (sim.robots[0] for sim in sims)
    assert one.gravity_efforts().tobytes() == other.gravity_efforts().tobytes()
    assert one.drives[0].feedforward.tobytes() == other.drives[0].feedforward.tobytes()
    assert np.abs(one.drives[0].feedforward).max() > 0.01


def _robot(given: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = given["robots"][0]
    return found


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda row: row["links"][1].update(body=0), "body must be a rigid one"),
        (lambda row: row["joints"][0].update(number=99), "joint 99"),
        (lambda row: row["joints"][0].update(number=None), "joints that move"),
        (lambda row: row["joints"][0].update(parent="none"), "parent = 'none'"),
        (lambda row: row["joints"][1].update(mimic={"joint": "bend"}), "mimics itself"),
        (lambda row: row.update(start=[0.0]), "start: must have 2 numbers"),
        (lambda row: row["drives"][0].update(actuators=[0]), "must be of the kind 'position_servo'"),
        (lambda row: row["drives"][0].update(rows=[7]), "an actuator of the scene and a shift"),
        (lambda row: row["drives"][1].update(gravity_compensation=True), "servos"),
        (lambda row: row.update(excluded=[["base"]]), "excluded ones pairs"),
    ],
)
def test_what_does_not_fit_is_refused(change: Any, text: str, tmp_path: Path) -> None:
    path = everything().save(tmp_path / "a.json")
    given = json.loads(path.read_text())
    change(_robot(given))
    path.write_text(json.dumps(given))
    with pytest.raises(DocumentError, match=text):
        stark.load_scene(path)


def test_names_are_unique(tmp_path: Path) -> None:
    path = everything().save(tmp_path / "a.json")
    given = json.loads(path.read_text())
    given["robots"] *= 2
    path.write_text(json.dumps(given))
    with pytest.raises(DocumentError, match="two robots 'robot'"):
        stark.load_scene(path)


def test_drives_along_knots_are_saved(tmp_path: Path) -> None:
    """Motions of all joints, by joint, and of efforts below their limits: the refusal of functions names
    these as its remedy."""
    base, tool = stark.robots.Link("base"), stark.robots.Inertia(1.0, np.array([0.1, 0, 0]), 0.01 * np.eye(3))
    links = [base, stark.robots.Link("arm", tool), stark.robots.Link("hand", tool)]
    ends = [("lift", "base", "arm", 1.5), ("turn", "arm", "hand", 0.7)]
    joints = [
        stark.robots.RobotJoint(name, "revolute", a, b, axis=np.array([0.0, 1.0, 0.0]), lower=-3.0, upper=3.0,
                                effort=effort)
        for name, a, b, effort in ends
    ]  # fmt: skip
    scene = stark.Scene()
    description = stark.robots.RobotDescription("two", links, joints)
    robot = scene.add_robot(description, q=[0.2, -0.3])
    servos = robot.add_servos(stiffness=50.0, damping=2.0, cap=20.0)
    path = stark.motion.spline([0.0, 0.1, 0.2], [(0.2, -0.3), (0.4, 0.1), (0.3, 0.0)])
    servos.target = path
    servos.target_rate = {"turn": stark.motion.linear([0.0, 0.2], [0.0, 0.5])}
    efforts = robot.add_efforts(target=stark.motion.linear([0.0, 0.2], [0.0, 0.6]))
    again = stark.load_scene(scene.save(tmp_path / "a.json"))
    sims = [stark.Simulation(each, time_step=0.01) for each in (scene, again)]
    for sim in sims:
        sim.run_until(0.15)
    assert sims[0].state == sims[1].state
    np.testing.assert_allclose(servos.target, path(0.15), atol=1e-12)
    efforts.target = stark.motion.linear([0.0, 0.2], [0.0, 1.0])  # cut at 0.7 N m: straight no more
    with pytest.raises(DocumentError, match="sample_functions"):
        scene.save(tmp_path / "b.json")
    sims[0].run_until(0.2)
    assert efforts.target[1] == 0.7 and efforts.target[0] == pytest.approx(1.0)
