"""Joints in Python: built-in kinds and their short forms, rewinding, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import stark


def body(
    scene: stark.Scene, position: tuple[float, float, float] = (0.0, 0.0, 0.0), mass: float = 1.0
) -> stark.RigidBody:
    return scene.add_box(0.1, mass=mass, position=position)


def simulate(scene: stark.Scene, **settings: object) -> stark.Simulation:
    return stark.Simulation(scene, **{"time_step": 0.01, "contact.enabled": False, **settings})


def test_the_sketch_of_the_readme_runs() -> None:
    scene = stark.Scene()
    base = scene.add_box(0.2, motion="fixed")
    arm = body(scene, (0.4, 0.0, 0.0))
    hinge = scene.add_hinge(base, arm, anchor=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    assert not scene.contact_enabled(base, arm)
    sim = simulate(scene)
    for _ in range(10):
        assert not sim.step().failed
    assert 0.0 < hinge.angle < 0.2  # the z axis of the hinge is +y, so falling arms turn by positive angles
    np.testing.assert_allclose(hinge.rates["angle"], arm.angular_velocity[1], rtol=1e-3)
    assert hinge.reaction.force[2] > 0.0
    assert np.abs(hinge.residuals).max() < 1e-6
    assert hinge.coordinates == {"angle": hinge.angle}
    assert hinge in scene.joints and sim.joints[0].angle == hinge.angle
    assert "angle" in dir(hinge)


@pytest.mark.parametrize(
    ("method", "options", "coordinates"),
    [
        ("add_fixed", {}, []),
        ("add_ball", {}, []),
        ("add_hinge", {"axis": (0, 0, 1)}, ["angle"]),
        ("add_slider", {"axis": (0, 1, 1)}, ["displacement"]),
        ("add_cylindrical", {"axis": (1, 0, 1)}, ["displacement", "angle"]),
        ("add_planar", {"normal": (0, 1, 0)}, ["displacement_x", "displacement_y", "angle"]),
        ("add_point_on_axis", {"axis": (1, 0, 0)}, ["displacement"]),
        ("add_universal", {"axis_a": (1, 0, 0), "axis_b": (0, 1, 0)}, ["angle_a", "angle_b"]),
    ],
)
@pytest.mark.parametrize("other", ["world", "body", "patch"])
def test_every_kind_holds(method: str, options: dict, coordinates: list[str], other: str) -> None:
    scene = stark.Scene()
    b = body(scene, (0.3, 0.0, 0.0))
    a: object = None
    if other == "body":
        a = body(scene, (-0.1, 0.0, 0.0), mass=3.0)
        scene.add_ball(None, a, anchor=(-0.2, 0.0, 0.0))
    place = {"anchor": (0.1, 0.0, 0.0), **options}
    if other == "patch":
        cloth = scene.add_cloth(
            stark.mesh.grid(0.2, 0.2, cells=4),
            stark.materials.cotton.replace(density=3.0),
            pins=[0, 4, 20, 24],
        )
        if method != "add_ball":
            return
        a, b_side = cloth.frame((12, 13, 17), position=(0.1, 0.0, 0.0)), b.frame(position=(-0.2, 0.0, 0.0))
        joint = scene.add_ball(a, b_side)
    else:
        joint = getattr(scene, method)(a, b, **place)
    assert list(dict(joint.formula.coordinates)) == coordinates
    sim = simulate(scene)
    for _ in range(20):
        report = sim.step()
        assert report.status == "accepted", report.message
    assert np.abs(joint.residuals).max() < 1e-5
    assert set(joint.coordinates) == set(coordinates)


def test_states_rewind_bitwise_with_joints() -> None:
    scene = stark.Scene()
    previous = None
    for k in range(5):
        link = body(scene, (0.15 * k + 0.075, 0.0, 0.0))
        scene.add_universal(previous, link, anchor=(0.15 * k, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1))
        previous = link
    sim = simulate(scene)
    for _ in range(5):
        sim.step()
    before = sim.state.copy()
    hashes = [(sim.step(), sim.state.hash)[1] for _ in range(3)]
    sim.state = before
    assert [(sim.step(), sim.state.hash)[1] for _ in range(3)] == hashes


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s, b, c: s.add_hinge(None, b, axis=(0, 0, 1)), "axis or rotation without anchor"),
        (lambda s, b, c: s.add_hinge(None, b), "no anchor: give anchor"),
        (
            lambda s, b, c: s.add_hinge(None, b, anchor=(0, 0, 0), axis=(0, 0, 0)),
            "must have a direction; give 'x'",
        ),
        (
            lambda s, b, c: s.add_hinge(None, b, anchor=(0, 0, 0), axis="w"),
            "axis = 'w': must be 'x', 'y', 'z' or three numbers",
        ),
        (lambda s, b, c: s.add_hinge(None, c, anchor=(0, 0, 0)), "give a patch of it"),
        (lambda s, b, c: s.add_hinge(None, None, anchor=(0, 0, 0)), "both frames are of the world"),
        (lambda s, b, c: s.add_hinge(3, b, anchor=(0, 0, 0)), "must be a rigid body"),
        (lambda s, b, c: s.add_joint("hing", None, b, anchor=(0, 0, 0)), "did you mean 'hinge'"),
        (lambda s, b, c: s.add_joint(3, None, b, anchor=(0, 0, 0)), "name of a built-in joint"),
        (lambda s, b, c: s.add_joint("distance", None, b, anchor=(0, 0, 0)), "'length' .m. has no value"),
        (lambda s, b, c: s.add_joint("ball", None, b, anchor=(0, 0, 0), length=2), "unknown value 'length'"),
        (lambda s, b, c: s.add_joint("ball", None, b, anchr=(0, 0, 0)), "did you mean 'anchor'"),
        (lambda s, b, c: s.add_ball(None, b, anchor=(0, np.nan, 0)), "anchor"),
        (
            lambda s, b, c: s.add_ball(None, b, anchor=(0, 0, 0), axis="z", name="hip"),
            "joint 'hip': axis = 'z': must be left out, as a ball joint turns about any axis; add_hinge and",
        ),
        (
            lambda s, b, c: s.add_ball(None, b, anchor=(0, 0, 0), rotation=np.eye(3)),
            "joint 'ball': rotation = .*: must be left out, as a ball joint turns about any axis",
        ),
        (
            lambda s, b, c: s.add_fixed(None, b, axis=(1, 0, 0)),
            r"joint 'fixed': axis = \(1, 0, 0\): must be left out, as a fixed joint holds both sides as",
        ),
        (lambda s, b, c: s.add_universal(None, b, anchor=(0, 0, 0), axis_a=(1, 0, 0)), "give both"),
        (
            lambda s, b, c: s.add_universal(None, b, anchor=(0, 0, 0), axis_a=(1, 0, 0), axis_b=(1, 1, 0)),
            "must be perpendicular",
        ),
        (
            lambda s, b, c: s.add_ball(stark.Scene().add_box(1, mass=1), b, anchor=(0, 0, 0)),
            "belongs to another scene",
        ),
    ],
)
def test_bad_joints_are_refused(call: object, message: str) -> None:
    scene = stark.Scene()
    b = body(scene)
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2))
    with pytest.raises(stark.InvalidArgument, match=message):
        call(scene, b, cloth)  # type: ignore[operator]
    assert scene.joints == ()


def test_a_joint_that_is_apart_at_the_start_is_refused() -> None:
    scene = stark.Scene()
    b = body(scene)
    scene.add_ball(stark.world_frame((0.0, 0.0, 0.2)), b.frame())
    with pytest.raises(stark.InvalidArgument, match=r"differ by 0.2 m at time 0"):
        simulate(scene)


def test_prescribed_bodies_that_leave_their_joint_fail_the_step() -> None:
    scene = stark.Scene()
    scripted = scene.add_box(0.1, motion="scripted")
    hinge = scene.add_hinge(None, scripted, anchor=(0, 0, 0), axis=(0, 0, 1))
    body(scene, (1.0, 0.0, 0.0))
    with pytest.warns(stark.StarkWarning, match="joint 'hinge' holds nothing: 'box' is scripted"):
        sim = simulate(scene, **{"time.min_step": 5e-3})
    scripted.angular_velocity = (0.0, 0.0, 1.0)
    assert not sim.step().failed
    np.testing.assert_allclose(hinge.angle, 0.01, rtol=1e-12)
    scripted.velocity = (1.0, 0.0, 0.0)
    report = sim.step()
    assert report.failed and "joint 'hinge' is apart by" in report.message
    hinge.enabled = False
    assert not sim.step().failed


def test_a_joint_within_one_rigid_body_is_refused() -> None:
    scene = stark.Scene()
    b = body(scene)
    with pytest.raises(stark.InvalidArgument, match="both frames are of 'box': must be of two bodies"):
        scene.add_ball(b, b, anchor=(0, 0, 0))


def test_forces_that_underflow_do_not_stop_bodies_on_sliders() -> None:
    """After the impact nothing acts, and joints are off by 1e-160 N, whose square is zero."""
    scene = stark.Scene()
    ball = stark.mesh.sphere(0.02, 3)
    left = scene.add_rigid(ball, mass=0.2, position=(-0.045, 0, 0), velocity=(0.9, 0, 0))
    right = scene.add_rigid(ball, mass=0.2)
    for body in (left, right):
        scene.add_slider(None, body, anchor=(0, 0, 0), axis=(1, 0, 0))
    sim = stark.Simulation(scene, time_step=4e-4, contact_distance=2e-4, gravity=(0, 0, 0))
    sim.run_until(0.06)
    assert left.velocity[0] + right.velocity[0] == pytest.approx(0.9, rel=1e-9)
    assert right.velocity[0] > 0.45


def test_an_anchor_of_no_use_is_refused() -> None:
    scene = stark.Scene()
    a, b = body(scene), body(scene, (0.3, 0.0, 0.0))
    frames = a.frame((0.05, 0.0, 0.0)), b.frame((-0.25, 0.0, 0.0))
    with pytest.raises(
        stark.InvalidArgument, match="anchor of no use, as both sides have frames of their own"
    ):
        scene.add_fixed(*frames, anchor=(5.0, 5.0, 5.0))
    with pytest.raises(stark.InvalidArgument, match="anchor and axis of no use"):
        scene.add_hinge(*frames, anchor=(0.05, 0.0, 0.0), axis="x")
    scene.add_hinge(frames[0], b, anchor=(0.05, 0.0, 0.0))  # of use to the body
    scene.add_fixed(*frames)


def test_a_distance_other_than_that_of_its_points_is_named() -> None:
    scene = stark.Scene()
    a, b = body(scene), body(scene, (0.3, 0.0, 0.0))
    scene.add_distance(a, b, (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), length=0.5)
    message = (
        r"length = 0\.5 m differs by 0\.2 m from the distance of its points at time 0: must be within 1e-06"
    )
    with pytest.raises(stark.InvalidArgument, match=message):
        simulate(scene)


def test_a_spring_rests_at_a_length() -> None:
    scene = stark.Scene()
    ball = scene.add_sphere(0.05, mass=1.0)
    for wrong, message in ((-0.1, r"rest_length = -0\.1 m: must be >= 0"), ("1", "must be a number")):
        with pytest.raises(stark.InvalidArgument, match=message):
            scene.add_spring(None, ball, (0, 0, 1), (0, 0, 0), stiffness=10.0, rest_length=wrong)  # type: ignore[arg-type]
    assert not scene.joints and not scene.actuators
