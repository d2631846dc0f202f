"""Bodies of MJCF files touch as they do in mujoco, by masks, exclusions and pairs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import written_mjcf

import stark.robots

mujoco = pytest.importorskip("mujoco")


@pytest.mark.parametrize("seed", range(4))
def test_bodies_touch_that_touch_in_mujoco(seed: int, tmp_path: Path) -> None:
    """Masks, exclusions and pairs of six balls at one place; mujoco says which of them collide."""
    random = np.random.default_rng(seed)
    body = "".join(
        f'<body name="b{k}"><joint name="j{k}" type="slide"/><geom name="g{k}" size=".1" '
        f'contype="{random.integers(4)}" conaffinity="{random.integers(4)}"/></body>'
        for k in range(6)
    )
    more = (
        '<contact><exclude body1="b0" body2="b1"/><exclude body1="b2" body2="b3"/>'
        '<pair geom1="g2" geom2="g3"/><pair geom1="g4" geom2="g5"/></contact>'
    )
    file = written_mjcf(tmp_path, f'<geom name="wall" type="box" size=".1 .1 .1"/>{body}', more)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geoms = {tuple(sorted(int(geom) for geom in contact.geom)) for contact in data.contact}
    bodies = {tuple(sorted(model.body(model.geom_bodyid[geom]).name for geom in pair)) for pair in geoms}
    robot = stark.robots.read(file)
    links = {
        tuple(sorted((one, other)))
        for one in robot.links
        for other in robot.links
        if one < other and robot.links[one].collisions and robot.links[other].collisions
    }
    assert links - {tuple(sorted(pair)) for pair in robot.excluded} == bodies


def test_masks_that_differ_within_a_body_are_reported(tmp_path: Path) -> None:
    geoms = '<geom size=".1"/><geom size=".2" contype="2" conaffinity="2"/>'
    body = "".join(f'<body name="{name}"><joint name="{name}"/>{geoms}</body>' for name in "ab")
    robot = stark.robots.read(written_mjcf(tmp_path, body))
    assert "some geoms of 1 pairs of bodies touch and others not" in str(robot.report)
    assert robot.excluded == ()
