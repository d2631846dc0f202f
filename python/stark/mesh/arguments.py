"""Numbers, indices and sizes of meshes that users give."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import refuse_masked

Points: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int32]


def points_of(values: ArrayLike, name: str) -> Points:
    """A copy as (n, 3) numbers: whoever goes on writing into the array that was given changes no mesh."""
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iuf":
            raise TypeError
        array = np.array(array, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):
        raise InvalidMesh(
            f"{name}: got {type(values).__name__}: must be an array of shape (n, 3) of real numbers [m]"
        ) from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidMesh(
            f"{name}: got the shape {array.shape}: must be (n, 3): one row of x, y, z [m] for each vertex"
        )
    return array


def shape_of(values: ArrayLike) -> tuple[int, ...]:
    """() where rows differ in length."""
    try:
        return np.shape(values)
    except (TypeError, ValueError, OverflowError):
        return ()


def columns_of(table: ArrayLike) -> int:
    """Entries in a row, 0 where rows differ in length."""
    shape = shape_of(table)
    return shape[1] if len(shape) == 2 else 0


def indices_of(values: ArrayLike, columns: int, name: str) -> Indices:
    """A copy as (m, columns) integers."""
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, OverflowError):
        array = np.empty((), dtype=object)
    if array.size == 0:
        return np.empty((0, columns), dtype=np.int32)
    if array.ndim != 2 or array.shape[1] != columns:
        raise InvalidMesh(
            f"{name}: got the shape {array.shape}: must be (m, {columns}): one row of vertex indices each"
        )
    if array.dtype.kind not in "iu":
        raise InvalidMesh(
            f"{name}: got numbers of type {array.dtype}: must be integers; convert with .astype(numpy.int32)"
        )
    if array.max() > 2**31 - 1 or array.min() < -(2**31):
        raise InvalidMesh(
            f"{name}: got the index {array.max()}: must be indices that fit 32 bits; check the numbering"
        )
    return np.array(array, dtype=np.int32, order="C")


def corners_of(vertices: Points, elements: Indices, name: str) -> list[Points]:
    """Positions of the first, second, ... vertex of all elements."""
    if elements.size and not (elements.min() >= 0 and elements.max() < len(vertices)):
        wrong = elements[(elements < 0) | (elements >= len(vertices))]
        raise InvalidMesh(
            f"{name}: one of them refers to vertex {wrong[0]}: must be in [0, {len(vertices)}), which "
            f"start at 0"
        )
    return [vertices[column] for column in elements.T]


def numbers_of(value: Any) -> NDArray[np.float64]:
    """As an array of real numbers, an empty one if it is none."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)
    return array.astype(np.float64) if array.dtype.kind in "iuf" else np.empty(0)


def sizes_of(size: float | ArrayLike, name: str) -> NDArray[np.float64]:
    refuse_masked(size, name)
    values = numbers_of(size)
    if values.shape == ():
        values = np.full(3, float(values))
    if values.shape != (3,) or not (np.isfinite(values) & (values > 0.0)).all():
        raise InvalidArgument(f"{name} = {size!r} m: must be one positive number or three")
    return values


def positive(value: float, name: str, unit: str = " m") -> float:
    """A length [m] or another number above 0, or InvalidArgument."""
    refuse_masked(value, name)
    number = numbers_of(value)
    if number.shape != () or not 0.0 < number < np.inf:
        raise InvalidArgument(f"{name} = {value!r}{unit}: must be a number > 0")
    return float(value)


def count_of(value: int, name: str, least: int = 1) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= 100_000:
        raise InvalidArgument(f"{name} = {value!r}: must be a whole number in [{least}, 100000]")
    return int(value)


def cells_of(cells: Any, dimensions: int, name: str) -> list[int]:
    """Cells along each axis, as many as indices of 32 bits can tell apart."""
    cells = cells[()] if isinstance(cells, np.ndarray) and cells.ndim == 0 else cells
    counts = [cells] * dimensions if isinstance(cells, (int, np.integer)) else cells
    if not isinstance(counts, (list, tuple, np.ndarray)) or len(counts) != dimensions:
        raise InvalidArgument(
            f"{name} = {cells!r}: must be one whole number, or {dimensions}: one for each direction"
        )
    checked = [count_of(count, name) for count in counts]
    require_few(math.prod(count + 1 for count in checked), f"{name} = {cells!r}")
    return checked


def require_few(vertex_count: int, what: str) -> None:
    if vertex_count > 2**28:
        raise InvalidArgument(f"{what}: makes {vertex_count} vertices: must be at most 2^28, choose fewer")


def counts_around(shape: str, **counts: tuple[int, int]) -> list[int]:
    """Two counts, given with the least that makes sense, whose product is the number of vertices."""
    checked = [count_of(value, f"{shape}: {name}", least) for name, (value, least) in counts.items()]
    require_few(math.prod(checked), f"{shape}: {' and '.join(counts)} = {checked}")
    return checked


def require_finite(vertices: NDArray[np.float64], what: str) -> None:
    """Of what was read of a file. InvalidMesh names the first that is not: ``what``, and its number."""
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        place = ", ".join(f"{x:g}" for x in vertices[bad[0]])
        more = f", and {len(bad) - 1} more are not finite, either" if len(bad) > 1 else ""
        raise InvalidMesh(
            f"{what} {bad[0]} (from 0) is at ({place}){more}: coordinates must be finite; leave such "
            f"vertices out where the file is written"
        )
