"""The same functions with stark.symbolic, CasADi, SymPy, SymEngine and JAX: time to build the value, gradient
and Hessian, and time per evaluation for one point and for 100,000 points, on one thread. Every result is
compared with that of Stark. The table goes into README.md beside this file.

    python -m venv bench && bench/bin/pip install "stark-sim[bench]"
    bench/bin/python benchmarks/symbolic/run.py [--count 100000] [--only jax]

A package that is not installed is skipped, and the table says so."""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

# Before JAX is imported: one thread, double precision.
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
os.environ.setdefault("JAX_ENABLE_X64", "1")

import numpy as np

Formula = Callable[[object, list, list], object]  # functions, unknowns, parameters -> value
Call = Callable[[np.ndarray, np.ndarray], np.ndarray]  # unknowns (..., n), parameters (..., m) -> result
README = Path(__file__).with_name("README.md")


def cross(a: list, b: list) -> list:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: list, b: list) -> object:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a: list, b: list) -> list:
    return [a[i] - b[i] for i in range(3)]


def tetrahedron(f: object, x: list, p: list) -> object:
    """Neo-Hookean solid of one tetrahedron; p: inverse rest matrix by rows, volume, mu, lambda."""
    edges = [minus(x[3 * k : 3 * k + 3], x[0:3]) for k in (1, 2, 3)]
    F = [[sum(edges[k][i] * p[3 * k + j] for k in range(3)) for j in range(3)] for i in range(3)]
    log_j = f.log(dot(F[0], cross(F[1], F[2])))
    first = sum(F[i][j] * F[i][j] for i in range(3) for j in range(3))
    return p[9] * (0.5 * p[10] * (first - 3.0) - p[10] * log_j + 0.5 * p[11] * log_j * log_j)


def hinge(f: object, x: list, p: list) -> object:
    """Bending of a discrete shell across one edge; p: rest angle, stiffness."""
    a, b, c, d = (x[3 * k : 3 * k + 3] for k in range(4))
    e = minus(b, a)
    n0, n1 = cross(e, minus(c, a)), cross(minus(d, a), e)
    theta = f.atan2(dot(cross(n0, n1), e) / f.sqrt(dot(e, e)), dot(n0, n1))
    return p[1] * (theta - p[0]) * (theta - p[0])


def rosenbrock(f: object, x: list, p: list) -> object:
    """Rosenbrock chain of 10 unknowns; p: both coefficients."""
    bend = [x[i + 1] - x[i] * x[i] for i in range(9)]
    return sum(p[1] * bend[i] * bend[i] + (p[0] - x[i]) * (p[0] - x[i]) for i in range(9))


