"""fold_by_arm: an arm pinches the edge of a towel, folds it over and lets go.

What it shows: the arm of examples/robot_arm.urdf, paths of its hand by inverse kinematics, cloth that is held
by friction alone between two fingers, layers of terry on one another.
The check: the hand does not lose the edge; at the end the upper half lies flat on the lower one, the edges
nearly on each other.

    python examples/fold_by_arm.py    leaves a recording, plots and a picture in out/fold_by_arm
    stark run examples/fold_by_arm.py --option cells=16
"""

import sys
from pathlib import Path
from typing import Any

import curves
import hand_paths
import numpy as np
import pictures
import running

import stark

until = 3.6  # [s]
options: dict[str, Any] = {"cells": 24, "time_step": 0.01}  # along the towel; [s]
FILE = Path(__file__).with_name("robot_arm.urdf")
ARM = ["turn", "shoulder", "elbow", "pitch", "roll"]
STIFFNESS, DAMPING = (900.0, 900.0, 700.0, 300.0, 100.0), (40.0, 40.0, 30.0, 10.0, 4.0)
LENGTH, WIDTH, TAB = 0.24, 0.15, 0.04  # of the towel, of the edge that stands up [m]
REACH, GRIP, FRICTION, OWN_FRICTION = 0.34, 1.6, 0.8, 0.5  # [m], of both fingers together [N], [1]
TERRY = stark.surfaces.terry_towel
LOW = TERRY.thickness + 0.0012  # middle of the lowest layer [m]
HALF = 0.5 * LENGTH - TAB  # from the fold to where the fingers hold [m]
TIP, CLEAR = 0.022, 0.004  # from the frame of the grip to the tips, from the tips to the layer below [m]
BOARD = (0.30, 0.42, 0.55)
EDGE = 0.003  # by which edges may be off [m]
FOLDED, RELEASED, RAISED = 2.2, 2.4, 3.0  # when [s]
DOWN = np.diag([-1.0, 1.0, -1.0])
path: dict[str, np.ndarray] = {}  # times (k,) and rows, q of the arm (k, 5)


def settings():
    return {"time_step": options["time_step"], "contact_distance": 0.0008}


def build():
    scene = stark.Scene()
    scene.default_friction = FRICTION
    floor = scene.add_floor(1.6)
    scene.add_box((0.20, 0.34, 0.02), name="board", motion="fixed", position=(REACH, 0, -0.0101), color=BOARD)
    scene.disable_contact("board", floor)
    times, places = hand_path()
    model = stark.Scene().add_robot(FILE)
    rows = hand_paths.of_joints(model, "grip", places, DOWN, ARM, (0.0, 0.5, 1.6, 1.0, 0.0, 0.0))[:, :5]
    path.update(times=times, rows=rows)
    robot = scene.add_robot(FILE, q=[*rows[0], 0.006], position=(0, 0, 0.001))
    robot.add_servos(ARM, stiffness=STIFFNESS, damping=DAMPING, gravity_compensation=True)
    robot.add_servos("left_slide", stiffness=4000.0, damping=40.0, cap=GRIP, target=0.006)
    mesh = towel_mesh()
    cloth = scene.add_cloth(
        mesh, stark.materials.towel, name="towel", initial_positions=laid(mesh.vertices), surface=TERRY,
        friction=FRICTION, color=(0.95, 0.93, 0.88),
    )  # fmt: skip
    scene.friction[cloth, cloth] = OWN_FRICTION
    return scene


def towel_mesh():
    """Flat, about the origin."""
    cells = (round(options["cells"] * WIDTH / LENGTH), options["cells"])
    return stark.mesh.grid(WIDTH, LENGTH, cells=cells)


def laid(flat):
    """The towel on the board, its edge up between the fingers."""
    x, y, _ = flat.T
    up = np.maximum(-HALF - y, 0.0)
    return np.column_stack([REACH + x, np.maximum(y, -HALF), LOW + up])


