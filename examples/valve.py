"""valve: a hand of three fingers turns a valve with dry friction by that of its fingertips, twice.

What it shows: a robot without a file (stark.robots.RobotDescription), inverse kinematics of a finger, servos
with caps, a hinge with dry friction, grip and slip from the contacts.
The check: two strokes turn the wheel as far as the fingers go; while they turn it, the torque of the
fingertips is that of the friction of the stem; they stay within Coulomb's limit, and drift little; the wheel
stays where it is while they go back.

    python examples/valve.py    leaves a recording, plots and a picture in out/valve
    stark run examples/valve.py --option torque=0.4
"""

import sys
from typing import Any

import curves
import numpy as np
import pictures
import robot_parts
import running
from three_fingers import FINGERS, GRAPHITE, JOINTS, LOWER, STEEL, TIP, description

import stark

until = 3.2  # [s]
options: dict[str, Any] = {"torque": 0.3, "time_step": 0.005}  # dry friction of the stem [N m]; [s]
RADIUS, HALF, MASS = 0.035, 0.008, 0.15  # of the wheel, half of its thickness [m], [kg]
RISE = 0.100  # of the hand above the wheel [m]
STROKE, SQUEEZE, OPENING = 80 * stark.deg, 0.005, 0.012  # [rad], beyond touching and before it [m]
STIFFNESS, DAMPING, FRICTION = 20.0, 0.4, 0.8  # [N m/rad], [N m s/rad], [1]
# A stroke: when the hand is where [s], share of the stroke, share of the grip.
KNOTS = np.array([(0.0, 0, 0), (0.3, 0, 1), (1.1, 1, 1), (1.3, 1, 0), (1.6, 0, 0)])
PERIOD = KNOTS[-1, 0]
RED = (0.80, 0.22, 0.18)
places: dict[str, np.ndarray] = {}  # q of a finger, open and gripping, along the stroke


def settings():
    return {
        "time_step": options["time_step"],
        "contact_distance": 0.0005,
        "contact.stick_velocity": 2e-4,
        "newton.step_tolerance": 1e-4,
    }


def build():
    scene = stark.Scene()
    scene.default_friction = FRICTION
    hand, at = description(), (0.0, 0.0, RISE)
    model = stark.Scene().add_robot(hand, position=at)
    for name, radius in (("open", RADIUS + TIP + OPENING), ("grip", RADIUS + TIP - SQUEEZE)):
        places[name] = np.array([finger_at(model, radius, s) for s in np.linspace(-0.5, 0.5, 9) * STROKE])
    robot = scene.add_robot(hand, position=at, q=targets(0.0))
    robot.add_servos(stiffness=STIFFNESS, damping=DAMPING, gravity_compensation=True)
    add_valve(scene)
    return scene


def add_valve(scene):
    """A wheel with a mark on a stem, a body on a pipe."""
    corner = 0.002
    half = [(0.55 * RADIUS, HALF), (RADIUS - corner, HALF), (RADIUS, HALF - corner)]
    rim = robot_parts.lathed([*((r, -z) for r, z in half), *half[::-1]], 72)
    wheel = scene.add_rigid(rim, name="wheel", mass=MASS, color=RED)
    mark = stark.mesh.box((0.4 * RADIUS, 0.006, 0.003)).translated((0.55 * RADIUS, 0, HALF + 0.0016))
    scene.add_fixed(wheel, scene.add_rigid(mark, name="mark", mass=1e-3, color=STEEL))
    stem = scene.add_hinge(None, wheel, (0, 0, 0), (0, 0, 1), name="stem")
    stem.add_friction(options["torque"])
    for name, size, z in (("bonnet", (0.014, 0.05), -0.036), ("body", (0.03, 0.04), -0.082)):
        scene.add_cylinder(*size, name=name, motion="fixed", position=(0, 0, z), color=GRAPHITE)
    scene.disable_contact("wheel", "bonnet")
    pipe = stark.mesh.cylinder(0.022, 0.26, 48).rotated(stark.rotation(axis="y", angle=90 * stark.deg))
    scene.add_rigid(pipe, name="pipe", motion="fixed", position=(0, 0, -0.085), color=STEEL)


