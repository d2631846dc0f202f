"""Mullins' effect against the published factor: loading, unloading, reloading, what is stored and lost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from formulas._laws import EQUILIBRIA

import stark

C10, C01, BULK = 1e5, 2e4, 1e8  # [Pa]
R, M, BETA = 1.6, 4e4, 0.1
VOLUME = 1e-3  # [m^3]


def rubber(**changed: float) -> stark.SolidMaterial:
    given = {"c10": C10, "c01": C01, "bulk_modulus": BULK, "r": R, "m": M, "beta": BETA}
    return stark.ogden_roxburgh(**{**given, **changed}, density=1000.0)


def block(mesh: Any, **changed: float) -> tuple[stark.Simulation, Any]:
    """A block whose vertices are prescribed."""
    scene = stark.Scene()
    body = scene.add_solid(mesh, rubber(**changed), pins=range(len(mesh.vertices)))
    return stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **EQUILIBRIA), body


def virgin_energy(stretch: float) -> float:
    """Of isochoric tension [J/m^3]."""
    return C10 * (stretch**2 + 2 / stretch - 3) + C01 * (2 * stretch + stretch**-2 - 3)


def virgin_stress(stretch: float) -> float:
    """Nominal stress in isochoric tension [Pa]."""
    return 2 * (stretch - stretch**-2) * (C10 + C01 / stretch)


def factor(energy: float, peak: float) -> float:
    """Of the stress below the peak, as published."""
    return 1 - math.erf(max(peak - energy, 0.0) / (M + BETA * peak)) / R


def recoverable(energy: float, peak: float) -> float:
    """Integral of the factor over the energy, by Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    at = 0.5 * energy * (nodes + 1)
    return 0.5 * energy * float(weights @ [factor(w, peak) for w in at])


#: First loading, unloading, reloading beyond the first peak, unloading to nothing.
PATH = np.concatenate(
    [
        np.linspace(1, 2, 6)[1:],
        np.linspace(2, 1, 6)[1:],
        np.linspace(1, 2.6, 9)[1:],
        np.linspace(2.6, 1, 9)[1:],
    ]
)


@pytest.mark.parametrize("mesh", [stark.mesh.tet_box(0.1, 1), stark.mesh.box_hexahedra(0.1, 1)])
def test_loading_unloading_and_reloading(mesh: Any) -> None:
    """Stresses, through the work of the ends; stored and dissipated energy; the peak that is remembered."""
    sim, body = block(mesh)
    X = np.asarray(body.mesh.vertices)
    peak, before, scale = 0.0, 1.0, virgin_energy(2.6)
    for stretch in PATH:
        body.pin_targets = X @ np.diag([stretch, stretch**-0.5, stretch**-0.5])
        report = sim.step()
        assert not report.failed
        energy = virgin_energy(stretch)
        old, peak = peak, max(peak, energy)
        # J = 1 bears no pressure, and forces of the end of the step act over its motion: those of the ends
        # and those of the sides, where the isochoric law has its deviator.
        stress = factor(energy, peak) * virgin_stress(stretch)
        side = factor(energy, peak) * deviator_beside(stretch)
        axial = stress + side * stretch**-1.5  # the tension of free sides, and what pressure adds
        way, way_beside = stretch - before, stretch**-0.5 - before**-0.5
        work = axial * way + 2 * side * way_beside
        before = stretch
        assert report.energy["external"] / VOLUME == pytest.approx(work, rel=1e-5, abs=1e-6 * scale)
        assert report.energy["elastic"] / VOLUME == pytest.approx(
            recoverable(energy, peak), rel=2e-6, abs=1e-7 * scale
        )
        lost = (energy - recoverable(energy, peak)) if energy == peak and peak > old else 0.0
        if lost:
            lost -= old - recoverable(old, old)
        assert report.energy["damping"] / VOLUME == pytest.approx(lost, rel=1e-5, abs=1e-7 * scale)
        assert report.energy["damping"] >= -1e-15 * scale * VOLUME
        peaks = sim.state.arrays()["internal_variable"]
        np.testing.assert_allclose(peaks, peak, rtol=1e-9)


def deviator_beside(stretch: float) -> float:
    """Nominal stress of the isochoric law on the sides in isochoric tension [Pa]: minus a third of the true
    stress of free sides, over the stretch there."""
    return -virgin_stress(stretch) * stretch / 3 / stretch**-0.5


def test_the_second_cycle_is_elastic_and_softer_than_the_first() -> None:
    sim, body = block(stark.mesh.tet_box(0.1, 1))
    X = np.asarray(body.mesh.vertices)
    rows = []
    for stretch in (1.25, 1.5, 1.25, 1.0, 1.25, 1.5, 1.25):
        body.pin_targets = X @ np.diag([stretch, stretch**-0.5, stretch**-0.5])
        energy = sim.step().energy
        rows.append((energy["elastic"], energy["damping"]))
    stored, lost = np.array(rows).T
    assert lost[0] > 0 and lost[1] > 0
    assert np.abs(lost[2:]).max() < 1e-12 * lost[1]
    assert stored[4] == pytest.approx(stored[2]) and stored[5] == pytest.approx(stored[1])
    assert stored[4] < 0.95 * stored[0]


def test_much_softening_room_is_the_virgin_rubber() -> None:
    """For large r nothing is lost: stark.materials.mooney_rivlin."""
    plain = stark.materials.mooney_rivlin(c10=C10, c01=C01, bulk_modulus=BULK, density=1000.0)
    mesh = stark.mesh.tet_box(0.1, 1)
    scene = stark.Scene()
    body = scene.add_solid(mesh, plain, pins=range(len(mesh.vertices)))
    elastic = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **EQUILIBRIA)
    sim, softening = block(mesh, r=1e9)
    for stretch in (1.5, 1.2):
        body.pin_targets = softening.pin_targets = np.asarray(mesh.vertices) * [stretch, 1.0, 0.9]
        expected = elastic.step().energy["elastic"]
        assert sim.step().energy["elastic"] == pytest.approx(expected, rel=1e-7)


def test_a_swinging_block_loses_energy_while_it_softens() -> None:
    """Free motion: nothing is dissipated below the peak, and never a negative amount."""
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(0.1, 2)
    bottom = np.flatnonzero(np.asarray(mesh.vertices)[:, 2] < -0.049)
    scene.add_solid(mesh, rubber(bulk_modulus=1e6), pins=bottom, velocity=(3.0, 0.0, 0.0))
    sim = stark.Simulation(scene, time_step=1e-3, gravity=(0, 0, 0), **{"contact.enabled": False})
    lost = [sim.step().energy["damping"] for _ in range(60)]
    assert min(lost) >= -1e-12
    assert sum(lost[:20]) > 0.02 and sum(lost[40:]) < 0.05 * sum(lost)


def test_derivatives_are_those_of_the_energy() -> None:
    report = stark.ogden_roxburgh.check(c10=C10, bulk_modulus=BULK, r=R, m=M)
    assert {f.name: f.status for f in report.findings}["stress"] == "ok", str(report)


def test_the_factor_cannot_take_more_than_the_stress() -> None:
    with pytest.raises(stark.InvalidArgument, match=r"r = 0\.5"):
        rubber(r=0.5)
