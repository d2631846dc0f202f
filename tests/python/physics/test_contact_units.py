"""Contact in its smallest forms (V24), judged by ipctk after every step: what meets does not pass through and
keeps its momentum, what lies comes to rest. The cases are data, in _contact_cases.py."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from _contact_cases import (
    BODIES,
    CLOTH,
    CLOTH_RESTS,
    CORD,
    CORD_ON_CLOTH,
    CORD_RESTS,
    CORDS,
    FALLS,
    FLOOR,
    QUARTER,
    RESTS,
    SLIDES,
    SURFACES,
    Meeting,
    Part,
)
from _helpers import Judge
from _mechanisms import Work
from _validation import validate

import stark

pytest.importorskip("ipctk")


def softened(part: Part) -> Part:
    return replace(part, soft=part.shape in SURFACES and not part.fixed)


def speed(bodies: list[Any]) -> float:
    """Largest of a vertex or of a centre of mass [m/s]."""
    return max(float(np.abs(b.velocity if b.kind == "rigid" else b.velocities).max()) for b in bodies)


@stark.energy
def push(p: stark.Point, force: stark.Vec3):
    """A force that keeps its direction [N]."""
    return -stark.dot(force, p.x)


@dataclass
class Run:
    """The worst of a run: what must be conserved, and what it took."""

    work: Work
    momentum: float = 0.0  # change over the momentum
    lever: float = 0.0  # change of the angular momentum over the momentum [m]
    energy: float = 0.0  # kinetic and elastic energy over that at the start
    contacts: int = 0
    speed: float = np.inf  # at the end [m/s]
    lowest: float = np.inf  # point of the first body at the end [m]


# --- what meets ---

MEETINGS: dict[str, dict[str, Meeting]] = {
    "rigid": BODIES,
    "soft": {name: (softened(a), b) for name, (a, b) in BODIES.items()},
    "cloth": CLOTH,
    "cords": CORDS,
    "cord_on_cloth": CORD_ON_CLOTH,
}


@cache
def met(group: str, case: str) -> Run:
    """The upper body comes down at 1 m/s, without gravity. Nothing may intersect or pass."""
    lower, upper = MEETINGS[group][case]
    scene = stark.Scene()
    lower.add_to(scene)
    above = (upper.at[0], upper.at[1], upper.at[2] + 0.012)
    replace(upper, at=above, velocity=(0.0, 0.0, -1.0)).add_to(scene)
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0))
    judge = Judge(sim)
    first = sim.step()
    assert first.contact_count == 0
    assert not judge.crossed()
    before, turning = np.array(first.momentum), np.array(first.angular_momentum)
    size = np.linalg.norm(before)
    run = Run(Work())
    for report in sim.run(0.05):
        assert not report.failed, report.message
        assert not judge.crossed()
        assert not judge.intersects()
        run.work.add(report)
        run.contacts += report.contact_count
        run.momentum = max(run.momentum, np.linalg.norm(report.momentum - before) / size)
        run.lever = max(run.lever, np.linalg.norm(report.angular_momentum - turning) / size)
        energy = report.energy["kinetic"] + report.energy["elastic"]
        run.energy = max(run.energy, energy / first.energy["kinetic"])
    return run


@pytest.mark.parametrize(("group", "case"), [(g, c) for g, cases in MEETINGS.items() for c in cases])
def test_what_meets_does_not_pass_and_keeps_its_momentum(group: str, case: str) -> None:
    run = met(group, case)
    assert run.contacts > 0
    assert run.momentum < 1e-9
    # Contact has no torque at the end of the step; implicit Euler takes levers from its start: h^2 v x f.
    assert run.lever < 1e-3
    assert run.energy < 1.0 + 1e-9
    assert run.work.retried == 0
    assert run.work.most_iterations <= 100


@pytest.mark.parametrize("group", MEETINGS)
def test_table_of_what_meets(group: str) -> None:
    runs = [met(group, case) for case in MEETINGS[group]]
    validate(f"V24.meets_{group}", [max(r.momentum for r in runs), max(r.lever for r in runs)])
    validate(f"V24.iterations_{group}", max(r.work.most_iterations for r in runs))


# --- what lies ---

LYING: dict[str, dict[str, list[Part]]] = {
    "rigid": RESTS,
    "soft": {name: [softened(p) for p in parts] for name, parts in RESTS.items()},
    "cloth": CLOTH_RESTS,
    "cords": CORD_RESTS,
}


@cache
def lain(group: str, case: str) -> Run:
    """Falls, rolls and slides for 6 s at most, until nothing has moved faster than friction creeps for
    0.3 s."""
    scene = stark.Scene()
    bodies = [part.add_to(scene, damping=5.0) for part in LYING[group][case]]
    FLOOR.add_to(scene)
    sim = stark.Simulation(scene, time_step=0.01)
    judge = Judge(sim)
    run = Run(Work())
    still = 0
    for k, report in enumerate(sim.run(6.0)):
        assert not report.failed, report.message
        assert not judge.crossed(), sim.time
        if k % 10 == 0:
            assert not judge.intersects()
        run.work.add(report)
        run.speed = speed(bodies)
        still = still + 1 if run.speed < 5e-4 and report.contact_count else 0
        if still == 30:
            break
    assert not judge.intersects()
    run.lowest = float(bodies[0].positions[:, 2].min())
    return run


# A rod that comes down on the border of a sheet by more than their contact distance in a step slips around
# it: the way through the iterates is clear, the straight one is not.
DETOURS = [("cords", "on_sheet_border")]
LYING_CASES = [
    pytest.param(
        g, c, marks=pytest.mark.xfail(strict=True, reason="takes a detour") if (g, c) in DETOURS else ()
    )
    for g, cases in LYING.items()
    for c in cases
]


@pytest.mark.slow
@pytest.mark.parametrize(("group", "case"), LYING_CASES)
def test_what_lies_comes_to_rest(group: str, case: str) -> None:
    run = lain(group, case)
    assert run.speed < 1e-3  # the default stick velocity
    if group in ("rigid", "soft") and RESTS[case][0].at[2] >= 0.0:
        assert (run.lowest < -0.2) == (case in FALLS)
    assert run.work.retried == 0
    # Most where an edge comes down on an edge: contact gives way by a law that does not follow the step.
    assert run.work.most_iterations <= 100


@pytest.mark.slow
@pytest.mark.parametrize("group", LYING)
def test_table_of_what_lies(group: str) -> None:
    runs = [lain(group, case) for case in LYING[group] if (group, case) not in DETOURS]
    validate(f"V24.lies_{group}", max(r.speed for r in runs))
    validate(f"V24.lies_iterations_{group}", max(r.work.most_iterations for r in runs))


# --- what a rod does to itself ---


def test_the_legs_of_a_hairpin_touch_at_their_thickness() -> None:
    """Two legs in one plane, 20 mm apart; one is held, the other, shorter, is pressed flat on it. Friction
    keeps it from rolling off sideways."""
    line, turn = np.linspace(0.0, 0.2, 21), np.linspace(-60.0, 60.0, 5) * stark.deg
    held = np.column_stack([line, 0 * line, 0 * line])
    bend = np.column_stack([0.2 + 0.01 * np.cos(turn), 0.01 + 0.01 * np.sin(turn), 0 * turn])
    free = np.column_stack([line[:5:-1], 0 * line[:5:-1] + 0.02, 0 * line[:5:-1]])
    points = np.concatenate([held, bend, free])
    scene = stark.Scene()
    cord = CORD.replace(mass_damping=20.0)
    rod = scene.add_rod(points, cord, pins=list(range(len(held))), friction=0.5)
    for vertex in range(len(points) - len(free), len(points)):
        scene.add(push(rod.vertices[vertex], force=(0.0, -5e-3, 0.0)))
    sim = stark.Simulation(scene, time_step=2e-3, gravity=(0, 0, 0))
    judge = Judge(sim)
    for report in sim.run(0.15):
        assert report.status == "accepted", report.message
        assert not judge.crossed()
        assert report.newton_iterations <= 40
    across = rod.positions[-len(free) :, 1]
    assert across.min() > 0.7 * 2e-3
    assert (across < 2e-3).sum() >= 5


def test_a_rod_of_segments_shorter_than_its_thickness_does_not_push_itself_apart() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.1, 0, 0), 100), CORD)
    start = rod.positions
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    for _ in range(3):
        report = sim.step()
        assert not report.failed
        assert report.contact_count == 0
    assert np.abs(rod.positions - start).max() < 1e-12


# --- what slides ---


def test_a_cube_slides_over_edges_within_a_plane() -> None:
    """Tiles of 0.1 m do not catch it, nor turn it: it stops where Coulomb says, v^2/(2 mu g), less the half
    step v h/2 of implicit Euler."""
    scene = stark.Scene()
    scene.default_friction = 0.2
    cube, _ = (part.add_to(scene) for part in SLIDES)
    start = cube.position
    sim = stark.Simulation(scene, time_step=2e-3)
    judge = Judge(sim)
    for report in sim.run(0.8):
        assert not report.failed, report.message
        assert not judge.crossed()
    assert np.abs(cube.velocity).max() < 1e-3
    assert np.abs(cube.rotation - np.eye(3)).max() < 1e-3
    validate("V24.slides", (cube.position - start)[:2])


# --- the judge itself ---


def test_the_judge_sees_rods_that_cross() -> None:
    """Rods without contact fall through each other. They are in no triangle: only the way shows it."""
    scene = stark.Scene()
    lower = Part("rod").add_to(scene)
    upper = Part("rod", (0.01, 0.02, 0.005), QUARTER, velocity=(0, 0, -1.0)).add_to(scene)
    scene.disable_contact(lower, upper)
    sim = stark.Simulation(scene, time_step=2e-3, gravity=(0, 0, 0))
    judge = Judge(sim)
    seen = []
    for _ in range(5):
        assert not sim.step().failed
        seen.append(judge.crossed())
        assert not judge.intersects()
    assert seen == [False, False, True, False, False]
