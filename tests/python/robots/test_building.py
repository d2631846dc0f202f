"""Bodies and joints of robots: masses, frames and coordinates are those of the file, wherever it starts."""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path

import numpy as np
import pytest
from robots._robots import pair, random_mjcf, random_urdf

import stark.robots
from stark.recording.format import surface
from stark.robots import Geometry, Inertia, Link, RobotDescription, RobotJoint, kinematics

BALL = Inertia(1.0, np.array([0.01, 0.02, 0.03]), 0.01 * np.eye(3))


def chain(count: int = 2, **options: object) -> RobotDescription:
    """Boxes on hinges about y, one above the other."""
    box = (Geometry("box", (0.05, 0.05, 0.1)),)
    links = [Link(f"link_{k}", BALL, box, box) for k in range(count)]
    joints = [
        RobotJoint(f"joint_{k}", "revolute", f"link_{k - 1}", f"link_{k}", position=np.array([0.0, 0.0, 0.2]),
                   axis=np.array([0.0, 1.0, 0.0]), lower=-7.0, upper=7.0, effort=50.0)
        for k in range(1, count)
    ]  # fmt: skip
    return RobotDescription("chain", links, joints, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("merge", [True, False])
def test_bodies_have_the_inertias_and_frames_of_pinocchio(merge: bool, tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    pinocchio = pytest.importorskip("pinocchio")
    file = tmp_path / "tree.urdf"
    file.write_text(random_urdf(11))
    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    random = np.random.default_rng(3)
    for _ in range(20):
        scene = stark.Scene()
        count = len(stark.robots.read(file).coordinates)
        q = random.uniform(-2.0, 2.0, count)
        robot = scene.add_robot(file, q=q, base="floating", merge_fixed=merge)
        other = pinocchio.neutral(model)
        for name, value in kinematics.joint_values(robot.description, q).items():
            joint = model.joints[model.getJointId(name)]
            other[joint.idx_q : joint.idx_q + joint.nq] = (
                value if joint.nq == 1 else (np.cos(value), np.sin(value))
            )
        pinocchio.framesForwardKinematics(model, data, other)
        for name, link in robot.links.items():
            place = data.oMf[model.getFrameId(name)]
            np.testing.assert_allclose(link.position, place.translation, atol=1e-9)
            np.testing.assert_allclose(link.rotation, place.rotation, atol=1e-9)
        assert len(robot.bodies) == (7 if merge else 9)
        for k, name in enumerate(model.names):
            if k == 0 or not merge:
                continue
            body = robot.links[robot.description.joints[name].child].body
            assert body is not None
            assert abs(body.mass - model.inertias[k].mass) < 1e-9
            np.testing.assert_allclose(body.center_of_mass, model.inertias[k].lever, atol=1e-9)
            np.testing.assert_allclose(body.inertia, model.inertias[k].inertia, atol=1e-9)


def test_bodies_have_the_frames_of_mujoco(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    file = tmp_path / "tree.xml"
    file.write_text(random_mjcf(5))
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    random = np.random.default_rng(3)
    for _ in range(20):
        scene = stark.Scene()
        q = random.uniform(-0.4, 0.4, 3)
        robot = scene.add_robot(file, q=q, self_contact=False)
        for name, value in kinematics.joint_values(robot.description, q).items():
            data.joint(name).qpos[0] = value
        mujoco.mj_forward(model, data)
        for name, link in robot.links.items():
            np.testing.assert_allclose(link.position, data.body(name).xpos, atol=1e-9)
            np.testing.assert_allclose(link.rotation.ravel(), data.body(name).xmat, atol=1e-9)
            if link.body is not None and link.body.motion == "dynamic" and name not in ("b3", "b6"):
                center = link.position + link.rotation @ link.body.center_of_mass
                children = [
                    k for k in range(1, model.nbody) if model.body(k).parentid[0] == model.body(name).id
                ]
                if all(model.body_jntnum[k] for k in children):  # nothing is fixed to it
                    np.testing.assert_allclose(center, data.body(name).xipos, atol=1e-9)
                    assert abs(link.body.mass - model.body(name).mass[0]) < 1e-9
        sim = stark.Simulation(scene, time_step=0.001)
        np.testing.assert_allclose(sim.robots[0].q, q, atol=1e-9)


@pytest.mark.parametrize("angle", [-6.5, -3.2, 0.0, 3.2, 6.5])
def test_angles_start_beyond_half_a_turn(angle: float) -> None:
    scene = stark.Scene()
    robot = scene.add_robot(chain(), q={"joint_1": angle})
    sim = stark.Simulation(scene, time_step=0.01)
    np.testing.assert_allclose(robot.q, [angle], atol=1e-12)
    stop = next(a for a in sim.actuators if a.name == "chain.joint_1.limit")
    assert abs((stop.upper - 7.0) - (robot.joints["joint_1"].angle - angle)) < 1e-12


def test_where_the_base_goes() -> None:
    place = {"position": (1.0, 2.0, 3.0), "rotation": stark.rotation(axis="z", angle=0.5)}
    for base, motion in (("fixed", "fixed"), ("floating", "dynamic"), ("scripted", "scripted")):
        scene = stark.Scene()
        robot = scene.add_robot(chain(), base=base, **place)
        body = robot.links["link_0"].body
        assert body is not None and body.motion == motion
        np.testing.assert_allclose(robot.links["link_1"].position, (1.0, 2.0, 3.2))
        sim = stark.Simulation(scene, time_step=0.01)
        if base == "scripted":
            body.position = (1.0, 2.0, 3.01)
        for _ in range(3):
            assert not sim.step().failed
        fallen = {"fixed": 0.0, "floating": -9.81 * 0.01**2 * 6, "scripted": 0.01}[base]
        assert abs(body.position[2] - 3.0 - fallen) < 1e-6


def test_a_base_without_shape_is_the_world(tmp_path: Path) -> None:
    pytest.importorskip("yourdfpy")
    file = tmp_path / "pair.urdf"
    file.write_text(pair())
    scene = stark.Scene()
    robot = scene.add_robot(file, position=(0, 0, 1))
    assert robot.links["base"].body is None and len(robot.bodies) == 1
    assert "touches nothing" in str(robot.report)
    np.testing.assert_array_equal(robot.links["base"].position, (0, 0, 1))
    with pytest.raises(stark.InvalidArgument, match="link 'base': has no shape: the base must have one"):
        scene.add_robot(file, base="scripted")
    with pytest.raises(stark.InvalidArgument, match="link 'base': has no mass: a link that moves must have"):
        scene.add_robot(file, base="floating")
    assert len(scene.bodies) == 1 and len(scene.joints) == 1 and len(scene.robots) == 1


def test_what_touches() -> None:
    scene = stark.Scene()
    floor = scene.add_floor()
    robot = scene.add_robot(chain(4, excluded=[("link_0", "link_3")]), position=(0, 0, 1))
    bodies = [robot.links[f"link_{k}"].body for k in range(4)]
    assert all(body is not None for body in bodies)
    touching = {(a, b) for a in range(4) for b in range(a) if scene.contact_enabled(bodies[a], bodies[b])}
    assert touching >= {(2, 0), (3, 1)} and (3, 0) not in touching
    apart = scene.add_robot(chain(4), self_contact=False, position=(1, 0, 1), exclude=[])
    a, b = apart.links["link_0"].body, apart.links["link_2"].body
    assert a is not None and b is not None and not scene.contact_enabled(a, b)
    assert scene.contact_enabled(b, floor)
    ghost = scene.add_robot(chain(2), contact=False, position=(2, 0, 1))
    later = scene.add_box(0.1, mass=1.0, position=(5, 0, 1))
    assert not any(scene.contact_enabled(body, other) for body in ghost.bodies for other in (floor, later, b))
    assert apart.name == "chain_2" and ghost.bodies[0].name == "chain_3.link_0"


def test_exclusions_of_an_srdf_file(tmp_path: Path) -> None:
    file = tmp_path / "chain.srdf"
    pair = '<disable_collisions link1="link_{}" link2="link_{}" reason="Never"/>'
    file.write_text(f'<robot name="chain">{pair.format(0, 2)}{pair.format(0, 9)}</robot>')
    scene = stark.Scene()
    robot = scene.add_robot(chain(4), exclude=file)
    bodies = {name: link.body for name, link in robot.links.items()}
    assert not scene.contact_enabled(bodies["link_0"], bodies["link_2"])
    assert scene.contact_enabled(bodies["link_1"], bodies["link_3"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"q": {"joint_1": 8.0}},
            r"joint 'joint_1': starts at q = 8 rad: must be in its limits, \[-7, 7\] rad",
        ),
        ({"base": "wheels"}, "base = 'wheels': must be 'fixed' or 'floating' or 'scripted'"),
        ({"exclude": ["link_0"]}, "must be pairs of links"),
        ({"exclude": "no.srdf"}, "'no.srdf': No such file"),
        ({"exclude": [("link_0", "leg")]}, "exclude: link 'leg': must be one of link_0, link_1"),
        ({"inertias": {"leg": (1, (0, 0, 0), np.eye(3))}}, r"inertias\['leg'\]: must be one of link_0"),
        (
            {"inertias": [1.0, 2.0]},
            r"inertias = \[1.0, 2.0\]: must be \(mass, centre of mass, 3x3 tensor\) by",
        ),
        ({"inertias": {"link_1": 1.0}}, r"inertias\['link_1'\] = 1.0: must be \(mass, centre of mass"),
        ({"inertias": {"link_1": (1, (0, 0, 0), np.diag([1, 1, 3]))}}, "the triangle inequality"),
        ({"shapes": "all"}, "shapes = 'all': must be 'collision' or 'visual'"),
        ({"name": ""}, "must be a non-empty text"),
    ],
)
def test_wrong_arguments_leave_the_scene_as_it_was(options: dict[str, object], message: str) -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=message):
        scene.add_robot(chain(), **options)  # type: ignore[arg-type]
    assert not scene.bodies and not scene.joints and not scene.actuators and not scene.robots
    scene.add_robot(chain())


