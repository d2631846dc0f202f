"""robot_towel: a vacuum robot meets a folded or rolled towel; the experiment of section IV-A of the paper.

What it shows: a robot with motors, suspension and casters on a folded towel, in one solve with the friction
of all pairs. The outcome is judged by numbers: "over" if the drive axle is 0.15 m beyond the front edge of
the towel at the end, still drives on, and the towel went less than half as far as the robot since they met;
"pushed" if the towel went 0.10 m and at least half as far; "stuck" otherwise, if the robot stands, as before
the roll at the end of a tail that it has driven onto. LABORATORY is Table I of the paper.
The check: motors keep their limit of torque, and the outcome is one of the three.

    python examples/robot_towel.py                  the flat towel on carpet; picture in out/robot_towel*
    stark run examples/robot_towel.py --option towel=two_folds --option floor=polished
    stark study run examples/robot_towel.toml       the sixteen runs of Table I, on coarse meshes
"""

import sys
from typing import Any

import curves
import numpy as np
import pictures
import towel
import vacuum_robot as robot

import stark
import stark.scenes
from stark.recording import Recording

until = 6.0  # [s]
options: dict[str, Any] = {
    "towel": "flat", "floor": "carpet", "cells": 100,
    # Factors of what is not known well, for studies of sensitivity.
    "mass": 1.0, "stretching": 1.0, "bending": 1.0, "friction": 1.0, "compliance": 1.0, "time_step": 0.005,
}  # fmt: skip
FRONT, LIFT = 0.514, 1.2e-3  # of the towel before the middle of the robot, above the floor [m]
OWN_FRICTION, WITH_ROBOT = 0.4, 1.0
AHEAD, MOVED, STANDS = 0.15, 0.10, 0.026  # [m], [m], [m/s]
COLOR = (0.93, 0.76, 0.42)
#: Table I of the paper.
LABORATORY = {
    "flat": ("over", "over"),
    "one_fold": ("over", "over"),
    "two_folds": ("over", "pushed"),
    "three_folds_folded": ("stuck", "pushed"),
    "three_folds_open": ("stuck", "pushed"),
    "roll_rolled": ("stuck", "pushed"),
    "roll_open": ("stuck", "over"),
    "roll_side": ("stuck", "stuck"),
}


def settings():
    return robot.settings() | {"time_step": options["time_step"]}


def build():
    robot.options.update(floor=options["floor"], segments=64)
    scene = robot.build()
    parts = [body for body in scene.bodies if body.name != "floor"]
    fabric = stark.materials.towel
    fabric = fabric.replace(
        youngs_modulus=options["stretching"] * fabric.youngs_modulus,
        strain_damping=options["stretching"] * fabric.strain_damping,
        bending_stiffness=options["bending"] * fabric.bending_stiffness,
        bending_damping=options["bending"] * fabric.bending_damping,
    )
    terry = stark.surfaces.terry_towel
    terry = terry.replace(stiffness=terry.stiffness / options["compliance"])
    cloth = scene.add_cloth(
        towel.mesh(options["cells"]), fabric, name="towel", mass=options["mass"] * towel.MASS,
        initial_positions=towel.placed(options["cells"], options["towel"]),
        position=(0.0, FRONT, LIFT + terry.thickness), surface=terry, friction=OWN_FRICTION, color=COLOR,
    )  # fmt: skip
    scene.friction[cloth, cloth] = OWN_FRICTION * options["friction"]
    scene.friction[cloth, scene["floor"]] = robot.FRICTION[options["floor"]]
    for part in parts:
        scene.friction[cloth, part] = WITH_ROBOT
    return scene


drive = robot.drive


