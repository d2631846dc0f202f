"""Scenes written once and built in other units and in a mirror: lengths, masses and times by powers of two,
which round nothing, and a reflection, in which vectors of rotation and torque turn the other way round."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

Floats = NDArray[np.float64]
#: Exponents of length, mass and time.
Unit = tuple[int, int, int]

LENGTH, AREA, VOLUME = (1, 0, 0), (2, 0, 0), (3, 0, 0)
MASS, TIME, RATE = (0, 1, 0), (0, 0, 1), (0, 0, -1)
SPEED, ACCELERATION = (1, 0, -1), (1, 0, -2)
FORCE, TORQUE, PRESSURE = (1, 1, -2), (2, 1, -2), (-1, 1, -2)
STIFFNESS, DAMPER, VISCOSITY, TURN_DAMPER = (0, 1, -2), (0, 1, -1), (-1, 1, -1), (2, 1, -1)
INERTIA, DENSITY, SHEET, SECTION = (2, 1, 0), (-3, 1, 0), (-2, 1, 0), (3, 1, -2)

#: Units of materials; other fields are pure numbers. The damping of strain has one for each kind.
_FIELDS: dict[str, Unit] = {
    "thickness": LENGTH, "radius": LENGTH, "width": LENGTH, "height": LENGTH, "youngs_modulus": PRESSURE,
    "strain_limit_stiffness": PRESSURE, "yield_stress": PRESSURE, "hardening_modulus": PRESSURE,
    "bending_stiffness": TORQUE, "flexural_rigidity": TORQUE, "bending_yield_moment": FORCE,
    "bending_hardening": TORQUE, "mass_damping": RATE, "bending_damping": TURN_DAMPER,
    "axial_stiffness": FORCE, "shear_stiffness": FORCE, "bending_stiffness_1": SECTION,
    "bending_stiffness_2": SECTION, "torsional_stiffness": SECTION, "yield_force": FORCE,
    "yield_moment_1": TORQUE, "yield_moment_2": TORQUE, "yield_torque": TORQUE,
}  # fmt: skip
_OF_KIND: dict[type, dict[str, Unit]] = {
    stark.ShellMaterial: {"density": SHEET, "strain_damping": DAMPER},
    stark.SolidMaterial: {"density": DENSITY, "strain_damping": VISCOSITY},
    stark.RodMaterial: {"density": DENSITY, "strain_damping": TIME},
}


@dataclass
class World:
    """``length``, ``mass`` and ``time`` are numbers of new units in an old one; ``axes`` may mirror."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0
    axes: Floats = field(default_factory=lambda: np.eye(3))

    @property
    def is_mirror(self) -> bool:
        return bool(np.linalg.det(self.axes) < 0.0)

    def of(self, value: Any, unit: Unit) -> Any:
        factor = self.length ** unit[0] * self.mass ** unit[1] * self.time ** unit[2]
        return value * factor if np.isscalar(value) else np.asarray(value, dtype=float) * factor

    def polar(self, vector: Any, unit: Unit = (0, 0, 0)) -> Floats:
        """Places, velocities, forces."""
        return np.asarray(self.of(np.asarray(vector, dtype=float) @ self.axes.T, unit))

    def axial(self, vector: Any, unit: Unit = (0, 0, 0)) -> Floats:
        """Axes of hinges, angular velocities, torques."""
        return self.polar(vector, unit) * (-1.0 if self.is_mirror else 1.0)

    def place(self, point: Any) -> Floats:
        return self.polar(point, LENGTH)

    def turn(self, axis: Any, angle: float) -> Floats:
        return np.asarray(self.axes @ stark.rotation(axis=axis, angle=angle) @ self.axes.T)

    def mesh(self, mesh: Any) -> Any:
        """A mirror image has its elements turned inside out, to be what they were."""
        x = self.place(mesh.vertices)
        if isinstance(mesh, stark.mesh.Polyline):
            return x
        if isinstance(mesh, stark.mesh.TriangleMesh):
            return stark.mesh.TriangleMesh(x, mesh.triangles[:, ::-1] if self.is_mirror else mesh.triangles)
        swapped = {4: [0, 2, 1, 3], 8: [1, 0, 3, 2, 5, 4, 7, 6], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
        order = swapped[mesh.elements.shape[1]] if self.is_mirror else slice(None)
        return type(mesh)(x, mesh.elements[:, order])

    def material(self, given: Any, **changes: Any) -> Any:
        units = _FIELDS | _OF_KIND[type(given)]
        values = {name: getattr(given, name) for name in units if hasattr(given, name)} | changes
        return given.replace(**{name: self.of(v, units[name]) for name, v in values.items() if name in units})

    def box(self, scene: stark.Scene, size: Any, at: Any, **options: Any) -> Any:
        return scene.add_rigid(self.mesh(stark.mesh.box(size)), position=self.place(at), **options)

    def run(self, scene: stark.Scene, integrator: str, steps: int, *, pull: Any = (0.3, 0.5, -9.81)) -> None:
        lengths = {"contact.distance": 1e-3, "joints.length_tolerance": 1e-6}
        speeds = {"newton.step_tolerance": 1e-3, "contact.stick_velocity": 1e-3}
        self.sim = stark.Simulation(
            scene,
            settings={
                "time.integrator": integrator,
                "time.step": self.of(0.01, TIME),
                "time.min_step": self.of(1e-6, TIME),
                "newton.acceleration_tolerance": self.of(0.01, ACCELERATION),
                "contact.stiffness": self.of(1e4, PRESSURE),
                **{name: self.of(value, LENGTH) for name, value in lengths.items()},
                **{name: self.of(value, SPEED) for name, value in speeds.items()},
            },
            gravity=tuple(self.polar(pull, ACCELERATION)),
        )
        for _ in range(steps):
            report = self.sim.step()
            assert not report.failed, report.message
        self.energy = report.energy

    # --- what is seen, in the units and axes in which the scene was written ---

    def seen(self, value: Any, unit: Unit = (0, 0, 0)) -> Floats:
        return np.asarray(value, dtype=float) / self.of(1.0, unit)

    def polar_seen(self, vector: Any, unit: Unit) -> Floats:
        return self.seen(vector, unit) @ self.axes

    def axial_seen(self, vector: Any, unit: Unit) -> Floats:
        return self.polar_seen(vector, unit) * (-1.0 if self.is_mirror else 1.0)

    def energy_seen(self) -> Floats:
        names = ("kinetic", "elastic")
        return self.seen([self.energy[name] for name in names if name in self.energy], TORQUE)


def roof() -> stark.mesh.TriangleMesh:
    """A third of a tube."""
    flat = stark.mesh.grid(0.3, 0.2, (8, 5))
    angle = flat.vertices[:, 0] / 0.1
    x = np.column_stack([0.1 * np.sin(angle), flat.vertices[:, 1], 0.1 * np.cos(angle)])
    return stark.mesh.TriangleMesh(x, flat.triangles)


def shells(w: World, integrator: str) -> list[Floats]:
    """Hinges, plates, creases; and one that curls."""
    scene = stark.Scene()
    cotton = stark.materials.cotton.replace(bending_stiffness=1e-4)
    sheet = stark.materials.plate(youngs_modulus=1e8, poissons_ratio=0.3, thickness=5e-4, density=1000.0)
    kinds = [
        w.material(cotton),
        w.material(sheet),
        w.material(cotton, yield_stress=2e3, hardening_modulus=1e3, bending_yield_moment=1e-5),
        w.material(sheet, yield_stress=2e5),
    ]
    cloths = [
        scene.add_cloth(
            w.mesh(roof()), kind, rest_angles="mesh", pins=[0, 1, 2, 9, 10], position=w.place((0, k, 0.3))
        )
        for k, kind in enumerate(kinds)
    ]
    tensor = np.array([[2.0, 1.0, 0.0], [1.0, -3.0, 0.0], [0.0, 0.0, 0.0]])
    cloths[1].natural_curvature = w.of(w.axes @ tensor @ w.axes.T, (-1, 0, 0))
    w.run(scene, integrator, 8)
    seen = [[w.polar_seen(c.positions, LENGTH), w.polar_seen(c.pin_forces, FORCE)] for c in cloths]
    return [w.energy_seen(), *(row for rows in seen for row in rows)]


def rods(w: World, integrator: str) -> list[Floats]:
    """A helix of a flat band, and straight ones that twist, curl and yield."""
    scene = stark.Scene()
    rubber = stark.materials.rubber_cord
    band = w.material(rubber, width=4e-3, height=2e-3, strain_damping=1e-3, youngs_modulus=1.5e8)
    line, side = stark.mesh.polyline((0, 0, 0), (0.2, 0, 0), 10), -1.0 if w.is_mirror else 1.0
    options = {"clamps": [0], "self_contact": False}
    helix = w.mesh(stark.mesh.helix(0.03, 0.04, 2, 16))
    a = scene.add_rod(helix, band, position=w.place((0, 0, 0.3)), normal=w.polar((0.3, 0.4, 0.8)), **options)
    across = w.polar((0, 1, 1))
    b = scene.add_rod(w.mesh(line), band, position=w.place((0, 1, 0.3)), normal=across, **options)
    b.natural_twist = w.of(3.0 * side, (-1, 0, 0))
    c = scene.add_rod(w.mesh(line), band, position=w.place((0, 2, 0.3)), normal=across, **options)
    # The second axis of a section is a cross product, so that a vector of rotation keeps its part there.
    c.natural_curvature = w.of((2.0 * side, 5.0), (-1, 0, 0))
    soft = w.material(rubber, yield_stress=3e4, hardening_modulus=1e4)
    d = scene.add_rod(w.mesh(line), soft, position=w.place((0, 3, 0.3)), **options)
    w.run(scene, integrator, 8)
    seen = [[w.polar_seen(r.positions, LENGTH), w.axial_seen(r.clamp_torques, TORQUE)] for r in (a, b, c, d)]
    return [w.energy_seen(), *(row for rows in seen for row in rows)]


def solids(w: World, integrator: str) -> list[Floats]:
    """Elements of all kinds, pulled and pressed; one grows and pulls along fibres."""
    scene = stark.Scene()
    rubber = stark.SolidMaterial(
        density=1000.0, youngs_modulus=3e4, poissons_ratio=0.4, strain_damping=20.0,
        strain_limit=0.1, strain_limit_stiffness=1e4,
    )  # fmt: skip
    tets, blocks = stark.mesh.tet_box(0.1, 2), stark.mesh.box_hexahedra(0.1, 2)
    kinds = [
        (tets, "displacement"),
        (stark.mesh.to_quadratic(tets), "displacement"),
        (blocks, "mean_dilatation"),
    ]
    bodies = []
    for k, (mesh, formulation) in enumerate(kinds):
        low = np.flatnonzero(mesh.vertices[:, 0] < -0.0499)
        solid = scene.add_solid(
            w.mesh(mesh), w.material(rubber), pins=low, position=w.place((k, 0, 0.2)), formulation=formulation
        )
        top = mesh.vertices[:, 2] > 0.0499
        scene.add_face_pressure(solid.faces[top[solid.triangles].all(axis=1)], w.of(300.0, PRESSURE))
        scene.add_traction(solid.faces, w.polar((20.0, 30.0, 5.0), PRESSURE))
        bodies.append(solid)
    grown = np.array([[1.1, 0.05, 0.0], [0.05, 1.0, 0.02], [0.0, 0.02, 0.95]])
    bodies[0].growth = w.axes @ grown @ w.axes.T
    bodies[0].fiber_direction = w.polar((1.0, 0.5, 0.2))
    bodies[0].active_stress = w.of(900.0, PRESSURE)
    w.run(scene, integrator, 8)
    seen = [[w.polar_seen(s.positions, LENGTH), w.polar_seen(s.pin_forces, FORCE)] for s in bodies]
    return [w.energy_seen(), *(row for rows in seen for row in rows)]


def gas(w: World, integrator: str) -> list[Floats]:
    scene = stark.Scene()
    skin = w.material(stark.materials.cotton, youngs_modulus=1e5)
    ball = scene.add_cloth(w.mesh(stark.mesh.sphere(0.1, 2)), skin, rest_angles="mesh", pins=[0, 1, 2])
    outside = w.of(101325.0, PRESSURE)
    filling = scene.add_gas(ball, w.of(300.0, PRESSURE), outside=outside, exponent=1.4)
    w.run(scene, integrator, 8)
    return [w.energy_seen(), w.polar_seen(ball.positions, LENGTH), w.seen(filling.volume, VOLUME)]


def friction(w: World, integrator: str) -> list[Floats]:
    """A box that slides and spins, one on a belt, one that grain turns aside; a ball that rolls."""
    scene = stark.Scene()
    scene.add_rigid(w.mesh(stark.mesh.grid(6.0, 6.0, 1)), motion="fixed", friction=0.4)
    mass = w.of(1.0, MASS)
    a = w.box(
        scene, 0.1, (0, 0, 0.0505), mass=mass,
        velocity=w.polar((1, 0.2, 0), SPEED), angular_velocity=w.axial((0, 0, 2), RATE),
    )  # fmt: skip
    ball = scene.add_rigid(
        w.mesh(stark.mesh.sphere(0.05, 1)), mass=mass, position=w.place((-1, 0, 0.051)),
        angular_velocity=w.axial((3, 20, 5), RATE),
    )  # fmt: skip
    belt = w.box(scene, (1, 1, 0.2), (0, 2, 0.1), motion="fixed", friction=0.5)
    belt.surface_velocity = w.polar((0.5, 0.1, 0), SPEED)
    belt.surface_spin = w.axial((0, 0, 1), RATE)
    carried = w.box(scene, 0.1, (0.1, 2, 0.2505), mass=mass, rotation=w.turn("z", 0.4))
    grain = w.box(scene, (1, 1, 0.2), (2, 2, 0.1), motion="fixed")
    grain.surface_direction = w.polar((1, 0.5, 0))
    aside = w.box(scene, 0.1, (2, 2, 0.2505), mass=mass, velocity=w.polar((1, 0, 0), SPEED))
    scene.friction[grain, aside] = stark.Anisotropic(0.6, 0.1)
    w.run(scene, integrator, 15)
    bodies = (a, ball, carried, aside)
    seen = [[w.polar_seen(b.position, LENGTH), w.polar_seen(b.contact_force, FORCE)] for b in bodies]
    turning = [w.axial_seen(b.angular_velocity, RATE) for b in (a, ball)]
    return [w.energy_seen(), *turning, *(row for rows in seen for row in rows)]


def machine(w: World, integrator: str) -> list[Floats]:
    """A driven arm with a slider in its end, a Cardan joint that a motor turns, a pair of gears."""
    scene = stark.Scene()
    kg = w.of(1.0, MASS)
    arm = w.box(scene, (0.3, 0.05, 0.05), (0.15, 0, 0), mass=kg)
    fore = w.box(scene, (0.2, 0.04, 0.04), (0.4, 0, 0), mass=0.5 * kg)
    tip = w.box(scene, 0.05, (0.55, 0, 0), mass=0.25 * kg)
    shoulder = scene.add_hinge(None, arm, w.place((0, 0, 0)), w.axial((0, 1, 0)), limits=(-1, 0.05))
    elbow = scene.add_hinge(arm, fore, w.place((0.3, 0, 0)), w.axial((0, 0.6, 0.8)))
    reach = scene.add_slider(fore, tip, w.place((0.5, 0, 0)), w.polar((1, 0, 0)))
    elbow.add_motor(w.of(1.0, RATE), cap=w.of(2.0, TORQUE), delta=w.of(0.1, RATE))
    reach.add_servo(
        w.of(0.002, LENGTH), stiffness=w.of(100.0, STIFFNESS), damping=w.of(3.0, DAMPER),
        cap=w.of(5.0, FORCE), integral=w.of(10.0, (0, 1, -3)),
    )  # fmt: skip
    shoulder.add_friction(cap=w.of(0.1, TORQUE), stick_rate=w.of(0.01, RATE))
    shoulder.add_armature(w.of(0.01, INERTIA))
    yoke = w.box(scene, (0.1, 0.05, 0.03), (0, 1, 0), mass=0.5 * kg)
    shaft = w.box(scene, (0.05, 0.1, 0.03), (0.2, 1, 0), mass=0.5 * kg)
    cross = scene.add_universal(None, yoke, w.place((-0.05, 1, 0)), w.axial((0, 1, 0)), w.axial((0, 0, 1)))
    sleeve = scene.add_cylindrical(yoke, shaft, w.place((0.1, 1, 0)), w.polar((1, 0, 0)))
    side = -1.0 if w.is_mirror else 1.0  # a turn about a direction goes the other way round
    sleeve.add_actuator(
        "velocity_motor", coordinate="angle", target=w.of(3.0 * side, RATE), cap=w.of(0.5, TORQUE),
        delta=w.of(0.1, RATE),
    )  # fmt: skip
    sleeve.add_actuator(
        "spring_damper", coordinate="displacement", stiffness=w.of(80.0, STIFFNESS), rest=0.0,
        damping=w.of(1.0, DAMPER),
    )  # fmt: skip
    cross.add_actuator("brake", coordinate="angle_a", cap=w.of(0.2, TORQUE), give=1e-3)
    wheels = [w.box(scene, (0.1, 0.05, 0.03), (x, 3, 0), mass=0.5 * kg) for x in (0.0, 0.2)]
    first = scene.add_hinge(None, wheels[0], w.place((0.02, 3, 0)), w.axial((0, 0.1, 1)))
    second = scene.add_hinge(None, wheels[1], w.place((0.2, 3.02, 0)), w.axial((0.2, 0, 1)))
    second.add_gear(first, -2.0)
    first.add_effort(w.of(0.05, TORQUE))
    w.run(scene, integrator, 12)
    hinges = (shoulder.angle, elbow.angle, cross.angle_a, cross.angle_b, first.angle, second.angle)
    return [
        w.energy_seen(),
        np.array([*hinges, side * sleeve.angle]),
        w.seen([reach.displacement, sleeve.displacement], LENGTH),
        w.polar_seen([b.position for b in scene.bodies], LENGTH),
        w.polar_seen(shoulder.reaction.force, FORCE),
        w.axial_seen(shoulder.reaction.torque, TORQUE),
    ]


def glued(w: World, integrator: str) -> list[Floats]:
    """A cloth with a skin and fibres, a soft and a rigid cube on it, a thread that breaks."""
    scene = stark.Scene()
    cotton, cord = w.material(stark.materials.cotton), w.material(stark.materials.rubber_cord, radius=2e-4)
    cloth = scene.add_cloth(w.mesh(stark.mesh.grid(0.2, 0.2, 4)), cotton, pins=[0, 4])
    cloth.add_fibres(cord, [[1, 6], [6, 11], [11, 16]])
    cloth.add_skin(cotton)
    cube = scene.add_solid(
        w.mesh(stark.mesh.tet_box(0.05, 1)), w.material(stark.materials.soft_rubber),
        position=w.place((0.012, -0.1, -0.03)),
    )  # fmt: skip
    die = w.box(scene, 0.05, (0.11, 0.1, -0.03), mass=w.of(0.05, MASS))
    scene.attach(cloth.vertices[[22]], cube.vertices[[0]])
    scene.attach(cloth.vertices[[24]], die)
    scene.attach(cloth.vertices[[12]], None, break_force=w.of(0.05, FORCE))
    w.run(scene, integrator, 10)
    return [
        w.energy_seen(),
        w.polar_seen(cloth.positions, LENGTH),
        w.polar_seen(cube.positions, LENGTH),
        w.polar_seen(die.position, LENGTH),
    ]


SCENES = (shells, rods, solids, gas, friction, machine, glued)


def farthest(seen: list[Floats], others: list[Floats]) -> float:
    """Largest difference of two runs, over the largest number of each reading."""
    pairs = zip(seen, others, strict=True)
    return max(float(np.abs(a - b).max() / max(np.abs(a).max(), 1e-300)) for a, b in pairs)
