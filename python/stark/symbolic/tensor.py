"""Small vectors and matrices of symbolic scalars. They only build scalar expressions, with the order of
operations of src/stark/symbolic/tensor.h, so that a formula gives the same graph from Python as from C++.

Operators are those of NumPy: `*` and `/` act entry by entry, `@` is the product of matrices and vectors.
Tuples, lists and arrays of numbers mix freely with them. Values are immutable; shapes are checked at once."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self, SupportsIndex

import numpy as np

from stark._core import TraceError
from stark._core import symbolic as core
from stark.arguments import is_iterable, shown_value
from stark.overloads import overload
from stark.symbolic.errors import TraceIndexError

Scalar = core.Scalar
#: Of unit matrices; formulas of larger ones do not compile in reasonable time.
_MOST_ROWS = 1000


def describe(value: object) -> str:
    """What a value is, for messages: 'a scalar', 'Vec of 3', 'Mat of 3 x 2', or its type."""
    if isinstance(value, Vec):
        return f"Vec of {len(value)}"
    if isinstance(value, Mat):
        return f"Mat of {value.shape[0]} x {value.shape[1]}"
    return "a scalar" if is_scalar_like(value) else type(value).__name__


def is_scalar_like(value: object) -> bool:
    """Whether it is a scalar of a formula or a number. Not None, which the core would read as a scalar."""
    if isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 0:
        value = value.item()
    return value is not None and core.is_scalar_like(value)


def listed(values: object, what: str) -> list[Any]:
    """Parts of a list; TraceError calls anything else `what`."""
    if isinstance(values, (str, bytes, Mapping)) or not is_iterable(values):
        raise TraceError(f"{what} = {shown_value(values)}: must be a list of scalars and numbers")
    return list(values)  # type: ignore[call-overload, no-any-return]


class Tensor:
    """What Vec and Mat have in common: entries in row-major order, a shape, operators entry by entry."""

    __slots__ = ("_entries", "shape")
    _entries: tuple[Scalar, ...]
    shape: tuple[int, ...]

    def __init__(self, entries: Sequence[object], shape: tuple[int, ...]) -> None:
        self._entries = tuple(entry if type(entry) is Scalar else core.constant(entry) for entry in entries)
        self.shape = shape

    @property
    def entries(self) -> tuple[Scalar, ...]:
        """Scalars, row by row."""
        return self._entries

    @property
    def ndim(self) -> int:
        """Number of dimensions: 1 for vectors, 2 for matrices."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of entries."""
        return len(self._entries)

    def map(self, function: Callable[[Scalar], object]) -> Self:
        """The function of every entry."""
        return type(self)._of([function(entry) for entry in self._entries], self.shape)

    @classmethod
    def _of(cls, entries: Sequence[object], shape: tuple[int, ...]) -> Self:
        result = object.__new__(cls)
        Tensor.__init__(result, entries, shape)
        return result

    def _like(self, function: Callable[..., object], sign: str, *operands: object) -> Self:
        """Of the shape of this one."""
        result: Self = elementwise(function, sign, *operands)
        return result

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, key: Any) -> Any:
        try:
            places = np.arange(self.size).reshape(self.shape)[key]
        except (IndexError, OverflowError, ValueError) as error:
            raise TraceIndexError(
                f"index {shown_value(key)} of {describe(self)}: {error}; the first is 0"
            ) from None
        if places.ndim == 0:
            return self._entries[int(places)]
        if places.ndim > 2:
            raise TraceError(
                f"index {key!r} of {describe(self)}: the result has {places.ndim} dimensions: must have at "
                "most 2"
            )
        return from_shape([self._entries[i] for i in places.ravel()], places.shape)

    def __setitem__(self, key: object, value: object) -> None:
        raise TraceError(
            f"{describe(self)} cannot be changed; collect the entries in a Python list and use "
            "stark.vec(entries) or stark.mat(rows)"
        )

    def __add__(self, other: object) -> Self:
        return self._like(operator.add, "+", self, other)

    def __radd__(self, other: object) -> Self:
        return self._like(operator.add, "+", other, self)

    def __sub__(self, other: object) -> Self:
        return self._like(operator.sub, "-", self, other)

    def __rsub__(self, other: object) -> Self:
        return self._like(operator.sub, "-", other, self)

    def __mul__(self, other: object) -> Self:
        return self._like(operator.mul, "*", self, other)

    def __rmul__(self, other: object) -> Self:
        return self._like(operator.mul, "*", other, self)

    def __truediv__(self, other: object) -> Self:
        return self._like(operator.truediv, "/", self, other)

    def __rtruediv__(self, other: object) -> Self:
        return self._like(operator.truediv, "/", other, self)

    def __pow__(self, other: object) -> Self:
        return self._like(core.pow, "**", self, other)

    def __rpow__(self, other: object) -> Self:
        return self._like(core.pow, "**", other, self)

    def __lt__(self, other: object) -> Self:
        return self._like(operator.lt, "<", self, other)

    def __le__(self, other: object) -> Self:
        return self._like(operator.le, "<=", self, other)

    def __gt__(self, other: object) -> Self:
        return self._like(operator.gt, ">", self, other)

    def __ge__(self, other: object) -> Self:
        return self._like(operator.ge, ">=", self, other)

    def __and__(self, other: object) -> Self:
        return self._like(operator.and_, "&", self, other)

    def __or__(self, other: object) -> Self:
        return self._like(operator.or_, "|", self, other)

    def __invert__(self) -> Self:
        return self.map(operator.invert)

    def __neg__(self) -> Self:
        return self.map(operator.neg)

    def __pos__(self) -> Self:
        return self

    def __abs__(self) -> Self:
        return self.map(core.abs)

    def __matmul__(self, other: object) -> Any:
        return matmul(self, other)

    def __rmatmul__(self, other: object) -> Any:
        return matmul(other, self)

    def __eq__(self, other: object) -> bool:
        raise TraceError(
            f"== or != of {describe(self)}: equality of computed numbers is not part of formulas; compare "
            "with <= and >="
        )

    def __ne__(self, other: object) -> bool:
        return self == other

    def __hash__(self) -> int:
        return object.__hash__(self)

    def __bool__(self) -> bool:
        raise TraceError(
            f"the truth of {describe(self)} was asked for (if, while, and, or, not): a formula is recorded "
            "once and then run for many inputs, so its values cannot steer Python code: write "
            "stark.where(condition, a, b) for if, and `&`, `|`, `~` for and, or, not"
        )

    def __float__(self) -> float:
        raise TraceError(
            f"float() of {describe(self)}: a formula is recorded once and then run for many inputs; use the "
            "functions of stark (stark.sqrt, stark.norm, ...) instead of those of math"
        )

    def sum(self) -> Scalar:
        """Sum of all entries, from the first to the last."""
        total = self._entries[0]
        for entry in self._entries[1:]:
            total = total + entry
        return total

    def all(self) -> Scalar:
        """Whether all entries, which are conditions, hold."""
        return self._fold(operator.and_)

    def any(self) -> Scalar:
        """Whether at least one entry, which is a condition, holds."""
        return self._fold(operator.or_)

    def min(self) -> Scalar:
        """Smallest entry."""
        return self._fold(core.minimum)

    def max(self) -> Scalar:
        """Largest entry."""
        return self._fold(core.maximum)

    def _fold(self, function: Callable[[Scalar, Scalar], Scalar]) -> Scalar:
        result = self._entries[0]
        for entry in self._entries[1:]:
            result = function(result, entry)
        return result

    def __repr__(self) -> str:
        def text(entry: Scalar) -> str:
            written = repr(entry)[len("Scalar(") : -1]
            return written if len(written) <= 40 else written[:37] + "..."

        if len(self.shape) == 1:
            return f"Vec({', '.join(map(text, self._entries))})"
        return f"Mat({', '.join('[' + ', '.join(map(text, row.entries)) + ']' for row in self)})"


