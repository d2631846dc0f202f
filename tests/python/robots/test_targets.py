"""Values for joints of a robot: numbers, by joint, over time; what they leave alone, what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from robots.test_drives import arm

import stark
from stark.robots.targets import by_joint, spread

pytest.importorskip("yourdfpy")
JOINTS = ["shoulder", "elbow"]


def test_values_are_for_all_for_each_or_by_joint() -> None:
    assert by_joint(2.0, JOINTS, "x") == {0: 2.0, 1: 2.0} and by_joint([1, 3], JOINTS, "x") == {
        0: 1.0,
        1: 3.0,
    }
    assert by_joint({"elbow": 4}, JOINTS, "x") == {1: 4.0}
    assert spread(1.5, 2, "x", JOINTS).tolist() == [1.5, 1.5]
    calls = []

    def both(time: float) -> list[float]:
        calls.append(time)
        return [time, 2.0 * time]

    over_time = by_joint(both, JOINTS, "x")
    calls.clear()
    assert [value(0.5) for value in over_time.values() if callable(value)] == [0.5, 1.0] and calls == [0.5]
    with pytest.raises(
        stark.InvalidArgument, match=r"x\['elbw'\] \(did you mean 'elbow'\?\): must be one of"
    ):
        by_joint({"elbw": 1.0}, JOINTS, "x")
    with pytest.raises(stark.InvalidArgument, match=r"x\['elbow'\] = nan: must be finite"):
        by_joint({"elbow": np.nan}, JOINTS, "x")
    with pytest.raises(
        stark.InvalidArgument, match=r"x at 0 s has the shape \(3,\): must be a number or \(2,"
    ):
        by_joint(lambda t: [t, t, t], JOINTS, "x")


def test_targets_by_joint_leave_the_others() -> None:
    scene, robot = arm()
    servos = robot.add_servos(JOINTS, stiffness=900.0, damping=60.0, target={"elbow": 1.2})
    np.testing.assert_allclose(servos.target, [0.7, 1.2])
    sim = stark.Simulation(scene, time_step=0.01)
    servos.target = {"shoulder": 0.5}
    np.testing.assert_allclose(servos.target, [0.5, 1.2])
    with pytest.raises(stark.InvalidArgument, match=r"servos: target\['elbw'\]"):
        servos.target = {"shoulder": 0.1, "elbw": 1.0}
    servos.target = {"elbow": lambda t: 1.2 - t}
    sim.run_until(0.1)
    np.testing.assert_allclose(servos.target, [0.5, 1.1])
    servos.target = {"shoulder": 0.6}  # the elbow goes on along its function
    sim.run_until(0.2)
    np.testing.assert_allclose(servos.target, [0.6, 1.0])


def test_targets_over_time_are_those_of_the_end_of_each_step() -> None:
    scene, robot = arm()
    servos = robot.add_servos(JOINTS, stiffness=900.0, damping=60.0, target=lambda t: [0.7 + t, 1.0 - t])
    efforts = robot.add_efforts("left_slide", target=lambda t: 1e3 * t)
    sim = stark.Simulation(scene, time_step=0.01)
    for report in sim.run(until=0.1):
        np.testing.assert_allclose(servos.target, [0.7 + report.time, 1.0 - report.time], atol=1e-14)
        assert efforts.effort == pytest.approx(min(1e3 * report.time, 20.0))  # cut at the limit of the file
    servos.target = [0.8, 0.9]
    sim.run_until(0.12)
    np.testing.assert_allclose(servos.target, [0.8, 0.9])


def test_a_target_beyond_the_limits_of_its_joint_warns_once() -> None:
    _, robot = arm()
    servos = robot.add_servos(JOINTS, stiffness=900.0, damping=60.0)
    upper = robot.limits[1][robot.coordinates.index("elbow")]
    servos.target = {"elbow": float(upper)}
    with pytest.warns(stark.StarkWarning, match=r"target of 'elbow' = 9 is beyond its limits") as found:
        servos.target = {"elbow": 9.0}
        servos.target = {"elbow": 9.5}
    assert len(found) == 1 and found[0].filename == __file__
