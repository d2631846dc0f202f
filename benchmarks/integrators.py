"""Compares implicit Euler and BDF2 on ten scenes, error against CPU time:

    PYTHONPATH=python python -m benchmarks.integrators [NAME...] [--write]

A run is sampled every 0.05 s of simulated time, which every step length meets. Its error is the largest
distance of the observable from the reference at these times. The reference is BDF2 at a step far below the
others, with tolerances a hundred times as small; implicit Euler, extrapolated from two such steps, tells how
sure it is. The CPU time is that of the stepping alone, on one thread, the best of several runs.

``--write`` puts the tables into docs/integrators.md. It takes some minutes."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

PAGE = Path(__file__).resolve().parents[1] / "docs" / "integrators.md"
INTEGRATORS = ("implicit_euler", "bdf2")
STEPS = {"1/60 s": 1 / 60, "10 ms": 0.01, "5 ms": 0.005, "2 ms": 0.002, "1 ms": 0.001}  # [s]
SAMPLE = 0.05  # [s]
#: Errors over the extent of the motion: what is asked for, what is as good as none.
GOAL, NOTHING = 0.01, 0.001
FINE = {"newton.acceleration_tolerance": 1e-4, "newton.step_tolerance": 1e-5}
STORED = ("kinetic", "elastic", "gravity", "contact")
BEGIN, END = "<!-- table -->", "<!-- end -->"
Vector = NDArray[np.float64]


@dataclass
class Setup:
    """A scene, and what is looked at in it: a point [m] or angles [rad]."""

    scene: stark.Scene
    observe: Callable[[], Any]
    #: Before each step, with the time at its end.
    drive: Callable[[float], None] | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class Case:
    name: str
    observable: str
    unit: str
    until: float  # [s]
    build: Callable[[], Setup]
    reference_step: float = 1e-4  # [s]
    #: Whether nothing feeds energy into the scene, so that what is stored must not grow.
    passive: bool = True
    #: Whether the reference is the state of rest, and only the end of the run counts.
    at_rest: bool = False


@dataclass
class Run:
    """Samples (times, size of the observable), and what they cost."""

    samples: Vector
    cpu_s: float
    iterations: int
    steps: int
    halvings: int
    growth: float  # rise of the stored energy above that of the first step, over the largest kinetic energy


# --- the scenes ---


def spin() -> Setup:
    scene = stark.Scene()
    box = scene.add_box((0.1, 0.2, 0.3), mass=1.0, angular_velocity=(0.3, 6.0, 0.2))
    # The norm of a small difference of two rotations is then its angle.
    return Setup(scene, lambda: box.rotation.ravel() / math.sqrt(2.0), gravity=(0.0, 0.0, 0.0))


def rolling() -> Setup:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_floor(4.0)
    ball = scene.add_sphere(
        0.1,
        subdivisions=4,
        mass=1.0,
        position=(-0.5, 0.03, 0.1012),
        velocity=(1, 0, 0),
        angular_velocity=(0, 10, 0),
    )
    return Setup(scene, lambda: ball.position[:1])


def drop() -> Setup:
    scene = stark.Scene()
    scene.add_floor(1.0)
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3, strain_damping=300.0)
    box = scene.add_solid(stark.mesh.tet_box(0.1, cells=2), rubber, position=(0.02, 0.01, 0.15))
    return Setup(scene, lambda: box.positions[:, 2].mean())


def stack() -> Setup:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_floor(1.0)
    boxes = [scene.add_box(0.1, mass=1.0, position=(0.02, 0.01, 0.055 + 0.105 * i)) for i in range(3)]
    return Setup(scene, lambda: np.concatenate([box.position for box in boxes]))


def cloth() -> Setup:
    scene = stark.Scene()
    cells = 8
    material = stark.ShellMaterial(
        density=0.2, youngs_modulus=1000.0, bending_stiffness=1e-5, strain_damping=0.1
    )
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, cells=cells), material, pins=[0, cells])
    corner = len(sheet.mesh.vertices) - 1
    return Setup(scene, lambda: sheet.positions[corner])


def soft() -> Setup:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box((0.2, 0.04, 0.04), cells=(8, 2, 2))
    material = stark.SolidMaterial(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3)
    clamped = mesh.vertices[:, 0] < mesh.vertices[:, 0].min() + 1e-9
    tip = mesh.vertices[:, 0] > mesh.vertices[:, 0].max() - 1e-9
    bar = scene.add_solid(mesh, material, pins=clamped)
    return Setup(scene, lambda: bar.positions[tip].mean(axis=0))


def _link(scene: stark.Scene, parent: Any, x: float) -> tuple[Any, Any]:
    """A link of 0.3 m that hangs at ``x`` on its parent, horizontally, and its hinge."""
    link = scene.add_box((0.28, 0.04, 0.04), mass=0.5, position=(x + 0.15, 0.0, 0.0))
    return link, scene.add_hinge(parent, link, anchor=(x, 0.0, 0.0), axis=(0.0, -1.0, 0.0))


def robot() -> Setup:
    scene = stark.Scene()
    base = scene.add_box(0.1, motion="fixed", position=(-0.06, 0.0, 0.0))
    upper, shoulder = _link(scene, base, 0.0)
    fore, elbow = _link(scene, upper, 0.3)
    servo = shoulder.add_servo(0.0, stiffness=100.0, damping=5.0, cap=30.0)
    motor = elbow.add_motor(0.0, cap=5.0, delta=1.0)

    def drive(end: float) -> None:
        servo.target = 0.6 * (1.0 - math.cos(2.0 * math.pi * end))
        motor.target = 3.0 * math.sin(2.0 * math.pi * end)

    return Setup(scene, lambda: fore.position + fore.rotation @ (0.15, 0.0, 0.0), drive)


def gripper() -> Setup:
    scene = stark.Scene()
    scene.default_friction = 0.5
    scene.add_floor(1.0)
    palm = scene.add_box((0.2, 0.06, 0.02), motion="scripted", position=(0.0, 0.0, 0.15))
    fingers = [scene.add_box((0.01, 0.03, 0.1), mass=0.1, position=(x, 0.0, 0.08)) for x in (-0.03, 0.03)]
    left, right = (scene.add_slider(palm, f, anchor=f.position, axis=(1.0, 0.0, 0.0)) for f in fingers)
    right.add_gear(left, ratio=-1.0)
    left.add_motor(0.1, cap=20.0, delta=0.02)
    box = scene.add_box(0.04, mass=0.2, position=(0.0, 0.0, 0.0215))
    palm.follow(
        position=stark.motion.spline([0.2, 0.4, 0.6], [(0, 0, 0.15), (0.05, 0, 0.25), (0.2, 0, 0.25)])
    )
    return Setup(scene, lambda: box.position)


def pendulum() -> Setup:
    scene = stark.Scene()
    upper, first = _link(scene, None, 0.0)
    _, second = _link(scene, upper, 0.3)
    return Setup(scene, lambda: (first.angle, second.angle))


def rod() -> Setup:
    scene = stark.Scene()
    material = stark.RodMaterial(density=1100.0, youngs_modulus=2e6, radius=0.004)
    cable = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.4, 0, 0), segments=16), material, clamps=[0])
    return Setup(scene, lambda: cable.positions[-1])


CASES = (
    Case("free spin", "orientation of a tumbling box", "rad", 1.0, spin, 1e-3),
    Case("rolling", "distance that a ball rolls", "m", 0.5, rolling),
    Case("drop", "height of a rubber box that falls by 0.1 m", "m", 0.5, drop),
    Case("stack", "places of three boxes, at 0.5 s, against those at rest", "m", 0.5, stack, at_rest=True),
    Case("cloth", "free corner of a sheet that swings", "m", 0.3, cloth),
    Case("soft solid", "tip of a clamped bar that swings", "m", 0.5, soft),
    Case("robot", "tip of an arm with servo and motor", "m", 1.0, robot, 5e-4, False),
    Case("gripper", "a box that is gripped, lifted, carried", "m", 0.7, gripper, passive=False),
    Case("mechanism", "angles of a double pendulum", "rad", 1.0, pendulum, 5e-4),
    Case("rod", "tip of a clamped rod that swings", "m", 0.5, rod),
)


# --- measuring ---


def run(case: Case, integrator: str, step: float, until: float | None = None, **settings: Any) -> Run:
    """One run, with the settings of the library but for what is given."""
    setup = case.build()
    settings = {"time_step": step, "time.integrator": integrator, "gravity": setup.gravity, **settings}
    sim = stark.Simulation(setup.scene, threads=1, **settings)
    end = case.until if until is None else until
    done = Run(np.empty(0), 0.0, 0, 0, 0, 0.0)
    samples, energies, kinetic = [np.atleast_1d(setup.observe()).copy()], [], 1e-12
    while sim.time < end - 1e-9:
        begin = time.process_time()
        if setup.drive is not None:
            setup.drive(sim.time + sim.time_step)
        report = sim.step(max_time_step=end - sim.time)
        done.cpu_s += time.process_time() - begin
        if report.failed:
            raise RuntimeError(f"{case.name}, {integrator}, step of {step} s: {report.message}")
        done.iterations += report.newton_iterations
        done.steps += 1
        done.halvings += report.rejected_steps
        energies.append(sum(report.energy[part] for part in STORED))
        kinetic = max(kinetic, report.energy["kinetic"])
        if sim.time > SAMPLE * len(samples) - 1e-9:
            samples.append(np.atleast_1d(setup.observe()).copy())
    done.samples = np.array(samples, float)
    done.growth = (max(energies) - energies[0]) / kinetic
    return done


def distance(a: Vector, b: Vector) -> float:
    """Largest of the distances at the times of the samples."""
    return float(np.linalg.norm(a - b, axis=1).max())


def reference(case: Case) -> tuple[Vector, float]:
    """What the samples should be, and how far from it the other integrator is."""
    if case.at_rest:
        rest = run(case, "implicit_euler", 0.004, until=3.0, **FINE).samples[-1:]
        return rest, distance(rest, run(case, "implicit_euler", 0.002, until=3.0, **FINE).samples[-1:])
    fine, half = case.reference_step, 0.5 * case.reference_step
    samples = run(case, "bdf2", half, **FINE).samples
    euler = 2.0 * run(case, "implicit_euler", half, **FINE).samples
    return samples, distance(samples, euler - run(case, "implicit_euler", fine, **FINE).samples)


def cost_of(error: float, rows: list[dict[str, Any]]) -> tuple[float | None, bool]:
    """CPU seconds for an error, from the coarsest step on from which all runs have it; whether a step as long
    as the longest one is already enough. Between two steps logarithms are linear."""
    good = len(rows)
    while good > 0 and rows[good - 1]["error"] <= error:
        good -= 1
    if good == len(rows):
        return None, False
    if good == 0:
        return rows[0]["cpu_s"], True
    a, b = rows[good - 1], rows[good]
    share = math.log(a["error"] / error) / math.log(a["error"] / max(b["error"], 1e-15))
    return a["cpu_s"] * (b["cpu_s"] / a["cpu_s"]) ** share, False


def error_ratio(euler: list[dict[str, Any]], bdf2: list[dict[str, Any]], least: float) -> float:
    """Error of implicit Euler over that of BDF2 at the same CPU time: geometric mean over the times of the
    steps of implicit Euler, where BDF2 has longer and shorter ones. Errors are ``least`` at least."""
    bdf2 = sorted(bdf2, key=lambda row: row["cpu_s"])
    times = [math.log(row["cpu_s"]) for row in bdf2]
    errors = [math.log(max(row["error"], least)) for row in bdf2]
    inside = [row for row in euler if times[0] <= math.log(row["cpu_s"]) <= times[-1]]
    logs = [
        math.log(max(row["error"], least)) - np.interp(math.log(row["cpu_s"]), times, errors)
        for row in inside
    ]
    return math.exp(sum(logs) / len(logs)) if logs else math.nan


def measure(case: Case) -> dict[str, Any]:
    expected, doubt = reference(case)
    start = run(case, "implicit_euler", SAMPLE, until=SAMPLE).samples[0]
    extent = float(np.linalg.norm(expected - start, axis=1).max())
    result: dict[str, Any] = {"scene": case.name, "observable": case.observable, "unit": case.unit}
    result |= {"extent": extent, "doubt": doubt}
    for integrator in INTEGRATORS:
        rows = result[integrator] = []
        for name, step in STEPS.items():
            runs = [run(case, integrator, step)]
            while len(runs) < 9 and sum(r.cpu_s for r in runs) < 0.4:
                runs.append(run(case, integrator, step))
            samples = runs[0].samples[-1:] if case.at_rest else runs[0].samples
            rows.append({"step": name, "error": distance(samples, expected)})
            rows[-1]["cpu_s"] = min(r.cpu_s for r in runs)
            rows[-1] |= {k: getattr(runs[0], k) for k in ("iterations", "steps", "halvings", "growth")}
            if not case.passive:
                rows[-1]["growth"] = None
    return result


# --- the page ---


def in_units(value: float, unit: str) -> str:
    """With two digits, in units of which there are no more than 1000."""
    if value < 1e-6:
        return "0"
    if unit == "rad":
        return f"{float(f'{value:.2g}'):g} rad"
    scale, name = next(
        u for u in ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm")) if value >= 0.1 * u[0] or u[0] < 1e-5
    )
    return f"{float(f'{value / scale:.2g}'):g} {name}"


def seconds(cost: float | None, longest: bool) -> str:
    if cost is None:
        return "not reached"
    return f"{'≤ ' if longest else ''}{float(f'{1e3 * cost:.2g}'):g} ms"


def better(euler: tuple[float | None, bool], bdf2: tuple[float | None, bool]) -> str:
    """Who needs less time for the goal, by which factor."""
    if euler[0] is None or bdf2[0] is None:
        return "neither" if euler[0] is bdf2[0] else "BDF2" if euler[0] is None else "implicit Euler"
    if euler[1] and bdf2[1]:
        return "both, at any step"
    factor = euler[0] / bdf2[0]
    return f"BDF2, {factor:.1f}" if factor > 1.0 else f"implicit Euler, {1.0 / factor:.1f}"


COSTS = """
CPU time for an error of 1 % of the motion. Errors are those of implicit Euler over those of BDF2, costs those
of BDF2 over those of implicit Euler. Errors below 0.1 % of the motion count as 0.1 %.

