"""Barrier, mollifier and friction potentials against the independent implementation ipctk."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stark import InvalidArgument, _core

ipctk = pytest.importorskip("ipctk")

D_HAT, KAPPA = 0.3, 2.0


def evaluate_potential(
    name: str, x: np.ndarray, x_prev: np.ndarray | None = None, *, values: dict[str, Any]
) -> tuple[float, np.ndarray, np.ndarray]:
    """Energy [J], gradient (n, 3) [N] and Hessian (3 n, 3 n) [N/m] of one element."""
    points = {"x": x, "X": x, "x_prev": x if x_prev is None else x_prev, "x_initial": x}
    numbers = {key: np.atleast_1d(value) for key, value in values.items()}
    inputs = {**points, "values": numbers, "time_step": 1.0, "time": 1.0}
    out = _core.registered_formula(name).sample(inputs).evaluate(2)
    n = x.size
    upper = np.zeros((n, n))
    upper[np.triu_indices(n)] = out[1 + n :]
    return float(out[0]), out[1 : 1 + n].reshape(-1, 3), upper + np.triu(upper, 1).T


def evaluate(name: str, x: np.ndarray, **values: Any) -> tuple[float, np.ndarray, np.ndarray]:
    energy, gradient, hessian = evaluate_potential(name, x, values=values)
    n = 3 * len(x)
    return energy, gradient.reshape(n), hessian.reshape(n, n)


def apart(a: list[list[float]], b: list[list[float]], rng: np.random.Generator) -> np.ndarray:
    """The two sides at a random distance below D_HAT along z, with noise in the plane."""
    x = np.array(a + b, dtype=float)
    x[:, :2] += rng.uniform(-0.05, 0.05, (len(x), 2))
    x[: len(a), 2] += D_HAT * rng.uniform(0.05, 0.95)
    return x


def chain(d: float, gradient: np.ndarray, hessian: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """kappa b(d) and its derivatives from those of the squared distance, with ipctk's barrier of d."""
    d_gradient = gradient / (2.0 * d)
    d_hessian = hessian / (2.0 * d) - np.outer(gradient, gradient) / (4.0 * d**3)
    first, second = ipctk.barrier_first_derivative(d, D_HAT), ipctk.barrier_second_derivative(d, D_HAT)
    energy = KAPPA * ipctk.barrier(d, D_HAT)
    curvature = second * np.outer(d_gradient, d_gradient) + first * d_hessian
    return energy, KAPPA * first * d_gradient, KAPPA * curvature


def assert_close(ours: tuple[Any, ...], theirs: tuple[Any, ...]) -> None:
    # Both are exact formulas: what is left is rounding, magnified by the barrier's curvature near contact.
    for mine, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-9, atol=1e-10 * np.abs(other).max())


STENCILS: dict[str, tuple[list[list[float]], list[list[float]], str]] = {
    "barrier_point_point": ([[0, 0, 0]], [[0, 0, 0]], "point_point"),
    "barrier_point_edge": ([[0, 0, 0]], [[-1, 0, 0], [1, 0, 0]], "point_line"),
    "barrier_point_triangle": ([[0, 0, 0]], [[-1, -1, 0], [1, -1, 0], [0, 1, 0]], "point_plane"),
    "barrier_edge_edge": ([[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]], "line_line"),
}


@pytest.mark.parametrize("name", STENCILS)
def test_barrier_agrees(name: str) -> None:
    a, b, distance = STENCILS[name]
    rng = np.random.default_rng(1)
    for _ in range(50):
        x = apart(a, b, rng)
        squared = getattr(ipctk, f"{distance}_distance")(*x)
        gradient = getattr(ipctk, f"{distance}_distance_gradient")(*x)
        hessian = getattr(ipctk, f"{distance}_distance_hessian")(*x)
        expected = chain(float(np.sqrt(squared)), np.asarray(gradient), np.asarray(hessian))
        assert_close(
            evaluate(name, x, stiffness=KAPPA, contact_distance=D_HAT, least_distance=1e-3 * D_HAT), expected
        )


