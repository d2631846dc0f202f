"""Descriptions are checked, whoever made them; inertias of parts add up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import stark
from stark.robots import Geometry, Inertia, Link, Mimic, RobotDescription, RobotJoint


def described(*joints: RobotJoint, **options: object) -> RobotDescription:
    names = ["base", *(f"link_{k}" for k in range(len(joints)))]
    return RobotDescription("odd", [Link(name) for name in names], joints, **options)  # type: ignore[arg-type]


def hinge(k: int, parent: str = "base", **values: object) -> RobotJoint:
    return RobotJoint(f"joint_{k}", "revolute", parent, f"link_{k}", **values)  # type: ignore[arg-type]


def test_parts_of_a_description_can_be_removed_and_replaced() -> None:
    """The scene gets what is there when the robot is added; what no longer fits is named."""
    arm = described(hinge(0), hinge(1, "link_0"), hinge(2, "link_1"), excluded=[("base", "link_2")])
    del arm.links["link_2"], arm.joints["joint_2"]
    arm.joints["joint_0"] = replace(arm.joints["joint_0"], kind="fixed")
    for name in ("link_0", "link_1"):
        arm.links[name] = replace(arm.links[name], inertia=Inertia(1.0, np.zeros(3), np.eye(3)))
    robot = stark.Scene().add_robot(arm, contact=False)
    assert robot.coordinates == ("joint_1",) and set(robot.links) == {"base", "link_0", "link_1"}
    del arm.links["link_1"]
    with pytest.raises(
        stark.InvalidArgument, match="joint 'joint_1': child = 'link_1': must be one of the li"
    ):
        stark.Scene().add_robot(arm, contact=False)


def test_an_inertia_of_points_is_the_sum_of_its_parts() -> None:
    random = np.random.default_rng(0)
    points, masses = random.normal(size=(6, 3)), random.uniform(0.5, 2.0, 6)

    def of(rows: slice) -> Inertia:
        mass = masses[rows].sum()
        center = masses[rows] @ points[rows] / mass
        away = points[rows] - center
        tensor = sum(
            m * (d @ d * np.eye(3) - np.outer(d, d)) for m, d in zip(masses[rows], away, strict=True)
        )
        return Inertia(float(mass), center, np.asarray(tensor))

    whole, total = of(slice(0, 6)), Inertia.sum([of(slice(0, 2)), of(slice(2, 6))])
    assert abs(whole.mass - total.mass) < 1e-12
    np.testing.assert_allclose(total.center, whole.center, atol=1e-12)
    np.testing.assert_allclose(total.tensor, whole.tensor, atol=1e-12)
    turn = stark.rotation(axis=(1, 2, 3), angle=0.7)
    moved = whole.moved(np.ones(3), turn)
    np.testing.assert_allclose(moved.center, 1.0 + turn @ whole.center, atol=1e-12)
    np.testing.assert_allclose(moved.tensor, turn @ whole.tensor @ turn.T, atol=1e-12)


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (
            [hinge(0, "link_1"), hinge(1, "link_0")],
            "joints: 'joint_0', 'joint_1' make a circle: must make a tree",
        ),
        ([hinge(0, axis=np.array([0.0, 2.0, 0.0]))], "joint 'joint_0': axis has the length 2: must be 1"),
        ([hinge(0, lower=1.0, upper=1.0)], "lower = 1, upper = 1 rad: lower must be below upper"),
        ([hinge(0, damping=-1.0)], "joint 'joint_0': damping = -1: must be >= 0"),
        ([RobotJoint("j", "screw", "base", "link_0")], "joint 'j': kind = 'screw': must be one of fixed"),
        (
            [hinge(0, mimic=Mimic("joint_1")), hinge(1, mimic=Mimic("joint_0"))],
            "joint 'joint_0': mimics itself",
        ),
        ([RobotJoint("", "fixed", "base", "link_0")], "a joint has no name"),
    ],
)
def test_what_is_wrong_is_named(joints: list[RobotJoint], message: str) -> None:
    with pytest.raises(stark.InvalidArgument, match=f"description 'odd': .*{message}"):
        described(*joints)
    with pytest.raises(stark.InvalidArgument, match="excluded pair: 'leg': must be the name of a link"):
        described(hinge(0), excluded=[("base", "leg")])


def test_mimics_of_mimics_follow_the_first_one() -> None:
    robot = described(
        hinge(0), hinge(1, mimic=Mimic("joint_0", 2.0, 0.1)), hinge(2, mimic=Mimic("joint_1", -1.0, 0.3))
    )
    assert robot.coordinates == ("joint_0",)
    name, ratio, offset = robot.drive_of(robot.joints["joint_2"])
    assert name == "joint_0" and ratio == -2.0 and abs(offset - 0.2) < 1e-15


def test_joints_are_in_the_order_of_the_file_or_from_the_root_outwards() -> None:
    assert described(hinge(0), hinge(1, "link_0")).coordinates == ("joint_0", "joint_1")
    assert described(hinge(0, "link_1"), hinge(1)).coordinates == ("joint_1", "joint_0")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Geometry("box", (1, 1, 1), position=0.5), "shape box: position = 0.5: must be three"),
        (lambda: Geometry("box", (1, 1, 1), rotation=-np.eye(3)), "shape box: rotation: .* determinant -1"),
        (lambda: Geometry("box", (1, 1, 1), rotation=2 * np.eye(3)), "shape box: rotation: .* by 3"),
        (lambda: Geometry("capsule", 0.1), "shape capsule: size = 0.1: must have 2 numbers"),
        (lambda: Geometry("cone", (0.1, 0.2)), "shape: kind = 'cone': must be one of box, sphere"),
        (lambda: Inertia("x", np.zeros(3), np.eye(3)), "inertia: mass = 'x': must be a number"),
        (lambda: Inertia(1.0, 0.0, np.eye(3)), "inertia: center = 0.0: must be three numbers"),
        (lambda: Inertia(1.0, np.zeros(3), np.eye(2)), "inertia: tensor = .*must be a 3x3 matrix"),
        (lambda: Link("leg", inertia=1.0), "link 'leg': inertia = 1.0: must be a stark.robots.Inertia"),
        (lambda: Link("leg", collisions=[1]), r"link 'leg': collisions = \[1\]: must be a tuple of"),
        (lambda: hinge(0, lower="-1"), "joint 'joint_0': lower = '-1': must be a number"),
        (lambda: hinge(0, lower=np.inf), "joint 'joint_0': lower = inf: must be .* or None for no limit"),
        (lambda: hinge(0, upper=np.nan), "joint 'joint_0': upper = nan: must be .* or None for no limit"),
        (lambda: hinge(0, rotation=np.zeros((3, 3))), "joint 'joint_0': rotation: .* determinant 0"),
        (lambda: hinge(0, friction=None), "joint 'joint_0': friction = None: must be a number"),
        (lambda: hinge(0, parent=["base"]), r"joint 'joint_0': parent = \['base'\]: must be a text"),
        (lambda: hinge(0, mimic="joint_1"), "joint 'joint_0': mimic = 'joint_1': must be a stark"),
        (lambda: hinge(0, servo=3.0), "joint 'joint_0': servo = 3.0: must be a stark"),
        (lambda: Mimic("joint_1", np.nan), "mimic of 'joint_1': ratio = nan: must be finite"),
        (lambda: Mimic("joint_1", "x"), "mimic of 'joint_1': ratio = 'x': must be a number"),
        (lambda: described(hinge(0), base="loose"), "'odd': base = 'loose': must be 'fixed' or 'floating'"),
        (lambda: RobotDescription("odd", [1], []), "description 'odd': link 1: must be a stark.robots.Link"),
        (lambda: RobotDescription("odd", None, []), "links = None: must be a list of stark.robots.Link"),
        (lambda: RobotDescription(3, [Link("leg")], []), "description: name = 3: must be a text"),
    ],
)
def test_parts_of_another_type_are_refused(make: Callable[[], object], message: str) -> None:
    """Most were bare errors where a scene was made of them. A number for a position was three, and a matrix
    that is no rotation made a body larger, or a mirror image."""
    with pytest.raises(stark.InvalidArgument, match=f"(?s){message}"):
        make()


def test_lists_and_quaternions_are_arrays() -> None:
    body = Inertia(1, [0, 0, -0.1], [[1, 0, 0], [0, 1, 0], [0, 0, 1]])  # type: ignore[arg-type]
    shape = Geometry("sphere", (0.1,), position=[0, 0, -0.1], rotation=[0, 1, 0, 0])  # type: ignore[arg-type]
    robot = RobotDescription("ball", [Link("ball", body, collisions=[shape])], [])  # type: ignore[arg-type]
    handle = stark.Scene().add_robot(robot, base="floating")
    assert handle.bodies[0].center_of_mass.tolist() == [0, 0, -0.1]
    np.testing.assert_array_equal(shape.rotation, np.diag([1, -1, -1]))


@pytest.mark.parametrize(
    "placement",
    [0, (1.0, 2.0, 3.0), "ab", np.eye(4), ((0, 0), np.eye(3)), ((0, 0, 0), np.eye(2)), ((0, 0, 0), 5.0)],
)
def test_a_placement_of_another_shape_is_named(placement: object) -> None:
    """It was found by NumPy, where the robot was added, or not at all."""
    with pytest.raises(stark.InvalidArgument, match="description 'odd': placement"):
        described(hinge(0), placement=placement)


@pytest.mark.parametrize(
    "excluded", [5, "ab", [5], ["ab"], [("base",)], [("base", "link_0", "base")], [("base", 1)]]
)
def test_excluded_pairs_of_another_shape_are_named(excluded: object) -> None:
    with pytest.raises(
        stark.InvalidArgument, match=r"description 'odd': excluded = .*: must be pairs of names"
    ):
        described(hinge(0), excluded=excluded)


def test_placements_and_pairs_may_be_lists() -> None:
    made = described(hinge(0), placement=[(0, 0, 1), None], excluded=[["base", "link_0"]])
    assert made.placement[0].tolist() == [0, 0, 1] and made.excluded == (("base", "link_0"),)
