"""Mistakes in formulas and in calls: the message names the rule, the remedy, and the user's own line."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable

import numpy as np
import pytest

import stark
import stark.symbolic as sym


def branch(x: sym.Vector[2], b: float):
    y = x[0]
    if y > b:  # here
        y = b
    return y


def loop(x: sym.Vector[2]):
    total = x[0]
    while total < x[1]:  # here
        total = 2.0 * total
    return total


def conjunction(x: sym.Vector[2]):
    return sym.where(x[0] > 0 and x[1] > 0, x[0], x[1])  # here


def chained(x: sym.Vector[2]):
    return sym.where(0.0 < x[0] < 1.0, x[0], x[1])  # here


def smallest(x: sym.Vector[2]):
    return min(x[0], x[1])  # here


def root(x: sym.Vector[2]):
    return math.sqrt(x[0] + x[1])  # here


def table(x: sym.Vector[2]):
    return [1.0, 2.0][x[0]] * x[1]  # here


def repeat(x: sym.Vector[2]):
    return sum(x[1] for _ in range(x[0]))  # here


def equality(x: sym.Vector[2]):
    return sym.where(x[0] == x[1], 1.0, x[0])  # here


def rounding(x: sym.Vector[2]):
    return x[0] % 1.0 + x[1]  # here


def numpy_rounding(x: sym.Vector[2]):
    return np.floor(x[0]) + x[1]  # here


def shapes(x: sym.Vector[2]):
    return (x + np.ones(3)).sum()  # here


def helper(v: sym.Vec) -> sym.Scalar:
    return sym.cross(v, (1.0, 2.0, 3.0))[0]  # here


def beyond(x: sym.Vector[2]):
    return x[0] * x[2]  # here


def nested(x: sym.Vector[2]):
    return helper(x)


def condition_as_number(x: sym.Vector[2]):
    return (x[0] > 0.0) * x[1]  # here


def number_as_condition(x: sym.Vector[2]):
    return sym.where(x[0], x[1], 0.0)  # here


def returns_nothing(x: sym.Vector[2]):  # here
    x @ x


def returns_condition(x: sym.Vector[2]):  # here
    return x[0] < x[1]


def returns_text(x: sym.Vector[2]):  # here
    return "x"


def returns_pair(x: sym.Vector[2]):  # here
    return x, x[0]


def unused(x: sym.Vector[2], b: float):  # here
    return x @ x


def constant(x: sym.Vector[2]):  # here
    return 4.0


TRACED: list[tuple[Callable, str]] = [
    (branch, r"the truth of the traced value \(b < x\[0\]\) .*stark\.where"),
    (loop, r"the truth of the traced value \(x\[0\] < x\[1\]\) .*stark\.where"),
    (conjunction, "`&`, `|`, `~` for and, or, not"),
    (chained, "both bounds of a < x < b with `&`"),
    (smallest, r"stark\.minimum, stark\.maximum for min, max"),
    (root, r"float\(\) of the traced value \(x\[0\] \+ x\[1\]\).*stark\.sqrt"),
    (table, "used as an index or a count; only fixed integers"),
    (repeat, "used as an index or a count; only fixed integers"),
    (beyond, "index 2 of Vec of 2: .*the first is 0"),
    (equality, "== or != of the traced value .*<= and >="),
    (rounding, "rounding has no derivative"),
    (numpy_rounding, r"np\.floor is not part of formulas"),
    (shapes, "Vec of 2 and Vec of 3 do not fit: must have equal shapes"),
    (nested, "cross: Vec of 2 and Vec of 3 do not fit"),
    (condition_as_number, r"is a condition, not a number; .*stark\.where"),
    (number_as_condition, r"is a number, not a condition; compare it"),
    (returns_nothing, "returns None; return a number"),
    (returns_condition, r"returns a condition, not a number; .*stark\.where"),
    (returns_text, "the result: got str: must be"),
    (returns_pair, "rows of 2, |Vec: got|Mat|rows"),
    (unused, "does not depend on 'b'; use every argument, or remove it"),
    (constant, "does not depend on 'x'"),
]


@pytest.mark.parametrize(("formula", "message"), TRACED, ids=lambda value: getattr(value, "__name__", ""))
def test_formulas_that_cannot_be_recorded(formula: Callable, message: str) -> None:
    compiled = sym.function(formula)
    zeros = [np.zeros(2), 0.0][: len(inspect.signature(formula).parameters)]
    with pytest.raises(stark.TraceError, match=message) as caught:
        compiled(*zeros)
    text = str(caught.value)
    assert text.startswith(f"{formula.__name__}: ")
    marked = helper if formula is nested else formula
    lines, first = inspect.getsourcelines(marked)
    (offset,) = [k for k, line in enumerate(lines) if "# here" in line]
    assert f'File "{__file__}", line {first + offset}, in {marked.__name__}\n    ' in text
    assert lines[offset].strip() in text
    # The same error again at the next use, not a half-recorded formula.
    with pytest.raises(stark.TraceError, match=message):
        compiled(*zeros)


def test_other_exceptions_keep_their_type_and_get_a_note() -> None:
    @sym.function
    def typo(x: sym.Vector[2]):
        return x[0] + undefined_name  # noqa: F821

    with pytest.raises(NameError) as caught:
        typo([1.0, 2.0])
    (note,) = caught.value.__notes__
    assert "while typo was recorded" in note
    assert "undefined_name" in note

    @sym.function
    def text(x: float):
        return x + "1"

    with pytest.raises(TypeError, match=r"unsupported operand type\(s\) for \+: '[\w.]*Scalar' and 'str'"):
        text(1.0)


def test_recursion_is_refused() -> None:
    @sym.function
    def endless(x: float):
        return endless(x) + x

    with pytest.raises(stark.TraceError, match="endless calls itself"):
        endless(1.0)


def test_values_of_two_formulas_do_not_mix() -> None:
    kept = []

    @sym.function
    def first(x: float):
        kept.append(x)
        return x * x

    @sym.function
    def second(x: float):
        return x + kept[0]

    first(1.0)
    with pytest.raises(stark.TraceError, match=r"two different formulas; .*own arguments"):
        second(1.0)
    x, y = sym.symbols("x y")
    with pytest.raises(
        stark.TraceError, match="uses the symbol y, which is in no argument; add it to the inputs"
    ):
        sym.compile([x], x * y)
    with pytest.raises(stark.TraceError, match="is not a symbol"):
        sym.compile({"z": x * y}, x * y)


@pytest.mark.parametrize(
    ("annotation", "message"),
    [
        (inspect.Parameter.empty, "argument 'x' has no annotation: must be float, sym.Vector"),
        (list, "argument 'x' has the annotation <class 'list'>"),
        ("sym.Vector[m]", "name 'm' is not defined"),
        ("sym.Vector[0]", r"must be Vector\[n\] with positive integers"),
    ],
)
def test_bad_annotations(annotation: object, message: str) -> None:
    def formula(x):
        return x

    if annotation is not inspect.Parameter.empty:
        formula.__annotations__["x"] = annotation
    with pytest.raises(stark.TraceError, match=message) as caught:
        sym.function(formula)
    assert __file__ in str(caught.value)


def test_bad_signatures() -> None:
    with pytest.raises(stark.TraceError, match=r"\*xs: the number of arguments must be fixed"):
        sym.function(lambda *xs: xs[0])
    with pytest.raises(stark.TraceError, match="there are no arguments"):
        sym.function(lambda: 1.0)

    def formula(wrt: float):
        return wrt

    with pytest.raises(stark.TraceError, match="an argument must not be called 'wrt'"):
        sym.function(formula)


@sym.function
def energy(x: sym.Vector[2], k: float = 1.0):
    return 0.5 * k * (x @ x)


@sym.function
def direction(x: sym.Vector[2]):
    return sym.normalized(x)


CALLS: dict[str, tuple[Callable[[], object], str]] = {
    "shape": (lambda: energy([1, 2, 3]), r"energy: argument 'x' has the shape \(3,\): must be \(\.\.\., 2\)"),
    "number for a vector": (lambda: energy(1.0), r"argument 'x' has the shape \(\): must be \(\.\.\., 2\)"),
    "batches": (
        lambda: energy(np.ones((3, 2)), np.ones(2)),
        r"batch shapes x \(3,\), k \(2,\) do not broadcast",
    ),
    "text": (lambda: energy("ab"), "argument 'x' has the type <U2: must be real numbers"),
    "complex": (lambda: energy([1j, 2]), "argument 'x' has the type complex128: must be real numbers"),
    "masked": (
        lambda: energy(np.ma.masked_array([1.0, 2.0], mask=[False, True])),
        "energy: argument 'x': 1 value is masked",
    ),
    "ragged": (lambda: energy([[1, 2], [3]]), "argument 'x' is no array"),
    "unknown wrt": (lambda: energy.gradient([1, 2], wrt="y"), "wrt='y' is no argument; there are x, k"),
    "wrt twice": (lambda: energy.gradient([1, 2], wrt=("x", "x")), "each once"),
    "wrt nothing": (lambda: energy.gradient([1, 2], wrt=()), "at least one argument"),
    "gradient of a vector": (
        lambda: direction.gradient([1, 2]),
        "gradient needs a scalar result.*use jacobian",
    ),
    "hessian of a vector": (lambda: direction.hessian([1, 2]), "hessian needs a scalar result.*use jacobian"),
    "back end": (
        lambda: sym.compile([S := sym.symbols("s")], S * S, backend="avx51"),
        r"backend = 'avx51'.*did you mean",
    ),
    "symbols": (lambda: sym.symbols("x[0]"), r"'x\[0\]' is not a name such as"),
    "no symbols": (lambda: sym.symbols(" "), "no names were given"),
    "no inputs": (lambda: sym.compile([], 1.0), "there are no inputs"),
    "same names": (
        lambda: sym.compile([sym.symbols("a"), sym.symbols("a")], 1.0),
        "two inputs have the same name",
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_bad_calls(name: str) -> None:
    call, message = CALLS[name]
    with pytest.raises(stark.InvalidArgument, match=message):
        call()


def test_trace_error_is_an_invalid_argument() -> None:
    assert issubclass(stark.TraceError, stark.InvalidArgument)
    assert stark.TraceError.__module__ == "stark"


def test_the_line_of_a_lambda_is_its_own() -> None:
    """The next `def` was named and quoted in its place."""
    formula = [lambda p: p]  # here

    def other(p: stark.Point) -> None: ...

    with pytest.raises(stark.TraceError, match="has no annotation") as found:
        stark.energy(formula[0])
    line = inspect.getsourcelines(test_the_line_of_a_lambda_is_its_own)[1] + 2
    assert f"line {line}, in <lambda>\n    formula = [lambda p: p]  # here" in str(found.value)
    assert other is not None
