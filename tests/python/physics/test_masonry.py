"""Structures that stand by friction alone: a masonry arch (V22), tents and a house of cards (V23)."""

from __future__ import annotations

import numpy as np
import pytest
from _validation import validate

import stark

GAP = 1e-4  # contact distance of each body [m]
APART = 1.9 * GAP  # about the gap at rest


def outcome(scene: stark.Scene, bodies: list[stark.RigidBody], until: float, fallen: float) -> float:
    """Largest displacement [m] when it has fallen by more than `fallen`, or at the end. Stick velocity 0.1
    mm/s: friction that sticks creeps, and cards are 1 mm thick."""
    settings = {"contact.stick_velocity": 1e-4}
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=GAP, **settings)
    start = np.array([body.position for body in bodies])
    moved = 0.0
    for report in sim.run(until):
        assert not report.failed, report.message
        moved = np.linalg.norm([body.position for body in bodies] - start, axis=1).max()
        if moved > fallen:
            break
    return float(moved)


def arch(thickness: float, mu: float, count: int = 15) -> tuple[stark.Scene, list[stark.RigidBody]]:
    """Semicircle of mean radius 1 m from equal voussoirs, between two fixed ones."""
    scene = stark.Scene()
    scene.default_friction = mu
    cube = stark.mesh.box(1.0)
    u, v, w = (cube.vertices + 0.5).T  # along the radius, across the arch, along it

    def add(first_angle: float, motion: str) -> stark.RigidBody:
        angle = first_angle + np.pi / count * w
        radius = 1.0 + thickness * (u - 0.5)
        radial = np.column_stack([-np.cos(angle), np.zeros(8), np.sin(angle)])
        along = np.column_stack([np.sin(angle), np.zeros(8), np.cos(angle)])
        vertices = radius[:, None] * radial + APART * (0.5 - w)[:, None] * along
        vertices[:, 1] = 0.2 * (v - 0.5)
        mesh = stark.TriangleMesh(vertices, cube.triangles)
        mesh = mesh if mesh.volume > 0 else mesh.flipped()
        inertia = {"density": 2000.0} if motion == "dynamic" else {}
        return scene.add_rigid(mesh, motion=motion, **inertia)

    add(-np.pi / count, "fixed")
    add(np.pi, "fixed")
    return scene, [add(np.pi * k / count, "dynamic") for k in range(count)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "thickness", "mu"), [("standing", 0.15, 0.5), ("thin", 0.11, 0.5), ("slippery", 0.15, 0.36)]
)
def test_arch_stands(name: str, thickness: float, mu: float) -> None:
    validate(f"V22.{name}", outcome(*arch(thickness, mu), until=2.0, fallen=0.05))


@pytest.mark.parametrize(
    ("thickness", "mu"),
    [
        (0.09, 0.5),
        pytest.param(0.10, 0.5, marks=pytest.mark.slow),
        pytest.param(0.15, 0.28, marks=pytest.mark.slow),
        pytest.param(0.15, 0.33, marks=pytest.mark.slow),
    ],
)
def test_arch_falls(thickness: float, mu: float) -> None:
    assert outcome(*arch(thickness, mu), until=2.0, fallen=0.2) > 0.2


LENGTH, WIDTH, THICKNESS = 0.09, 0.06, 1e-3  # of a card [m]
SLOPE = np.radians(65.0)


class House:
    """Cards that lean against each other in pairs."""

    def __init__(self, mu: float, mu_floor: float) -> None:
        self.scene = stark.Scene()
        self.scene.default_friction = mu
        self.floor, self.mu_floor = self.scene.add_floor(1.0), mu_floor
        self.cards: list[stark.RigidBody] = []

    def tent(self, x: float, ground: float) -> float:
        """Two cards that meet at x; returns the height of their tops."""
        top = 0.0
        for side in (1, -1):
            up, y = np.array([side * np.cos(SLOPE), 0, np.sin(SLOPE)]), np.array([0.0, 1.0, 0.0])
            axes = np.column_stack([up, y, np.cross(up, y)])
            extent = np.abs(axes) @ (LENGTH / 2, WIDTH / 2, THICKNESS / 2)
            top = ground + APART + 2 * extent[2]
            self.card(LENGTH, (x - side * (extent[0] + APART / 2), 0.17, top - extent[2]), axes)
        return top

    def card(self, length: float, position: tuple[float, float, float], axes: np.ndarray) -> None:
        size = (length, WIDTH, THICKNESS)
        card = self.scene.add_box(size, density=800.0, rotation=axes, position=position)
        self.scene.friction[card, self.floor] = self.mu_floor
        self.cards.append(card)


def tent(mu_floor: float) -> float:
    house = House(0.5, mu_floor)
    house.tent(0.0, 0.0)
    return outcome(house.scene, house.cards, until=2.0, fallen=0.02)


def test_tent_of_cards() -> None:
    """Each card presses on the floor with its weight and pushes outwards with half of it over tan 65 deg."""
    for name, mu in (("stands", 0.30), ("just_stands", 0.25)):
        validate(f"V23.{name}", tent(mu))
    for mu in (0.20, 0.22):
        assert tent(mu) > 0.02


@pytest.mark.parametrize("mu", [0.5, 0.2])
def test_house_of_cards(mu: float) -> None:
    house = House(mu, mu)
    half = LENGTH * np.cos(SLOPE) + THICKNESS * np.sin(SLOPE) + APART
    top = 0.0
    for x in (-half, half):
        top = house.tent(x, 0.0)
    deck = top + APART + THICKNESS / 2
    house.card(2 * half + 0.02, (0.0, 0.17, deck), np.eye(3))
    house.tent(0.0, deck + THICKNESS / 2)
    moved = outcome(house.scene, house.cards, until=3.0, fallen=0.02)
    if mu == 0.5:
        validate("V23.house", moved)
    else:
        assert moved > 0.02
