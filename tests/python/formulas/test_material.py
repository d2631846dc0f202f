"""Constitutive laws written in Python: statics against closed forms, directions, refused formulas."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import InvalidArgument, TraceError

MODULUS = stark.parameter(1e4, unit="Pa", above=0.0)


@stark.material
def saint_venant(F: stark.DeformationGradient, mu: float = MODULUS, lam: float = MODULUS):
    """St. Venant-Kirchhoff."""
    E = 0.5 * (F.T @ F - stark.identity(3))
    return mu * stark.squared_norm(E) + 0.5 * lam * stark.trace(E) ** 2


@stark.material
def membrane(C: stark.CauchyGreen, mu: float = MODULUS, lam: float = MODULUS):
    E = 0.5 * (C - stark.identity(2))
    return mu * stark.squared_norm(E) + 0.5 * lam * stark.trace(E) ** 2


@stark.material
def woven(
    F: stark.ShellDeformationGradient,
    F_prev: stark.ShellDeformationGradient,
    h: stark.TimeStep,
    warp: float = MODULUS,
    weft: float = MODULUS,
    viscosity: float = stark.parameter(0.0, unit="Pa s", min=0.0),
):
    E = 0.5 * (F.T @ F - stark.identity(2))
    E_prev = 0.5 * (F_prev.T @ F_prev - stark.identity(2))
    elastic = 0.5 * warp * E[0, 0] ** 2 + 0.5 * weft * E[1, 1] ** 2 + warp * E[0, 1] ** 2
    return elastic + 0.5 * viscosity / h * stark.squared_norm(E - E_prev)


def test_a_stretched_bar_carries_the_closed_form_force() -> None:
    # Lateral positions are prescribed: F = diag(s, 1, 1), P11 = s (lam + 2 mu) E11.
    mu, lam, s, size = 3e4, 2e4, 1.2, 0.1
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(size, 2)
    bar = scene.add_solid(
        mesh,
        saint_venant(mu=mu, lam=lam, density=1000.0),
        initial_positions=mesh.vertices * [s, 1.0, 1.0],
        pins=np.arange(len(mesh.vertices)),
    )
    scene.add_box(size=0.1, position=(1.0, 0.0, 0.0), mass=1.0)

    @stark.energy
    def copy(t: stark.Tetrahedron, mu: float, lam: float):
        return saint_venant(t.F, mu, lam) * t.rest_volume

    probe = scene.add(copy(bar.tetrahedra, mu=mu, lam=lam))
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    forces = np.zeros((len(mesh.vertices), 3))
    np.add.at(forces, mesh.tets, probe.forces)
    end = mesh.vertices[:, 0] > 0.5 * size - 1e-9
    strain = 0.5 * (s**2 - 1.0)
    assert forces[end, 0].sum() == pytest.approx(-s * (lam + 2.0 * mu) * strain * size**2, rel=1e-12)
    volume = size**3
    assert probe.energy == pytest.approx((mu + 0.5 * lam) * strain**2 * volume, rel=1e-12)


def test_a_law_of_material_directions_takes_a_warp_direction() -> None:
    def sag(direction: tuple) -> np.ndarray:
        scene = stark.Scene()
        cloth = scene.add_cloth(
            stark.mesh.grid(0.2, 0.1, cells=(4, 2)),
            woven(warp=1e5, weft=1e3, viscosity=1.0, warp_direction=direction, density=0.2),
            pins=[0, 4],
        )
        sim = stark.Simulation(scene, time_step=0.01)
        sim.run_until(0.1)
        return cloth.positions

    along, across = sag((1.0, 0.0, 0.0)), sag((0.0, 1.0, 0.0))
    assert np.abs(along - across).max() > 1e-4
    report = woven.check(warp=1e5, weft=1e3)
    assert report.ok and report["isotropy"].status == "note"
    assert membrane.check()["isotropy"].status == "ok"


def law_of(body: str, strain: str = "F: stark.DeformationGradient", options: str = "mu: float = MODULUS"):
    names: dict = {"stark": stark, "MODULUS": MODULUS}
    exec(f"@stark.material\ndef law({strain}, {options}):\n    return {body}\n", names)
    return names["law"]


@pytest.mark.parametrize(
    ("error", "make", "words"),
    [
        (InvalidArgument, lambda: law_of("mu * stark.norm(F - stark.identity(3))")(), "stress is not finite"),
        (InvalidArgument, lambda: law_of("mu * stark.log(F[0, 1])")(), "the energy is not finite at rest"),
        (TraceError, lambda: law_of("mu * stark.log(2.0)")(), "does not depend on F"),
        (TraceError, lambda: law_of("F[0, 0] ** 2")(), "does not depend on 'mu'"),
        (TraceError, lambda: law_of("mu * F")(), "returns Mat of 3 x 3: must be a scalar"),
        (TraceError, lambda: law_of("mu", strain="F: float"), "first argument must be the strain"),
        (TraceError, lambda: law_of("mu * F[0, 0]", options="thickness: float, mu: float"), "'thickness'"),
        (TraceError, lambda: law_of("mu * F[0, 0]", options="mu: str"), "argument 'mu' has the annotation"),
        (InvalidArgument, lambda: saint_venant(mu=-1.0), r"mu = -1 Pa: must be > 0"),
        (InvalidArgument, lambda: saint_venant(mu=[1.0, 0.0]), r"mu\[1\] of element 1 = 0 Pa: must be > 0"),
        (InvalidArgument, lambda: saint_venant(mu=np.ones((2, 2))), r"shape \(2, 2\)"),
        (InvalidArgument, lambda: saint_venant(mew=1.0), "mew"),
        (InvalidArgument, lambda: saint_venant(base=stark.materials.cotton), "must be a stark.SolidMaterial"),
        (InvalidArgument, lambda: law_of("mu * F[0, 0]", options="mu: float")(), "'mu' has no value"),
    ],
)
def test_refused_laws(error: type[Exception], make: object, words: str) -> None:
    with pytest.raises(error, match=words):
        make()