class Vec(Tensor):
    """Vector of scalars."""

    __slots__ = ()

    if TYPE_CHECKING:

        @overload
        def __getitem__(self, key: SupportsIndex) -> Scalar: ...
        @overload
        def __getitem__(self, key: slice) -> Vec: ...
        @overload
        def __getitem__(self, key: object) -> Any: ...
        def __getitem__(self, key: object) -> Any: ...
        @overload
        def __matmul__(self, other: Vec) -> Scalar: ...
        @overload
        def __matmul__(self, other: Mat) -> Vec: ...
        @overload
        def __matmul__(self, other: object) -> Any: ...
        def __matmul__(self, other: object) -> Any: ...
        def __iter__(self) -> Iterator[Scalar]: ...

    def __init__(self, entries: Sequence[object]) -> None:
        entries = listed(entries, "Vec: entries")
        if not entries:
            raise TraceError("Vec: got no entries: must have at least one")
        for entry in entries:
            if not is_scalar_like(entry):
                raise TraceError(f"Vec: got {describe(entry)} as an entry: must be scalars and numbers")
        super().__init__(entries, (len(entries),))

    @property
    def x(self) -> Scalar:
        """First component."""
        return self._component(0, "x")

    @property
    def y(self) -> Scalar:
        """Second component."""
        return self._component(1, "y")

    @property
    def z(self) -> Scalar:
        """Third component."""
        return self._component(2, "z")

    @property
    def T(self) -> Vec:
        """Itself, as in NumPy; outer(a, b) is the matrix."""
        return self

    def _component(self, place: int, name: str) -> Scalar:
        if len(self) <= place:
            raise AttributeError(f"{describe(self)} has no component {name}")
        return self._entries[place]