def finger_at(model, radius, angle):
    """q of the first finger (3,) that has the middle of its tip at a radius and an angle about the wheel."""
    start = model.q.copy()
    start[:3] = angle, -0.3, 0.5
    return model.inverse_kinematics(
        f"{FINGERS[0]}_lower", (radius * np.cos(angle), radius * np.sin(angle), 0.0),
        point=(0.0, 0.0, -LOWER), joints=[f"{FINGERS[0]}_{joint}" for joint in JOINTS], start=start,
    ).q[:3]  # fmt: skip


def targets(time):
    """q of the hand (9,): the same for each finger."""
    when = time % PERIOD
    shares = (np.interp(when, KNOTS[:, 0], KNOTS[:, column]) for column in (1, 2))
    turned, grip = (s * s * (3.0 - 2.0 * s) for s in shares)
    row = np.linspace(0.0, 1.0, len(places["open"]))
    open_, closed = (
        np.array([np.interp(turned, row, column) for column in places[name].T]) for name in ("open", "grip")
    )
    return np.tile(open_ + grip * (closed - open_), len(FINGERS))


def drive(sim):
    (robot,) = sim.robots
    (servos,) = robot.drives
    servos.target = targets(min(sim.time + sim.time_step, until - 1e-9))


def measure(sim):
    """After every step: angle of the wheel [rad], grip [N], moment on the wheel [N m], slip [m/s]."""
    stem = next(joint for joint in sim.joints if joint.name == "stem")
    series = {"angle": stem.angle, "rate": stem.rates["angle"], "moment": 0.0, "slip": 0.0, "use": 0.0}
    for name in FINGERS:
        pairs = sim.contacts.of("wheel", f"hand.{name}_lower")
        normal = np.linalg.norm(pairs.normal_forces.sum(axis=0))
        series[f"grip_{name}"] = normal
        series["moment"] += pairs.torque_about((0, 0, 0))[2]
        if normal > 0.5:
            # Tips also spin about where they touch: the middle of the contact counts.
            shares = np.linalg.norm(pairs.normal_forces, axis=1) / normal
            series["slip"] = max(series["slip"], np.linalg.norm(shares @ pairs.slips))
            used = np.linalg.norm(pairs.frictions.sum(axis=0)) / (FRICTION * normal)
            series["use"] = max(series["use"], used)
    return series


def check(run):
    running.assert_close(results(run))


def results(run):
    """What came out, what is expected and how far it may be off, by name, in SI units."""
    t = running.measured(run)
    phase = t["time"] % PERIOD
    turning, back = (phase > 0.5) & (phase < 0.95), (phase > 1.32) & (phase < PERIOD - 0.02)
    grip = np.mean([t[f"grip_{name}"][turning] for name in FINGERS], axis=0)
    needed = options["torque"] / (FRICTION * RADIUS * len(FINGERS))  # at the least
    torque, strokes = options["torque"], round(t["time"][-1] / PERIOD)
    return {
        # Tips roll on the wheel, which turns more than they do; servos give way by a few degrees.
        "angle": (t["angle"][-1], strokes * STROKE * (1.0 + TIP / RADIUS), strokes * 8 * stark.deg),
        "moment": (np.median(t["moment"][turning]), torque, 0.02 * torque),
        # Of the middle of the contact, about which tips spin while the fingers swing, and so drift a little.
        "slip": (t["slip"][turning].max(), 0.0, 0.03 * RADIUS * t["rate"].max()),
        "friction used": (t["use"][turning].max(), 0.5, 0.5),
        "grip": (grip.mean(), 3.0 * needed, 2.0 * needed),
        "back": (np.ptp(t["angle"][back & (t["time"] < PERIOD)]), 0.0, 1e-3),
    }


def plot(run, path):
    """Angle of the wheel, moment on it, grip and slip over time."""
    t = running.measured(run)
    panels = {
        "wheel [deg]": {"": np.rad2deg(t["angle"])},
        "moment on it [N m]": {"": t["moment"]},
        "grip [N]": {name: t[f"grip_{name}"] for name in FINGERS},
        "slip [mm/s]": {"": 1e3 * t["slip"]},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """Three moments of the first stroke side by side: the grip, half way, let go."""
    shown = []
    for k, time in enumerate((0.3, 0.72, 1.3)):
        frame = run.frame(run.nearest(time))
        shown += [pictures.part(body, shift=(0.30 * k, 0.0, 0.0)) for body in frame.bodies]
    return pictures.compose(path, shown, azimuth=-90, elevation=24)


if __name__ == "__main__":
    sys.exit(running.main(__file__))
