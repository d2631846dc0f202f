"""Every operator and function of scalars against NumPy: values; derivatives against central differences."""

from __future__ import annotations

import operator
from collections.abc import Callable

import numpy as np
import pytest

import stark
import stark.symbolic as sym

# Machine code has its own elementary functions, good to about 1 ulp; compositions lose a few.
VALUE_TOLERANCE = 4e-15
# Central differences with steps of 1e-6 of values of order 1: rounding 1e-10, truncation 1e-12, a margin.
SLOPE_TOLERANCE = 2e-8

UNARY = {
    "abs": (np.abs, (-2.0, 2.0)),
    "sqrt": (np.sqrt, (0.1, 5.0)),
    "square": (np.square, (-2.0, 2.0)),
    "exp": (np.exp, (-3.0, 3.0)),
    "log": (np.log, (0.1, 5.0)),
    "sin": (np.sin, (-7.0, 7.0)),
    "cos": (np.cos, (-7.0, 7.0)),
    "tan": (np.tan, (-1.4, 1.4)),
    "asin": (np.arcsin, (-0.95, 0.95)),
    "acos": (np.arccos, (-0.95, 0.95)),
    "atan": (np.arctan, (-4.0, 4.0)),
    "sinh": (np.sinh, (-4.0, 4.0)),
    "cosh": (np.cosh, (-4.0, 4.0)),
    "tanh": (np.tanh, (-4.0, 4.0)),
}
BINARY = {
    "+": (operator.add, operator.add),
    "-": (operator.sub, operator.sub),
    "*": (operator.mul, operator.mul),
    "/": (operator.truediv, operator.truediv),
    "**": (operator.pow, operator.pow),
    "minimum": (sym.minimum, np.minimum),
    "maximum": (sym.maximum, np.maximum),
    "atan2": (sym.atan2, np.arctan2),
    "pow": (sym.pow, np.power),
}


def compiled(formula: Callable[..., object], count: int) -> sym.Function:
    graph = sym.Graph()
    x = [sym.symbols(name, graph) for name in "xyz"[:count]]
    return sym.compile(x, formula(*x))


def slope(f: Callable[..., np.ndarray], x: list[np.ndarray], place: int) -> np.ndarray:
    step = 1e-6
    shifted = [list(x), list(x)]
    shifted[0][place] = x[place] + step
    shifted[1][place] = x[place] - step
    return (f(*shifted[0]) - f(*shifted[1])) / (2 * step)


