"""MJCF files: what no scene has is named once, and what a file switches off is warned of."""

from __future__ import annotations

from pathlib import Path

import pytest
from robots._robots import written_mjcf

import stark
import stark.robots

pytest.importorskip("mujoco")

BODY = '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
ARM = f'<body name="a"><joint name="j" axis="0 1 0"/>{BODY}<geom size=".1"/></body>'


def test_what_flags_switch_off_acts_and_is_warned_of(tmp_path: Path) -> None:
    option = '<option><flag contact="disable" limit="disable"/></option>'
    file = written_mjcf(tmp_path, ARM, option)
    with pytest.warns(UserWarning, match="<flag contact='disable'>: it acts; give contact=False"):
        robot = stark.Scene().add_robot(file)
    assert "file: <flag limit='disable'>: it acts; remove what it switches off" in str(robot.report)


def test_what_free_joints_and_mocap_bodies_lose_is_named(tmp_path: Path) -> None:
    free = '<joint name="f" type="free" damping="3" armature="0.5" frictionloss="2" stiffness="4"/>'
    bodies = (
        f'{ARM}<body name="b" pos="1 0 0">{free}{BODY}</body>'
        '<body name="hand" mocap="true"><geom size=".1" pos="0 2 0"/></body><camera name="c"/>'
    )
    report = str(stark.robots.read(written_mjcf(tmp_path, bodies)).report)
    for line in (
        "joint 'f': damping, dry friction, armature, spring: of free joints they are not kept",
        "body 'hand': mocap: it is fixed where the file has it; add it to the scene with motion='scripted'",
        "file: 1 cameras",
    ):
        assert report.count(line) == 1


@pytest.mark.parametrize(
    ("geom", "said"),
    [('surfacevel="0.5 0 0 0 0 0"', "surfacevel of geoms"), ('adhesion="3"', "adhesion of geoms")],
)
def test_what_geoms_lose_is_named(geom: str, said: str, tmp_path: Path) -> None:
    try:
        robot = stark.robots.read(written_mjcf(tmp_path, ARM.replace("<geom", f"<geom {geom}")))
    except stark.InvalidArgument as error:
        assert "unrecognized attribute" in str(error)  # mujoco before 4
        return
    assert f"file: {said}" in str(robot.report)


def test_a_plain_file_drops_nothing_but_contact(tmp_path: Path) -> None:
    dropped = stark.robots.read(written_mjcf(tmp_path, ARM)).report.dropped
    assert [str(finding) for finding in dropped] == [
        "file: friction, softness and margins of contact: those of the scene hold"
    ]
