"""robot_arm: an arm from a URDF file picks a cube from the floor, lifts it and carries it to the side.

What it shows: a robot with limits, friction and a gripper from examples/robot_arm.urdf, servos with gravity
compensation, inverse kinematics by the Jacobian, a gripper that closes with a given force.
The check: the cube is where the gripper carries it; the servos hold the weight of the arm and of the cube, up
to the dry friction of the joints; the grip is the force of the drive, half of it a finger.

    python examples/robot_arm.py    leaves a recording, plots and a picture in out/robot_arm
    stark run examples/robot_arm.py
"""

import sys
from pathlib import Path

import curves
import numpy as np
import pictures

import stark
import stark.scenes
from stark.recording import Recording

until = 2.6  # [s]
FILE = Path(__file__).with_suffix(".urdf")
ARM = ("turn", "shoulder", "elbow", "pitch", "roll")
STIFFNESS, DAMPING = (900.0, 900.0, 700.0, 300.0, 100.0), (60.0, 60.0, 40.0, 15.0, 5.0)
CUBE, MASS, FRICTION, GRIP = 0.04, 0.12, 0.6, 12.0  # [m], [kg], [1], of both fingers together [N]
REACH, LIFT, SIDE, GRAVITY = 0.34, 0.12, 0.6, 9.81  # [m], [m], [rad], [m/s^2]
OPEN = 0.035  # of a finger [m]
# When the arm is to be where [s]; it rests in between.
TIMES = (0.0, 0.5, 0.9, 1.5, 2.1)
GOALS = ("above", "at", "at", "lifted", "aside")
CLOSING = 0.55  # [s]
places: dict[str, np.ndarray] = {}  # q of the arm by name, from inverse kinematics


def settings():
    return {"time_step": 0.005, "contact_distance": 0.0005, "contact.stick_velocity": 1e-4}


def build():
    scene = stark.Scene()
    scene.default_friction = FRICTION
    scene.add_floor(1.4, color=(0.62, 0.64, 0.68))
    scene.add_box(
        CUBE, mass=MASS, position=(REACH, 0, 0.5 * CUBE + 0.0005), name="cube", color=(0.2, 0.62, 0.62)
    )
    low = 0.5 * CUBE + 0.01
    heights = {"above": 0.08, "at": 0.0, "lifted": LIFT}
    model = stark.Scene().add_robot(FILE)
    for name, height in heights.items():
        places[name] = inverse_kinematics(model, np.array([REACH, low + height]))
    places["aside"] = places["lifted"] + (SIDE, 0, 0, 0, 0)
    start = dict(zip(ARM, places["above"], strict=True)) | {"left_slide": OPEN}
    robot = scene.add_robot(FILE, q=start, position=(0, 0, 0.001))
    robot.add_servos(ARM, stiffness=STIFFNESS, damping=DAMPING, gravity_compensation=True)
    robot.add_efforts("left_slide")
    return scene


def inverse_kinematics(robot, goal):
    """q of the arm (5,) that has the gripper at ``goal`` (x, z) [m], pointing down."""
    q = np.array([0.0, 0.5, 1.6, 1.0, 0.0, 0.0])
    rows, columns = [0, 2, 4], [1, 2, 3]  # x, z and turn about y; shoulder, elbow, pitch
    error = np.ones(3)
    while np.abs(error).max() > 1e-9:
        frame = robot.forward_kinematics(q)["grip"]
        down = np.arctan2(frame.rotation[0, 2], frame.rotation[2, 2])  # pi where it points down
        error = np.array([*(goal - frame.position[[0, 2]]), np.pi - down % (2.0 * np.pi)])
        q[columns] += np.linalg.solve(robot.jacobian("grip", q=q)[np.ix_(rows, columns)], error)
    return q[:5]


def drive(sim):
    (robot,) = sim.robots
    arm, gripper = robot.drives
    time = sim.time + sim.time_step
    k = min(int(np.searchsorted(TIMES, time, side="right")), len(TIMES) - 1)
    s = np.clip((time - TIMES[k - 1]) / (TIMES[k] - TIMES[k - 1]), 0.0, 1.0)
    before, after = places[GOALS[k - 1]], places[GOALS[k]]
    arm.target = before + s * s * (3.0 - 2.0 * s) * (after - before)
    gripper.target = -GRIP if time > CLOSING else 0.0


def measure(sim):
    """After every step: place of the cube and of the gripper [m], efforts [N m] and what statics asks for."""
    (robot,) = sim.robots
    cube, grip = sim["cube"].position, robot.links["grip"]
    load = robot.jacobian("grip", grip.rotation.T @ (cube - grip.position))[2] * MASS * GRAVITY
    pads = [sim.contacts.of("cube", f"arm.{side}_finger").forces.sum(axis=0) for side in ("left", "right")]
    series = {"cube_height": cube[2], "grip_height": grip.position[2], "grip": np.linalg.norm(pads[0])}
    series |= {"cube_angle": np.arctan2(cube[1], cube[0])}
    for k, name in enumerate(ARM):
        series[f"tau_{name}"] = robot.tau[k]
        series[f"statics_{name}"] = (robot.gravity_efforts() + load)[k]
    return series


def check(run):
    for name, (value, reference, tolerance) in results(run).items():
        assert abs(value - reference) <= tolerance, f"{name} is {value:.6g}, expected {reference:.6g}"


def results(run):
    """What came out, what is expected and how far it may be off, by name, in SI units."""
    t = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    found = {
        "lift": (t["cube_height"][-1] - t["cube_height"][0], LIFT, 3e-3),  # a soft servo sags by the load
        "side": (t["cube_angle"][-1], SIDE, 5e-3),
        "grip": (t["grip"][-1], 0.5 * np.hypot(GRIP, MASS * GRAVITY), 0.05 * GRIP),
    }
    friction = {"turn": 0.05, "shoulder": 0.05, "elbow": 0.05, "pitch": 0.02, "roll": 0.02}
    for name in ARM:
        found[f"tau_{name}"] = (t[f"tau_{name}"][-1], t[f"statics_{name}"][-1], friction[name] + 0.01)
    return found


def plot(run, path):
    """Height of the cube, grip and efforts over time."""
    t = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    panels = {
        "height [mm]": {"cube": 1e3 * t["cube_height"], "gripper": 1e3 * t["grip_height"]},
        "grip [N]": {"": t["grip"]},
        "efforts [N m]": {name: t[f"tau_{name}"] for name in ARM[:4]},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """The end of the run."""
    shown = [pictures.part(body) for body in run.frame(-1).bodies if body.name != "floor"]
    return pictures.compose(path, shown, azimuth=50, elevation=20)


def main():
    result = stark.scenes.run(stark.scenes.load(__file__))
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    if result.exit_code:
        return result.exit_code
    run = Recording(result.folder)
    for name, (value, reference, tolerance) in results(run).items():
        print(f"  {name}: {value:.5g}, expected {reference:.5g} within {tolerance:.2g}")
    print(plot(run, run.folder / "curves.svg"))
    print(draw(run, run.folder / "robot_arm.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
