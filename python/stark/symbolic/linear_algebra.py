"""Products, norms, determinants and inverses of small vectors and matrices, with the order of operations of
src/stark/symbolic/tensor.h."""

from __future__ import annotations

from typing import Any

from stark._core import TraceError
from stark._core import symbolic as core
from stark.symbolic.tensor import Mat, Scalar, Tensor, Vec, convert, describe, dot_entries, transpose


def _vectors(name: str, a: object, b: object) -> tuple[Vec, Vec]:
    a, b = convert(a, name), convert(b, name)
    if not (isinstance(a, Vec) and isinstance(b, Vec)) or (name != "outer" and len(a) != len(b)):
        raise TraceError(
            f"{name}: {describe(a)} and {describe(b)} do not fit: must be two vectors of equal length"
        )
    return a, b


def _square(name: str, a: object) -> Mat:
    a = convert(a, name)
    if not isinstance(a, Mat) or a.shape[0] != a.shape[1]:
        raise TraceError(f"{name}: got {describe(a)}: must be a square matrix")
    return a


def dot(a: object, b: object) -> Scalar:
    """Sum of products of two vectors."""
    a, b = _vectors("dot", a, b)
    return dot_entries(a.entries, b.entries)


def cross(a: Any, b: Any) -> Any:
    """Cross product of vectors of 3; of vectors of 2, its out-of-plane component."""
    a, b = _vectors("cross", a, b)
    if len(a) == 2:
        return a[0] * b[1] - a[1] * b[0]
    if len(a) != 3:
        raise TraceError(f"cross: got {describe(a)} and {describe(b)}: must be vectors of 2 or 3")
    return Vec([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def squared_norm(a: Any) -> Scalar:
    """Sum of the squares of all entries."""
    a = convert(a, "squared_norm")
    return dot_entries(a.entries, a.entries) if isinstance(a, Tensor) else a * a


def norm(a: object) -> Scalar:
    """Square root of the sum of squares. Its derivative at zero is not a number; see the documentation."""
    return core.sqrt(squared_norm(a))


def normalized(a: object) -> Vec:
    """The vector divided by its norm."""
    a = convert(a, "normalized")
    if not isinstance(a, Vec):
        raise TraceError(f"normalized: got {describe(a)}: must be a vector")
    return a / norm(a)


def outer(a: object, b: object) -> Mat:
    """Matrix of the products a_i b_j."""
    a, b = _vectors("outer", a, b)
    return Mat._of([x * y for x in a.entries for y in b.entries], (len(a), len(b)))


def skew(a: object) -> Mat:
    """Matrix of the cross product: skew(a) @ b = cross(a, b)."""
    a = convert(a, "skew")
    if not isinstance(a, Vec) or len(a) != 3:
        raise TraceError(f"skew: got {describe(a)}: must be a vector of 3")
    return Mat([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def trace(a: object) -> Scalar:
    """Sum of the diagonal of a square matrix."""
    a = _square("trace", a)
    total = a[0, 0]
    for i in range(1, len(a)):
        total = total + a[i, i]
    return total


def determinant(a: object) -> Scalar:
    """Determinant of a square matrix of at most 4 rows."""
    a = _square("determinant", a)
    n = len(a)
    if n == 1:
        return a[0, 0]
    if n == 2:
        return a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    if n == 3:
        return dot(a.column(0), cross(a.column(1), a.column(2)))
    if n == 4:
        return dot(a[0], _cofactors(a)[0])
    raise TraceError(f"determinant: got {describe(a)}: must have at most 4 rows")


def inverse(a: object) -> Mat:
    """Inverse of a square matrix of at most 4 rows."""
    a = _square("inverse", a)
    n = len(a)
    if n == 1:
        return Mat([[1.0 / a[0, 0]]])
    if n == 2:
        return Mat([[a[1, 1], -a[0, 1]], [-a[1, 0], a[0, 0]]]) * (1.0 / determinant(a))
    if n == 3:
        r0 = cross(a.column(1), a.column(2))
        r1 = cross(a.column(2), a.column(0))
        r2 = cross(a.column(0), a.column(1))
        return Mat([r0, r1, r2]) * (1.0 / dot(a.column(0), r0))
    if n == 4:
        cofactors = _cofactors(a)
        return transpose(cofactors) * (1.0 / dot(a[0], cofactors[0]))
    raise TraceError(f"inverse: got {describe(a)}: must have at most 4 rows")


def _cofactors(a: Mat) -> Mat:
    n = len(a)

    def minor(i: int, j: int) -> Mat:
        return Mat([[a[k, m] for m in range(n) if m != j] for k in range(n) if k != i])

    return Mat([[(-1) ** (i + j) * determinant(minor(i, j)) for j in range(n)] for i in range(n)])


def invariants(a: object) -> tuple[Scalar, ...]:
    """(I1, I2, I3) = (tr A, (tr(A)^2 - tr(A A)) / 2, det A) of a 3 x 3 matrix, (tr A, det A) of 2 x 2."""
    a = _square("invariants", a)
    if len(a) == 2:
        return trace(a), determinant(a)
    if len(a) != 3:
        raise TraceError(f"invariants: got {describe(a)}: must be a matrix of 2 x 2 or 3 x 3")
    first = trace(a)
    return first, 0.5 * (first * first - trace(a @ a)), determinant(a)