def test_impossible_inertias_are_refused_and_can_be_replaced() -> None:
    bad = Inertia(1.0, np.zeros(3), np.diag([0.01, 0.01, 0.03]))
    links = [Link("base", BALL), Link("arm", bad)]
    joints = [RobotJoint("hinge", "continuous", "base", "arm")]
    description = RobotDescription("odd", links, joints)
    with pytest.raises(
        stark.InvalidArgument, match=r"'arm': principal moments \(0.01, 0.01, 0.03\).*give inertias="
    ):
        stark.Scene().add_robot(description)
    robot = stark.Scene().add_robot(description, inertias={"arm": (2.0, (0, 0, 0.1), 0.01 * np.eye(3))})
    body = robot.links["arm"].body
    assert body is not None and body.mass == 2.0
    # Weight 2 kg, axis x through the origin, centre 0.1 m above: none along gravity.
    assert abs(robot.gravity_efforts([0.5 * np.pi])[0] + 2.0 * 9.81 * 0.1) < 1e-2


def test_what_starts_beyond_zero_is_reported() -> None:
    links = [Link("base", BALL), Link("arm", BALL)]
    joint = RobotJoint("hinge", "revolute", "base", "arm", lower=0.3, upper=1.0)
    robot = stark.Scene().add_robot(RobotDescription("late", links, [joint]))
    assert robot.q.tolist() == [0.3]
    assert "joint 'hinge': starts at its limit 0.3 rad, as 0 is beyond" in str(robot.report)


