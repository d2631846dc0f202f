"""rover: six driven wheels on rockers and bogies, from an MJCF file, drive over loose rubble.

What it shows: a robot with a free base from examples/rover.xml, a differential between its rockers (a linear
equality of the file becomes a gear), motors on a group of joints, contact wrenches of the wheels.
The check: at rest the wheels carry the weight; motors keep their limit; the rockers turn against each other;
the rover goes as far as its wheels would roll, less what they slip on stones.

    python examples/rover.py    leaves a recording, plots and a picture in out/rover
    stark run examples/rover.py --option rocks=20
"""

import sys
from pathlib import Path
from typing import Any

import curves
import numpy as np
import pictures

import stark
import stark.scenes
from stark.recording import Recording

until = 4.0  # [s]
options: dict[str, Any] = {"rocks": 60, "seed": 3}
FILE = Path(__file__).with_suffix(".xml")
SIDES = [f"{side}_{place}_wheel" for side in ("left", "right") for place in ("front", "middle", "rear")]
MASS, RADIUS, GRAVITY = 8.0 + 2 * (0.8 + 0.4 + 3 * 0.6), 0.065, 9.81  # [kg], [m], [m/s^2]
SPEED, CAP, START = 4.0, 1.5, 0.3  # of the wheels [rad/s], [N m], when they set off [s]
FRICTION, DENSITY = 0.8, 2600.0  # [1], of stones [kg/m^3]


def settings():
    return {"time_step": 0.01, "contact_distance": 0.001, "contact.stick_velocity": 0.005}


def build():
    scene = stark.Scene()
    scene.default_friction = FRICTION
    scene.add_floor(4.0, color=(0.72, 0.55, 0.42))
    robot = scene.add_robot(FILE, position=(0, 0, 0.002))
    robot.add_group("wheels", SIDES)
    robot.add_motors("wheels", cap=CAP, delta=0.5)
    add_rubble(scene)
    return scene


def add_rubble(scene):
    """Stones in front of the rover, each in a cell of its own."""
    random = np.random.default_rng(options["seed"])
    columns = 6
    for k in range(options["rocks"]):
        row, column = divmod(k, columns)
        radius = random.uniform(0.016, 0.034)
        ball = stark.mesh.sphere(radius, 1)
        stone = stark.mesh.TriangleMesh(
            ball.vertices * random.uniform(0.8, 1.15, len(ball.vertices))[:, None] * (1.2, 1.0, 0.7),
            ball.triangles,
        )
        at = (0.42 + 0.1 * row, 0.1 * (column - 0.5 * (columns - 1)), 0.002 - stone.bounds[0, 2])
        shift = random.uniform(-0.008, 0.008, 2)
        gray = random.uniform(0.35, 0.62)
        scene.add_rigid(
            stone, name=f"rock_{k}", density=DENSITY, position=np.add(at, (*shift, 0.0)),
            color=(gray, 0.85 * gray, 0.72 * gray),
        )  # fmt: skip


def drive(sim):
    (robot,) = sim.robots
    (motors,) = robot.drives
    motors.target = SPEED if sim.time + sim.time_step > START else 0.0


def measure(sim):
    """After every step: place [m], pitch and rockers [rad], torques [N m], load of the wheels [N]."""
    (robot,) = sim.robots
    chassis = robot.links["chassis"]
    q = dict(zip(robot.coordinates, robot.q, strict=True))
    wrenches = [robot.links[name].contact_wrench() for name in SIDES]
    return {
        "x": chassis.position[0],
        "z": chassis.position[2],
        "pitch": -np.arcsin(chassis.rotation[2, 0]),
        "rocker": q["left_rocker"],
        "other_rocker": robot.joints["right_rocker"].angle,
        "rolled": RADIUS * np.mean([q[name] for name in SIDES]),
        "torque": np.abs(robot.tau).max(),
        "load": sum(wrench.force[2] for wrench in wrenches),
    }


def check(run):
    for name, (value, reference, tolerance) in results(run).items():
        assert abs(value - reference) <= tolerance, f"{name} is {value:.6g}, expected {reference:.6g}"


def results(run):
    """What came out, what is expected and how far it may be off, by name, in SI units."""
    t = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    rest = np.searchsorted(t["time"], START - 0.02)
    rolled = t["rolled"][-1] - t["rolled"][rest]
    return {
        "load": (t["load"][rest], MASS * GRAVITY, 0.01 * MASS * GRAVITY),
        "torque": (t["torque"].max(), 0.5 * CAP, 0.5 * CAP * (1.0 + 1e-9)),
        "differential": (np.abs(t["rocker"] + t["other_rocker"]).max(), 0.0, 1e-3),
        # Wheels climb stones, and slip: the way is shorter than what they roll, by a fifth at most.
        "way": (t["x"][-1] - t["x"][rest], 0.9 * rolled, 0.1 * rolled + 0.01),
    }


def plot(run, path):
    """Way, attitude and drives over time."""
    t = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    panels = {
        "way [m]": {"chassis": t["x"], "wheels": t["rolled"]},
        "angle [deg]": {"pitch": np.rad2deg(t["pitch"]), "rocker": np.rad2deg(t["rocker"])},
        "largest torque [N m]": {"": t["torque"]},
        "load of the wheels [N]": {"": t["load"]},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """On the stones, half way."""
    frame = run.frame(run.nearest(0.6 * run.telemetry["time"][-1]))
    shown = [pictures.part(body) for body in frame.bodies if body.name != "floor"]
    return pictures.compose(path, shown, azimuth=-50, elevation=22)


def main():
    result = stark.scenes.run(stark.scenes.load(__file__, dict(word.split("=") for word in sys.argv[1:])))
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    run = Recording(result.folder)
    for name, (value, reference, tolerance) in results(run).items():
        print(f"  {name}: {value:.5g}, expected {reference:.5g} within {tolerance:.2g}")
    print(plot(run, run.folder / "curves.svg"))
    print(draw(run, run.folder / "rover.png"))
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
