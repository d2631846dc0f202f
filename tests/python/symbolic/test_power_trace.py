"""Sums of powers of eigenvalues against those of NumPy, derivatives where eigenvalues meet, laws of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark
import stark.symbolic as sym

RANDOM = np.random.default_rng(7)


def spread(count: int, size: int, least: float, most: float) -> np.ndarray:
    """Symmetric matrices with eigenvalues in a range."""
    values = np.exp(RANDOM.uniform(np.log(least), np.log(most), (count, size)))
    turns = np.linalg.qr(RANDOM.normal(size=(count, size, size)))[0]
    found: np.ndarray = np.einsum("nij,nj,nkj->nik", turns, values, turns)
    return found


def compiled(size: int, exponent: float) -> Any:
    @sym.function
    def power(A: sym.Matrix[size, size]):  # type: ignore[valid-type]
        return sym.power_trace(A, exponent)

    return power


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("exponent", [0.5, 0.65, 1.3, 2.75, -0.5, -1.9, 0.02, 3, -2])
def test_it_is_the_sum_of_powers_of_eigenvalues(size: int, exponent: float) -> None:
    power = compiled(size, exponent)
    for least, most, error in ((0.25, 4.0, 1e-12), (1 / 16, 16.0, 1e-9), (1 / 64, 64.0, 3e-5)):
        A = spread(40, size, least, most)
        exact = (np.linalg.eigvalsh(A) ** exponent).sum(axis=1)
        assert power(A) == pytest.approx(exact, rel=error)


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("exponent", [0.5, 1.3, -0.5])
def test_matrices_of_any_size(size: int, exponent: float) -> None:
    """Moments in SI units are small: with a mean far from 1 values and derivatives scale as they have to."""
    power = compiled(size, exponent)
    A = spread(40, size, 0.5, 2.0)
    value, gradient, hessian = power(A), power.gradient(A), power.hessian(A)
    for factor in (1e-12, 1e-4, 1e-2, 1e2, 1e6):
        assert power(factor * A) == pytest.approx(factor**exponent * value, rel=1e-11)
        assert power.gradient(factor * A) == pytest.approx(factor ** (exponent - 1.0) * gradient, rel=1e-8)
        # Of the largest entry: others are differences of large numbers.
        scaled = power.hessian(factor * A) / factor ** (exponent - 2.0)
        assert np.abs(scaled - hessian).max() < 1e-8 * np.abs(hessian).max()


@pytest.mark.parametrize("size", [2, 3])
def test_derivatives_exist_where_eigenvalues_meet(size: int) -> None:
    """d tr(A^s) = s A^(s-1), and along H, which commutes with A = c, s (s - 1) c^(s-2) |H|^2."""
    for exponent in (0.5, 1.7, -0.8):
        power = compiled(size, exponent)
        for c in (1.0, 2.0):
            gradient = power.gradient(c * np.eye(size))
            assert gradient == pytest.approx(exponent * c ** (exponent - 1.0) * np.eye(size), abs=1e-11)
            H = np.diag(RANDOM.normal(size=size)).reshape(-1)
            second = H @ power.hessian(c * np.eye(size)).reshape(size**2, size**2) @ H
            assert second == pytest.approx(exponent * (exponent - 1.0) * c ** (exponent - 2.0) * (H @ H))


def test_exponents_that_vary_and_shapes_are_refused() -> None:
    with pytest.raises(stark.TraceError, match=r"exponent = .*must be a fixed number"):

        @sym.function
        def power(A: sym.Mat3, s: float):
            return sym.power_trace(A, s)

        power(np.eye(3), 0.5)
    for exponent in (np.nan, 17.0):
        with pytest.raises(stark.TraceError, match=r"must be in \[-16, 16\]"):
            sym.power_trace(np.eye(3), exponent)
    with pytest.raises(stark.TraceError, match="2 x 2 or 3 x 3"):
        sym.power_trace(np.eye(4), 0.5)


def ogden(terms: list[tuple[float, float]], bulk: float) -> Any:
    """Sum of mu/alpha (stretches^alpha - 3), without the change of volume."""

    @stark.material
    def law(F: stark.DeformationGradient, bulk: float = stark.parameter(bulk, unit="Pa", above=0.0)):
        J = stark.determinant(F)
        C = (F.T @ F) * J ** (-2.0 / 3.0)
        shape = sum(mu / alpha * (stark.power_trace(C, alpha / 2.0) - 3.0) for mu, alpha in terms)
        return shape + 0.5 * bulk * (J - 1.0) ** 2

    return law(density=1000.0)


def test_rubber_of_treloar_in_tension() -> None:
    """Ogden's three terms of 1972 in uniaxial tension: nominal stress sum mu (s^(a-1) - s^(-a/2-1))."""
    terms = [(0.63e6, 1.3), (0.0012e6, 5.0), (-0.01e6, -2.0)]
    scene, box = stark.Scene(), stark.mesh.box_hexahedra(1.0, 1)
    bar = scene.add_solid(box, ogden(terms, 1e10))
    for k, axis in enumerate("xyz"):
        scene.add_rollers(bar.vertices[box.vertices[:, k] < -0.49], axis)
    end = scene.add_rollers(bar.vertices[box.vertices[:, 0] > 0.49], "x")
    settings = {"time.integrator": "quasistatic", "gravity": (0, 0, 0)}
    sim = stark.Simulation(scene, settings, time_step=1.0)
    for shift in (0.2, 1.0, 2.0, 3.0, 4.0, 5.0):
        end.shift = shift
        assert not sim.step().failed
        s = 1.0 + (np.ptp(bar.positions[:, 0]) - 1.0)
        exact = sum(mu * (s ** (alpha - 1.0) - s ** (-alpha / 2.0 - 1.0)) for mu, alpha in terms)
        assert end.forces.sum(axis=(0, 1))[0] == pytest.approx(exact, rel=1e-3), s


def test_as_rigid_as_possible_is_the_corotated_law() -> None:
    """|F - R|^2 = tr C - 2 tr U + 3 where nothing is inverted; the built-in law has it with lambda = 0."""

    @stark.material
    def rigid(F: stark.DeformationGradient, mu: float = stark.parameter(unit="Pa", above=0.0)):
        C = F.T @ F
        return mu * (stark.trace(C) - 2.0 * stark.power_trace(C, 0.5) + 3.0)

    places = []
    for law in (
        rigid(mu=5e4, density=1000.0),
        stark.materials.corotated(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.0),
    ):
        scene, mesh = stark.Scene(), stark.mesh.tet_box((0.2, 0.05, 0.05), (4, 1, 1))
        bar = scene.add_solid(mesh, law, pins=mesh.vertices[:, 0] < -0.099)
        stark_sim = stark.Simulation(scene, time_step=0.01)
        stark_sim.run_until(0.2)
        places.append(bar.positions)
    assert places[0] == pytest.approx(places[1], abs=1e-7)
    assert np.ptp(places[0][:, 2]) > 0.06  # it bends
