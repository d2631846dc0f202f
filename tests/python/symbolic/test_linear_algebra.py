"""Products, norms, determinants and inverses of symbols: values against NumPy, derivatives against closed
forms, shapes that do not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
import pytest

import stark
import stark.symbolic as sym

RANDOM = np.random.default_rng(11)


def compiled(formula: Callable[..., Any], *shapes: tuple[int, ...]) -> sym.Function:
    """A function of symbols of these shapes."""
    names = ["a", "b"][: len(shapes)]
    text = " ".join(f"{n}{list(s)}".replace(" ", "") for n, s in zip(names, shapes, strict=True))
    symbols = sym.symbols(text)
    inputs = list(symbols) if len(shapes) > 1 else [symbols]
    return sym.compile(inputs, formula(*inputs))


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_determinants_and_inverses_are_those_of_numpy(n: int) -> None:
    A = RANDOM.normal(size=(50, n, n)) + 2.0 * np.eye(n)
    det, inv = compiled(sym.determinant, (n, n)), compiled(sym.inverse, (n, n))
    assert np.allclose(det(A), np.linalg.det(A), rtol=1e-11, atol=1e-12)
    well = np.linalg.cond(A) < 100.0
    assert well.sum() > 20 and np.allclose(inv(A[well]), np.linalg.inv(A[well]), rtol=1e-10, atol=1e-11)
    # Jacobi: the gradient of the determinant is det(A) A^-T.
    exact = np.linalg.det(A)[:, None, None] * np.linalg.inv(A).swapaxes(1, 2)
    assert np.allclose(det.gradient(A)[well], exact[well], rtol=1e-9, atol=1e-10)
    # d(A^-1)_ij / dA_kl = -(A^-1)_ik (A^-1)_lj
    B = np.linalg.inv(A[well])
    assert np.allclose(inv.jacobian(A[well]), -np.einsum("nik,nlj->nijkl", B, B), rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize(
    ("formula", "numpy_function", "shapes"),
    [
        (sym.dot, lambda a, b: (a * b).sum(-1), [(5,), (5,)]),
        (sym.cross, np.cross, [(3,), (3,)]),
        (sym.cross, lambda a, b: a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], [(2,), (2,)]),
        (sym.outer, lambda a, b: a[..., :, None] * b[..., None, :], [(3,), (2,)]),
        (sym.norm, lambda a: np.linalg.norm(a, axis=-1), [(4,)]),
        (sym.norm, lambda a: np.linalg.norm(a, axis=(-2, -1)), [(2, 3)]),
        (sym.squared_norm, lambda a: (a * a).sum((-2, -1)), [(2, 3)]),
        (sym.normalized, lambda a: a / np.linalg.norm(a, axis=-1, keepdims=True), [(3,)]),
        (sym.trace, lambda a: np.trace(a, axis1=-2, axis2=-1), [(3, 3)]),
    ],
)
def test_products_and_norms_are_those_of_numpy(
    formula: Callable[..., Any], numpy_function: Callable[..., Any], shapes: list[tuple[int, ...]]
) -> None:
    values = [RANDOM.normal(size=(20, *shape)) for shape in shapes]
    assert np.allclose(compiled(formula, *shapes)(*values), numpy_function(*values), rtol=1e-13, atol=1e-14)


def test_skew_is_the_matrix_of_the_cross_product() -> None:
    a, b = RANDOM.normal(size=(2, 3))
    product = compiled(lambda u, v: sym.skew(u) @ v, (3,), (3,))
    assert np.allclose(product(a, b), np.cross(a, b), rtol=1e-14, atol=1e-15)
    entries = np.array([float(entry) for entry in sym.skew(a).entries]).reshape(3, 3)
    assert np.array_equal(entries, -entries.T)


def test_invariants_are_the_coefficients_of_the_characteristic_polynomial() -> None:
    A = RANDOM.normal(size=(30, 3, 3))
    for k in range(3):
        own = compiled(lambda a, k=k: sym.invariants(a)[k], (3, 3))(A)
        exact = [(-1) ** (k + 1) * np.poly(a)[k + 1] for a in A]
        assert np.allclose(own, exact, rtol=1e-10, atol=1e-11)
    B = RANDOM.normal(size=(2, 2))
    first, second = sym.invariants(sym.mat(B))
    assert float(first) == pytest.approx(np.trace(B)) and float(second) == pytest.approx(np.linalg.det(B))


def test_the_gradient_of_a_norm_is_the_direction() -> None:
    a = RANDOM.normal(size=(10, 3))
    exact = a / np.linalg.norm(a, axis=1, keepdims=True)
    assert np.allclose(compiled(sym.norm, (3,)).gradient(a), exact, rtol=1e-14)
    assert np.isnan(compiled(sym.norm, (3,)).gradient([0.0, 0.0, 0.0])).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sym.dot((1, 2), (1, 2, 3)), "two vectors of equal length"),
        (lambda: sym.cross((1, 2, 3, 4), (1, 2, 3, 4)), "vectors of 2 or 3"),
        (lambda: sym.outer(np.eye(2), (1, 2)), "Mat of 2 x 2"),
        (lambda: sym.normalized(np.eye(2)), "must be a vector"),
        (lambda: sym.skew((1, 2)), "must be a vector of 3"),
        (lambda: sym.trace(np.ones((2, 3))), "square matrix"),
        (lambda: sym.determinant(np.eye(5)), "at most 4 rows"),
        (lambda: sym.inverse(np.eye(5)), "at most 4 rows"),
        (lambda: sym.inverse((1, 2)), "square matrix"),
        (lambda: sym.invariants(np.eye(4)), "2 x 2 or 3 x 3"),
    ],
)
def test_shapes_that_do_not_fit_are_refused_with_what_is_needed(
    call: Callable[[], Any], message: str
) -> None:
    with pytest.raises(stark.TraceError, match=message):
        call()


def test_matrices_of_other_sizes_multiply() -> None:
    @sym.function
    def quadratic(A: Annotated[sym.Mat, 2, 4], x: sym.Vec4):
        return sym.squared_norm(A @ x)

    A, x = RANDOM.normal(size=(2, 4)), RANDOM.normal(size=4)
    assert quadratic(A, x) == pytest.approx(float(np.sum((A @ x) ** 2)), rel=1e-13)
    assert np.allclose(quadratic.gradient(A, x), 2.0 * np.outer(A @ x, x), rtol=1e-12)
