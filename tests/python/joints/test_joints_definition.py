"""``@stark.joint``: the same as built-in joints, values, errors with the user's line."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import stark


@stark.joint
def my_hinge(a: stark.Frame, b: stark.Frame):
    """Hinge of my own."""
    return stark.hold(
        length=b.origin - a.origin,
        direction=b.z - a.z,
        angle={"angle": stark.atan2(b.x @ a.y, b.x @ a.x)},
    )


@stark.joint
def screw(a: stark.Frame, b: stark.Frame, pitch: float = stark.parameter(0.01, unit="m/rad", above=0.0)):
    """Turns in proportion to its displacement, up to half a turn."""
    d = b.origin - a.origin
    turn = stark.atan2(b.x @ a.y, b.x @ a.x)
    return stark.hold(
        length=[a.x @ d, a.y @ d, a.z @ d - pitch * turn],
        direction=a.z - b.z,
        displacement={"displacement": a.z @ d},
    )


def swing(kind: object) -> tuple[stark.Joint, str]:
    scene = stark.Scene()
    arm = scene.add_box(0.1, mass=1.0, position=(0.3, 0.0, 0.0))
    joint = scene.add_joint(kind, None, arm, anchor=(0, 0, 0), axis=(0, 1, 0))
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(30):
        assert not sim.step().failed
    return joint.angle, sim.state.hash


def test_a_joint_of_ones_own_does_what_the_built_in_one_does() -> None:
    mine, theirs = swing(my_hinge), swing("hinge")
    np.testing.assert_allclose(mine[0], theirs[0], rtol=1e-9)
    assert my_hinge.coordinates == (("angle", "rad"),)
    assert "my_hinge" in repr(my_hinge) and my_hinge.doc == "Hinge of my own."
    assert "atan2" in str(my_hinge.graph())


def test_values_of_a_screw() -> None:
    scene = stark.Scene()
    nut = scene.add_box(0.1, mass=1.0)
    joint = scene.add_joint(screw, None, nut, anchor=(0, 0, 0), axis=(0, 0, 1), pitch=0.05)
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(12):
        assert not sim.step().failed
    turned = np.arctan2(nut.rotation[1, 0], nut.rotation[0, 0])
    assert abs(joint.displacement) > 1e-3
    np.testing.assert_allclose(joint.displacement, 0.05 * turned, atol=2e-6)
    with pytest.raises(stark.InvalidArgument, match="pitch = -1 m/rad: must be > 0"):
        scene.add_joint(screw, None, nut, anchor=(0, 0, 0), pitch=-1.0)


def test_joints_of_cloth_patches_and_bodies() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(
        stark.mesh.grid(0.4, 0.4, cells=8), stark.materials.cotton.replace(density=1.0), pins=[0, 8, 72, 80]
    )
    box = scene.add_box(0.05, mass=0.02, position=(0.0, 0.0, -0.05))
    patch = cloth.frame((40, 41, 49), position=(0.0, 0.0, 0.0), rotation=np.eye(3))
    joint = scene.add_joint(my_hinge, patch, box.frame(position=(0.0, 0.0, 0.05)), contact=True)
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
    for _ in range(20):
        assert not sim.step().failed
    assert np.abs(joint.residuals).max() < 1e-5
    # The cloth gives way under the box, which hangs from it.
    assert cloth.positions[40, 2] < -1e-4
    held = box.position + box.rotation @ (0.0, 0.0, 0.05)
    np.testing.assert_allclose(held, cloth.positions[40], atol=1e-5)


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (lambda a, b: None, "must be stark.hold"),
        (lambda a, b: stark.hold(), "of nothing"),
        (lambda a, b: stark.hold(length=a.origin), "does not depend on 'b'"),
        (lambda a, b: stark.hold(length=a.origin - b.origin) if a.x @ b.x > 0 else None, "stark.where"),
        (lambda a, b: stark.hold(displacement={"no name": a.x @ b.x}), "must be an identifier"),
        (lambda a, b: stark.hold(angle={"q": a.x}), "must be one number"),
        (lambda a, b: stark.hold(angle=[a.x @ b.x]), "goes into length= or direction="),
    ],
)
def test_formulas_that_are_no_joints(formula: object, message: str) -> None:
    def bad(a: stark.Frame, b: stark.Frame):
        return formula(a, b)  # type: ignore[operator]

    with pytest.raises(stark.TraceError, match=message):
        stark.joint(bad)


def test_arguments_that_do_not_fit() -> None:
    with pytest.raises(stark.TraceError, match="function of two frames"):

        @stark.joint
        def one(a: stark.Frame):
            return stark.hold(length=a.origin)

    with pytest.raises(stark.TraceError, match="does not depend on 'unused'"):

        @stark.joint
        def idle(a: stark.Frame, b: stark.Frame, unused: float = 1.0):
            return stark.hold(length=a.origin - b.origin)


def test_names_that_joints_need_are_refused() -> None:
    with pytest.raises(stark.TraceError, match="a parameter must not be called 'contact'"):

        @stark.joint
        def _(a: stark.Frame, b: stark.Frame, contact: float = 1.0):
            return stark.hold(length=contact * (b.origin - a.origin))

    with pytest.raises(stark.TraceError, match="coordinate 'reaction': joints have another attribute"):

        @stark.joint
        def _(a: stark.Frame, b: stark.Frame):
            return stark.hold(length=b.origin - a.origin, angle={"reaction": a.x @ b.y})


def test_a_joint_without_derivatives_at_the_start_is_refused() -> None:
    @stark.joint
    def rope(a: stark.Frame, b: stark.Frame):
        return stark.hold(length=stark.norm(b.origin - a.origin))

    scene = stark.Scene()
    box = scene.add_rigid(stark.mesh.box(0.1), mass=1.0)
    scene.add_joint(rope, None, box, anchor=(0, 0, 0))
    with pytest.raises(stark.InvalidArgument, match=r"rope.*not finite at time 0.*norm of a zero vector"):
        stark.Simulation(scene)


def test_joints_are_pickled_by_name(tmp_path: Path) -> None:
    """As functions are; built-in ones by theirs, and those of documents not at all."""
    scene = stark.Scene()
    ball = scene.add_ball(None, scene.add_box(0.1, mass=1.0), anchor=(0, 0, 0))
    for formula in (screw, ball.formula):
        for again in (pickle.loads(pickle.dumps(formula)), copy.copy(formula), copy.deepcopy(formula)):
            assert again is formula
    scene = stark.Scene()
    scene.add_joint(screw, None, scene.add_box(0.1, mass=1.0), anchor=(0, 0, 0), axis="z")
    scene.save(tmp_path / "screw.json")
    loaded = stark.load_scene(tmp_path / "screw.json").joints[0].formula
    with pytest.raises(TypeError, match=r"joint 'screw' cannot be pickled: .* load the document again"):
        pickle.dumps(loaded)
    assert copy.deepcopy(loaded) is loaded