| scene | implicit Euler | BDF2 | less time, by | error at the same CPU time | CPU time of a step | iterations | doubt |
|---|--:|--:|---|--:|--:|--:|--:|
"""  # noqa: E501


def tables(results: list[dict[str, Any]]) -> str:
    shown = [name for name in STEPS if name != "2 ms"]
    text = "Error, implicit Euler / BDF2:\n\n"
    text += f"| scene | observable | 1 % of its motion | {' | '.join(shown)} |\n"
    text += f"|---|---|--:|{'--:|' * len(shown)}\n"
    for result in results:
        unit, cells = result["unit"], []
        for name in shown:
            pair = [next(r for r in result[i] if r["step"] == name)["error"] for i in INTEGRATORS]
            cells.append(" / ".join(in_units(error, unit) for error in pair))
        goal = in_units(GOAL * result["extent"], unit)
        text += f"| {result['scene']} | {result['observable']} | {goal} | {' | '.join(cells)} |\n"
    text += COSTS
    for result in results:
        euler, bdf2, extent = *(result[i] for i in INTEGRATORS), result["extent"]
        costs = [cost_of(GOAL * extent, rows) for rows in (euler, bdf2)]
        cpu, iterations = (
            math.exp(np.mean([math.log(b[k] / a[k]) for a, b in zip(euler, bdf2, strict=True)]))
            for k in ("cpu_s", "iterations")
        )
        text += f"| {result['scene']} | {seconds(*costs[0])} | {seconds(*costs[1])} | {better(*costs)} "
        text += f"| {error_ratio(euler, bdf2, NOTHING * extent):.2g} | {cpu:.2f} | {iterations:.2f} "
        text += f"| {100.0 * result['doubt'] / extent:.1g} % |\n"
    runs = [row for result in results for i in INTEGRATORS for row in result[i]]
    growth = max((row["growth"] for row in runs if row["growth"] is not None), default=0.0)
    halvings = sum(row["halvings"] for row in runs)
    text += (
        f"\nSteps that had to be halved, in all runs: {halvings}. Largest rise of the stored energy above "
    )
    text += f"that of the\nfirst step, in scenes that nothing drives: {100.0 * growth:.1f} % of the largest "
    text += "kinetic energy.\n"
    return text


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.integrators", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="default: all")
    parser.add_argument("--write", action="store_true", help="write docs/integrators.md")
    arguments = parser.parse_args()
    if unknown := set(arguments.names) - {case.name for case in CASES}:
        parser.error(f"no such scene: {', '.join(sorted(unknown))}")
    if arguments.names and arguments.write:
        parser.error("--write takes all scenes")
    results = []
    for case in CASES:
        if not arguments.names or case.name in arguments.names:
            results.append(measure(case))
            print(json.dumps(results[-1]), flush=True)
    text = tables(results)
    print(text)
    if arguments.write:
        before, rest = PAGE.read_text().split(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}\n{text}{END}{rest.split(END)[1]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