def test_bodies_have_the_colour_of_their_shapes() -> None:
    red, blue = (0.8, 0.1, 0.1), (0.1, 0.1, 0.8)
    seen, touched = (Geometry("box", (0.1, 0.1, 0.1), color=color) for color in (red, blue))
    links = [Link("both", BALL, (seen,), (touched,)), Link("touches", BALL, (), (touched,))]
    joint = RobotJoint("joint", "continuous", "both", "touches", position=np.array([0.0, 0.0, 1.0]))
    robot = stark.Scene().add_robot(RobotDescription("pair", links, [joint]))
    for link, color in (("both", red), ("touches", blue)):
        body = robot.links[link].body
        assert body is not None and body.color == pytest.approx(color)


def test_pictures_show_the_visual_shapes_where_that_is_wanted(tmp_path: Path) -> None:
    """Links that are fixed to each other show all of theirs; those without a visual shape what touches."""
    seen, touched = Geometry("sphere", (0.05,)), Geometry("box", (0.1, 0.1, 0.1))
    links = [
        Link("both", BALL, (seen,), (touched,)),
        Link("tool", BALL, (seen,), ()),
        Link("touches", BALL, (), (touched,)),
    ]
    above, there = np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.0, 0.0])
    joints = [
        RobotJoint("joint", "continuous", "touches", "both", position=above),
        RobotJoint("flange", "fixed", "both", "tool", position=there),
    ]
    robots = RobotDescription("pair", [links[2], *links[:2]], joints)
    assert stark.Scene().add_robot(robots).links["both"].body.shown is None  # type: ignore[union-attr]
    scene = stark.Scene()
    robot = scene.add_robot(robots, shown="visual", rotation=stark.rotation(axis="x", angle=0.4))
    body, plain = robot.links["both"].body, robot.links["touches"].body
    assert body is not None and plain is not None and plain.shown is None
    positions, triangles = surface(body)
    for link in ("both", "tool"):
        away = np.linalg.norm(positions - robot.links[link].position, axis=1)
        assert (np.abs(away - 0.05) < 1e-12).sum() == len(positions) // 2
    assert len(triangles) > len(body.triangles) == 12
    scene.save(tmp_path / "scene.json")
    again = stark.load_scene(tmp_path / "scene.json")
    np.testing.assert_array_equal(surface(again.bodies[body.name])[0], positions)


