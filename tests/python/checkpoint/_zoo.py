"""Small scenes of everything that can influence the next step, each with a controller that reads sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import stark

LIGHT = stark.materials.cotton.replace(density=0.5)
RUBBER = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=0.01)
NO_CONTACT = {"contact.enabled": False}


@stark.energy
def pull(
    p: stark.Point,
    target: stark.Vec3,
    stiffness: float = stark.parameter(unit="N/m", min=0.0),
    time: stark.Time = 0.0,
):
    """A spring to a target that swings."""
    d = p.x - target - stark.vec([0.01 * stark.sin(20.0 * time), 0.0, 0.0])
    return 0.5 * stiffness * d @ d


@stark.actuator
def ratchet(c: stark.Coordinate, furthest: stark.Memory):
    """Never turns back from where it has been, but for a tenth of a radian of play."""
    reached = stark.maximum(furthest, c.q_start)
    return stark.act(limit=reached - 0.1 - c.q, remember={"furthest": reached})


@dataclass
class Case:
    """A scene, its settings, what drives it before every step, and how many steps it takes in two halves."""

    build: Callable[[], stark.Scene]
    drive: Callable[[stark.Simulation, dict[str, Any]], None] = lambda sim, memory: None
    settings: dict[str, Any] = field(default_factory=dict)
    halves: tuple[int, int] = (6, 6)

    def simulate(self, **settings: Any) -> stark.Simulation:
        return stark.Simulation(self.build(), **{"time_step": 0.01, **self.settings, **settings})


def advance(case: Case, sim: stark.Simulation, memory: dict[str, Any], steps: int) -> list[tuple[str, bytes]]:
    """Hash of the state and bits of all sensors after each step."""
    trace = []
    for _ in range(steps):
        case.drive(sim, memory)
        report = sim.step()
        assert not report.failed, report.message
        trace.append((sim.state.hash, sensors(sim)))
    return trace


def sensors(sim: stark.Simulation) -> bytes:
    """The bits of everything that can be read between two steps."""
    contacts = sim.contacts
    rows = [contacts.forces, contacts.slips, contacts.distances, contacts.points_a]
    rows += [joint.reaction.force for joint in sim.joints] + [joint.reaction.torque for joint in sim.joints]
    rows += [list(joint.coordinates.values()) + list(joint.rates.values()) for joint in sim.joints]
    rows += [[a.effort, a.power] for a in sim.actuators] + [a.forces for a in sim.attachments]
    rows += [energy.energies for energy in sim.energies] + [energy.forces for energy in sim.energies]
    rows += [body.acceleration() for body in sim.bodies if isinstance(body, stark.RigidBody)]
    report = sim._core.report.to_dict()
    rows += [[report["residual"], report["contact_count"], *report["energy"].values()]]
    return b"".join(np.asarray(row, dtype=np.float64).tobytes() for row in rows)


def clutter() -> stark.Scene:
    """All kinds of surfaces in frictional contact: a cloth between a ball and a soft box, on a floor."""
    scene = stark.Scene()
    scene.default_friction = 0.4
    scene.add_floor(1.0)
    rubber = stark.materials.soft_rubber.replace(youngs_modulus=5e4)
    scene.add_solid(stark.mesh.tet_box(0.08, 2), rubber, position=(0, 0, 0.0415))
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, 8), position=(0.01, 0, 0.084), velocity=(0.2, 0, -0.5))
    scene.add_sphere(0.03, subdivisions=1, mass=0.05, position=(0.01, 0.005, 0.117), velocity=(0.2, 0, -0.5))
    return scene


def mechanism() -> stark.Scene:
    """Servo, motor, ratchet, gear, a joint with limits."""
    scene = stark.Scene()
    arm = scene.add_box(0.1, mass=1.0, position=(0.2, 0.0, 0.0), name="arm")
    hand = scene.add_box(0.05, mass=0.2, position=(0.4, 0.0, 0.0), name="hand")
    wheel = scene.add_cylinder(0.05, 0.02, mass=0.3, position=(0.0, 1.0, 0.0), name="wheel")
    axis = {"axis": (0.0, 1.0, 0.0)}
    shoulder = scene.add_hinge(None, arm, anchor=(0.0, 0.0, 0.0), name="shoulder", **axis)
    scene.add_hinge(arm, hand, anchor=(0.3, 0.0, 0.0), limits=(-0.3, 0.05), name="wrist", **axis)
    axle = scene.add_hinge(None, wheel, anchor=(0.0, 1.0, 0.0), name="axle", **axis)
    shoulder.add_servo(0.2, stiffness=40.0, damping=2.0, cap=30.0, integral=5.0, name="servo")
    axle.add_motor(2.0, cap=0.1, delta=0.1, name="motor")
    axle.add_actuator(ratchet)
    return scene


def control_mechanism(sim: stark.Simulation, memory: dict[str, Any]) -> None:
    """Feedback of a reaction, which is that of the last step, through a filter with memory."""
    shoulder, wrist, _ = sim.joints
    felt = float(np.linalg.norm(shoulder.reaction.force))
    memory["filtered"] = 0.7 * memory.get("filtered", 0.0) + 0.3 * felt
    memory["count"] = memory.get("count", 0) + 1
    servo, motor = (a for a in sim.actuators if a.name in ("servo", "motor"))
    servo.target = 0.01 * memory["filtered"]
    motor.target = 2.0 if memory["count"] % 3 else -1.0
    if memory["count"] == 8:
        wrist.enabled = False
    elif not wrist.enabled:
        wrist.pull_together()


def peel() -> stark.Scene:
    """A box is drawn away from under a cloth that is pinned at one edge: glue breaks row by row."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=6), LIGHT, pins=range(7))
    box = scene.add_box((0.3, 0.3, 0.02), motion="scripted", position=(0.0, 0.0, -0.012))
    scene.attach(cloth.vertices[7:], box, break_force=0.1)
    box.follow(position=lambda t: (0.0, 0.0, -0.012 - 0.2 * t))
    return scene


