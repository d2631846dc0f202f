"""Annotations of formulas: their shapes, in the spelling for type checkers and in the short one."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import pytest

import stark
import stark.symbolic as sym
from stark.symbolic.signature import evaluated_signature, new_symbols


def test_both_spellings_give_the_same_shapes() -> None:
    def checked(
        x: Annotated[sym.Vec, 5], A: Annotated[sym.Mat, 2, 5], k: Annotated[float, "N/m"], t: sym.Vec3
    ): ...

    def short(x: sym.Vector[5], A: sym.Matrix[2, 5], k: float, t: sym.Vector[3]): ...

    names = {"sym": sym}
    assert evaluated_signature(checked, names) == evaluated_signature(short, names)


def test_a_formula_with_checked_annotations_is_the_closed_form() -> None:
    @sym.function
    def energy(x: Annotated[sym.Vec, 5], A: Annotated[sym.Mat, 2, 5]):
        y = A @ x
        return 0.5 * (y @ y)

    random = np.random.default_rng(3)
    x, A = random.normal(size=(7, 5)), random.normal(size=(2, 5))
    assert np.allclose(energy(x, A), 0.5 * ((x @ A.T) ** 2).sum(axis=1), rtol=1e-14)
    assert np.allclose(energy.gradient(x, A), x @ A.T @ A, rtol=1e-12, atol=1e-14)
    assert np.allclose(energy.hessian(x, A), A.T @ A, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    ("annotation", "message"),
    [
        (Annotated[sym.Vec, 0], r"must be Vector\[n\]"),
        (Annotated[sym.Vec, 2, 3], r"must be Vector\[n\]"),
        (Annotated[sym.Vec, "m"], r"must be Vector\[n\]"),
        (Annotated[sym.Mat, 3], r"must be Matrix\[rows, columns\]"),
        (Annotated[str, 3], "must be float"),
        (sym.Vec, "must be float"),
        (list, "must be float"),
    ],
)
def test_a_wrong_annotation_is_refused_with_the_name_of_the_formula(annotation: object, message: str) -> None:
    def wrong(x): ...

    wrong.__annotations__ = {"x": annotation}
    with pytest.raises(stark.TraceError, match=message) as caught:
        sym.function(wrong)
    assert "wrong" in str(caught.value)


def test_names_of_formulas_and_the_number_of_arguments_are_checked() -> None:
    with pytest.raises(stark.TraceError, match="no arguments"):
        sym.function(lambda: 0.0)
    with pytest.raises(stark.TraceError, match="must be fixed"):

        @sym.function
        def several(*x: float): ...

    with pytest.raises(stark.TraceError, match="'wrt'"):

        @sym.function
        def taken(wrt: float): ...

    with pytest.raises(stark.TraceError, match="'missing' is not defined"):

        @sym.function
        def unknown(x: missing): ...  # type: ignore[name-defined] # noqa: F821


def test_symbols_have_the_shapes_that_are_asked_for() -> None:
    a, x, F = sym.symbols("a, x[3] F[2, 3]")
    assert isinstance(a, sym.Scalar) and x.shape == (3,) and F.shape == (2, 3)
    assert [entry.name for entry in F.entries] == ["F[0,0]", "F[0,1]", "F[0,2]", "F[1,0]", "F[1,1]", "F[1,2]"]
    assert isinstance(sym.symbols("alone"), sym.Scalar)
    for wrong in ("", "3x", "x[0]", "x[2", "x[1,2,3]"):
        with pytest.raises(stark.TraceError, match="symbols"):
            sym.symbols(wrong)


def test_new_symbols_are_inputs_of_their_graph() -> None:
    graph = sym.Graph()
    v = new_symbols(graph, "v", (2,))
    total = sym.compile([v], v[0] + 2.0 * v[1])
    assert total([3.0, 4.0]) == 11.0


def test_stencils_and_parameters_of_energies_take_checked_annotations() -> None:
    @stark.energy
    def pull(s: Annotated[stark.Stencil, 3], A: Annotated[stark.Mat, 3, 3], k: float = 1.0):
        d = s[0].x - 0.5 * (s[1].x + s[2].x)
        return 0.5 * k * (d @ (A @ d))

    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells=2))
    A = np.diag([1.0, 2.0, 3.0])
    handle = scene.add(pull(stark.stencils(cloth, [[0, 1, 2], [4, 1, 8]]), A=A, k=2.0))
    X = cloth.mesh.vertices
    d = X[[0, 4]] - 0.5 * (X[[1, 1]] + X[[2, 8]])
    sim = stark.Simulation(scene, gravity=(0, 0, 0))
    exact = 0.5 * 2.0 * (d @ A * d).sum(axis=1)
    assert np.allclose(sim.energies[0].energies, exact, rtol=1e-12)
    assert handle.A.shape == (3, 3)
    with pytest.raises(stark.TraceError, match="k points"):

        @stark.energy
        def without_a_count(s: stark.Stencil): ...

    with pytest.raises(stark.TraceError, match="k >= 1"):

        @stark.energy
        def none(s: Annotated[stark.Stencil, 0]): ...
