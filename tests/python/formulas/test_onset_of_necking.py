"""The strain at which a bar of metal may neck, against the bifurcation theory of Hutchinson and Miles 1974,
"Bifurcation analysis of the onset of necking in an elastic/plastic cylinder under uniaxial tension"."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from formulas.test_metal_bars import EXACT, held, pulled, round_section

import stark

YOUNG, RATIO, FLOW, HARDENING, RADIUS = 206.9e9, 0.29, 450e6, 600e6, 0.01  # [Pa], [1], [Pa], [Pa], [m]


def uniform(strain: float) -> tuple[float, float]:
    """Stress and its slope [Pa] in uniaxial tension to a logarithmic strain."""
    plastic = (strain - FLOW / YOUNG) / (1 + HARDENING / YOUNG)
    return FLOW + HARDENING * plastic, 1 / (1 / HARDENING + 1 / YOUNG)


def least_stiffness(stress: float, slope: float, wave: float, terms: int = 4) -> float:
    """Of waves along an incompressible round bar in tension whose moduli are those of plastic loading, over
    that of its stretch [Pa]; wave: 2 pi radius over their length.

    The second variation of Hill's comparison solid [Hutchinson and Miles 1974, section 2], minimised over
    polynomials of the radius: u_r = V(r) cos(kz), u_z = W(r) sin(kz) with V' + V/r + kW = 0."""
    r, weight = np.polynomial.legendre.leggauss(20)
    r, weight = (r + 1) / 2, weight * (r + 1) / 4
    shear = YOUNG / 3
    softening = 1 - slope / YOUNG
    rows = []
    for n in range(terms):
        V, dV, W = r ** (2 * n + 1), (2 * n + 1) * r ** (2 * n), -(2 * n + 2) * r ** (2 * n) / wave
        dW = -(2 * n + 2) * 2 * n * r ** max(2 * n - 1, 0) / wave
        rows.append([dV, V / r, wave * W, -wave * V, (dW - wave * V) / 2])
    stiffness, stretch = np.zeros((2, terms, terms))
    for i, (rr, tt, zz, slant, rz) in enumerate(rows):
        for j, (rr2, tt2, zz2, slant2, rz2) in enumerate(rows):
            moduli = 2 * shear * (rr * rr2 + tt * tt2 + (1 - 1.5 * softening) * zz * zz2 + 2 * rz * rz2)
            tension = stress * (slant * slant2 - zz * zz2 - 2 * rz * rz2)
            stiffness[i, j] = weight @ (moduli + tension)
            stretch[i, j] = weight @ (zz * zz2)
    return float(scipy.linalg.eigh(stiffness, stretch, eigvals_only=True)[0])


def bifurcation(slenderness: float) -> float:
    """Logarithmic strain at which a bar may neck; slenderness: half of its length over its radius."""

    def stiffness(strain: float) -> float:
        return least_stiffness(*uniform(strain), np.pi / slenderness * np.exp(-1.5 * strain))

    return scipy.optimize.brentq(stiffness, 0.2, 0.8)


@stark.energy
def pushed(p: stark.Point, force: float, wave: float):
    """Forces along z on points of a bar, in a wave that makes it thinner on one side."""
    return -force * stark.sin(wave * p.X[2]) * p.x[2]


def half_bar(slenderness: float, along: int) -> Any:
    """A quarter of a round bar, hexahedra of 27 nodes, two across."""
    mesh = stark.mesh.to_quadratic(stark.mesh.box_hexahedra((1, 1, 1), (2, 2, along)))
    X = np.asarray(mesh.vertices) + 0.5
    X = np.column_stack([round_section(X[:, :2]), slenderness * X[:, 2]]) * RADIUS
    return stark.mesh.SolidMesh(X, mesh.elements)


def stiffnesses(slenderness: float, along: int, strains: np.ndarray) -> np.ndarray:
    """Force over displacement of the wave [N/m] while the bar is stretched from strain to strain: half of the
    difference of two steps of a strain of 1e-5 with forces that change it by 1e-8."""
    metal = stark.j2_plasticity(
        shear_modulus=YOUNG / (2 * (1 + RATIO)), bulk_modulus=YOUNG / (3 * (1 - 2 * RATIO)),
        yield_stress=FLOW, hardening_modulus=HARDENING, density=7850.0,
    )  # fmt: skip
    mesh, length, stiff = half_bar(slenderness, along), slenderness * RADIUS, 5 * YOUNG * RADIUS
    X, scene = np.asarray(mesh.vertices), stark.Scene()
    body = scene.add_solid(mesh, metal)
    for i in range(3):
        side = np.flatnonzero(X[:, i] < 1e-9)
        scene.add(held(body.vertices[side], normal=np.eye(3)[i], stiffness=stiff))
    end = np.flatnonzero(X[:, 2] > length - 1e-9)
    pull = scene.add(pulled(body.vertices[end], way=0.0, stiffness=stiff))
    push = scene.add(pushed(body.vertices, force=0.0, wave=np.pi / length))
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), **EXACT)
    wave, step = np.sin(np.pi * X[:, 2] / length), 1e-5

    def stretch_to(strain: float) -> float:
        pull.way = length * np.expm1(strain)
        report = sim.step()
        assert not report.failed, report.message
        return wave @ sim[body].positions[:, 2] / len(X)

    found, before = [], 0.0
    for strain in strains:
        for between in np.linspace(before, strain - step, 8)[1:]:
            stretch_to(between)
        start, moved = sim.state, []
        force = 1e-8 * least_stiffness(*uniform(strain), np.pi / slenderness) * RADIUS**2 / len(X)
        for push.force in (force, -force):
            moved.append(stretch_to(strain))
            sim.reset(start)
        push.force, before = 0.0, strain - step
        found.append(2 * force / (moved[0] - moved[1]))
    return np.array(found)


@pytest.mark.parametrize("slenderness, along", [(4, 10), (8, 16)])
def test_a_bar_may_neck_where_theory_says(slenderness: int, along: int) -> None:
    """The force that a neck takes vanishes there. Short bars neck later than at the largest load, where
    Considere has it (0.25), since what is not uniform in a section is elastic."""
    expected = bifurcation(slenderness)
    strains = np.linspace(0.5, 0.85, 5) * expected
    found = stiffnesses(slenderness, along, strains)
    roots = np.roots(np.polyfit(strains, found * np.exp(2 * strains), 3))
    root = roots[np.argmin(np.abs(roots - expected))]
    assert abs(root.imag) < 1e-12
    assert root.real == pytest.approx(expected, rel=0.02)
    considere = (HARDENING - FLOW) / HARDENING
    assert root.real > 1.03 * considere


def test_slender_bars_neck_as_the_one_dimensional_theory_says() -> None:
    """The slope of the stress over it is 1 - wave^2/8 there [Hutchinson and Miles 1974, the first terms of
    their series; Audoly and Hutchinson 2016]."""
    for slenderness in (20, 40):
        stress, slope = uniform(strain := bifurcation(slenderness))
        wave = np.pi / slenderness * np.exp(-1.5 * strain)
        assert 1 - slope / stress == pytest.approx(wave**2 / 8, rel=25 / slenderness**2)