def test_mollified_edge_edge_agrees() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        x = apart([[-1, 0.2, 0], [1, -0.2, 0]], [[-1, 0, 0], [1, 0, 0]], rng)
        threshold = 4.0
        squared = ipctk.line_line_distance(*x)
        e, g, H = chain(
            float(np.sqrt(squared)),
            np.asarray(ipctk.line_line_distance_gradient(*x)),
            np.asarray(ipctk.line_line_distance_hessian(*x)),
        )
        m = ipctk.edge_edge_mollifier(*x, threshold)
        mg = np.asarray(ipctk.edge_edge_mollifier_gradient(*x, threshold))
        mH = np.asarray(ipctk.edge_edge_mollifier_hessian(*x, threshold))
        assert 0.0 < m < 1.0
        expected = (m * e, m * g + e * mg, m * H + np.outer(mg, g) + np.outer(g, mg) + e * mH)
        ours = evaluate(
            "barrier_mollified_edge_edge",
            x,
            stiffness=KAPPA,
            contact_distance=D_HAT,
            least_distance=1e-3 * D_HAT,
            parallel_threshold=threshold,
        )
        assert_close(ours, expected)


@pytest.mark.parametrize("speed", [0.0, 1e-3, 0.3, 0.999, 1.001, 5.0])
def test_friction_agrees(speed: float) -> None:
    """The friction of two points slipping by `speed` stick distances, against f0, f1/y and f2 of ipctk."""
    strength, eps = 3.0, 0.01
    y = speed * eps
    x_prev = np.zeros((2, 3))
    # A quarter of the slip was there at the start of the step. The part along the normal does no work.
    x = np.array([[0.75 * y, 0.0, 0.4], [0.0, 0.0, 0.0]])
    values = {
        "limit": strength,
        "deflection": [0.25 * y, 0.0, 0.1],
        "slope": 7.0,
        "pull": [0.0, 0.0, 0.0],
        "way": [1.0, 0.0, 0.0],
        "pull_at_iterate": 0.0,
        "way_at_iterate": y,
        "is_model": 0.0,
        "normal": [0.0, 0.0, 1.0],
        "weight0": 1.0,
        "weight1": -1.0,
        "stick_displacement": eps,
    }
    energy, gradient, hessian = evaluate_potential("friction_2", x, x_prev=x_prev, values=values)
    along = strength * ipctk.smooth_friction_f2(y, eps)
    across = strength * ipctk.smooth_friction_f1_over_x(y, eps)
    force = strength * ipctk.smooth_friction_f1(y, eps)
    scale = 2.0 * strength / eps
    assert energy == pytest.approx(strength * ipctk.smooth_friction_f0(y, eps), rel=1e-9)
    np.testing.assert_allclose(gradient, [[force, 0, 0], [-force, 0, 0]], atol=1e-9 * strength)
    # Below 1e-8 of the stick distance our curvature is that of y = 0, hence the 1e-7.
    block = hessian.reshape(6, 6)[:3, :3]
    np.testing.assert_allclose(block, np.diag([along, across, 0.0]), atol=1e-7 * scale)
    # The model has the same force, and by the dual force a curvature between that of the parabola above and,
    # with the force there, that of the energy.
    if y > 0.0:
        slope = across / strength
        taken = strength * ipctk.smooth_friction_f1(y, eps) / (strength * slope * y) * (1.0 - along / across)
        for part in (0.0, 0.5, 1.0):
            pull = part * taken
            values |= {"slope": slope, "is_model": 1.0, "pull": [pull, 0.0, 0.0], "pull_at_iterate": pull * y}
            _, model_gradient, model = evaluate_potential("friction_2", x, x_prev=x_prev, values=values)
            np.testing.assert_allclose(model_gradient, gradient, atol=1e-9 * strength)
            expected = np.diag([across - part * (across - along), across, 0.0])
            np.testing.assert_allclose(model.reshape(6, 6)[:3, :3], expected, atol=1e-9 * scale)


def test_potentials_are_listed_and_checked() -> None:
    names = [row["name"] for row in _core.potentials()]
    assert len(names) == len(set(names)) >= 19
    with pytest.raises(InvalidArgument, match="did you mean 'friction_2'"):
        _core.registered_formula("frition_2")
