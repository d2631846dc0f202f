"""USD files: the same robots as mujoco has, in any units; shapes, masses of shapes, joints of all kinds, what
is wrong with a file. UsdPhysics keeps numbers in single precision: so do the tolerances."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots._robots import GRAVITY, random_mjcf
from robots._stages import body, joint, numbers, of_mujoco, shape, stage

import stark
from stark.robots import kinematics
from stark.robots.kinematics import Placement
from stark.robots.weight import Weight

pytest.importorskip("pxr")

SINGLE = 3e-6  # a few roundings of numbers of a metre or a kilogram
HINGE = 'uniform token physics:axis = "Z"\n'


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("metre", "kilogram", "turned"), [(1.0, 1.0, False), (0.01, 0.001, True)])
def test_robots_are_those_of_mujoco(
    seed: int, metre: float, kilogram: float, turned: bool, tmp_path: Path
) -> None:
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "tree.xml").write_text(random_mjcf(seed))
    model = mujoco.MjSpec.from_file(str(tmp_path / "tree.xml")).compile()
    robot = stark.robots.read(of_mujoco(tmp_path, model, metre=metre, kilogram=kilogram, turned=turned))
    data = mujoco.MjData(model)
    # Joints move the second body as seen from the first one.
    signs = {
        model.joint(k).name: -1.0 if turned and model.jnt_bodyid[k] % 2 == 0 else 1.0
        for k in range(model.njnt)
    }
    random = np.random.default_rng(seed)
    for k in range(1, model.nbody):
        link = robot.links[model.body(k).name]
        assert link.inertia is not None
        assert link.inertia.mass == pytest.approx(model.body_mass[k], rel=1e-6)
        np.testing.assert_allclose(link.inertia.center, model.body_ipos[k], atol=SINGLE)
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[k])
        tensor = axes.reshape(3, 3) @ np.diag(model.body_inertia[k]) @ axes.reshape(3, 3).T
        np.testing.assert_allclose(link.inertia.tensor, tensor, atol=SINGLE)
    model.opt.gravity[:] = GRAVITY
    for _ in range(20):
        q = random.uniform(-1.0, 1.0, len(robot.coordinates))
        values = kinematics.joint_values(robot, q)
        columns = [model.joint(name).dofadr[0] for name in robot.coordinates]
        for name, value in values.items():
            data.joint(name).qpos[0] = model.joint(name).qpos0[0] + signs[name] * value
        mujoco.mj_forward(model, data)
        frames = kinematics.placements(robot, q, Placement(*robot.placement))
        for k in range(1, model.nbody):
            frame = frames[model.body(k).name]
            np.testing.assert_allclose(frame.position, data.xpos[k], atol=SINGLE)
            np.testing.assert_allclose(frame.rotation.ravel(), data.xmat[k], atol=SINGLE)
        efforts = Weight(robot).efforts_at(frames, GRAVITY)
        theirs = [signs[name] * data.qfrc_bias[k] for name, k in zip(robot.coordinates, columns, strict=True)]
        np.testing.assert_allclose(efforts, theirs, atol=100 * SINGLE)


def test_a_pendulum_swings_as_that_of_an_mjcf_file(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_text(
        '<mujoco><worldbody><body name="arm" pos="0 0 1"><joint name="hinge" axis="0 1 0"/>'
        '<inertial pos="0.4 0 0" mass="2" diaginertia="0.1 0.2 0.3"/></body></worldbody></mujoco>'
    )
    frames = 'point3f physics:localPos0 = (0, 0, 1)\nuniform token physics:axis = "Y"\n'
    inertia = (
        "float physics:mass = 2\nfloat3 physics:diagonalInertia = (0.1, 0.2, 0.3)\n"
        "point3f physics:centerOfMass = (0.4, 0, 0)\n"
    )
    arm = body("arm", inertia, place=(0, 0, 1), mass=None)
    usd = stage(tmp_path, arm + joint("hinge", "PhysicsRevoluteJoint", "", "arm", frames))
    angles = []
    for file in (tmp_path / "arm.xml", usd):
        scene = stark.Scene()
        robot = scene.add_robot(file)
        sim = stark.Simulation(scene, time_step=0.01)
        sim.run_until(0.5)
        angles.append(float(robot.q[0]))
    assert angles[0] > 0.5 and abs(angles[1] - angles[0]) < 1e-6


def test_masses_of_shapes(tmp_path: Path) -> None:
    """Where the file gives none: of water; of a density; of a mass; about a given centre."""
    cube = shape("Cube", "double size = 0.2")
    density = body("b", cube + "float physics:density = 500\n", mass=None)
    weighed = body("c", cube + "float physics:mass = 3\n", mass=None)
    moved = body(
        "d", cube + "float physics:mass = 3\npoint3f physics:centerOfMass = (0.1, 0, 0)\n", mass=None
    )
    joints = "".join(joint(f"j{k}", "PhysicsFixedJoint", "a", k) for k in "bcd")
    robot = stark.robots.read(
        stage(tmp_path, body("a", cube, mass=None) + density + weighed + moved + joints)
    )
    masses = {name: link.inertia.mass for name, link in robot.links.items() if link.inertia is not None}
    assert masses == pytest.approx({"a": 8.0, "b": 4.0, "c": 3.0, "d": 3.0})
    for name, center, moment in (("a", 0.0, 8.0 * 0.04 / 6), ("d", 0.1, 3.0 * (0.04 / 6 + 0.01))):
        inertia = robot.links[name].inertia
        assert inertia is not None and inertia.center[0] == pytest.approx(center)
        assert inertia.tensor[2, 2] == pytest.approx(moment)
    assert "body 'a': mass 8 kg and inertia: those of its shapes" in str(robot.report)
    assert "body 'c': inertia: that of its shapes, with the mass of the file" in str(robot.report)


def test_the_base_stands_where_a_fixed_joint_holds_it(tmp_path: Path) -> None:
    quat = numbers((np.sqrt(0.5), 0, 0, np.sqrt(0.5)))
    frames = (
        f"point3f physics:localPos0 = (1, 2, 3)\nquatf physics:localRot0 = {quat}\n"
        "point3f physics:localPos1 = (0.5, 0, 0)\n"
    )
    held = joint("ground", "PhysicsFixedJoint", "", "a", frames)
    robot = stark.robots.read(stage(tmp_path, body("a", place=(1, 1.5, 3)) + held))
    assert robot.base == "fixed"
    np.testing.assert_allclose(robot.placement[0], (1, 1.5, 3), atol=SINGLE)
    free = stark.robots.read(stage(tmp_path, body("a", place=(1, 1.5, 3))))
    assert free.base == "floating" and free.placement[0] == pytest.approx([1, 1.5, 3])


def test_the_robot_is_told_from_loose_bodies(tmp_path: Path) -> None:
    pair = body("a") + body("b") + joint("j", "PhysicsRevoluteJoint", "a", "b", HINGE)
    robot = stark.robots.read(stage(tmp_path, pair + body("cup")))
    assert list(robot.links) == ["a", "b"] and "body 'cup': is no part of the robot" in str(robot.report)


def test_pairs_that_do_not_touch(tmp_path: Path) -> None:
    filtered = (
        body("a")
        .replace('"PhysicsMassAPI"', '"PhysicsMassAPI", "PhysicsFilteredPairsAPI"')
        .replace("float physics:mass", "rel physics:filteredPairs = </robot/c>\nfloat physics:mass")
    )
    joints = joint("j", "PhysicsRevoluteJoint", "a", "b", HINGE) + joint(
        "k", "PhysicsRevoluteJoint", "b", "c", HINGE
    )
    robot = stark.robots.read(stage(tmp_path, filtered + body("b") + body("c") + joints))
    assert robot.excluded == (("a", "c"),)


LOOP = "".join(joint(f"j{a}{b}", "PhysicsRevoluteJoint", a, b, HINGE) for a, b in ("ab", "bc", "ca"))


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        ("", "stage: has no prim with PhysicsRigidBodyAPI: must have a body"),
        (
            body("a") + body("b") + body("c") + LOOP,
            "joint 'jca': closes a loop: joints must make a tree; set exclude",
        ),
        (
            body("a") + body("b"),
            "has 2 parts that no joint connects, with '/robot/a', '/robot/b': must have one",
        ),
        (
            body("a") + joint("j", "PhysicsRevoluteJoint", "a", "gone"),
            "joint 'j': body1 = /robot/gone: must be a prim",
        ),
        (
            body("a") + body("b") + joint("j", "PhysicsSphericalJoint", "a", "b"),
            "joint 'j': is a PhysicsSphericalJoint: must",
        ),
        (body("a") + body("b") + joint("j", "PhysicsJoint", "a", "b"), "joint 'j': leaves all six axes free"),
        (
            body("a", "float physics:mass = 2\n", mass=None),
            "body 'a': has the mass 2 kg, but neither diagonalInertia nor",
        ),
        (
            body(
                "a",
                shape(
                    "Mesh",
                    "point3f[] points = [(0,0,0)]\nint[] faceVertexCounts = [3]\n"
                    "int[] faceVertexIndices = [0,1,2]",
                ),
            ),
            "faceVertexIndices do not fit",
        ),
        (
            body("a")
            .replace("double3 xformOp:translate", "double3 xformOp:scale")
            .replace('"xformOp:translate"', '"xformOp:scale"'),
            "has a scale of 0",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_named(inner: str, message: str, tmp_path: Path) -> None:
    with pytest.raises((stark.InvalidArgument, stark.InvalidMesh), match=message) as caught:
        stark.robots.read(stage(tmp_path, inner))
    assert "robot.usda'" in str(caught.value)


def test_loops_that_the_file_leaves_out_are_reported(tmp_path: Path) -> None:
    outside = LOOP.replace('"jca"  {\n', '"jca"  {\nbool physics:excludeFromArticulation = true\n')
    robot = stark.robots.read(stage(tmp_path, body("a") + body("b") + body("c") + outside))
    assert len(robot.coordinates) == 2 and "joint 'jca': closes a loop, exclude" in str(robot.report)


def test_damaged_files_and_missing_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "robot.usda"
    file.write_text("#usda 1.0\ndef Xform {")
    with pytest.raises(stark.InvalidArgument, match="USD cannot read it"):
        stark.robots.read(file)
    with pytest.raises(stark.InvalidArgument, match=r"gone\.usd'"):
        stark.robots.read(tmp_path / "gone.usd")
    monkeypatch.setitem(__import__("sys").modules, "pxr", None)
    with pytest.raises(ImportError, match=r"USD files need usd-core: pip install 'stark-sim\[usd\]'"):
        stark.robots.read(file)
