"""Bars of metal in three dimensions against closed forms and published values: torsion, impact on a wall."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

EXACT: dict[str, Any] = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.acceleration_tolerance": 0.0,
    "newton.residual_tolerance": 1e-8,
}


SHEAR, YIELD, RADIUS = 8e10, 2.5e8, 0.01  # [Pa], [Pa], [m]


def round_section(x: np.ndarray) -> np.ndarray:
    """Squares of half a side 1 to discs of radius 1, circle by circle outside and square by square inside."""
    large = np.abs(x).max(axis=1)
    length = np.linalg.norm(x, axis=1)
    ratio = np.where(length > 0, large / np.where(length > 0, length, 1.0), 1.0)
    return x * ((1 - large) + large * ratio)[:, None]


def round_bar(radius: float, length: float, across: int, along: int) -> Any:
    """Hexahedra of 27 nodes along z from 0."""
    mesh = stark.mesh.to_quadratic(stark.mesh.box_hexahedra((2, 2, 1), (across, across, along)))
    X = np.asarray(mesh.vertices)
    X = np.column_stack([round_section(X[:, :2]) * radius, (X[:, 2] + 0.5) * length])
    return stark.mesh.SolidMesh(X, mesh.elements)


def torques(across: int, twists: list[float]) -> list[float]:
    """Torques [N m] of a bar of radius 10 mm, of a perfectly plastic metal, whose ends turn against each
    other to angles per length [rad/m]."""
    length = 0.01
    metal = stark.j2_plasticity(shear_modulus=SHEAR, bulk_modulus=1.7e11, yield_stress=YIELD, density=7850.0)
    mesh = round_bar(RADIUS, length, across, 1)
    X = np.asarray(mesh.vertices)
    top = X[:, 2] > 0.999 * length
    scene = stark.Scene()
    ends = np.flatnonzero(top | (X[:, 2] < 1e-3 * length))
    body = scene.add_solid(mesh, metal, pins=ends)
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), **EXACT)
    found, before = [], 0.0
    for twist in twists:
        angle = twist * length
        c, s = np.cos(angle), np.sin(angle)
        turned = X @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        body.pin_targets = np.where(top[:, None], turned, X)[body.pins]
        report = sim.step()
        assert not report.failed
        found.append(report.energy["external"] / np.sin(angle - before))
        before = angle
    return found


def test_torsion_of_a_bar() -> None:
    """Elastic, elastic-plastic and fully plastic torque of a round bar, and elastic unloading on the way.
    Sections stay plane, so a slice of the bar is the bar."""
    shear_yield = YIELD / np.sqrt(3)
    first = shear_yield / (SHEAR * RADIUS)  # twist at which the surface yields [rad/m]
    full = 2 * np.pi / 3 * shear_yield * RADIUS**3
    stiffness = np.pi / 2 * SHEAR * RADIUS**4
    partly = {ratio: full * (1 - ratio**-3 / 4) for ratio in (1.5, 2.0, 4.0)}
    found = torques(4, [first * ratio for ratio in (0.5, 1.5, 2.0, 4.0, 3.0, 20.0)])
    expected = [0.5 * stiffness * first, *partly.values(), partly[4.0] - stiffness * first, full]
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-3 * full)


@stark.energy
def wall(p: stark.Point, stiffness: float):
    """Plane z = 0 without friction, for what comes from above."""
    return 0.5 * stiffness * stark.minimum(p.x[2], 0.0) ** 2


@stark.energy
def held(p: stark.Point, normal: stark.Vec3, stiffness: float):
    """Keeps points in planes through where they were."""
    return 0.5 * stiffness * ((p.x - p.X) @ normal) ** 2


def sector(radius: float, length: float, across: int, along: int) -> tuple[Any, np.ndarray, np.ndarray]:
    """Hexahedra of 8 nodes in a round bar between two planes through its axis, finer at z = 0; vertices of
    these planes and next to the axis, and normals of the planes that they stay in."""
    angle, hole = np.radians(7.5), 0.02
    mesh = stark.mesh.box_hexahedra((1, 1, 1), (across, 1, along))
    r, turn, z = (np.asarray(mesh.vertices) + 0.5).T
    turn, distance = angle * turn, radius * (hole + (1 - hole) * r)
    X = np.column_stack([distance * np.cos(turn), distance * np.sin(turn), length * z * (0.5 + 0.5 * z)])
    normals = np.column_stack([-np.sin(turn), np.cos(turn), 0 * turn])
    inner = np.flatnonzero(r < 1e-9)
    outward = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])[inner]
    places = np.concatenate([np.arange(len(X)), inner])
    return stark.mesh.SolidMesh(X, mesh.elements), places, np.vstack([normals, outward])


def impact(across: int, along: int, step: float) -> tuple[float, float, float]:
    """Length and largest radius [mm] 80 microseconds after the impact, and the largest plastic strain."""
    radius, length, young, ratio = 3.2e-3, 32.4e-3, 117e9, 0.35
    copper = stark.j2_plasticity(
        shear_modulus=young / (2 * (1 + ratio)), bulk_modulus=young / (3 * (1 - 2 * ratio)),
        yield_stress=400e6, hardening_modulus=100e6, density=8930.0,
    )  # fmt: skip
    mesh, places, normals = sector(radius, length, across, along)
    scene = stark.Scene()
    rod = scene.add_solid(mesh, copper, formulation="mean_dilatation", velocity=(0, 0, -227.0))
    scene.add(held(rod.vertices[places], normal=normals, stiffness=young * radius))
    foot = np.asarray(mesh.vertices)[:, 2] < 1e-9
    scene.add(wall(rod.vertices[foot], stiffness=0.1 * young * radius / across))
    settings = {"contact.enabled": False, "time.integrator": "bdf2", "time.min_step": 0.1 * step}
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings)
    while sim.time < 80e-6 - 0.5 * step:
        report = sim.step()
        assert not report.failed, report.message
        assert report.energy["damping"] >= 0.0
    x = sim[rod].positions
    strain = sim.state.arrays()["internal_variable"].reshape(-1, 10)[:, 9]
    height, spread = np.ptp(x[:, 2]), np.linalg.norm(x[:, :2], axis=1).max()
    return 1e3 * float(height), 1e3 * float(spread), float(strain.max())


@pytest.mark.slow
def test_impact_of_a_copper_rod() -> None:
    """Taylor's test. Published computations have lengths of 21.4 to 21.6 mm, radii of 6.9 to 7.1 mm and
    strains of about 3. The length is within 3 %; the foot spreads more, by what docs/validation.md says."""
    for cells, step, measured in (
        ((4, 16), 1e-6, (21.68, 7.29, 3.08)),
        ((5, 50), 2.5e-7, (21.52, 7.39, 3.25)),
    ):
        found = impact(*cells, step)
        assert found[0] == pytest.approx(21.5, rel=0.03)
        np.testing.assert_allclose(found, measured, rtol=5e-3)
