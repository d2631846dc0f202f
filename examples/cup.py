"""cup: two fingers hold a plastic cup by friction while steel balls are laid into it, until it slides.

What it shows: a rigid gripper, a thin shell and many balls in one solve; the experiment of section IV-B of
the paper. Both fingers share 5 N, so each pad presses with 2.5 N, and two pads carry at most 2 mu N = 2.5 N:
the cup and 17 balls weigh 2.39 N, the cup and 18 balls 2.52 N. Then the cup slides, and the dents in its wall
latch onto the pads.
The check: pads press with half of the limit of the motor; nothing slides before 16 balls lie in the cup; it
slides before there are 22; the pads carry the weight of all; no ball leaves through the shell.

    python examples/cup.py              with 5 N of both fingers, then with 10 N, which hold all balls;
                                        leaves recordings, plots and a picture in out/cup*
    stark run examples/cup.py --option force=10.0
    stark study run examples/cup.toml   both, as a table
"""

import sys
from typing import Any

import curves
import gripper
import numpy as np
import pictures

import stark
import stark.scenes
from stark.recording import Recording

until = 11.0  # [s]
options: dict[str, Any] = {
    "force": 5.0,
    "balls": 24,
    "cells": 12,
}  # of both fingers [N]; balls; cells across the bottom
HEIGHT, BOTTOM, RIM, LIP_WIDTH = 0.100, 0.027, 0.036, 0.0025  # height, radii, lip [m]
# The sheet of the authors' program: E t = 1e6 N/m, E t^3 / (12 (1 - nu^2)) = 3e-4 N m, 0.2 kg/m^2.
PLASTIC = stark.ShellMaterial(
    density=0.2, thickness=1e-3, youngs_modulus=1e9, poissons_ratio=0.45, flexural_rigidity=3e-4,
    mass_damping=2.0, strain_damping=0.2, bending_damping=1e-7,
)  # fmt: skip
# Its edge is rolled, as that of PET cups is: a tube of 3 mm with a wall of 0.145 mm and E = 2.5 GPa.
LIP = stark.RodMaterial(
    density=267.0, radius=1.5e-3, youngs_modulus=2.5e9, axial_stiffness=3416.0, shear_stiffness=700.0,
    bending_stiffness_1=3.8e-3, bending_stiffness_2=3.8e-3, torsional_stiffness=2.8e-3, strain_damping=1e-3,
)  # fmt: skip
BALL_MASS, BALL_DENSITY = 0.014, 7850.0  # [kg], [kg/m^3]
CONTACT_DISTANCE, FRICTION = 0.0005, 0.5  # [m], between pads and cup
#: When the floor starts to slide away and how fast, when the first ball is let go, and the next [s], [m/s].
SLIDE, SLIDE_SPEED, FIRST, NEXT = 1.0, 0.1, 2.0, 0.25
#: A ball is lowered with this part of gravity, for so long; then what carries it fades away [1], [s], [s].
SINKING, LOWERED, FADED = 0.03, 1.0, 0.3
GRAVITY = 9.81  # [m/s^2]
CUP, STEEL = (0.35, 0.68, 0.85), (0.72, 0.74, 0.77)


def settings():
    return {
        "time_step": 0.005,
        "contact_distance": CONTACT_DISTANCE,
        "contact.stick_velocity": 1e-4,
        "newton.step_tolerance": 1e-5,
    }


def build():
    scene = stark.Scene()
    scene.default_friction = 0.0
    floor = (0.0, 0.0, -0.5 * HEIGHT - 0.01 - 1.5 * CONTACT_DISTANCE)
    scene.add_box(
        (0.12, 0.12, 0.02), name="floor", motion="scripted", position=floor, color=gripper.TABLE
    ).follow(position=lambda t: (0.0, max(t - SLIDE, 0.0) * SLIDE_SPEED, floor[2]))
    gripper.add_hand(scene, options["force"])
    cup = scene.add_cloth(
        cup_mesh(options["cells"]), PLASTIC, name="cup", rest_angles="mesh", self_contact=False, color=CUP
    )
    cup.add_fibres(LIP, paths=_rim(), color=CUP)
    for name in ("floor", "finger_left", "finger_right"):
        scene.friction[cup, scene[name]] = FRICTION
    for ball in range(options["balls"]):
        _add_ball(scene, ball)
    return scene


