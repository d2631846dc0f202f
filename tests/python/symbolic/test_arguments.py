"""Numbers that are too large, words that are not known and values of other types: refused by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark
import stark.symbolic as sym

LARGE: list[int] = [10**400, -(10**400), 10**5000]


@pytest.mark.parametrize("number", LARGE, ids=["positive", "negative", "unprintable"])
@pytest.mark.parametrize(
    "formula",
    [
        lambda x, n: x * n,
        lambda x, n: n - x,
        lambda x, n: x**n,
        lambda x, n: n**x,
        lambda x, n: sym.maximum(x, n),
        lambda x, n: sym.where(x > n, x, 1.0),
        lambda x, n: sym.vec(x, x) * n,
        lambda x, n: sym.vec(x, n),
        lambda x, n: sym.vec(x, x) + np.array([n, 1], dtype=object),
        lambda x, n: sym.sqrt(np.array(n, dtype=object)),
    ],
)
def test_integers_that_no_float_holds_are_refused(formula: Callable[[Any, int], object], number: int) -> None:
    with pytest.raises(stark.TraceError, match=r"an integer of about \d+ digits.*below 1.8e308.*units"):
        formula(sym.symbols("x"), number)


def test_an_integer_in_an_energy_names_the_line() -> None:
    huge = 10**400

    @stark.energy
    def spring(p: stark.Point):
        return huge * p.x[2] ** 2

    scene = stark.Scene()
    ball = scene.add_sphere(0.1, mass=1.0)
    with pytest.raises(stark.TraceError, match=r"(?s)spring: an integer of about 400 digits.*huge \* p\.x"):
        scene.add(spring(ball.points([(0.0, 0.0, 0.0)])))


def test_integer_exponents_that_are_too_large() -> None:
    x = sym.symbols("x")
    for exponent in (10**12, 10**30):
        with pytest.raises(stark.TraceError, match=rf"exponent {exponent} is too large; write it as a float"):
            x**exponent
    assert float(sym.pow(2.0, float(10**30))) == np.inf


@pytest.mark.parametrize("backend", ["nope", None, 3, [1], b"avx2"])
def test_backends_that_do_not_exist(backend: Any) -> None:
    x = sym.symbols("x")
    rule = "backend = .*must be 'automatic' or 'avx512' or 'avx2' or 'neon' or 'interpreter'"
    with pytest.raises(stark.InvalidArgument, match=rule):
        sym.compile([x], x * x, backend=backend)
    with pytest.raises(stark.InvalidArgument, match=rule):
        sym.function(backend=backend)
    if backend is not None:
        rule = "must be one of 'automatic', 'interpreter', 'avx2'"
        with pytest.raises(stark.InvalidArgument, match=rule):
            stark._core.symbolic.compile_arrays([x], [("x", [x], True)], backend)


def test_kinds_of_inputs_that_do_not_exist() -> None:
    for kind in ("nope", 3):
        with pytest.raises(stark.InvalidArgument, match=r"input kind .*must be one of 'unknown', 'element'"):
            sym.Graph().input(kind)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda x: sym.compile(3, x), stark.InvalidArgument, "inputs = 3: must be a list of symbols"),
        (lambda x: sym.compile("x", x), stark.InvalidArgument, "inputs = 'x': must be a list of symbols"),
        (lambda x: sym.compile({3: x}, x), stark.InvalidArgument, "the input name 3: must be one"),
        (lambda x: sym.compile({"a b": x}, x), stark.InvalidArgument, "the input name 'a b': must be"),
        (lambda x: sym.compile([x], x, name=None), stark.InvalidArgument, "name = None: must be a non-empty"),
        (
            lambda x: sym.compile([x], x).gradient(1.0, wrt=3),
            stark.InvalidArgument,
            "wrt=3: must be the name",
        ),
        (lambda x: sym.symbols(3), stark.TraceError, "symbols: got 3: must be a text"),
        (lambda x: sym.vec(object), stark.TraceError, "vec: got type: must be a list"),
        (lambda x: sym.mat(3), stark.TraceError, "mat: got a scalar: must be a list"),
        (lambda x: sym.mat([None]), stark.TraceError, "vec: got NoneType: must be a list"),
        (lambda x: sym.columns(None), stark.TraceError, "columns: got NoneType: must be a list"),
        (lambda x: sym.identity(2.5), stark.TraceError, "identity: n = 2.5: must be a number of rows"),
        (lambda x: sym.identity(0), stark.TraceError, "identity: n = 0: must be a number of rows"),
        (lambda x: sym.vec(x, x)[[[0, 1], [1]]], IndexError, "of Vec of 2: .*; the first is 0"),
        (lambda x: sym.power_trace(sym.mat([[x, 0], [0, x]]), 10**400), stark.TraceError, "exponent = 1000"),
        (lambda x: sym.vec(x, x)[np.uint64(2**63)], IndexError, "of Vec of 2: .*; the first is 0"),
    ],
)
def test_arguments_of_other_types(call: Callable[[Any], object], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        call(sym.symbols("x"))