@pytest.mark.parametrize("name", UNARY)
def test_functions_of_one_argument(name: str) -> None:
    expected, (low, high) = UNARY[name]
    x = np.linspace(low, high, 1000)  # without 0, where abs has a kink
    f = compiled(getattr(sym, name), 1)
    np.testing.assert_allclose(f(x), expected(x), rtol=VALUE_TOLERANCE, atol=1e-15)
    np.testing.assert_allclose(f.gradient(x), slope(expected, [x], 0), rtol=1e-6, atol=SLOPE_TOLERANCE)
    curvature = (f.gradient(x + 1e-6) - f.gradient(x - 1e-6)) / 2e-6
    np.testing.assert_allclose(f.hessian(x), curvature, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("name", BINARY)
def test_functions_of_two_arguments(name: str) -> None:
    traced, expected = BINARY[name]
    random = np.random.default_rng(1)
    x, y = random.uniform(0.2, 3.0, (2, 500))
    f = compiled(traced, 2)
    np.testing.assert_allclose(f(x, y), expected(x, y), rtol=VALUE_TOLERANCE)
    for place, argument in enumerate("xy"):
        np.testing.assert_allclose(
            f.gradient(x, y, wrt=argument), slope(expected, [x, y], place), rtol=1e-7, atol=SLOPE_TOLERANCE
        )


@pytest.mark.parametrize("number", [2.0, 3, np.float64(2.0), np.float32(0.5), np.int64(3), np.array(2.0)])
@pytest.mark.parametrize("name", ["+", "-", "*", "/", "**"])
def test_numbers_on_both_sides(name: str, number: object) -> None:
    traced, expected = BINARY[name]
    x = np.linspace(0.5, 2.0, 9)
    right = compiled(lambda s: traced(s, number), 1)
    left = compiled(lambda s: traced(number, s), 1)
    np.testing.assert_allclose(right(x), expected(x, float(number)), rtol=VALUE_TOLERANCE)
    np.testing.assert_allclose(left(x), expected(float(number), x), rtol=VALUE_TOLERANCE)


def test_unary_signs() -> None:
    x = np.linspace(-2.0, 2.0, 9)
    np.testing.assert_array_equal(compiled(lambda s: -s + 0 * s, 1)(x), -x)
    np.testing.assert_array_equal(compiled(lambda s: abs(+s), 1)(x), np.abs(x))


@pytest.mark.parametrize("exponent", [0, 1, 2, 3, 7, -1, -2, -5])
def test_integer_powers_take_any_base(exponent: int) -> None:
    x = np.array([-2.5, -1.0, 0.5, 3.0])
    f = compiled(lambda s: s**exponent + 0.0 * s + (s - s), 1) if exponent else None
    if f is not None:
        np.testing.assert_allclose(f(x), x**exponent, rtol=VALUE_TOLERANCE)
        np.testing.assert_allclose(f.gradient(x), exponent * x ** (exponent - 1.0), rtol=1e-14)
    else:
        assert float(sym.symbols("x") ** 0) == 1.0


def test_real_powers() -> None:
    x = np.linspace(0.1, 4.0, 50)
    np.testing.assert_allclose(compiled(lambda s: s**1.7, 1)(x), x**1.7, rtol=VALUE_TOLERANCE)
    np.testing.assert_allclose(compiled(lambda s: s**0.5, 1)(x), np.sqrt(x), rtol=0)
    np.testing.assert_allclose(compiled(lambda s: 1.7**s, 1)(x), 1.7**x, rtol=VALUE_TOLERANCE)
    with pytest.raises(stark.TraceError, match="exponent 10000000000000 is too large"):
        sym.symbols("x") ** 10000000000000


@pytest.mark.parametrize(
    ("name", "compare"),
    [("<", operator.lt), ("<=", operator.le), (">", operator.gt), (">=", operator.ge)],
)
def test_comparisons(name: str, compare: Callable) -> None:
    x = np.array([-1.0, 0.5, 0.5, 2.0])
    y = np.array([0.0, 0.5, 0.25, 3.0])
    both = compiled(lambda s, t: sym.where(compare(s, t), s, 10.0 * t), 2)
    np.testing.assert_array_equal(both(x, y), np.where(compare(x, y), x, 10.0 * y))
    left = compiled(lambda s: sym.where(compare(0.5, s), s, 7.0), 1)
    np.testing.assert_array_equal(left(x), np.where(compare(0.5, x), x, 7.0))


def test_logic() -> None:
    x = np.linspace(-2.0, 2.0, 33)
    cases = {
        "and": (lambda s: (s > -1) & (s < 1), (x > -1) & (x < 1)),
        "or": (lambda s: (s < -1) | (s > 1), (x < -1) | (x > 1)),
        "not": (lambda s: ~(s > 0), ~(x > 0)),
        "xor": (lambda s: (s > -1) ^ (s > 1), (x > -1) ^ (x > 1)),
        "constants": (lambda s: ((s > 0) & True) | False, x > 0),
    }
    for condition, expected in cases.values():
        f = compiled(lambda s, c=condition: sym.where(c(s), s * s, -1.0), 1)
        np.testing.assert_array_equal(f(x), np.where(expected, x * x, -1.0))


def test_the_branch_not_taken_contributes_nothing() -> None:
    f = compiled(lambda s: sym.where(s > 0.0, sym.sqrt(s) * sym.log(s), s * s), 1)
    x = np.array([-1.0, 0.0, 4.0])
    value, gradient, hessian = f.value_gradient_hessian(x)
    np.testing.assert_allclose(value, [1.0, 0.0, 2 * np.log(4)], rtol=1e-15)
    np.testing.assert_allclose(gradient, [-2.0, 0.0, np.log(4) / 4 + 0.5], rtol=1e-14)
    assert np.isfinite(hessian).all()


def test_sinh_keeps_its_digits_near_zero() -> None:
    x = np.logspace(-12, 0.5, 200)
    np.testing.assert_allclose(compiled(sym.sinh, 1)(x), np.sinh(x), rtol=VALUE_TOLERANCE)


@pytest.mark.parametrize("name", ["sinh", "cosh"])
def test_hyperbolic_functions_reach_the_largest_numbers(name: str) -> None:
    x = np.array([1.0, 1.5, 30.0, 700.0, 709.7, 709.79, 710.2, 710.475, 710.48, 800.0])
    x = np.concatenate([x, -x])
    f, exact = compiled(getattr(sym, name), 1), getattr(np, name)
    slope = np.cosh if name == "sinh" else np.sinh
    with np.errstate(over="ignore"):
        np.testing.assert_allclose(f(x), exact(x), rtol=1e-15)
        np.testing.assert_allclose(f.gradient(x), slope(x), rtol=1e-15)
    assert np.isfinite(f([710.475])).all() and np.isinf(f([710.48])).all()


@pytest.mark.parametrize("backend", ["automatic", "interpreter"])
def test_nan_propagates_through_extremes_as_in_numpy(backend: str) -> None:
    nan = np.nan
    a, b = np.array([nan, 1.0, nan, 2.0, -0.5]), np.array([1.0, nan, nan, 1.0, 3.0])

    def of(formula: Callable[..., object], count: int = 1) -> sym.Function:
        graph = sym.Graph()
        x = [sym.symbols(name, graph) for name in "xyz"[:count]]
        return sym.compile(x, formula(*x), backend=backend)

    for name in ("minimum", "maximum"):
        traced, exact = getattr(sym, name), getattr(np, name)
        np.testing.assert_array_equal(of(traced, 2)(a, b), exact(a, b))
        np.testing.assert_array_equal(of(lambda x, t=traced: t(x, 1.0))(a), exact(a, 1.0))
        np.testing.assert_array_equal(of(lambda x, t=traced: t(1.0, x))(a), exact(1.0, a))
    clipped = of(lambda x: sym.clip(x, -1.0, 1.0))(a)
    np.testing.assert_array_equal(clipped, np.clip(a, -1.0, 1.0))
    three = of(sym.clip, 3)(a, -1.0, b)
    np.testing.assert_array_equal(three, np.minimum(np.maximum(a, -1.0), b))


def test_fused_multiply_add_rounds_once() -> None:
    x = 1.0 + 2.0**-30
    f = compiled(sym.fma, 3)
    assert f(x, x, -1.0 - 2.0**-29) == 2.0**-60


def test_clip() -> None:
    x = np.linspace(-2.0, 2.0, 17)
    np.testing.assert_array_equal(compiled(lambda s: sym.clip(s, -1.0, 0.5), 1)(x), np.clip(x, -1.0, 0.5))


def test_functions_of_numbers_give_constants() -> None:
    assert float(sym.sqrt(4.0)) == 2.0
    assert float(sym.vec(1, 2, 3) @ (4, 5, 6)) == 32.0
    assert float(sym.where(sym.sqrt(4.0) > 1.0, 3.0, 5.0)) == 3.0
    assert int(sym.sqrt(6.25)) == 2 and int(sym.exp(100.0)) == int(float(sym.exp(100.0)))
    with pytest.raises(OverflowError, match="infinity"):
        int(sym.exp(1e4))
    with pytest.raises(ValueError, match="NaN"):
        int(sym.sqrt(-1.0))


@pytest.mark.parametrize(
    ("numpy_function", "own"),
    [
        (np.sqrt, sym.sqrt),
        (np.exp, sym.exp),
        (np.arctan, sym.atan),
        (np.abs, sym.abs),
        (np.negative, operator.neg),
        (np.tanh, sym.tanh),
    ],
)
def test_numpy_functions_record_the_same_operation(numpy_function: Callable, own: Callable) -> None:
    x = sym.symbols("x")
    assert sym.is_same(numpy_function(x), own(x))
    assert sym.is_same(numpy_function(sym.vec(x, 2 * x))[1], own(2 * x))


def test_numpy_operators_record_the_same_operation() -> None:
    a, v = sym.symbols("a v[3]")
    array = np.array([1.0, 2.0, 3.0])
    matrix = np.arange(9.0).reshape(3, 3)
    pairs = [
        (np.float64(2.0) * a, 2.0 * a),
        (np.add(a, 1.0), a + 1.0),
        (np.maximum(a, v[0]), sym.maximum(a, v[0])),
        ((array * v)[2], 3.0 * v[2]),
        ((v / array)[1], v[1] / 2.0),
        ((array * a)[1], 2.0 * a),
        (np.dot(array, v), sym.dot(array, v)),
        (array @ v, sym.dot(array, v)),
        ((matrix @ v)[1], sym.dot((3.0, 4.0, 5.0), v)),
        (np.cross(array, v)[0], sym.cross(array, v)[0]),
        (np.linalg.norm(v), sym.norm(v)),
        (np.where(a > 0, a, -a), sym.where(a > 0, a, -a)),
        (np.sum(v), v[0] + v[1] + v[2]),
        (np.hypot(a, v[0]), sym.sqrt(a * a + v[0] * v[0])),
    ]
    for place, (left, right) in enumerate(pairs):
        assert sym.is_same(left, right), place


def test_the_slope_of_cosh_keeps_its_digits_near_zero() -> None:
    @sym.function
    def cosh(x: float):
        return sym.cosh(x)

    x = np.array([1e-15, 1e-9, 1e-6, 1e-3, 0.3, 0.999, 1.001, 5.0])
    x = np.concatenate([x, -x])
    np.testing.assert_allclose(cosh.gradient(x), np.sinh(x), rtol=2e-15)


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
def test_angles_too_large_for_a_quadrant_have_no_sine(name: str) -> None:
    function = getattr(sym, name)

    @sym.function
    def of(x: float):
        return function(x)

    largest = 2.0**51
    exact = getattr(np, name)([largest, -largest])
    np.testing.assert_allclose(of(np.array([largest, -largest])), exact, rtol=1e-15)
    beyond = of(np.array([np.nextafter(largest, np.inf), -1e16, 1e22, 1e300, np.inf]))
    assert np.isnan(beyond).all()


def test_what_is_no_scalar_is_not_compared() -> None:
    """None ended in an AttributeError of the bindings."""

    @sym.function
    def compared(x: sym.Real) -> sym.Real:
        assert sym.is_same(x, x) and sym.is_same(2, 2.0) and not sym.is_same(x, 2.0)
        for wrong in (None, "x", [x], sym.vec(x, x)):
            with pytest.raises(stark.TraceError, match=r"is_same: b is .*: must be a scalar of a formula"):
                sym.is_same(x, wrong)
        for wrong in (None, 3, "x", np.array(1.0)):
            with pytest.raises(stark.TraceError, match="must be a list of scalars"):
                sym.Vec(wrong)
            with pytest.raises(stark.TraceError, match="must be a list of scalars"):
                sym.ExpressionGraph("g", wrong)
        with pytest.raises(stark.TraceError, match="Mat: rows = None: must be a list"):
            sym.Mat(None)
        with pytest.raises(stark.TraceError, match="output 3: must be a scalar of a formula"):
            sym.ExpressionGraph("g", [3])
        return x

    assert compared(1.0) == 1.0