def measure(sim):
    """After every step: of the robot place, height [m] and speed [m/s], motors [N m], suspension [m], pitch
    [rad]; of the towel its mean place [m] and the force of the robot on it [N]."""
    series = robot.measure(sim)
    cloth = sim["towel"].positions
    parts = ("body", *robot.WHEELS, *robot.CASTERS)
    push = np.sum([sim.contacts.of("towel", part).forces.sum(axis=0) for part in parts], axis=0)
    series |= {
        "y": sim["body"].position[1],
        "x": sim["body"].position[0],
        "pitch": np.arcsin(sim["body"].rotation[2, 1]),
        "towel_x": cloth[:, 0].mean(),
        "towel_y": cloth[:, 1].mean(),
        "towel_front": cloth[:, 1].min(),
        "push": push[1],
    }
    return series


def outcome(robot_y, towel_y, speed):
    """Over, pushed, stuck or undecided, and how far robot and towel went since the robot's front came to the
    towel [m], from the last places [m] and the speed of the robot [m/s]."""
    cells, configuration = options["cells"], options["towel"]
    robot_went = robot_y - (FRONT - robot.PROFILE[1][0])
    towel_went = towel_y - (FRONT + towel.placed(cells, configuration)[:, 1].mean())
    stands = abs(speed) < STANDS
    if robot_y > FRONT + AHEAD and towel_went < 0.5 * robot_went and not stands:
        word = "over"
    elif towel_went >= MOVED and towel_went >= 0.5 * robot_went:
        word = "pushed"
    else:
        word = "stuck" if stands else "undecided"
    return word, {"robot_went": robot_went, "towel_went": towel_went, "speed": speed}


def observables(sim):
    """At the end: outcome, in words as a status of its own, and what it follows from."""
    places = sim["body"].position[1], sim["towel"].positions[:, 1].mean()
    word, numbers = outcome(*places, sim["body"].velocity[1])
    return {name: float(word == name) for name in ("over", "pushed", "stuck")} | numbers


def results(run):
    """Outcome and what it follows from [m, m/s], largest torque [N m]."""
    series = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    time, y = series["time"], series["y"]
    last = time > time[-1] - 1.0
    speed = (y[-1] - y[last][0]) / (time[-1] - time[last][0])
    word, numbers = outcome(y[-1], series["towel_y"][-1], speed)
    torque = max(np.abs(series[f"torque_{name}"]).max() for name in robot.WHEELS)
    return {"outcome": word, **numbers, "torque": float(torque)}


def check(run):
    found = results(run)
    assert found["torque"] <= robot.TORQUE * (1.0 + 1e-9), f"torque {found['torque']} N m"
    assert found["outcome"] != "undecided", str(found)


def plot(run, path):
    """Place, speed, torque and suspension of the robot, place of the towel, over time."""
    settled = run.telemetry["time"] > 0.1
    t = {name.removeprefix("measured."): run.telemetry[name][settled] for name in run.telemetry.names}
    panels = {
        "went [m]": {"robot": t["y"], "towel": t["towel_y"] - t["towel_y"][0]},
        "speed [m/s]": {"": t["speed"]},
        "torque [mN m]": {name: 1e3 * t[f"torque_{name}"] for name in robot.WHEELS},
        "suspension [mm]": {name: 1e3 * t[f"compression_{name}"] for name in robot.WHEELS},
        "push [N]": {"": t["push"]},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """Robot and towel at the start, when they have met, and at the end."""
    shown = []
    for k, time in enumerate((0.0, 2.5, until)):
        bodies = run.frame(run.nearest(time)).bodies
        shown += [pictures.part(body, shift=(-1.2 * k, 0.0, 0.0)) for body in bodies if body.name != "floor"]
    return pictures.compose(path, shown, azimuth=-60, elevation=28)


def main():
    result = stark.scenes.run(stark.scenes.load(__file__, dict(word.split("=") for word in sys.argv[1:])))
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    run = Recording(result.folder)
    print(
        results(run),
        plot(run, run.folder / "curves.svg"),
        draw(run, run.folder / "robot_towel.png"),
        sep="\n",
    )
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
