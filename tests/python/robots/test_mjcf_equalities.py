"""Equalities of MJCF files: what holds bodies together becomes joints, against mujoco itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import written_mjcf

import stark
import stark.robots

mujoco = pytest.importorskip("mujoco")

BODY = '<inertial pos="0.1 0 0.02" mass="1" diaginertia="0.01 0.02 0.015"/>'

#: A four-bar linkage in the plane y = 0, and a double pendulum of a ball joint and a weld.
FOUR_BAR = f"""
<body name="crank" pos="0 0 0.5"><joint name="a" axis="0 1 0"/>{BODY}
  <body name="rod" pos="0.1 0 0.1"><joint name="b" axis="0 1 0"/>{BODY}</body></body>
<body name="rocker" pos="0.4 0 0.5"><joint name="c" axis="0 1 0"/>{BODY}</body>
"""
LOOP = '<equality><connect name="loop" body1="rod" body2="rocker" anchor="0.3 0 0.1"/></equality>'


def positions_of_mujoco(file: Path, time: float) -> dict[str, np.ndarray]:
    """Of bodies after a run with steps of 0.1 ms, in which equalities are as stiff as they can be."""
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = 1e-4
    model.eq_solref[:] = (4e-4, 1.0)
    data = mujoco.MjData(model)
    while data.time < time - 1e-9:
        mujoco.mj_step(model, data)
    return {model.body(k).name: np.array(data.xpos[k]) for k in range(1, model.nbody)}


def positions_of_stark(file: Path, time: float) -> dict[str, np.ndarray]:
    scene = stark.Scene()
    robot = scene.add_robot(file)
    sim = stark.Simulation(scene, time_step=2e-3, **{"time.integrator": "bdf2"})
    sim.run_until(time)
    return {name: np.array(link.position) for name, link in robot.links.items()}


#: A pendulum of a ball joint, and a body that a weld holds where the file has it.
WELDED = (
    f'<body name="a" pos="0 0 1"><joint type="ball" pos="0.05 0 0"/>{BODY}</body>'
    f'<body name="b" pos="0.272 0.1 1.096" quat="0.8 0 0.6 0"><freejoint/>{BODY}</body>'
)
WELD = '<weld body1="a" body2="b" relpose="0.3 0.1 0 0.8 0 0.6 0" anchor="0.1 0 0"/>'
#: The same of sites, which hangs on the world.
AT_SITES = "".join(
    f'<body name="{body}" pos="{x} 0 1"><freejoint/>{BODY}'
    f'<site name="{site}" pos="{at} 0 0" euler="0 90 0"/></body>'
    for body, x, site, at in (("a", 0.0, "s", 0.2), ("b", 0.3, "t", -0.1))
)
SITES = '<weld site1="s" site2="t"/><connect body1="a" anchor="-0.1 0 0"/>'


@pytest.mark.parametrize(
    ("body", "more", "length"),
    [
        (FOUR_BAR, LOOP, 0.5),
        (WELDED, f"<equality>{WELD}</equality>", 0.4),
        (AT_SITES, f"<equality>{SITES}</equality>", 0.4),
    ],
    ids=["four-bar", "ball and weld", "sites and world"],
)
@pytest.mark.filterwarnings("ignore::stark.StarkWarning")
def test_what_is_held_together_moves_as_in_mujoco(
    body: str, more: str, length: float, tmp_path: Path
) -> None:
    file = written_mjcf(tmp_path, body, more)
    expected, found = positions_of_mujoco(file, 0.4), positions_of_stark(file, 0.4)
    for name, position in expected.items():
        # Of a way of some decimetres: mujoco is of first order, and its equalities give way.
        np.testing.assert_allclose(found[name], position, atol=0.01 * length, err_msg=name)


def test_what_cannot_be_held_is_reported(tmp_path: Path) -> None:
    body = (
        f'<body name="a"><joint name="j" axis="0 1 0"/>{BODY}</body>'
        f'<body name="b" pos="1 0 0"><joint name="k" axis="0 1 0"/>{BODY}</body>'
        '<body name="hand" mocap="true"/>'
    )
    more = (
        '<equality><weld name="grasp" body1="a" body2="b" active="false"/>'
        '<weld name="lead" body1="hand" body2="a"/></equality>'
    )
    robot = stark.robots.read(written_mjcf(tmp_path, body, more))
    report = str(robot.report)
    assert not robot.closures
    assert "equality 'grasp': is not active at the start; what it holds together, scene.add_fixed" in report
    assert "equality 'lead': holds a mocap body: make it a scripted one" in report


def test_a_closure_of_what_is_fixed_is_refused(tmp_path: Path) -> None:
    body = f'<body name="a"><joint name="j"/>{BODY}<body name="b">{BODY}</body></body>'
    more = '<equality><connect name="e" body1="a" body2="b" anchor="0 0 0"/></equality>'
    with pytest.raises(
        stark.InvalidArgument, match="closure 'e': holds 'a' and 'b', which are fixed to each"
    ):
        stark.Scene().add_robot(written_mjcf(tmp_path, body, more))
