"""A scene of everything that a document holds, small enough to be saved and loaded hundreds of times."""

from __future__ import annotations

import numpy as np

import stark
from stark.robots import Geometry, Inertia, Link, Mimic, RobotDescription, RobotJoint


@stark.energy
def tether(
    p: stark.Point, f: stark.Frame, h: stark.TimeStep, stiffness: float = stark.parameter(unit="N/m", min=0.0)
):
    """A spring from a point to the origin of a frame, with a little damping."""
    d = p.x - f.origin
    return 0.5 * stiffness * stark.dot(d, d) + 1e-4 * h * stark.dot(p.v, p.v)


@stark.energy
def push(p: stark.Point, t: stark.Time, force: stark.Vec3):
    """A force that starts after 10 ms."""
    return -stark.where(t > 0.01, 1.0, 0.5) * stark.dot(force, p.x)


@stark.material
def saint_venant(F: stark.DeformationGradient, mu: float = stark.parameter(unit="Pa", above=0.0)):
    E = 0.5 * (F.T @ F - stark.identity(3))
    return mu * stark.trace(E @ E)


@stark.material
def membrane(
    C: stark.CauchyGreen, C_prev: stark.CauchyGreen, h: stark.TimeStep, mu: float = stark.parameter(unit="Pa")
):
    E, D = 0.5 * (C - stark.identity(2)), C - C_prev
    return mu * (stark.trace(E @ E) + 1e-6 / h * stark.trace(D @ D))


@stark.material
def kirchhoff(
    stretch,
    curvature,
    twist,
    EA: float = stark.parameter(unit="N"),
    EI: float = stark.parameter(unit="N m^2"),
):
    bending = curvature[0] ** 2 + curvature[1] ** 2 + twist**2
    return 0.5 * (EA * (stretch - 1) ** 2 + EI * bending)


@stark.joint
def on_line(a: stark.Frame, b: stark.Frame):
    d = b.origin - a.origin
    return stark.hold(length=[a.x @ d, a.y @ d], direction=a.z - b.z, displacement={"height": a.z @ d})


@stark.actuator
def counting(c: stark.Coordinate, steps: stark.Memory, stiffness: float = stark.parameter(2.0, unit="N/m")):
    return stark.act(0.5 * stiffness * c.q**2 * (1.0 + 1e-3 * steps), remember={"steps": steps + 1.0})


def everything() -> stark.Scene:
    """Bodies of all kinds far from each other, and all that acts on them."""
    scene = stark.Scene("everything")
    scene.default_friction = 0.4
    _add_soft(scene)
    _add_rigid(scene)
    _add_robot(scene)
    _add_energies(scene)
    _add_pairs(scene)
    return scene


def _add_soft(scene: stark.Scene) -> None:
    sheet = stark.mesh.grid(0.3, 0.3, 3)
    cloth = scene.add_cloth(
        sheet, name="cloth", pins=[0, 3], color=(1, 0, 0), friction=0.2,
        surface=stark.surfaces.terry_towel.replace(thickness=5e-4, core=1e-4),
        initial_positions=1.01 * sheet.vertices, rest_angles="mesh", mass=0.05,
    )  # fmt: skip
    cloth.surface_direction = (1.0, 0.0, 0.0)
    own = membrane(mu=2e3, density=0.2, thickness=1e-3)
    scene.add_cloth(
        sheet, own, name="own cloth", position=(0, 0, 1), velocity=(0.1, 0, 0), angular_velocity=(0, 0, 1)
    )
    box = stark.mesh.box_hexahedra(0.1, 1)
    solid = scene.add_solid(
        box, stark.materials.soft_rubber.replace(youngs_modulus=np.linspace(1e5, 2e5, 1)), name="solid",
        position=(1, 0, 0), rotation=stark.rotation(axis="z", angle=0.3),
    )  # fmt: skip
    tets = stark.mesh.tet_box(0.1, 1)
    scene.add_solid(
        tets, saint_venant(mu=np.full(len(tets.tets), 1e5), density=1e3), name="own solid", position=(1, 0, 1)
    )
    scene.add_solid(stark.mesh.to_quadratic(tets), name="quadratic", position=(1, 0, 2), pins=[0])
    line = stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 4)
    rod = scene.add_rod(line, name="rod", position=(0, 1, 0), pins=[0], clamps=[0], rest_shape="straight")
    scene.add_rod(
        line, kirchhoff(EA=10.0, EI=1e-4, density=1e3, radius=1e-3), name="own rod", position=(0, 1, 1)
    )
    cloth.add_skin(stark.materials.cotton, name="patch", color=(0, 1, 0))
    cloth.add_fibres(stark.materials.steel_wire, [[0, 1], [1, 2], [5, 6]], name="wires")
    solid.add_fibres(stark.materials.rubber_cord, paths=[[0, 1], [0, 2]], bending=False, name="cords")
    cloth.follow(displacement=stark.motion.spline([0, 1], [(0, 0, 0), (0, 0, 0.1)]), vertices=[0])
    cloth.follow(
        targets=stark.motion.linear([0, 1], [sheet.vertices[[3]] * 1.01, sheet.vertices[[3]]]), vertices=[3]
    )
    rod.follow(rotation=stark.motion.rotations([0, 1], [np.eye(3), stark.rotation(axis="x", angle=0.2)]))
    scene.attach(cloth.vertices[[5]], solid.vertices[[0]], name="thread", break_force=5.0)
    scene.attach(cloth.vertices[[9, 10]], None, name="nailed")
    scene.attach(scene["own cloth"].vertices[[0]], cloth, name="glued", contact=False)
    scene.attach(rod.vertices[[4]], scene["own rod"], name="tied", enabled=False)


