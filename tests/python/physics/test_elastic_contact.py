"""Contact of elastic bodies against closed forms: Hertz, and Cattaneo and Mindlin."""

from __future__ import annotations

import numpy as np
from _validation import validate

import stark

MODULUS, RATIO, RADIUS, APPROACH = 1e6, 0.3, 1.0, 0.0025
SHEAR = MODULUS / 2.0 / (1.0 + RATIO)
SIZE, FRICTION, DISTANCE = 0.4, 0.5, 2e-5
PATCH = np.sqrt(RADIUS * APPROACH)
LOAD = 4.0 / 3.0 * MODULUS / (1.0 - RATIO**2) * np.sqrt(RADIUS) * APPROACH**1.5


def pressed_by_a_force(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Displacements of a half-space below z = 0 by the load, z downwards [Boussinesq]."""
    r = np.sqrt(x * x + y * y + z * z)
    across = z / r**3 - (1.0 - 2.0 * RATIO) / (r * (r + z))
    down = z * z / r**3 + 2.0 * (1.0 - RATIO) / r
    return LOAD / (4.0 * np.pi * SHEAR) * np.column_stack([across * x, across * y, -down])


def dragged_by_a_force(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The same of a force along x of the friction at which all slides [Cerruti]."""
    r = np.sqrt(x * x + y * y + z * z)
    k = 1.0 - 2.0 * RATIO
    along = 1.0 / r + x * x / r**3 + k * (1.0 / (r + z) - x * x / (r * (r + z) ** 2))
    across = x * y / r**3 - k * x * y / (r * (r + z) ** 2)
    down = x * z / r**3 + k * x / (r * (r + z))
    return FRICTION * LOAD / (4.0 * np.pi * SHEAR) * np.column_stack([along, across, -down])


class Press:
    """The top of a ball, half of it beyond a plane of symmetry, below a plate. The ends of the block that is
    looked at move as those of a half-space."""

    def __init__(self, cells: int, friction: bool) -> None:
        block = stark.mesh.box_hexahedra(1.0, (2 * cells, cells, cells))
        u = block.vertices + np.array([0.0, 0.5, 0.5])

        def graded(s: np.ndarray) -> np.ndarray:
            return SIZE * np.sign(s) * (0.12 * np.abs(s) + 0.88 * np.abs(s) ** 2.5)

        x, y, depth = graded(2.0 * u[:, 0]), graded(u[:, 1]), graded(1.0 - u[:, 2])
        depth = depth + (x * x + y * y) / 2.0 / RADIUS * (1.0 - depth / SIZE)
        far = (np.abs(u[:, 0]) > 0.4999) | (u[:, 1] > 0.9999) | (u[:, 2] < 1e-4)
        self.rest = np.column_stack([x, y, -depth])[far]
        self.pressed = pressed_by_a_force(x[far], y[far], depth[far])
        self.dragged = dragged_by_a_force(x[far], y[far], depth[far])
        scene = stark.Scene()
        scene.default_friction = FRICTION
        mesh = stark.mesh.SolidMesh(np.column_stack([x, y, -depth]), block.elements)
        rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=MODULUS, poissons_ratio=RATIO)
        self.ball = scene.add_solid(mesh, rubber, pins=far)
        scene.add_rollers(self.ball.vertices[(y < 1e-9) & ~far], "y")
        self.plate = scene.add_box((2.0, 2.0, 0.1), motion="scripted", position=(0, 0, 0.05 + 2 * DISTANCE))
        settings = {
            "time.integrator": "quasistatic",
            "contact.friction": friction,
            "contact.self_contact": False,
            "contact.stick_velocity": 1e-6,
        }
        self.sim = stark.Simulation(
            scene, time_step=1.0, gravity=(0, 0, 0), contact_distance=DISTANCE, settings=settings
        )

    def forces(self, approach: float, shift: float, pull: float) -> np.ndarray:
        """Forces on the plate, of both halves, at this share of the approach, this shift [m] and this share
        of the friction at which all slides."""
        self.ball.pin_targets = self.rest + approach**1.5 * self.pressed + pull * self.dragged
        down = approach * APPROACH + 2 * DISTANCE
        self.plate.pose = (shift, 0, 0.05 + 2 * DISTANCE - down), np.eye(3)
        assert not self.sim.step().failed
        return 2.0 * np.asarray(self.plate.contact_force)


def test_a_ball_is_pressed_as_hertz_says() -> None:
    press = Press(14, friction=False)
    validate("hertz.force", press.forces(1.0, 0.0, 0.0)[2] / LOAD)


def test_a_ball_is_dragged_as_cattaneo_and_mindlin_say() -> None:
    press = Press(14, friction=False)
    press.forces(1.0, 0.0, 0.0)
    stuck = Press(14, friction=True)
    stuck.sim.state = press.sim.state  # pressed without friction, which the closed form asks for
    measured = []
    for pull in (0.3, 0.5, 0.7, 0.9):
        shift = (
            3.0 * FRICTION * LOAD / (16.0 * PATCH) * (2.0 - RATIO) / SHEAR * (1.0 - (1.0 - pull) ** (2 / 3))
        )
        force = stuck.forces(1.0, shift, pull)
        measured.append(-force[0] / (FRICTION * force[2]))
    validate("hertz.drag", measured)