def test_robots_that_touch_nothing_cost_no_more_than_those_that_do(tmp_path: Path) -> None:
    """Steps carry the surfaces of bodies along, whether they touch or not: those of the collision shapes,
    which are smaller. Pictures show the visual ones. A collision mesh that cannot be read is left out."""
    seen, touched = Geometry("sphere", (0.05,)), Geometry("box", (0.1, 0.1, 0.1))
    (tmp_path / "cut.stl").write_bytes(b"cut off")
    cut = Geometry("mesh", file=tmp_path / "cut.stl")
    links = [
        Link("both", BALL, (seen,), (touched,)),
        Link("broken", BALL, (seen,), (cut,)),
        Link("seen", BALL, (seen,)),
        Link("touches", BALL, (), (touched,)),
    ]
    names = [link.name for link in links]
    joints = [
        RobotJoint(f"to {child}", "continuous", parent, child, position=np.array([0.0, 0.0, 1.0]))
        for parent, child in itertools.pairwise(names)
    ]
    description = RobotDescription("four", links, joints)
    robot = stark.Scene().add_robot(description, contact=False)
    bodies = {name: robot.links[name].body for name in names}
    ball = len(stark.mesh.sphere(0.05).triangles)
    triangles = {name: len(body.triangles) for name, body in bodies.items() if body is not None}
    assert triangles == {"both": 12, "broken": ball, "seen": ball, "touches": 12}
    drawn = {name: len(surface(body)[1]) for name, body in bodies.items()}
    assert drawn == {"both": ball, "broken": ball, "seen": ball, "touches": 12}
    assert "link 'broken': collision shapes: " in str(robot.report.dropped[0])
    with pytest.raises(stark.InvalidArgument, match="leave it out with contact=False"):
        stark.Scene().add_robot(description)


def test_what_is_only_shown_and_cannot_be_read_is_left_out(tmp_path: Path) -> None:
    """It was refused, with the remedy that had asked for it."""
    (tmp_path / "empty.obj").write_text("# nothing\n")
    empty = Geometry("mesh", file=tmp_path / "empty.obj")
    links = [Link("leg", BALL, (empty,), (Geometry("box", (0.1, 0.1, 0.1)),))]
    for options in ({"contact": False}, {"shown": "visual"}):
        robot = stark.Scene().add_robot(RobotDescription("leg", links, []), base="floating", **options)  # type: ignore[arg-type]
        body = robot.links["leg"].body
        assert body is not None and body.shown is None and len(body.triangles) == 12
        finding = robot.report.dropped[0]
        assert finding.part == "link 'leg'" and finding.text.startswith(
            "what is only shown of it: shape mesh: "
        )
        assert "contact=False" not in finding.text
    with pytest.raises(stark.InvalidArgument, match="shape mesh"):
        stark.Scene().add_robot(RobotDescription("leg", links, []), base="floating", shapes="visual")


def test_a_robot_that_has_nothing_to_touch_with_warns() -> None:
    ball = (Geometry("sphere", (0.05,)),)
    seen, bare = (RobotDescription("ball", [Link("ball", BALL, visuals)], []) for visuals in (ball, ()))
    with pytest.warns(
        stark.StarkWarning, match="no link has a collision shape: .*; give shapes='visual', or"
    ):
        robot = stark.Scene().add_robot(seen)
    assert robot.report.suspicious[-1].part == "robot"
    with pytest.warns(stark.StarkWarning, match="touches nothing; add some to the file, or contact=False"):
        stark.Scene().add_robot(bare, base="floating")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Scene().add_robot(seen, contact=False)
        stark.Scene().add_robot(seen, shapes="visual")
