"""A helical spring of a rod against its stiffness by Castigliano's theorem."""

from __future__ import annotations

import numpy as np
import pytest
from _validation import validate

import stark

TURNS, DIAMETER, WIRE = 5, 0.05, 0.002  # [m]
STEEL = stark.RodMaterial(density=7850.0, youngs_modulus=2e11, poissons_ratio=0.3, radius=WIRE / 2)
SETTINGS = {"time.integrator": "quasistatic", "contact.enabled": False}


def helix(pitch: float, segments: int) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi * TURNS, segments * TURNS + 1)
    around = DIAMETER / 2 * np.array([np.cos(angle), np.sin(angle)])
    return np.column_stack((*around, pitch * angle / (2.0 * np.pi)))


def by_castigliano(pitch: float) -> float:
    """Stiffness [N/m] between ends that are held but for the way along the axis: of the six loads at the end
    the compliance is an integral along the wire."""
    points = helix(pitch, 400)
    middles, ways = (points[1:] + points[:-1]) / 2, np.diff(points, axis=0)
    length = np.linalg.norm(ways, axis=1)
    along = np.einsum("ki,kj->kij", ways, ways) / length[:, None, None] ** 2
    across = np.eye(3) - along
    levers = np.array([0.0, 0.0, pitch * TURNS]) - middles
    moments = np.zeros((len(levers), 3, 6))  # on the section, of a force and a moment at the end
    for k in range(3):
        moments[:, :, k] = np.cross(levers, np.eye(3)[k])
    moments[:, :, 3:] = np.eye(3)
    section = STEEL.section
    bent = along / section["torsional_stiffness"] + across / section["bending_stiffness_1"]
    stretched = along / section["axial_stiffness"] + across / section["shear_stiffness"]
    compliance = np.einsum("k,kia,kij,kjb->ab", length, moments, bent, moments)
    compliance[:3, :3] += np.einsum("k,kij->ij", length, stretched)
    return float(np.linalg.inv(compliance)[2, 2])


def measured(pitch: float, segments: int) -> float:
    scene = stark.Scene()
    wire = scene.add_rod(helix(pitch, segments), STEEL, clamps=[0])
    top = (0.0, 0.0, pitch * TURNS)
    plate = scene.add_box(0.01, mass=1.0, position=top)
    scene.add_fixed(wire.frame(-1), plate)
    scene.add_slider(None, plate, anchor=top, axis="z")
    scene.add_force(plate, (0.0, 0.0, 0.01))
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings=SETTINGS)
    assert not sim.step().failed
    return 0.01 / float(plate.position[2] - top[2])


def test_a_helical_spring_is_as_stiff_as_castigliano_says() -> None:
    found = []
    for pitch in (0.005, 0.04):
        coarse, fine = (measured(pitch, segments) for segments in (30, 60))
        found.append((4.0 * fine - coarse) / 3.0 / by_castigliano(pitch))
    validate("spring.stiffness", found)


def test_wahls_formula_is_that_of_a_close_coil() -> None:
    """G d^4 / (8 D^3 n), without the stretch and shear of the wire, its pitch and what holds the ends."""
    shear = STEEL.youngs_modulus / 2.6
    wahl = shear * WIRE**4 / (8 * DIAMETER**3 * TURNS)
    assert measured(0.005, 30) == pytest.approx(wahl, rel=0.01)
