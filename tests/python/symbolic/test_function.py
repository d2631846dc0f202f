"""Compiled functions: derivatives against SymPy and central differences, batches of every layout, equal bits
of all back ends, threads."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable

import numpy as np
import pytest
import sympy

import stark
import stark.symbolic as sym

BACKENDS = ["automatic", "interpreter"]


@sym.function
def rosenbrock(x: sym.Vector[2], a: float = 1.0, b: float = 100.0):
    return (a - x[0]) ** 2 + b * (x[1] - x[0] ** 2) ** 2


@sym.function
def project(p: sym.Vector[3], R: sym.Matrix[3, 3], f: float):
    """Pinhole camera."""
    q = R @ p
    return f * sym.vec(q[0], q[1]) / q[2]


def sample(shape: tuple[int, ...], seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.5, 2.0, shape)


# Formulas that run with symbols of Stark and of SymPy alike; `f` has the functions.
FORMULAS: dict[str, Callable] = {
    "rosenbrock": lambda f, x: (1 - x[0]) ** 2 + 100 * (x[1] - x[0] ** 2) ** 2 + x[2] * x[3],
    "rational": lambda f, x: (x[0] * x[1] - x[2]) / (x[3] + x[0] ** 2) + 1 / x[1],
    "roots": lambda f, x: f.sqrt(x[0] ** 2 + x[1] ** 2 + x[2] ** 2) * x[3] ** 1.5,
    "exponentials": lambda f, x: f.exp(-x[0] * x[1]) * f.log(x[2]) + x[3] ** x[0] + f.tanh(x[1] * x[2]),
    "angles": lambda f, x: f.sin(x[0] * x[1]) * f.cos(x[2]) + f.tan(x[3] / 3) + f.atan2(x[0], x[1]),
    "inverse angles": lambda f, x: f.acos(x[0] * x[1] / 5) + f.asin(x[2] / 4) * f.atan(x[3]),
    "hyperbolic": lambda f, x: f.sinh(x[0]) * f.cosh(x[1]) - f.sinh(x[2] / 4) * x[3],
    "shared parts": lambda f, x: sum(
        (x[i] - x[j]) ** 4 * f.exp(x[i] * x[j]) for i in range(4) for j in range(i)
    ),
    "unused entries": lambda f, x: x[2] ** 3,
    "linear": lambda f, x: 2 * x[0] - 3 * x[3],
}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", FORMULAS)
def test_derivatives_are_those_of_sympy(name: str, backend: str) -> None:
    x = sym.symbols("x[4]")
    f = sym.compile([x], FORMULAS[name](sym, x), backend=backend)
    s = sympy.symbols("s0:4")
    expression = sympy.sympify(FORMULAS[name](sympy, s))
    points = sample((20, 4))
    value, gradient, hessian = f.value_gradient_hessian(points)
    for k, point in enumerate(points):
        at = dict(zip(s, map(sympy.Float, point, [30] * 4), strict=True))
        exact = [float(expression.subs(at).evalf(25))]
        slopes = [float(expression.diff(a).subs(at).evalf(25)) for a in s]
        curvatures = [[float(expression.diff(a, b).subs(at).evalf(25)) for b in s] for a in s]
        # A few dozen roundings each, relative to the largest entry.
        for ours, theirs in ((value[k], exact[0]), (gradient[k], slopes), (hessian[k], curvatures)):
            np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-13 * np.abs(theirs).max())
        if k >= 2 and name == "shared parts":
            break  # SymPy takes its time here


def test_shapes_of_results() -> None:
    x = sample((5, 4, 2))
    assert rosenbrock(x).shape == (5, 4)
    assert rosenbrock.gradient(x).shape == (5, 4, 2)
    assert rosenbrock.hessian(x).shape == (5, 4, 2, 2)
    assert isinstance(rosenbrock(x[0, 0]), float)
    p, R = sample((6, 3)), np.broadcast_to(np.eye(3), (6, 3, 3))
    assert project(p, R, 1.0).shape == (6, 2)
    assert project.jacobian(p, R, 1.0).shape == (6, 2, 3)
    assert project.jacobian(p, R, 1.0, wrt="R").shape == (6, 2, 3, 3)
    assert project.jacobian(p, R, 1.0, wrt="f").shape == (6, 2)
    value, blocks = project.value_and_jacobian(p, R, 1.0, wrt=("f", "p"))
    assert (value.shape, blocks[0].shape, blocks[1].shape) == ((6, 2), (6, 2), (6, 2, 3))


def test_defaults_keywords_and_positions() -> None:
    x = sample((7, 2))
    expected = (2.0 - x[:, 0]) ** 2 + 3.0 * (x[:, 1] - x[:, 0] ** 2) ** 2
    for values in (rosenbrock(x, 2.0, 3.0), rosenbrock(x, b=3.0, a=2.0), rosenbrock(a=2.0, x=x, b=3)):
        np.testing.assert_allclose(values, expected, rtol=1e-14)
    with pytest.raises(TypeError, match=r"rosenbrock\(x.*: .*'x'"):
        rosenbrock()
    with pytest.raises(TypeError, match="unexpected keyword argument 'c'"):
        rosenbrock(x, c=1.0)


@pytest.mark.parametrize("what", ["x", "R", "f"])
def test_jacobian_by_every_argument(what: str) -> None:
    arguments = {"p": sample((4, 3)), "R": sample((4, 3, 3), 5), "f": sample((4,), 6)}
    wrt = {"x": "p"}.get(what, what)
    jacobian = project.jacobian(**arguments, wrt=wrt)
    own = arguments[wrt].shape[1:]
    for index in np.ndindex(*own):
        step = np.zeros(own)
        step[index] = 1e-6
        up, down = ({**arguments, wrt: arguments[wrt] + sign * step} for sign in (1, -1))
        np.testing.assert_allclose(
            jacobian[(..., *index)], (project(**up) - project(**down)) / 2e-6, rtol=1e-7, atol=1e-8
        )


def test_blocks_of_several_arguments() -> None:
    x = sample((2,))
    value, gradients, rows = rosenbrock.value_gradient_hessian(x, 1.5, 80.0, wrt=("b", "x"))
    (bb, bx), (xb, xx) = rows
    assert value == rosenbrock(x, 1.5, 80.0)
    np.testing.assert_array_equal(gradients[1], rosenbrock.gradient(x, 1.5, 80.0))
    np.testing.assert_allclose(gradients[0], (x[1] - x[0] ** 2) ** 2, rtol=1e-14)
    np.testing.assert_array_equal(xx, rosenbrock.hessian(x, 1.5, 80.0))
    np.testing.assert_array_equal(bx, xb)
    np.testing.assert_allclose(bx, 2 * (x[1] - x[0] ** 2) * np.array([-2 * x[0], 1.0]), rtol=1e-14)
    assert bb == 0.0
    (only,) = rosenbrock.gradient(x, wrt=("x",))
    np.testing.assert_array_equal(only, rosenbrock.gradient(x))


def test_parameters_broadcast() -> None:
    x, a, b = sample((5, 1, 2)), sample((4,)), sample((3, 1, 1), 9)
    values = rosenbrock(x, a, b)
    assert values.shape == (3, 5, 4)
    for i, j, k in np.ndindex(3, 5, 4):
        assert values[i, j, k] == rosenbrock(x[j, 0], a[k], b[i, 0, 0])
    assert rosenbrock.hessian(x, a, b).shape == (3, 5, 4, 2, 2)


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 64, 65, 1000])
def test_batches_of_any_length(count: int) -> None:
    x = sample((count, 2))
    value, gradient, hessian = rosenbrock.value_gradient_hessian(x)
    assert (value.shape, gradient.shape, hessian.shape) == ((count,), (count, 2), (count, 2, 2))
    for k in range(0, count, 13):
        assert value[k] == rosenbrock(x[k])
        np.testing.assert_array_equal(hessian[k], rosenbrock.hessian(x[k]))


def test_arrays_of_any_layout() -> None:
    x = sample((6, 8, 2))
    expected = rosenbrock.gradient(x)
    packed = np.zeros((6, 8), dtype=[("flag", "i1"), ("x", "f8", 2)])  # not aligned, odd strides
    packed["x"] = x
    layouts = {
        "columns": np.asfortranarray(x),
        "reversed": x[::-1, ::-1].copy()[::-1, ::-1],
        "every other": np.repeat(x, 2, axis=1)[:, ::2],
        "components apart": np.moveaxis(np.ascontiguousarray(np.moveaxis(x, -1, 0)), 0, -1),
        "other byte order": x.astype(">f8"),
        "not aligned": packed["x"],
        "read only": np.broadcast_to(x, (6, 8, 2)),
        "lists": x.tolist(),
    }
    for name, array in layouts.items():
        np.testing.assert_array_equal(rosenbrock.gradient(array), expected, err_msg=name)
    for kind in (np.float32, np.int32, np.uint8, bool):
        converted = (4 * x).astype(kind)
        np.testing.assert_array_equal(rosenbrock(converted), rosenbrock(converted.astype(float)))
    np.testing.assert_array_equal(rosenbrock.gradient(x[:, :0]), np.zeros((6, 0, 2)))


def test_results_are_new_arrays() -> None:
    x = sample((3, 2))
    gradient = rosenbrock.gradient(x)
    kept = gradient.copy()
    rosenbrock.gradient(x + 1.0)
    gradient[0] += 0.0  # writable
    np.testing.assert_array_equal(gradient, kept)


def bits_of(backend: str, points: np.ndarray) -> list[np.ndarray]:
    x = sym.symbols("x[4]")
    results = []
    for formula in FORMULAS.values():
        results += sym.compile([x], formula(sym, x), backend=backend).value_gradient_hessian(points)
    return results


def test_back_ends_give_the_same_bits() -> None:
    points = sample((301, 4))
    reference = bits_of("interpreter", points)
    compared = 0
    for backend in ("automatic", "avx2", "avx512"):
        try:
            results = bits_of(backend, points)
        except stark.InvalidArgument as error:
            assert "avx512" in str(error).lower().replace("-", "")
            continue
        compared += 1
        for ours, theirs in zip(results, reference, strict=True):
            assert ours.tobytes() == theirs.tobytes()
    assert compared >= 1


def test_values_have_the_same_bits_in_every_order() -> None:
    x = sample((100, 2))
    value, gradient, _ = rosenbrock.value_gradient_hessian(x)
    assert value.tobytes() == rosenbrock(x).tobytes() == rosenbrock.value_and_gradient(x)[0].tobytes()
    assert gradient.tobytes() == rosenbrock.gradient(x).tobytes()
    p, R = sample((9, 3)), sample((3, 3))
    assert project.value_and_jacobian(p, R, 2.0)[0].tobytes() == project(p, R, 2.0).tobytes()


def test_a_big_batch_from_several_threads() -> None:
    @sym.function
    def wave(x: sym.Vector[3], t: float):
        return sym.sin(x @ x - t) * sym.exp(-t)

    x = sample((100_000, 3))
    expected = np.sin((x * x).sum(axis=1) - 0.5) * np.exp(-0.5)
    results: list[tuple] = []
    threads = [
        threading.Thread(target=lambda: results.append(wave.value_gradient_hessian(x, 0.5))) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    for value, _, hessian in results:
        # The argument of the sine, up to 12, is rounded to 2e-15.
        np.testing.assert_allclose(value, expected, rtol=0, atol=4e-15)
        assert hessian.tobytes() == results[0][2].tobytes()


def test_functions_of_functions() -> None:
    @sym.function
    def twice(x: sym.Vector[2]):
        return rosenbrock(x) + rosenbrock(2.0 * x, b=3.0)

    x = sample((5, 2))
    np.testing.assert_allclose(twice(x), rosenbrock(x) + rosenbrock(2 * x, b=3.0), rtol=1e-15)
    with pytest.raises(stark.TraceError, match="argument 'x' is Vec of 3: must be Vec of 2"):
        rosenbrock(sym.symbols("y[3]"))


def test_derivatives_inside_formulas() -> None:
    """The stress of a St. Venant-Kirchhoff solid, P = F (lambda tr(E) I + 2 mu E), from its energy."""

    @sym.function
    def stress(F: sym.Matrix[3, 3], mu: float, la: float):
        E = 0.5 * (F.T @ F - sym.identity(3))
        density = mu * sym.squared_norm(E) + 0.5 * la * sym.trace(E) ** 2
        return sym.gradient(density, F)

    F, mu, la = np.eye(3) + 0.1 * sample((10, 3, 3)), 3.0, 5.0
    E = 0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(3))
    trace = np.trace(E, axis1=1, axis2=2)[:, None, None]
    np.testing.assert_allclose(stress(F, mu, la), F @ (la * trace * np.eye(3) + 2 * mu * E), rtol=1e-13)

    # With respect to computed values, by a function of them.
    @sym.function
    def density(E: sym.Matrix[3, 3], mu: float, la: float):
        return mu * sym.squared_norm(E) + 0.5 * la * sym.trace(E) ** 2

    @sym.function
    def same_stress(F: sym.Matrix[3, 3], mu: float, la: float):
        E = 0.5 * (F.T @ F - sym.identity(3))
        value, S = density.value_and_gradient(E, mu, la)
        return F @ S + 0.0 * value

    np.testing.assert_allclose(same_stress(F, mu, la), stress(F, mu, la), rtol=1e-13)
    a, b = sym.symbols("a b")
    at = {"a": 0.3, "b": 1.7}
    gradient = sym.compile([a, b], rosenbrock.gradient(sym.vec(2 * a, a * b)))
    hessian = sym.compile([a, b], rosenbrock.hessian(sym.vec(2 * a, a * b)))
    point = [2 * at["a"], at["a"] * at["b"]]
    np.testing.assert_allclose(gradient(**at), rosenbrock.gradient(point), rtol=1e-13)
    np.testing.assert_allclose(hessian(**at), rosenbrock.hessian(point), rtol=1e-13)
    x = sym.symbols("x[2]")
    curl = sym.jacobian(sym.vec(x[0] * x[1], x[1] ** 2), x)
    assert sym.is_same(curl[0, 1], x[0])
    assert sym.is_same(sym.hessian(x[0] ** 2 * x[1], x)[0, 0], 2 * x[1])


def test_functions_are_pickled_by_name() -> None:
    assert pickle.loads(pickle.dumps(rosenbrock)) is rosenbrock


def test_results_as_lists_and_constants() -> None:
    @sym.function
    def mixed(x: sym.Vector[2]):
        return [x[0], 4.0, 2 * x[1]]

    np.testing.assert_array_equal(mixed([1.0, 2.0]), [1.0, 4.0, 4.0])
    np.testing.assert_array_equal(mixed.jacobian([1.0, 2.0]), [[1, 0], [0, 0], [0, 2]])

    @sym.function
    def matrix(x: sym.Vector[2]):
        return [[x[0], x[1]], [x[1], x[0] * x[1]]]

    assert matrix(sample((7, 2))).shape == (7, 2, 2)
    assert matrix.jacobian(sample((7, 2))).shape == (7, 2, 2, 2)

    @sym.function
    def one_entry(x: sym.Vector[2]):
        return sym.vec(x @ x)

    assert one_entry(sample((3, 2))).shape == (3, 1)
    assert one_entry.jacobian(sample((3, 2))).shape == (3, 1, 2)


def test_numbers_from_outside_are_fixed_when_recorded() -> None:
    scale = 2.0

    @sym.function
    def scaled(x: float, *, shift: float = 0.0):
        return scale * x + shift

    assert scaled(3.0, shift=1.0) == 7.0
    scale = 5.0
    assert scaled(3.0) == 6.0


def test_annotations_from_local_names_and_strings() -> None:
    n = 3

    @sym.function
    def length(x: sym.Vector[n]):
        return sym.norm(x)

    assert length([1.0, 2.0, 2.0]) == 3.0


def test_stages_change_no_result() -> None:
    @sym.function
    def staged(w: sym.Vector[3], p: sym.Vector[3]):
        moved = sym.mark_stage(p + sym.cross(w, p) + 0.5 * sym.cross(w, sym.cross(w, p)))
        return sym.norm(moved) ** 3

    @sym.function
    def plain(w: sym.Vector[3], p: sym.Vector[3]):
        moved = p + sym.cross(w, p) + 0.5 * sym.cross(w, sym.cross(w, p))
        return sym.norm(moved) ** 3

    w, p = sample((20, 3)), sample((20, 3), 4)
    np.testing.assert_allclose(staged.hessian(w, p), plain.hessian(w, p), rtol=1e-10, atol=1e-11)


def test_compile_with_a_mapping_and_statistics() -> None:
    x, a = sym.symbols("x[2] a")
    f = sym.compile({"position": x, "factor": a}, a * (x @ x), name="energy", backend="interpreter")
    assert f(factor=3.0, position=[1.0, 2.0]) == 15.0
    np.testing.assert_array_equal(f.gradient([1.0, 2.0], 3.0), [6.0, 12.0])
    s = f.statistics
    assert s.backend == "interpreter"
    assert s.operations == {
        "value": 4,
        "gradient": s.operations["gradient"],
        "hessian": s.operations["hessian"],
    }
    assert s.operations["value"] <= s.operations["gradient"]
    assert all(seconds > 0 for seconds in s.build_seconds.values())
    assert s.algorithm
    assert "interpreter" in str(s)
    assert set(project.statistics.operations) == {"value", "jacobian"}


def test_a_chain_of_many_unknowns() -> None:
    @sym.function
    def chain(x: sym.Vector[60]):
        return sum(100.0 * (x[i + 1] - x[i] ** 2) ** 2 + (1.0 - x[i]) ** 2 for i in range(59))

    hessian = chain.hessian(np.ones(60))
    assert chain(np.ones(60)) == 0.0
    assert np.count_nonzero(hessian) == 60 + 2 * 59  # tridiagonal
    assert np.linalg.eigvalsh(hessian).min() > 0.0