def cup_mesh(cells):
    """The shell about z = 0, its bottom a square grid that is made round; its triangles have about the
    length of the cells at the bottom."""
    grid = stark.mesh.grid(2.0, 2.0, cells)
    x, y, _ = grid.vertices.T
    disc = np.column_stack([x * np.sqrt(1.0 - 0.5 * y**2), y * np.sqrt(1.0 - 0.5 * x**2)])
    border = np.flatnonzero(np.maximum(abs(x), abs(y)) > 1.0 - 1e-9)
    border = border[np.argsort(np.arctan2(disc[border, 1], disc[border, 0]))]
    rows = round(HEIGHT / (0.5 * np.pi * RIM / cells))
    radius = [*np.linspace(BOTTOM, RIM, rows + 1)[1:], RIM + LIP_WIDTH]
    height = [*(HEIGHT * (np.arange(1, rows + 1) / rows - 0.5)), 0.5 * HEIGHT]
    points = [np.column_stack([BOTTOM * disc, np.full(len(disc), -0.5 * HEIGHT)])]
    faces, below, first = [grid.triangles], border, len(disc)
    for r, z in zip(radius, height, strict=True):
        points.append(np.column_stack([r * disc[border], np.full(len(border), z)]))
        above = first + np.arange(len(border))
        faces += [
            np.column_stack([below, np.roll(above, -1), np.roll(below, -1)]),
            np.column_stack([below, above, np.roll(above, -1)]),
        ]
        below, first = above, first + len(border)
    return stark.mesh.TriangleMesh(np.concatenate(points), np.concatenate(faces))


def _rim():
    """Vertices where the wall ends and the lip begins, in order."""
    count = 4 * options["cells"]
    first = len(cup_mesh(options["cells"]).vertices) - 2 * count
    return [[first + k % count for k in range(count + 1)]]


def _add_ball(scene, ball):
    """One of four above each other; it hovers until it is let go."""
    radius = (BALL_MASS / BALL_DENSITY * 0.75 / np.pi) ** (1.0 / 3.0)  # 7.5 mm
    level, place = divmod(ball, 4)
    x, y = ((-1, -1), (1, 1), (1, -1), (-1, 1))[place]
    body = scene.add_sphere(
        radius, subdivisions=2, mass=BALL_MASS, name=f"ball_{ball:02d}", color=STEEL,
        position=(0.013 * x, 0.010 * y, 0.062 + 0.018 * level),
    )  # fmt: skip
    weight, start = BALL_MASS * GRAVITY, let_go(ball)

    def carried(t):
        fades = min(max((t - start - LOWERED) / FADED, 0.0), 1.0)
        return (0.0, 0.0, weight * ((1.0 - SINKING) if t > start else 1.0) * (1.0 - fades))

    scene.add_force(body, carried)


def let_go(ball):
    """When a ball, counted from 0, starts to sink [s]."""
    return FIRST + NEXT * ball


def lies(ball):
    """When it carries itself no more [s]."""
    return let_go(ball) + LOWERED + FADED


def between_pads():
    """Vertices of the wall that the pads press on."""
    x, _, z = cup_mesh(options["cells"]).vertices.T
    return np.flatnonzero(
        (abs(z) < 0.5 * gripper.PAD_HEIGHT) & (abs(x) > 0.95 * np.abs(x[abs(z) < 0.02]).max())
    )


def measure(sim):
    """After every step: force of the drive, of the pads and what they carry [N], height of the wall between
    the pads [m], balls in the cup."""
    series = {"motor": next(a for a in sim.actuators if a.name == "motor").force}
    for name in gripper.FINGERS:
        force = sim.contacts.of("cup", f"finger_{name}").forces.sum(axis=0)
        series[f"grip_{name}"], series[f"carried_{name}"] = abs(force[0]), force[2]
    series["height"] = sim["cup"].positions[between_pads(), 2].mean()
    series["inside"] = float(count_inside(sim))
    return series