def scripted() -> stark.Scene:
    """A plate that does not lie about its origin, turned and then only moved: what is not set must stay."""
    scene = stark.Scene()
    plate = stark.mesh.box((0.1, 0.1, 0.02)).translated((0.31, 0.17, 0.03))
    scene.add_rigid(plate, motion="scripted", name="plate", rotation=stark.rotation(axis="x", angle=0.3))
    scene.add_sphere(0.03, subdivisions=1, mass=0.05, position=(0.3, 0.12, 0.16))
    return scene


def move_plate(sim: stark.Simulation, memory: dict[str, Any]) -> None:
    plate, step = sim["plate"], sim.state.step_count
    if step < 3:
        plate.angular_velocity = (0.0, 0.0, 0.5)
    elif step < 8:
        plate.rotation = stark.rotation(axis=(1.0, 0.3, 0.2), angle=0.3 + 0.01 * step)
    else:
        plate.position = (0.001 * step, 0.0, 0.002)


def energies() -> stark.Scene:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 3), name="cloth")
    scene.add(pull(cloth.vertices, target=(0.0, 0.0, 0.05), stiffness=np.full(16, 0.1)))
    scene.add(pull(cloth.vertices[:2], target=(0.0, 0.0, 0.02), stiffness=0.3))
    return scene


def tune_energies(sim: stark.Simulation, memory: dict[str, Any]) -> None:
    """Live values of all kinds; some are changed once, and never again after the checkpoint."""
    first, second = sim.scene.energies
    step = sim.state.step_count
    if step == 2:
        first.stiffness[3] = 0.7
    if step == 4:
        second.stiffness = 0.05 + 0.01 * second.energy
    if step % 4 == 1:
        first.target = (0.001 * step, 0.0, 0.05)


def rods() -> stark.Scene:
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.5, 0, 0), 8), RUBBER, clamps=[0], name="rod")
    turn = stark.motion.rotations([0.0, 0.2], [np.eye(3), stark.rotation(axis="x", angle=1.0)])
    rod.follow(displacement=lambda t: (0.0, 0.1 * t, 0.0), rotation=turn)
    scene.add_floor(1.0, height=-0.03)
    return scene


def pressing() -> stark.Scene:
    scene = stark.Scene()
    scene.add_floor(1.0)
    soft = stark.materials.soft_rubber.replace(youngs_modulus=5e4)
    scene.add_solid(stark.mesh.tet_box(0.05, 2), soft, position=(0, 0, 0.026), name="pad")
    scene.add_box((0.1, 0.1, 0.02), motion="scripted", position=(0, 0, 0.064), name="press")
    return scene


def press(sim: stark.Simulation, memory: dict[str, Any]) -> None:
    """Moves down until it feels something: a controller by contact force."""
    felt = float(sim["pad"].contacts("press").forces[:, 2].sum())
    height = float(sim["press"].position[2])
    sim["press"].position = (0.0, 0.0, height - 0.002 + 1e-3 * min(1.0, abs(felt)))


def belts() -> stark.Scene:
    """A belt that follows a function of the time and one that a controller drives, each with a box."""
    scene = stark.Scene()
    for y, name in ((-0.2, "a"), (0.2, "b")):
        belt = scene.add_box((1.0, 0.2, 0.1), motion="fixed", position=(0, y, -0.05), name=f"belt_{name}")
        belt.surface_velocity = (0, 0, 0)
        scene.add_box(0.05, mass=0.1, position=(0, y, 0.026), name=f"box_{name}")
    scene["belt_a"].surface_velocity = lambda t: (2.0 * t, 0, 0)
    return scene


def drive_belt(sim: stark.Simulation, memory: dict[str, Any]) -> None:
    if sim.state.step_count == 3:
        sim["belt_b"].surface_velocity = (0.3, 0, 0)
        sim["belt_b"].surface_spin = (0, 0, 1.0)


HARD = {"newton.max_iterations": 4, "time.growth": 1.3}

CASES = {
    "clutter": Case(clutter, settings={"contact_distance": 1e-3}),
    "clutter_bdf2": Case(clutter, settings={"contact_distance": 1e-3, "time.integrator": "bdf2"}),
    "clutter_pcg": Case(clutter, settings={"contact_distance": 1e-3, "linear.solver": "pcg"}),
    "mechanism": Case(mechanism, control_mechanism, NO_CONTACT),
    "mechanism_bdf2": Case(mechanism, control_mechanism, {**NO_CONTACT, "time.integrator": "bdf2"}),
    "peel": Case(peel, settings={"contact.distance": 1e-3}, halves=(8, 4)),
    "scripted": Case(scripted, move_plate),
    "energies": Case(energies, tune_energies, NO_CONTACT),
    "energies_quasistatic": Case(energies, tune_energies, {**NO_CONTACT, "time.integrator": "quasistatic"}),
    "rods": Case(rods, settings={"contact.distance": 1e-3}),
    "pressing": Case(pressing, press),
    "belts": Case(belts, drive_belt, {"contact.distance": 1e-3}),
    "belts_bdf2": Case(belts, drive_belt, {"contact.distance": 1e-3, "time.integrator": "bdf2"}),
    "halved_steps": Case(clutter, settings={"contact_distance": 1e-3, **HARD}),
}
