"""Vectors and matrices of scalars: values against NumPy, shapes, and messages about wrong ones."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import stark
import stark.symbolic as sym

random = np.random.default_rng(7)
U, V = random.normal(size=(2, 3))
M = {n: random.normal(size=(n, n)) + 2 * np.eye(n) for n in (1, 2, 3, 4)}
R = random.normal(size=(3, 2))


def value(result: object) -> np.ndarray:
    """Numbers of a tensor of constants."""
    shape = getattr(result, "shape", ())
    entries = result.entries if shape else [result]
    return np.array([float(entry) for entry in entries]).reshape(shape)


def traced(shape: tuple[int, ...]) -> object:
    return sym.symbols("x" + str(list(shape)).replace(" ", ""))


CASES = {
    "add": (lambda: sym.vec(U) + V, U + V),
    "subtract from array": (lambda: U - sym.vec(V), U - V),
    "tuple": (lambda: tuple(U) * sym.vec(V), U * V),
    "scalar product": (lambda: 2.0 * sym.vec(U) / 4.0, U / 2),
    "scalar over vector": (lambda: 2.0 / sym.vec(U), 2.0 / U),
    "plus a number": (lambda: sym.vec(U) + 1.0, U + 1),
    "negative": (lambda: -sym.vec(U), -U),
    "square": (lambda: sym.vec(U) ** 2, U**2),
    "dot": (lambda: sym.dot(U, V), U @ V),
    "matrix times vector": (lambda: sym.mat(M[3]) @ V, M[3] @ V),
    "vector times matrix": (lambda: U @ sym.mat(M[3]), U @ M[3]),
    "matrix times matrix": (lambda: sym.mat(M[3]) @ R, M[3] @ R),
    "transpose": (lambda: sym.mat(R).T, R.T),
    "cross": (lambda: sym.cross(U, V), np.cross(U, V)),
    "cross in the plane": (lambda: sym.cross(U[:2], V[:2]), U[0] * V[1] - U[1] * V[0]),
    "norm": (lambda: sym.norm(U), np.linalg.norm(U)),
    "norm of a matrix": (lambda: sym.squared_norm(R), (R**2).sum()),
    "normalized": (lambda: sym.normalized(U), U / np.linalg.norm(U)),
    "outer": (lambda: sym.outer(U, V[:2]), np.outer(U, V[:2])),
    "skew": (lambda: sym.skew(U) @ V, np.cross(U, V)),
    "trace": (lambda: sym.trace(M[3]), np.trace(M[3])),
    "diag": (lambda: sym.diag(U), np.diag(U)),
    "diagonal": (lambda: sym.diag(M[3]), np.diag(M[3])),
    "identity": (lambda: sym.identity(3), np.eye(3)),
    "columns": (lambda: sym.columns(U, V), np.column_stack([U, V])),
    "rows": (lambda: sym.mat([U, sym.vec(V)]), np.stack([U, V])),
    "sum": (lambda: sym.vec(U).sum(), U.sum()),
    "min": (lambda: sym.vec(U).min(), U.min()),
    "max": (lambda: sym.mat(R).max(), R.max()),
    "minimum": (lambda: sym.minimum(sym.vec(U), V), np.minimum(U, V)),
    "where by entry": (lambda: sym.where(sym.vec(U) > V, U, 0.0), np.where(U > V, U, 0)),
    "where for all": (lambda: sym.where(sym.vec(U)[0] > V[0], sym.vec(U), V), U if U[0] > V[0] else V),
    "invariants": (
        lambda: sym.vec(sym.invariants(M[3])),
        [np.trace(M[3]), (np.trace(M[3]) ** 2 - np.trace(M[3] @ M[3])) / 2, np.linalg.det(M[3])],
    ),
    "invariants in the plane": (
        lambda: sym.vec(sym.invariants(M[2])),
        [np.trace(M[2]), np.linalg.det(M[2])],
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_values(name: str) -> None:
    formula, expected = CASES[name]
    np.testing.assert_allclose(value(formula()), expected, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_determinant_and_inverse(n: int) -> None:
    np.testing.assert_allclose(value(sym.determinant(M[n])), np.linalg.det(M[n]), rtol=1e-13)
    np.testing.assert_allclose(value(sym.inverse(M[n])), np.linalg.inv(M[n]), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    "key", [0, -1, slice(1, None), slice(None, None, -1), (0, 1), (slice(None), 1), (slice(1), 0), (1,), ...]
)
def test_indexing_is_that_of_numpy(key: object) -> None:
    a = np.arange(6.0).reshape(3, 2)
    np.testing.assert_array_equal(value(sym.mat(a)[key]), a[key])


def test_iteration_and_components() -> None:
    v = sym.vec(1.0, 2.0, 3.0)
    assert [float(x) for x in v] == [1.0, 2.0, 3.0]
    assert (float(v.x), float(v.y), float(v.z)) == (1.0, 2.0, 3.0)
    assert [len(row) for row in sym.mat(R)] == [2, 2, 2]
    assert (len(sym.mat(R)), sym.mat(R).shape, sym.mat(R).ndim, v.size) == (3, (3, 2), 2, 3)
    with pytest.raises(AttributeError, match="Vec of 2 has no component z"):
        _ = sym.vec(1.0, 2.0).z


def test_object_arrays_of_scalars_are_vectors() -> None:
    x = sym.symbols("x")
    total = sym.vec(1.0, 2.0) + np.array([x, 2 * x])
    assert sym.is_same(total[1], 2 * x + 2.0)


def test_operations_come_in_the_order_of_the_cpp_layer() -> None:
    """tensor.h: dot from the first entry on, determinant by a triple product, inverse by one division."""
    a, b = sym.symbols("a[3] b[3]")
    assert sym.is_same(a @ b, (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2])
    F = traced((3, 3))
    c = [F.column(j) for j in range(3)]
    assert sym.is_same(sym.determinant(F), sym.dot(c[0], sym.cross(c[1], c[2])))
    assert sym.is_same(sym.inverse(F)[1, 2], sym.cross(c[2], c[0])[2] * (1.0 / sym.determinant(F)))
    G = traced((2, 2))
    assert sym.is_same(sym.inverse(G)[0, 1], -G[0, 1] * (1.0 / (G[0, 0] * G[1, 1] - G[0, 1] * G[1, 0])))
    assert sym.is_same(sym.normalized(a)[1], a[1] / sym.sqrt(a @ a))


def test_representations() -> None:
    assert repr(sym.symbols("x[2]")) == "Vec(x[0], x[1])"
    assert repr(sym.symbols("F[2,2]")) == "Mat([F[0,0], F[0,1]], [F[1,0], F[1,1]])"
    x = sym.symbols("x")
    assert repr(2 * x + 1) == "Scalar(((2 * x) + 1))"
    for _ in range(60):
        x = x * x + 1.0  # written out, this has 2^60 terms
    assert len(repr(x)) < 230


A, B = sym.symbols("a[3] b[2]")
S = sym.symbols("s")
F32 = sym.symbols("F[3,2]")
FAILURES: dict[str, tuple[Callable[[], object], str]] = {
    "sum of shapes": (lambda: A + B, r"\+: Vec of 3 and Vec of 2 do not fit: must have equal shapes"),
    "matmul": (lambda: F32 @ A, r"@: Mat of 3 x 2 and Vec of 3 do not fit, 2 columns meet 3 rows"),
    "matmul by scalar": (lambda: F32 @ 2.0, r"@: Mat of 3 x 2 and a scalar do not fit.*written with \*"),
    "dot": (lambda: sym.dot(A, (1, 2)), r"dot: Vec of 3 and Vec of 2 do not fit"),
    "cross": (
        lambda: sym.cross((1, 2, 3, 4), (1, 2, 3, 4)),
        r"cross: got Vec of 4 .* must be vectors of 2 or 3",
    ),
    "determinant": (lambda: sym.determinant(F32), r"determinant: got Mat of 3 x 2: must be a square matrix"),
    "large": (lambda: sym.inverse(np.eye(5)), r"inverse: got Mat of 5 x 5: must have at most 4 rows"),
    "trace of a vector": (lambda: sym.trace(A), r"trace: got Vec of 3: must be a square matrix"),
    "skew": (lambda: sym.skew(B), r"skew: got Vec of 2: must be a vector of 3"),
    "ragged": (lambda: sym.mat([[1, 2], [3]]), r"rows of 2, 1 entries: must have equal lengths"),
    "empty": (lambda: sym.vec([]), r"got no entries"),
    "nested": (lambda: sym.vec(A, A), r"got Vec of 3 as an entry"),
    "assignment": (lambda: A.__setitem__(0, 1.0), r"cannot be changed; .*stark.vec\(entries\)"),
    "three dimensions": (lambda: A + np.zeros((2, 2, 2)), r"array of 3 dimensions: must have at most 2"),
    "truth": (lambda: bool(A), r"the truth of Vec of 3 .* stark.where"),
    "equality": (lambda: A == A, r"== or != of Vec of 3"),
    "float": (lambda: math.sqrt(sym.vec(S, S)), r"float\(\) of Vec of 2: .*stark.sqrt"),
    "where condition": (lambda: sym.where("yes", A, A), r"where: got str as the condition"),
    "invariants": (lambda: sym.invariants(np.eye(4)), r"must be a matrix of 2 x 2 or 3 x 3"),
    "unknown numpy function": (lambda: np.linalg.svd(F32), r"np.svd does not work on traced values"),
    "unknown numpy ufunc": (lambda: np.floor(A), r"np.floor is not part of formulas"),
    "numpy keyword": (lambda: np.sum(F32, axis=0), r"np.sum: only its plain form works"),
    "gradient of vector": (lambda: sym.gradient(A, S), r"output is not a scalar; use jacobian"),
    "gradient by number": (
        lambda: sym.gradient(S * S, 2.0),
        r"with respect to 2, only with respect to symbols",
    ),
    # (2 s) (2 s) is simplified to 4 (s s), in which 2 s does not occur: zero would be a wrong answer.
    "gradient by expression": (
        lambda: sym.gradient((2 * S) ** 2, 2 * S),
        r"\(2 \* s\), only .*@stark.symbolic",
    ),
}


@pytest.mark.parametrize("name", FAILURES)
def test_wrong_shapes_and_types_say_what_and_why(name: str) -> None:
    formula, message = FAILURES[name]
    with pytest.raises(stark.TraceError, match=message):
        formula()


def test_bad_index() -> None:
    with pytest.raises(IndexError, match="index 3 of Vec of 3"):
        _ = A[3]
    with pytest.raises(IndexError, match=r"index .* of Mat of 3 x 2"):
        _ = F32[0, 2]
