"""Beams of solid elements: small deflection and first frequency (V05), convergence in space and time (V08).
Cook's membrane (V07) is in test_elements.py, large deflections (V06) in theirs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from _mechanisms import BDF2, at, crossings, extrapolate, observed_order, record, simulate
from _validation import validate

import stark

Mesh = stark.TetMesh | stark.SolidMesh
LENGTH, WIDTH, MODULUS, DENSITY, LOAD = 1.0, 0.1, 1e7, 1000.0, 2.5  # [m], [m], [Pa], [kg/m^3], [N]
STATIC = {
    "time.integrator": "quasistatic",
    "newton.acceleration_tolerance": 1e-6,
    "newton.step_tolerance": 1e-12,
}
DYNAMIC = {"newton.acceleration_tolerance": 1e-7, "newton.step_tolerance": 1e-9}


@stark.energy
def load(p: stark.Point, force: stark.Vec3):
    """A force on each point [N]."""
    return -(force @ p.x)


def beam_mesh(kind: str, cells: int, across: int = 1) -> Mesh:
    size, count = (LENGTH, WIDTH, WIDTH), (cells, across, across)
    coarse = stark.mesh.tet_box(size, count) if "tet" in kind else stark.mesh.box_hexahedra(size, count)
    return stark.mesh.to_quadratic(coarse) if kind in ("tet10", "hex27") else coarse


def cantilever(
    mesh: Mesh, start: np.ndarray | None = None, *, modulus: float = MODULUS
) -> tuple[stark.Scene, Any, np.ndarray]:
    """Clamped at its left end; without lateral contraction, so that the clamp is that of beam theory. Returns
    the vertices of its right end too."""
    x = mesh.vertices[:, 0]
    material = stark.SolidMaterial(youngs_modulus=modulus, poissons_ratio=0.0, density=DENSITY)
    scene = stark.Scene()
    pins = x < -0.4999 * LENGTH
    body = scene.add_solid(mesh, material, pins=pins, initial_positions=start, self_contact=False)
    return scene, body, np.flatnonzero(x > 0.4999 * LENGTH)


def deflected(mesh: Mesh) -> tuple[np.ndarray, float]:
    """Positions under the load, and by how much the end went down [m]."""
    scene, body, end = cantilever(mesh)
    scene.add(load(body.vertices[end], force=(0, 0, -LOAD / len(end))))
    sim = simulate(scene, 1.0, gravity=(0, 0, 0), **STATIC)
    report = sim.step()
    assert report.status == "accepted", report.message
    return body.positions, float((mesh.vertices - body.positions)[end, 2].mean())


@pytest.mark.parametrize("kind", ["tet10", "hex27"])
def test_small_deflection_with_quadratic_elements(kind: str) -> None:
    validate(f"V05.deflection_{kind}", deflected(beam_mesh(kind, 10))[1])


@pytest.mark.parametrize("kind", ["tet4", "hex8"])
def test_small_deflection_converges_with_linear_elements(kind: str) -> None:
    beam = LOAD * LENGTH**3 * 4 / (MODULUS * WIDTH**4) + LOAD * LENGTH / (5 / 6 * MODULUS / 2 * WIDTH**2)
    ends = [deflected(beam_mesh(kind, 10 * n, n))[1] for n in (4, 8)]
    validate(f"V05.order_{kind}", np.log2((beam - ends[0]) / (beam - ends[1])))
    validate(f"V05.deflection_{kind}", extrapolate(*ends, order=2))


def test_first_frequency_of_a_cantilever() -> None:
    """Released from the deflection of the load, which is 97 % of the first mode; from the first to the fifth
    passage of the end through the middle it is two periods."""
    mesh = beam_mesh("hex27", 10)
    start, _ = deflected(mesh)
    scene, body, end = cantilever(mesh, start)
    sim = simulate(scene, 4e-3, gravity=(0, 0, 0), **DYNAMIC, **BDF2)
    passages = crossings(record(sim, 1.5, lambda: body.positions[end, 2].mean()))
    validate("V05.frequency", 2.0 / (passages[4] - passages[0]))


@stark.energy
def push(p: stark.Point, t: stark.Time, mass: float, acceleration: float):
    """Gravity that comes and goes within a second: a motion that is smooth in time has an order."""
    return mass * acceleration * stark.sin(np.pi * t) ** 2 * p.x[2]


def swing(cells: int, time_step: float, **settings: Any) -> np.ndarray:
    """The end of a soft bar (1 MPa) at 0.25, 0.5, 0.75 and 1 s, when it swings by 0.9 of its length. One cell
    deep, because nothing depends on the depth without lateral contraction."""
    mesh = stark.mesh.box_hexahedra((LENGTH, WIDTH, WIDTH), (10 * cells, 1, cells))
    scene, body, end = cantilever(mesh, modulus=1e6)
    masses = np.zeros(len(mesh.vertices))
    np.add.at(masses, mesh.elements, (mesh.volumes * DENSITY / 8)[:, None])
    scene.add(push(body.vertices, mass=masses, acceleration=9.81))
    sim = simulate(scene, time_step, gravity=(0, 0, 0), **DYNAMIC, **settings)
    history = record(sim, 1.0, lambda: body.positions[end].mean(axis=0)[[0, 2]])
    return at(history, [0.25, 0.5, 0.75, 1.0])


@pytest.mark.parametrize(("name", "settings"), [("implicit_euler", {}), ("bdf2", BDF2)])
def test_swinging_bar_converges_in_time(name: str, settings: dict[str, str]) -> None:
    validate(f"V08.time_{name}", observed_order(*(swing(2, h, **settings) for h in (5e-3, 2.5e-3, 1.25e-3))))


@pytest.mark.slow
def test_swinging_bar_converges_in_space() -> None:
    validate("V08.space", observed_order(*(swing(n, 0.01, **BDF2) for n in (2, 4, 8))))