def hand_path():
    """Times (k,) and places of the grip (k, 3): over to the other side on half a circle, then up."""
    angles = np.linspace(0.0, np.pi, 25)
    rise = 0.9 * HALF * np.sin(angles) + np.linspace(0.0, 2.0 * TERRY.thickness, 25)
    low = LOW + TIP + CLEAR
    over = np.column_stack([np.full(25, REACH), -HALF * np.cos(angles), low + rise])
    times = 0.3 + (FOLDED - 0.3) * np.linspace(0.0, 1.0, 25)
    raised = over[-1] + (0.0, 0.0, 0.12)
    return np.array([0.0, *times, RELEASED + 0.15, RAISED]), np.array([over[0], *over, over[-1], raised])


def drive(sim):
    (robot,) = sim.robots
    arm, fingers = robot.drives
    time = sim.time + sim.time_step
    arm.target = hand_paths.at(time, **path)
    closing, opening = 0.006 - 0.03 * time, 0.05 * (time - RELEASED)
    fingers.target = max(closing, 0.0) if time < RELEASED else min(opening, 0.012)


def measure(sim):
    """After every step: grip [N], edge in the hand [m], share of the upper half that lies on the lower one,
    distance of their edges, height and fastest vertex [m], [m/s]."""
    (robot,) = sim.robots
    hand, towel, flat = robot.links["grip"], sim["towel"], towel_mesh().vertices
    now = towel.positions
    held = (flat[:, 1] < -0.5 * LENGTH + 0.6 * TAB) & (np.abs(flat[:, 0]) < 0.011)
    upper, lower = now[flat[:, 1] < -1e-9], now[flat[:, 1] > 1e-9]
    low, top = lower[:, :2].min(axis=0) - EDGE, lower[:, :2].max(axis=0) + EDGE
    inside = (upper[:, :2] > low) & (upper[:, :2] < top)
    sides = (sim.contacts.of("towel", f"arm.{side}_finger").normal_forces for side in ("left", "right"))
    edges = (np.isclose(flat[:, 1], side * 0.5 * LENGTH) for side in (-1.0, 1.0))
    apart = np.subtract(*(now[edge].mean(axis=0) for edge in edges))
    return {
        "grip": 0.5 * sum(np.linalg.norm(forces.sum(axis=0)) for forces in sides),
        "slip": ((now[held] - hand.position) @ hand.rotation).mean(axis=0)[2],
        "overlap": inside.all(axis=1).mean(),
        "edges": abs(apart[1]),
        "height": now[:, 2].max(),
        "speed": np.linalg.norm(towel.velocities, axis=1).max(),
    }


def check(run):
    running.assert_close(results(run))


def results(run):
    """What came out, what is expected and how far it may be off, by name, in SI units."""
    t = running.measured(run)
    time = t["time"]
    carried = (time > 0.35) & (time < FOLDED)
    return {
        "grip": (t["grip"][carried].mean(), 0.5 * GRIP, 0.1 * GRIP),
        "slip": (np.ptp(t["slip"][carried]), 0.0, 5e-4),
        "overlap": (t["overlap"][-1], 1.0, 0.03),
        "edges": (t["edges"][-1], 0.0, 0.005),
        "height": (t["height"][-1], LOW + 2.0 * TERRY.thickness, 0.002),
        "speed": (t["speed"].max(), 0.0, 1.5),
        "rest": (t["speed"][-1], 0.0, 0.02),
    }


def plot(run, path):
    """Grip, how far the edge moves in the hand, share of the towel that is folded, over time."""
    t = running.measured(run)
    panels = {
        "grip [N]": {"": t["grip"]},
        "edge in the hand [mm]": {"": 1e3 * t["slip"]},
        "upper half on the lower one": {"": t["overlap"]},
        "highest point [mm]": {"": 1e3 * t["height"]},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """Three moments side by side: gripped, half way, let go."""
    shown = []
    for k, time in enumerate((0.3, 1.3, until)):
        frame = run.frame(run.nearest(time))
        shown += [
            pictures.part(body, shift=(0.0, 0.46 * k, 0.0)) for body in frame.bodies if body.name != "floor"
        ]
    return pictures.compose(path, shown, azimuth=14, elevation=24)


if __name__ == "__main__":
    sys.exit(running.main(__file__))
