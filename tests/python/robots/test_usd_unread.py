"""USD files: what nothing reads is named once, with how many prims have it; values of 0 are not."""

from __future__ import annotations

from pathlib import Path

import pytest
from robots._stages import body, joint, stage

import stark.robots

pytest.importorskip("pxr")

HINGE = 'uniform token physics:axis = "Z"\n'


def test_values_that_nothing_reads_are_named_with_their_number(tmp_path: Path) -> None:
    damped = "float physxRigidBody:linearDamping = 0.5\nbool physxRigidBody:disableGravity = 0\n"
    driven = (
        f"{HINGE}float drive:angular:physics:targetPosition = 30\nfloat drive:angular:physics:stiffness = 9\n"
        "float state:angular:physics:position = 0\nfloat mjc:damping = 2\n"
    )
    pair = body("a", damped) + body("b", f"{damped}vector3f physics:velocity = (1, 0, 0)\n")
    drive = '"PhysicsDriveAPI:angular"'
    file = stage(tmp_path, pair + joint("j", "PhysicsRevoluteJoint", "a", "b", driven, drive))
    found = [str(finding) for finding in stark.robots.read(file).report.dropped if "not read" in finding.text]
    assert sorted(found) == [
        "file: drive: targetPosition of 1 prim: not read",
        "file: mjc: damping of 1 prim: not read",
        "file: physics: velocity of 1 prim: not read",
        "file: physxRigidBody: linearDamping of 2 prims: not read",
    ]


@pytest.mark.parametrize(
    ("direction", "is_named"), [((0, 0, -1), False), ((0, 0, 0), False), ((1, 0, 0), True)]
)
def test_gravity_that_does_not_point_down_is_named(
    direction: tuple[int, ...], is_named: bool, tmp_path: Path
) -> None:
    scene = f'def PhysicsScene "scene" {{\nvector3f physics:gravityDirection = {direction}\n}}\n'
    report = str(stark.robots.read(stage(tmp_path, body("a") + scene)).report)
    assert ("gravity along [1.0, 0.0, 0.0]: that of the simulation holds" in report) == is_named
