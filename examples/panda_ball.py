"""panda_ball: a Franka Panda squeezes a soft ball, lifts it and hands it over to a second one.

What it shows: two robots from one URDF file with meshes, paths of the hand by inverse kinematics, servos with
gravity compensation, grippers that close with a given force, friction on a soft solid that two hands hold.
The check: the grip is the force of the drive; the ball does not slip in either hand; friction carries its
weight; it ends up where the second hand is to bring it; no joint leaves its path.

    python examples/panda_ball.py    leaves a recording, plots and pictures in out/panda_ball
    stark run examples/panda_ball.py
                                     needs pip install 'stark-sim[examples]'
"""

import sys
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import curves
import hand_paths
import numpy as np
import pictures
import running

import stark

until = 4.2  # [s]
options: dict[str, Any] = {"subdivisions": 2, "time_step": 0.01}  # of the ball; [s]
RADIUS, FRICTION, GRIP = 0.032, 0.8, 8.0  # of the ball [m], [1], of both fingers together [N]
BALL = stark.SolidMaterial(density=600.0, youngs_modulus=2e4, poissons_ratio=0.4, strain_damping=40.0)
STIFFNESS, DAMPING = (3e3, 3e3, 3e3, 3e3, 1e3, 1e3, 3e2), (60.0, 60.0, 60.0, 60.0, 15.0, 15.0, 4.0)
HOME = {
    "giver": (0, -0.1, 0, -1.9, 0, 3.4, 0.785, 0.0399),
    "taker": (0, -0.1, 0, -1.9, 0, 3.4, -0.785, 0.0399),
}
OPEN, CLOSING, GRAVITY = 0.0399, 0.06, 9.81  # of a finger [m], its speed [m/s], [m/s^2]
APART, START, MEET, END = 1.30, (0.60, 0.0, 0.66), (0.65, 0.0, 0.80), (0.74, 0.0, 0.70)  # [m]
RING = (0.018, 0.004)  # that the ball lies on, radii [m]
BACK = 0.09  # how far behind the ball a hand waits [m]
MOMENTS = (1.5, 2.45)  # of the pictures [s]
LIFTED, GIVEN, LET_GO = 1.6, 2.5, 3.0  # when [s]: it is at the meeting place, both hold it, one is away
# Where the hands are when [s], as places of the ball and metres behind it, and when fingers close and open.
PATHS = {
    "giver": [(0.0, START, BACK), (0.5, START, 0.0), (0.9, START, 0.0), (LIFTED, MEET, 0.0),
              (2.8, MEET, 0.0), (3.3, MEET, BACK)],
    "taker": [(0.0, MEET, BACK), (LIFTED, MEET, BACK), (2.0, MEET, 0.0), (LET_GO, MEET, 0.0),
              (4.0, END, 0.0)],
}  # fmt: skip
FINGERS = {"giver": (0.5, GIVEN), "taker": (2.0, 9.0)}
TURNED = {
    "giver": np.array([(0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)]),  # fingers close along y
    "taker": np.array([(0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]),  # along z
}
WHITE, ORANGE, DARK = (0.90, 0.91, 0.92), (0.90, 0.45, 0.20), (0.35, 0.37, 0.42)
knots: dict[str, tuple[np.ndarray, np.ndarray]] = {}  # times (k,) and q of the arm (k, 7)


def settings():
    return {
        "time_step": options["time_step"],
        "contact_distance": 0.0005,
        "contact.stick_velocity": 5e-4,
        "newton.step_tolerance": 1e-4,
    }


def build():
    folder = running.installed("cmeel", "cmeel.prefix/share/example-robot-data/robots/panda_description")
    scene = stark.Scene()
    scene.default_friction = FRICTION
    scene.add_floor(3.0)
    description = stark.robots.read(folder / "urdf/panda.urdf")
    for name, base, turn in (("giver", 0.0, 0.0), ("taker", APART, np.pi)):
        at, rotation = (base, 0.0, 0.0), stark.rotation(axis="z", angle=turn)
        model = stark.Scene().add_robot(description, position=at, rotation=rotation)
        times, path = hand_path(name)
        arm = (path, TURNED[name], "panda_joint*", HOME[name])
        knots[name] = times, hand_paths.of_joints(model, "panda_hand_tcp", *arm)[:, :7]
        robot = scene.add_robot(
            description, name=name, q=[*knots[name][1][0], OPEN], exclude=folder / "srdf/panda.srdf",
            self_contact=False, color=WHITE, position=at, rotation=rotation,
        )  # fmt: skip
        robot.add_servos("panda_joint*", stiffness=STIFFNESS, damping=DAMPING, gravity_compensation=True)
        robot.add_servos("panda_finger_joint1", stiffness=4000.0, damping=40.0, cap=GRIP)
    ball = stark.mesh.tet_ball(RADIUS, options["subdivisions"])
    scene.add_solid(ball, BALL, name="ball", position=START, color=ORANGE)
    # It lies on a ring: on a plane a ball of triangles would tip over to the next one, and roll away.
    top = START[2] - np.sqrt((RADIUS + RING[1] + 0.0005) ** 2 - RING[0] ** 2)
    scene.add_rigid(
        stark.mesh.torus(*RING), name="ring", motion="fixed", position=(*START[:2], top), color=DARK
    )
    post = (0.05, 0.05, top - RING[1])
    scene.add_box(post, name="stand", motion="fixed", position=(*START[:2], 0.5 * post[2]), color=DARK)
    return scene


def hand_path(name):
    """Times (k,) and places of the middle between the fingertips (k, 3) along smooth straight lines."""
    behind = -TURNED[name][:, 2]
    rows = [(time, np.asarray(place) + back * behind) for time, place, back in PATHS[name]]
    times, places = [rows[0][0]], [rows[0][1]]
    for (t0, p0), (t1, p1) in pairwise(rows):
        for s in np.linspace(0.0, 1.0, 9)[1:] if np.linalg.norm(p1 - p0) > 0.0 else [1.0]:
            times.append(t0 + s * (t1 - t0))
            places.append(p0 + s * s * (3.0 - 2.0 * s) * (p1 - p0))
    return np.array(times), np.array(places)


def drive(sim):
    time = sim.time + sim.time_step
    for robot in sim.robots:
        arm, fingers = robot.drives
        arm.target = hand_paths.at(time, *knots[robot.name])
        closes, opens = FINGERS[robot.name]
        closed = OPEN - CLOSING * max(time - closes, 0.0)
        fingers.target = max(closed, 0.0) if time < opens else min(OPEN, 0.02 + CLOSING * (time - opens))


def measure(sim):
    """After every step: ball [m], grips and what hands carry [N], ball in the hands [m], error of arms."""
    ball = sim["ball"]
    middle = ball.positions.mean(axis=0)
    series = dict(zip("xyz", middle, strict=True)) | {"width_y": np.ptp(ball.positions[:, 1])}
    for robot in sim.robots:
        hand = robot.links["panda_hand_tcp"]
        seen = hand.rotation.T @ (middle - hand.position)
        sides = [sim.contacts.of("ball", f"{robot.name}.panda_{side}finger") for side in ("left", "right")]
        forces = [pairs.forces.sum(axis=0) for pairs in sides]
        series |= {f"{robot.name}_{axis}": value for axis, value in zip("xyz", seen, strict=True)}
        series[f"{robot.name}_grip"] = 0.5 * sum(abs(force @ hand.rotation[:, 1]) for force in forces)
        series[f"{robot.name}_carries"] = np.sum(forces, axis=0)[2]
        wanted = hand_paths.at(sim.time, *knots[robot.name])
        series[f"{robot.name}_error"] = np.abs(robot.q[:7] - wanted).max()
    series["weight"] = ball.mass * GRAVITY
    return series


def check(run):
    running.assert_close(results(run))


def results(run):
    """What came out, what is expected and how far it may be off, by name, in SI units."""
    t = running.measured(run)
    time, weight = t["time"], t["weight"][0]
    found: dict[str, tuple[float, float, float]] = {}
    alone = {"giver": (time > 0.95) & (time < 1.95), "taker": time > LET_GO + 0.1}
    for name, held in alone.items():
        slid = float(np.linalg.norm([np.ptp(t[f"{name}_{axis}"][held]) for axis in ("x", "y", "z")]))
        found |= {
            f"grip of the {name}": (t[f"{name}_grip"][held].mean(), 0.5 * GRIP, 0.02 * GRIP),
            f"slip in the {name}": (slid, 0.0, 2e-3),  # the ball sways and sags by a part of that
            f"error of the {name}": (t[f"{name}_error"].max(), 0.0, 0.03),
        }
    rest = time > time[-1] - 0.15
    found["carried"] = (t["taker_carries"][rest].mean(), weight, 0.03 * weight)
    squeezed = t["width_y"][(time > 1.2) & (time < 1.9)].mean()
    found["squeeze"] = (1.0 - squeezed / (2.0 * RADIUS), 0.2, 0.1)
    for axis, place in zip("xyz", END, strict=True):
        found[f"end {axis}"] = (t[axis][-1], place, 0.01)
    return found


def plot(run, path):
    """Height of the ball, grips, what the hands carry and where the ball is in them, over time."""
    t = running.measured(run)
    hands = ("giver", "taker")
    panels = {
        "height [mm]": {"": 1e3 * t["z"]},
        "grip [N]": {name: t[f"{name}_grip"] for name in hands},
        "carried [N]": {name: t[f"{name}_carries"] for name in hands},
        "error of the arms [mrad]": {name: 1e3 * t[f"{name}_error"] for name in hands},
    }
    return curves.write(path, t["time"], panels)


taken: list[list[SimpleNamespace]] = []  # what is where at MOMENTS


def on_step(sim, report):
    """Keeps what is where, with the surfaces that the file shows, at two moments."""
    if len(taken) < len(MOMENTS) and sim.time > MOMENTS[len(taken)] - 1e-9:
        arms = [part for robot in sim.robots for part in pictures.visuals(robot, {"finger": DARK}, WHITE)]
        taken.append([*arms, *(pictures.snapshot(sim[name]) for name in ("ball", "ring", "stand"))])


def draw(run, path):
    """The arms with the ball lifted, and the hands when both hold it, side by side."""
    arms, both = taken
    hands = [body for body in both if "finger" in body.name or "hand" in body.name or body.name == "ball"]
    views = []
    for bodies, seen, width, azimuth, elevation in ((arms, arms, 760, -78, 16), (both, hands, 520, -58, 24)):
        points = np.concatenate([body.positions for body in seen])
        camera = pictures.fitted_camera(points, azimuth * stark.deg, elevation * stark.deg, width / 520)
        views.append(stark.render.render(SimpleNamespace(bodies=bodies), width, 520, camera=camera))
    stark.render.write_png(path, np.concatenate(views, axis=1))
    return path


if __name__ == "__main__":
    sys.exit(running.main(__file__))