def _add_rigid(scene: stark.Scene) -> None:
    floor = scene.add_floor(4.0, height=-1.0)
    arm = scene.add_box((0.2, 0.05, 0.05), density=500.0, name="arm", position=(2, 0, 0), linear_damping=0.1)
    tip = scene.add_sphere(0.05, subdivisions=1, mass=0.1, name="tip", position=(2.3, 0, 0), hollow=True)
    slab = scene.add_box(
        0.1, name="slab", position=(2, 1, 0), inertia=(0.5, (0, 0, 0.01), np.diag([1e-3, 1e-3, 1e-3])),
        surface=stark.surfaces.rubber,
    )  # fmt: skip
    mover = scene.add_box(0.1, name="mover", motion="scripted", position=(3, 0, 0))
    mover.follow(position=stark.motion.linear([0, 1], [(3, 0, 0), (3, 0, 0.1)]))
    mover.surface_center = (0.01, 0, 0)
    mover.surface_spin = (0, 0, 1.0)
    mover.surface_velocity = stark.motion.linear([0, 1], [(0.1, 0, 0), (0.2, 0, 0)])
    hinge = scene.add_hinge(None, arm, (2, 0, 0), (0, 0, 1), limits=(-1.0, 1.0), name="shoulder")
    slider = scene.add_slider(arm, tip, (2.2, 0, 0), (1, 0, 0), name="reach")
    own = scene.add_joint(on_line, None, slab, anchor=(2, 1, 0), axis=(0, 0, 1), name="own joint")
    scene.add_ball(scene["cloth"].frame((5, 6, 9)), scene["rod"].frame(2), name="loose", enabled=False)
    hinge.add_motor(1.0, cap=0.5, delta=0.1, name="motor").target = stark.motion.linear([0, 1], [1.0, 2.0])
    slider.add_spring(10.0, damping=0.1, name="spring")
    slider.add_servo(0.01, stiffness=10.0, damping=1.0, cap=20.0, name="servo", enabled=False)
    own.add_actuator(counting, name="counter")
    hinge.add_gear(slider, 2.0, name="gear", enabled=False)
    scene.friction[arm, floor] = 0.3, 0.2
    scene.restitution[tip, floor] = 0.5


def _add_robot(scene: stark.Scene) -> None:
    """Two links on a turning base, the second one turns twice as far as the first."""
    inertia = Inertia(0.2, np.array([0.0, 0.0, 0.05]), 1e-3 * np.eye(3))
    shape = Geometry("box", (0.02, 0.02, 0.1), position=np.array([0.0, 0.0, 0.05]))
    links = [Link("base"), *(Link(name, inertia, collisions=(shape,)) for name in ("lower", "upper", "tool"))]
    y, up = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.11])
    joints = [
        RobotJoint(
            "lift", "revolute", "base", "lower", axis=y, lower=-1.0, upper=1.0, effort=5.0, damping=0.01
        ),
        RobotJoint("bend", "revolute", "lower", "upper", position=up, axis=y, mimic=Mimic("lift", 2.0, 0.1)),
        RobotJoint("slide", "prismatic", "upper", "tool", position=up, axis=up / 0.11, effort=3.0),
    ]
    robot = scene.add_robot(
        RobotDescription("arm", links, joints), name="robot", position=(5, 0, 0), q={"lift": 0.2}
    )
    robot.add_servos("lift", stiffness=20.0, damping=1.0, gravity_compensation=True)
    robot.add_efforts("slide")


def _add_energies(scene: stark.Scene) -> None:
    cloth, arm, solid = scene["cloth"], scene["arm"], scene["solid"]
    scene.add(tether(cloth.vertices[[5, 6]], arm, stiffness=[1.0, 2.0]), name="tethers")
    scene.add(
        tether(solid.vertices[1], scene["own cloth"].frame((0, 1, 5)), stiffness=1.0), name="patch tether"
    )
    scene.add(tether(scene["rod"].vertices[3], scene["own rod"].frame(1), stiffness=0.5), name="node tether")
    scene.add(push(cloth.embedded([0, 1], (0.2, 0.3, 0.5)), force=(0.0, 0.0, 1e-3)), name="push")
    scene.add_force(
        arm.points([(0.1, 0, 0)]), stark.motion.linear([0, 1], [(0, 0, 0), (0, 0, 1)]), name="pull"
    )
    scene.add_torque(arm, (0.0, 0.0, 1e-3), name="twist")
    scene.add_pressure(solid, 100.0, name="pressure")
    scene.add_face_pressure(solid.faces, stark.motion.linear([0, 1], [0.0, 10.0]), name="face pressure")
    scene.add_symmetry(scene["cloth"].vertices[[0, 1]], "x", name="symmetry")
    scene.add_traction(solid.faces, (0.0, 0.0, 1.0), name="traction")


def _add_pairs(scene: stark.Scene) -> None:
    cloth, floor = scene["cloth"], scene["floor"]
    scene.friction[cloth, floor] = stark.Anisotropic(0.4, 0.2, 0.9)
    scene.disable_contact(cloth, scene["arm"])
    scene.disable_contact([cloth, scene["arm"]], [scene["tip"], scene["slab"]])
    scene.enable_contact(cloth, scene["tip"])
