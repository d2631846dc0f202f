"""Coulomb's law at default settings over coefficients, floors and bodies: acceleration down inclines beyond
the limit, no creep below it, stopping distance and time on the level."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _helpers import G, advance, inclined_floor, lumped_masses

import stark

STEP, GAP = 1 / 60, 1e-3  # defaults of time.step [s] and contact.distance [m]
COEFFICIENTS = [0.05, 0.2, 0.5, 0.8, 1.2]
# Two triangles; cells of 75 mm, smaller than the bodies; those turned, so that edges cross in all directions.
FLOORS = {"flat": (1, 0.0), "fine": (40, 0.0), "turned": (40, 31.0)}
BODIES = ["rigid", "soft", "cloth"]
SIDE, HEIGHT, DENSITY = 0.1, 0.04, 1000.0  # [m], [m], [kg/m^3]: flat enough not to topple at mu = 1.2
RUBBER = stark.SolidMaterial(density=DENSITY, youngs_modulus=1e6, poissons_ratio=0.3)
CLOTH = stark.ShellMaterial(density=0.3, youngs_modulus=1e5, bending_stiffness=1e-5)


class Slider:
    """A body just above a floor that is inclined by an angle [deg], at x and y [m] of its surface."""

    def __init__(
        self,
        body: str,
        floor: str,
        mu: float,
        angle: float = 0.0,
        speed: float = 0.0,
        place: tuple[float, float] = (0.0, 1.0),  # the diagonal of the flat floor is at x = y
        **settings: Any,
    ) -> None:
        scene = stark.Scene()
        cells, turn = FLOORS[floor]
        self.axes = inclined_floor(scene, angle, cells=cells, turn=turn)
        lift = (0.0 if body == "cloth" else HEIGHT / 2) + 1.9 * GAP
        options: dict[str, Any] = {
            "name": "slider",
            "rotation": self.axes,
            "position": self.axes @ (*place, lift),
            "velocity": speed * self.axes[:, 0],
        }
        size = (SIDE, SIDE, HEIGHT)
        if body == "rigid":
            self.body: Any = scene.add_box(size, density=DENSITY, **options)
        elif body == "soft":
            self.body = scene.add_solid(stark.mesh.tet_box(size, (4, 4, 2)), RUBBER, **options)
            self.shares = lumped_masses(self.body, DENSITY) / self.body.mass
        else:
            grid = stark.mesh.grid(0.3, 0.3, 10)
            self.body = scene.add_cloth(grid, CLOTH, self_contact=False, **options)
            self.shares = np.zeros(len(grid.vertices))
            np.add.at(self.shares, grid.triangles, 1 / (3 * len(grid.triangles)))
        scene.friction["slider", "floor"] = mu
        self.sim = stark.Simulation(scene, **settings)

    @property
    def place(self) -> np.ndarray:
        """Of the centre of mass: downhill, across, normal [m]."""
        body = self.body
        return (body.position if body.kind == "rigid" else self.shares @ body.positions) @ self.axes

    @property
    def speed(self) -> float:
        """Downhill [m/s]."""
        body = self.body
        velocity = body.velocity if body.kind == "rigid" else self.shares @ body.velocities
        return float(velocity @ self.axes[:, 0])


def combinations(fast: list[tuple[str, str, float]]) -> list[Any]:
    """All of them, those that are not listed marked as slow."""
    return [
        pytest.param(body, floor, mu, marks=[] if (body, floor, mu) in fast else pytest.mark.slow)
        for body in BODIES
        for floor in FLOORS
        for mu in COEFFICIENTS
    ]


def sliding_error(slider: Slider, mu: float, angle: float) -> float:
    """Relative error of the acceleration from 0.3 s, when the body has settled on the barrier, to 0.8 s."""
    advance(slider.sim, 0.3)
    start, time = slider.speed, slider.sim.time
    advance(slider.sim, 0.8)
    a = angle * stark.deg
    return (slider.speed - start) / (slider.sim.time - time) / (G * (np.sin(a) - mu * np.cos(a))) - 1.0


@pytest.mark.parametrize(
    ("body", "floor", "mu"),
    combinations(
        [("rigid", "flat", mu) for mu in COEFFICIENTS]
        + [("rigid", "turned", mu) for mu in COEFFICIENTS]
        + [("soft", "turned", 0.8), ("cloth", "turned", 0.2)]
    ),
)
def test_acceleration_eight_degrees_beyond_the_limit(body: str, floor: str, mu: float) -> None:
    angle = np.arctan(mu) / stark.deg + 8.0
    # Flat faces of rigid bodies have no edges inside: nothing is left but rounding and the residual. Of the
    # others: the resultant is a third of the friction at mu = 1.2, so 1 % of it is 0.3 % of the friction.
    bound = 1e-9 if body == "rigid" else 0.01
    assert abs(sliding_error(Slider(body, floor, mu, angle), mu, angle)) < bound


def test_acceleration_across_the_diagonal_of_the_floor() -> None:
    mu = 0.2
    angle = np.arctan(mu) / stark.deg + 8.0
    assert abs(sliding_error(Slider("rigid", "flat", mu, angle, place=(0.0, 0.4)), mu, angle)) < 1e-9


@pytest.mark.parametrize(
    ("body", "floor", "mu"),
    combinations([("rigid", "turned", 0.05), ("rigid", "flat", 1.2), ("rigid", "fine", 0.5)]),
)
def test_no_creep_just_below_the_limit(body: str, floor: str, mu: float) -> None:
    slider = Slider(body, floor, mu, 0.95 * np.arctan(mu) / stark.deg)
    advance(slider.sim, 1.0)
    start = slider.place
    advance(slider.sim, 11.0)
    # Bristles hold without moving: what is left is the residual of the solver. The bar is 0.1 mm in 10 s.
    assert np.linalg.norm(slider.place - start) < 1e-7


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize(
    ("body", "floor", "mu"),
    [c for c in combinations([("rigid", "flat", 0.2), ("rigid", "flat", 1.2)]) if c.values[0] != "cloth"],
)
def test_stopping_distance_and_time(body: str, floor: str, mu: float, integrator: str) -> None:
    distance = 0.8  # [m]
    speed = np.sqrt(2.0 * mu * G * distance)
    stop = speed / (mu * G)
    settings = {"time.integrator": integrator}
    slider = Slider(body, floor, mu, speed=speed, place=(-0.6, 1.0), **settings)
    start = slider.place[0]
    while slider.speed > 2e-3:  # twice the stick velocity
        assert not slider.sim.step().failed
        assert slider.sim.time < 2.0 * stop
    assert abs(slider.sim.time - stop) < STEP
    advance(slider.sim, slider.sim.time + 0.3)
    # Implicit Euler takes the velocity of the end for the whole step, which is short by v h / 2 in all.
    lost = speed * STEP / 2 if integrator == "implicit_euler" else 0.0
    assert slider.place[0] - start == pytest.approx(distance - lost, rel=0.01)
    assert abs(slider.place[1] - 1.0) < (1e-6 if body == "rigid" else 0.01 * distance)
    assert abs(slider.speed) < 1e-6
