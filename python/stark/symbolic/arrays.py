"""Arguments of compiled functions as arrays, and the batch that their leading dimensions make."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stark._core import InvalidArgument
from stark.arguments import refuse_masked
from stark.symbolic.signature import Argument


def batch_of(
    formula: str, arguments: Sequence[Argument], values: Sequence[object]
) -> tuple[list[np.ndarray], tuple[int, ...]]:
    """Arrays of float64 and the batch shape that their leading dimensions broadcast to. Raises
    InvalidArgument naming the argument, what it is and what is needed."""
    arrays = [_array(formula, a.name, x, a.shape) for a, x in zip(arguments, values, strict=True)]
    leading = [x.shape[: x.ndim - len(a.shape)] for x, a in zip(arrays, arguments, strict=True)]
    if all(shape == leading[0] for shape in leading):
        return arrays, leading[0]
    try:
        return arrays, np.broadcast_shapes(*leading)
    except ValueError:
        shapes = ", ".join(f"{a.name} {shape}" for a, shape in zip(arguments, leading, strict=True))
        raise InvalidArgument(
            f"{formula}: the batch shapes {shapes} do not broadcast; leading dimensions must be equal or 1"
        ) from None


def _array(formula: str, name: str, value: object, shape: tuple[int, ...]) -> np.ndarray:
    """The argument as an array of float64 whose strides are whole numbers of float64."""
    refuse_masked(value, f"{formula}: argument '{name}'")
    try:
        given = np.asarray(value)
    except ValueError as error:
        raise InvalidArgument(f"{formula}: argument '{name}' is no array: {error}") from None
    if given.dtype.kind not in "biuf":
        raise InvalidArgument(
            f"{formula}: argument '{name}' has the type {given.dtype}: must be real numbers"
        )
    if shape and given.shape[max(given.ndim - len(shape), 0) :] != shape:
        need = ", ".join(["...", *map(str, shape)])
        raise InvalidArgument(f"{formula}: argument '{name}' has the shape {given.shape}: must be ({need})")
    if given.dtype != np.float64:
        given = given.astype(np.float64)
    if given.flags.c_contiguous and given.flags.aligned:
        return given
    return given if given.flags.aligned and not any(stride % 8 for stride in given.strides) else given.copy()