def count_inside(sim):
    """Balls below the rim, above the bottom and within the wall."""
    cup = sim["cup"].positions
    rim = cup[_rim()[0]].mean(axis=0)
    places = [sim[f"ball_{ball:02d}"].position for ball in range(options["balls"])]
    return sum(
        np.linalg.norm((x - rim)[:2]) < RIM and cup[:, 2].min() < x[2] < rim[2] for x in map(np.array, places)
    )


def observables(sim):
    """At the end: what the pads carry [N], balls in the cup."""
    series = measure(sim)
    return {"carried": series["carried_left"] + series["carried_right"], "inside": series["inside"]}


def check(run):
    want = expected()
    for name, value in results(run).items():
        low, high = want[name]
        assert low <= value <= high, f"{name} is {value:.6g}, expected {low:.6g} to {high:.6g}"


def results(run):
    """What came out, by name, in SI units."""
    series = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    time, balls = series["time"], options["balls"]
    grip = 0.5 * (series["grip_left"] + series["grip_right"])
    carried = series["carried_left"] + series["carried_right"]
    at_rest = time > time[-1] - 0.2

    def slid(ball):
        """From the first ball on until so many balls lie in the cup [m]."""
        return float(-np.diff(np.interp([FIRST, lies(ball - 1)], time, series["height"]))[0])

    found = {
        "motor": float(series["motor"].max()),
        "grip": float(grip[time > FIRST].mean()),
        "balance": float(np.abs(series["grip_left"] - series["grip_right"])[at_rest].max()),
        "carried": float(carried[at_rest].mean()),
        "inside": float(series["inside"][-1]),
        "creep": slid(min(balls, 16)),
    }
    return found | ({"slid": slid(22)} if balls >= 22 else {})


def expected():
    """What statics and the law of friction say: least and largest value by name."""
    force, load = options["force"], weight(options["balls"])
    want = {
        "motor": (force * (1.0 - 1e-9), force * (1.0 + 1e-9)),
        "grip": (0.98 * 0.5 * force, 1.02 * 0.5 * force),
        "balance": (0.0, 0.02 * force),
        "carried": (0.99 * load, 1.01 * load),
        "inside": (options["balls"], options["balls"]),
        "creep": (-2e-4, 2e-4),
    }
    # 22 balls weigh 3.08 N: more than two pads of 5 N carry, less than two of 10 N.
    slides = weight(22) > FRICTION * force
    return want | {"slid": (2e-4, HEIGHT) if slides else (-2e-4, 2e-4)}


def weight(balls):
    """Of the cup and of balls [N]."""
    lip = 2.0 * np.pi * RIM * LIP.density * np.pi * LIP.radius**2
    return GRAVITY * (cup_mesh(options["cells"]).area * PLASTIC.density + lip + balls * BALL_MASS)


def plot(run, path):
    """Force of the pads, what they carry, how far the cup has slid, over time."""
    t = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    start = np.interp(FIRST, t["time"], t["height"])
    panels = {
        "grip [N]": {name: t[f"grip_{name}"] for name in gripper.FINGERS},
        "carried by the pads [N]": {"": t["carried_left"] + t["carried_right"]},
        "slid [mm]": {"": np.where(t["time"] > FIRST, 1e3 * (start - t["height"]), 0.0)},
        "balls in the cup": {"": t["inside"]},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """Gripped, half full, at the end; the wall in front is cut away."""
    shown = []
    for k, time in enumerate((FIRST, lies(11), run.times[-1])):
        frame = run.frame(run.nearest(time))
        for body in frame.bodies:
            is_waiting = body.name.startswith("ball") and body.positions[:, 2].mean() > 0.055
            if is_waiting or body.name in ("floor", "hand"):
                continue
            keep = None
            if body.name == "cup":
                keep = body.positions[body.triangles].mean(axis=1)[:, 1] < 0.012
            shown.append(pictures.part(body, shift=(-0.13 * k, 0.0, 0.0), keep=keep))
    return pictures.compose(path, shown, azimuth=80, elevation=22)


def main():
    for force in sys.argv[1:] or ("5.0", "10.0"):
        result = stark.scenes.run(stark.scenes.load(__file__, {"force": force}))
        print(
            f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s"
        )
        if result.exit_code:
            return result.exit_code
        run = Recording(result.folder)
        print(plot(run, run.folder / "curves.svg"))
        print(draw(run, run.folder / "cup.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