def samples(name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns and parameters of `count` elements."""
    random = np.random.default_rng(1)
    if name == "rosenbrock chain":
        return random.uniform(0.5, 1.5, (count, 10)), np.tile([1.0, 100.0], (count, 1))
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    if name == "hinge":
        corners = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0.2], [0.5, -1, 0.1]], float)
    x = corners.ravel() + random.uniform(-0.1, 0.1, (count, 12))
    rest = np.array([*np.eye(3).ravel(), 1 / 6, 1e5, 2e5]) if name == "tetrahedron" else np.array([0.1, 1e-3])
    return x, np.tile(rest, (count, 1))


FORMULAS: dict[str, tuple[Formula, int, int]] = {
    "tetrahedron": (tetrahedron, 12, 12),
    "hinge": (hinge, 12, 2),
    "rosenbrock chain": (rosenbrock, 10, 2),
}


def build_stark(formula: Formula, n: int, m: int) -> list[Call]:
    import stark.symbolic as sym

    x, p = sym.symbols(f"x[{n}] p[{m}]")
    f = sym.compile([x, p], formula(sym, list(x), list(p)))
    _ = f.statistics  # builds the code of all orders
    return [f, f.gradient, f.hessian]


def build_casadi(formula: Formula, n: int, m: int) -> list[Call]:
    """Its virtual machine, mapped over the points; with a C compiler it could do better."""
    import casadi

    x, p = casadi.SX.sym("x", n), casadi.SX.sym("p", m)
    y = formula(casadi, [x[i] for i in range(n)], [p[i] for i in range(m)])
    hessian, gradient = casadi.hessian(y, x)
    functions = [
        casadi.Function("f", [x, p], [casadi.densify(e)], {"cse": True}) for e in (y, gradient, hessian)
    ]

    def call(function: object, rows: int) -> Call:
        mapped = {1: function}

        def run(x: np.ndarray, p: np.ndarray) -> np.ndarray:
            count = x.size // n
            if count not in mapped:
                mapped[count] = function.map(count, "serial")
            flat = mapped[count](x.reshape(count, n).T, p.reshape(count, m).T).full()
            return flat.reshape(rows, count, -1).transpose(1, 2, 0)

        return run

    return [call(functions[0], 1), call(functions[1], n), call(functions[2], n)]


def build_sympy(formula: Formula, n: int, m: int) -> list[Call]:
    import sympy

    x, p = sympy.symbols(f"x0:{n}"), sympy.symbols(f"p0:{m}")
    y = formula(sympy, list(x), list(p))
    gradient = [y.diff(a) for a in x]
    hessian = [gradient[i].diff(x[j]) for i in range(n) for j in range(i, n)]
    functions = [sympy.lambdify([x, p], e, modules="numpy", cse=True) for e in ([y], gradient, hessian)]
    return [_stacked(f, k, n) for k, f in enumerate(functions)]


def _stacked(function: Callable, order: int, n: int) -> Call:
    """Columns of unknowns in, list of arrays out."""
    upper = np.triu_indices(n)

    def run(x: np.ndarray, p: np.ndarray) -> np.ndarray:
        entries = function(np.moveaxis(x, -1, 0), np.moveaxis(p, -1, 0))
        values = np.stack(np.broadcast_arrays(*entries, x[..., 0])[:-1], axis=-1)
        return values[..., 0] if order == 0 else values if order == 1 else _full(values, n, upper)

    return run


def _full(entries: np.ndarray, n: int, upper: tuple) -> np.ndarray:
    hessian = np.empty((*entries.shape[:-1], n, n))
    hessian[(..., *upper)] = entries
    hessian[(..., *upper[::-1])] = entries
    return hessian


def build_symengine(formula: Formula, n: int, m: int) -> list[Call]:
    """With LLVM where the package has it."""
    import symengine

    x, p = list(symengine.symbols(f"x0:{n}")), list(symengine.symbols(f"p0:{m}"))
    y = formula(symengine, x, p)
    gradient = [y.diff(a) for a in x]
    hessian = [gradient[i].diff(x[j]) for i in range(n) for j in range(i, n)]
    backend = "llvm" if symengine.have_llvm else "lambda"
    functions = [symengine.Lambdify(x + p, e, backend=backend, cse=True) for e in ([y], gradient, hessian)]
    upper = np.triu_indices(n)

    def call(order: int) -> Call:
        def run(x: np.ndarray, p: np.ndarray) -> np.ndarray:
            values = functions[order](np.concatenate([x, p], axis=-1))
            return values[..., 0] if order == 0 else values if order == 1 else _full(values, n, upper)

        return run

    return [call(order) for order in range(3)]


def build_jax(formula: Formula, n: int, m: int) -> list[Call]:
    """jit of vmap; it compiles for every batch shape, the time given is for one point."""
    import jax
    import jax.numpy as jnp

    functions = SimpleNamespace(log=jnp.log, sqrt=jnp.sqrt, atan2=jnp.arctan2)

    def value(x: object, p: object) -> object:
        return formula(functions, [x[i] for i in range(n)], [p[i] for i in range(m)])

    calls = []
    for f in (value, jax.grad(value), jax.hessian(value)):
        compiled = jax.jit(jax.vmap(f))

        def run(x: np.ndarray, p: np.ndarray, compiled: Callable = compiled) -> np.ndarray:
            return np.asarray(compiled(x.reshape(-1, n), p.reshape(-1, m)).block_until_ready())

        run(np.ones((1, n)) + np.arange(n) % 4, np.ones((1, m)))
        calls.append(run)
    return calls


LIBRARIES = {
    "stark": ("stark.symbolic", build_stark),
    "CasADi": ("casadi", build_casadi),
    "JAX": ("jax", build_jax),
    "SymEngine": ("symengine", build_symengine),
    "SymPy": ("sympy", build_sympy),
}


def best_time(call: Call, x: np.ndarray, p: np.ndarray, budget: float = 0.5) -> float:
    """Seconds of one call: the best of as many as fit into the budget, the first not counted."""
    call(x, p)
    best, begin = np.inf, time.perf_counter()
    while not np.isfinite(best) or time.perf_counter() - begin < budget:
        start = time.perf_counter()
        call(x, p)
        best = min(best, time.perf_counter() - start)
    return best


def rows(count: int, only: str) -> Iterator[str]:
    """Lines of the table."""
    for name, (formula, n, m) in FORMULAS.items():
        reference: list[np.ndarray] = []
        x, p = samples(name, count)
        for library, (package, build) in LIBRARIES.items():
            if only and library not in ("stark", only):
                continue
            try:
                importlib.import_module(package)
            except ImportError:
                yield f"| {name} | {library} | not installed |" + " |" * 6
                continue
            start = time.perf_counter()
            calls = build(formula, n, m)
            seconds = time.perf_counter() - start
            shapes = [(count,), (count, n), (count, n, n)]
            results = [np.asarray(call(x, p)).reshape(s) for call, s in zip(calls, shapes, strict=True)]
            reference = reference or results
            for ours, theirs in zip(reference, results, strict=True):
                error = np.abs(theirs - ours).max() / np.abs(ours).max()
                assert error < 1e-10, f"{library}, {name}: relative difference {error}"
            one = [best_time(call, x[:1], p[:1], 0.2) for call in calls]
            many = [best_time(call, x, p) / count for call in calls]
            cells = [
                f"{1e3 * seconds:,.1f}",
                *(f"{1e6 * t:,.1f}" for t in one),
                *(f"{1e9 * t:,.0f}" for t in many),
            ]
            yield f"| {name} | {library} | " + " | ".join(cells) + " |"
            print(f"{name:18} {library:10}", *(f"{c:>10}" for c in cells), flush=True)


def machine() -> str:
    model = re.search(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text())
    found = []
    for package in ("stark", "casadi", "jax", "symengine", "sympy", "numpy"):
        try:
            found.append(f"{package} {importlib.import_module(package).__version__}")
        except ImportError:
            found.append(f"{package} not installed")
    processor = model[1] if model else platform.machine()
    return f"{processor}, Python {platform.python_version()}, {', '.join(found)}."


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=100_000, help="points of the large batch")
    parser.add_argument("--only", default="", help="one library beside stark; the README stays as it is")
    options = parser.parse_args()
    table = list(rows(options.count, options.only))
    if options.only:
        return
    begin, end = "<!-- table -->\n", "<!-- end -->"
    head, rest = README.read_text().split(begin)
    titles = "| function | library | build [ms] | E(1) [us] | g(1) | H(1) | E [ns] | g | H |"
    titles += "\n|---|---|" + "--:|" * 7
    tail = rest[rest.index(end) :]
    README.write_text(f"{head}{begin}{titles}\n" + "\n".join(table) + f"\n\n{machine()}\n{tail}")


if __name__ == "__main__":
    main()