class Mat(Tensor):
    """Matrix of scalars."""

    __slots__ = ()

    if TYPE_CHECKING:

        @overload
        def __getitem__(self, key: SupportsIndex) -> Vec: ...
        @overload
        def __getitem__(self, key: slice) -> Mat: ...
        @overload
        def __getitem__(self, key: tuple[SupportsIndex, SupportsIndex]) -> Scalar: ...
        @overload
        def __getitem__(self, key: tuple[SupportsIndex, slice] | tuple[slice, SupportsIndex]) -> Vec: ...
        @overload
        def __getitem__(self, key: tuple[slice, slice]) -> Mat: ...
        @overload
        def __getitem__(self, key: object) -> Any: ...
        def __getitem__(self, key: object) -> Any: ...
        @overload
        def __matmul__(self, other: Vec) -> Vec: ...
        @overload
        def __matmul__(self, other: Mat) -> Mat: ...
        @overload
        def __matmul__(self, other: object) -> Any: ...
        def __matmul__(self, other: object) -> Any: ...
        def __iter__(self) -> Iterator[Vec]: ...

    def __init__(self, rows: Sequence[Sequence[object]]) -> None:
        vectors = [vec(row) for row in listed(rows, "Mat: rows")]
        if not vectors:
            raise TraceError("Mat: got no rows: must have at least one")
        if len({len(v) for v in vectors}) > 1:
            raise TraceError(
                f"Mat: rows of {', '.join(str(len(v)) for v in vectors)} entries: must have equal lengths"
            )
        super().__init__([entry for v in vectors for entry in v.entries], (len(vectors), len(vectors[0])))

    @property
    def T(self) -> Mat:
        """Transpose."""
        return transpose(self)

    def row(self, i: int) -> Vec:
        """Row ``i`` as a vector."""
        return self[i, :]

    def column(self, j: int) -> Vec:
        """Column ``j`` as a vector."""
        return self[:, j]


def from_shape(entries: Sequence[Any], shape: tuple[int, ...]) -> Scalar | Vec | Mat:
    """Scalar, Vec or Mat of row-major entries."""
    if len(shape) == 0:
        return core.constant(entries[0])
    if 0 in shape:
        raise TraceError(f"shape {tuple(shape)}: vectors and matrices have at least one entry")
    return (Vec if len(shape) == 1 else Mat)._of(entries, tuple(shape))


