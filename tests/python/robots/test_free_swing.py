"""An arm with seven joints falls from rest as mujoco has it fall."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark

mujoco = pytest.importorskip("mujoco")
UNTIL = 2.0  # [s]
_AXES = ("0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
_MASSES = (2.4, 2.3, 2.1, 1.9, 1.6, 1.4, 0.6)
_START = (0.3, 1.1, -0.4, -1.3, 0.5, 0.9, 0.2)


def arm(in_a_row: bool) -> str:
    """As long and heavy as a collaborative arm; centres of mass off the axes; some damping and armature.
    ``in_a_row``: the last two joints are those of one body."""
    text = more = ""
    for k in reversed(range(7)):
        if in_a_row and k == 6:
            more = f'<joint name="joint_6" axis="{_AXES[6]}"/>'
            continue
        moments = " ".join(str(moment / (k + 1)) for moment in (0.02, 0.021, 0.008))
        place = f"{0.02 * (k % 2)} 0 {0.17 if k else 0.1}"
        text = (
            f'<body name="link_{k}" pos="{place}" euler="{5 * k} 0 {-7 * k}">'
            f'<joint name="joint_{k}" axis="{_AXES[k]}"/>{more}<inertial pos="0.02 {0.015 * (-1) ** k} 0.09" '
            f'mass="{_MASSES[k]}" fullinertia="{moments} 0.0005 0 0.0004"/>'
            f"{text}</body>"
        )
        more = ""
    return (
        '<mujoco model="arm"><default><joint damping="0.4" armature="0.05"/></default>'
        f"<worldbody>{text}</worldbody></mujoco>"
    )


def swing_of_mujoco(file: Path, times: np.ndarray) -> np.ndarray:
    """q (t, 7) by Runge-Kutta with steps that change nothing any more."""
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 1e-4
    data = mujoco.MjData(model)
    data.qpos[:] = _START
    found = []
    for time in times:
        while data.time < time - 0.5e-4:
            mujoco.mj_step(model, data)
        found.append(data.qpos.copy())
    return np.array(found)


@pytest.mark.parametrize("in_a_row", [False, True])
def test_seven_joints_swing_as_in_mujoco(in_a_row: bool, tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(arm(in_a_row))
    times = np.arange(0.1, UNTIL + 1e-9, 0.1)
    theirs = swing_of_mujoco(file, times)
    scene = stark.Scene()
    robot = scene.add_robot(file, q=_START, contact=False)
    sim = stark.Simulation(scene, time_step=0.001, time={"integrator": "bdf2"})
    ours = []
    for time in times:
        sim.run_until(time)
        ours.append(robot.q)
    # 1 % of how far the joints swing.
    swing = np.abs(theirs - _START).max()
    assert swing > 1.0
    assert np.abs(np.array(ours) - theirs).max() < 0.01 * swing