def convert(value: Any, what: str) -> Scalar | Vec | Mat:
    """A scalar, number, sequence or array as Scalar, Vec or Mat; `what` names it in the message."""
    if isinstance(value, (Scalar, Vec, Mat)):
        return value
    if is_scalar_like(value):
        return core.constant(value)
    if isinstance(value, (list, tuple)):
        if any(isinstance(item, (list, tuple, Vec, np.ndarray)) for item in value):
            return Mat(value)
        return Vec(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufO":
        if value.ndim > 2:
            raise TraceError(f"{what}: an array of {value.ndim} dimensions: must have at most 2")
        for entry in value.flat if value.dtype == object else ():
            if not is_scalar_like(entry):
                raise TraceError(f"{what}: got {describe(entry)} as an entry: must be scalars and numbers")
        return from_shape(value.ravel().tolist(), value.shape)
    raise TraceError(f"{what}: got {type(value).__name__}: must be a scalar, Vec, Mat or numbers")


def _listed(value: Any, what: str) -> list[Any]:
    """The items of a sequence; TraceError for what is none."""
    try:
        return list(value)
    except TypeError:
        raise TraceError(f"{what}: got {describe(value)}: must be a list of scalars and numbers") from None


def vec(*entries: Any) -> Vec:
    """vec(a, b, c) or vec([a, b, c])."""
    if len(entries) == 1 and not is_scalar_like(entries[0]):
        if isinstance(entries[0], Vec):
            return entries[0]
        if isinstance(entries[0], Mat):
            raise TraceError(f"vec: got {describe(entries[0])}: must be scalars and numbers")
        return Vec(_listed(entries[0], "vec"))
    return Vec(entries)


def mat(rows: Any) -> Mat:
    """Matrix of rows: mat([[a, b], [c, d]]) or mat([u, v])."""
    return rows if isinstance(rows, Mat) else Mat(_listed(rows, "mat"))


def columns(*vectors: Any) -> Mat:
    """Matrix with these columns."""
    alone = len(vectors) == 1 and not isinstance(vectors[0], Vec)
    return transpose(Mat(_listed(vectors[0], "columns") if alone else vectors))


def identity(n: int) -> Mat:
    """Unit matrix of n rows."""
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or not 1 <= n <= _MOST_ROWS:
        raise TraceError(f"identity: n = {shown_value(n)}: must be a number of rows, 1 to {_MOST_ROWS}")
    return Mat([[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)])


def diag(value: object) -> Mat | Vec:
    """Matrix with this diagonal; of a matrix, its diagonal."""
    value = convert(value, "diag")
    if isinstance(value, Mat):
        return Vec([value[i, i] for i in range(min(value.shape))])
    if not isinstance(value, Vec):
        raise TraceError("diag: got a scalar: must be a vector or a matrix")
    n = len(value)
    return Mat([[value[i] if i == j else 0.0 for j in range(n)] for i in range(n)])


def elementwise(function: Callable[..., object], sign: str, *operands: object) -> Any:
    """The function entry by entry; scalars go with every entry, other shapes have to be equal."""
    values = [convert(operand, f"operator {sign}" if not sign.isalpha() else sign) for operand in operands]
    tensors = [value for value in values if isinstance(value, Tensor)]
    if not tensors:
        return function(*values)
    first = tensors[0]
    for other in tensors[1:]:
        if other.shape != first.shape:
            raise TraceError(
                f"{sign}: {describe(first)} and {describe(other)} do not fit: must have equal shapes"
            )
    size = first.size
    entries = zip(*[v.entries if isinstance(v, Tensor) else [v] * size for v in values], strict=True)
    return type(first)._of([function(*items) for items in entries], first.shape)


def dot_entries(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    total = a[0] * b[0]
    for i in range(1, len(a)):
        total = total + a[i] * b[i]
    return total


def matmul(a: object, b: object) -> Any:
    """Product of matrices and vectors, the operator @."""
    a, b = convert(a, "@"), convert(b, "@")
    if not (isinstance(a, Tensor) and isinstance(b, Tensor)):
        raise TraceError(f"@: {describe(a)} and {describe(b)} do not fit; a scalar factor is written with *")
    if a.shape[-1] != b.shape[0]:
        raise TraceError(
            f"@: {describe(a)} and {describe(b)} do not fit, {a.shape[-1]} columns meet {b.shape[0]} rows"
        )
    rows = list(a) if isinstance(a, Mat) else [a]
    cols = list(transpose(b)) if isinstance(b, Mat) else [b]
    entries = [dot_entries(row.entries, column.entries) for row in rows for column in cols]
    return from_shape(entries, a.shape[:-1] + b.shape[1:])


def transpose(a: object) -> Mat:
    """Rows become columns."""
    a = convert(a, "transpose")
    if not isinstance(a, Mat):
        raise TraceError(f"transpose: got {describe(a)}: must be a matrix")
    rows, cols = a.shape
    return Mat._of([a.entries[i * cols + j] for j in range(cols) for i in range(rows)], (cols, rows))
