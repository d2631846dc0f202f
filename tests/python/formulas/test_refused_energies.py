# ruff: noqa: E501
"""Errors of energies: the exception, its words, and the user's own line for all that the formula says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from _scenes import anchor, sheet_and_box, spring, tie

import stark
from stark import InvalidArgument, TraceError

SCENE, CLOTH, BOX = sheet_and_box(2)
P = CLOTH.vertices
KEPT: list = []


@stark.energy
def branch(p: stark.Point, k: float):
    if p.x[2] > 0.0:  # branch line
        return k * p.x[2]
    return 0.0


@stark.energy
def python_max(p: stark.Point):
    return max(p.x[0], 0.0)  # max line


@stark.energy
def python_sqrt(p: stark.Point):
    return math.sqrt(p.x[0])  # sqrt line


@stark.energy
def shapes(p: stark.Point):
    return stark.dot(p.x, np.ones(2))  # shape line


@stark.energy
def vector(p: stark.Point):
    return p.x


@stark.energy
def nothing(p: stark.Point):
    p.x @ p.x


@stark.energy
def condition(p: stark.Point):
    return p.x[0] > 0.0


@stark.energy
def unused_parameter(p: stark.Point, k: float = 1.0):
    return p.x @ p.x + 0.0 * k


@stark.energy
def unused_point(p: stark.Point, q: stark.Point):
    return p.x @ p.x


@stark.energy
def unused_corner(t: stark.Triangle):
    return t[0].x @ t[1].x


@stark.energy
def unused_time(p: stark.Point, t: stark.Time):
    return p.x @ p.x


@stark.energy
def unused_frame(p: stark.Point, f: stark.Frame):
    return p.x @ p.x


@stark.energy
def constant(p: stark.Point):
    return p.X @ p.X


@stark.energy
def keeper(p: stark.Point):
    KEPT.append(p.x[0])
    return p.x @ p.x


@stark.energy
def borrower(p: stark.Point):
    return p.x[0] * KEPT[0]  # borrow line


@stark.energy
def too_many(s: stark.Stencil[9]):
    return sum(p.x @ p.x for p in s)


@stark.energy
def misspelt(p: stark.Point):
    return p.position @ p.x  # attribute line


TRACED = [
    (lambda: branch(P, k=1.0), TraceError, ["branch:", "stark.where", "# branch line"]),
    (lambda: python_max(P), TraceError, ["python_max:", "stark.maximum", "# max line"]),
    (lambda: python_sqrt(P), TraceError, ["float() of", "p.x[0]", "stark.sqrt", "# sqrt line"]),
    (lambda: shapes(P), TraceError, ["Vec of 3 and Vec of 2", "# shape line"]),
    (lambda: vector(P), TraceError, ["returns Vec of 3: must be a scalar", "def vector"]),
    (lambda: nothing(P), TraceError, ["returns None", "def nothing"]),
    (lambda: condition(P), TraceError, ["returns a condition", "def condition"]),
    (lambda: unused_parameter(P), TraceError, ["does not depend on 'k'", "def unused_parameter"]),
    (lambda: unused_point(P, P), TraceError, ["does not depend on 'q'", "def unused_point"]),
    (lambda: unused_corner(CLOTH.faces), TraceError, ["does not depend on 't[2]'"]),
    (lambda: unused_time(P), TraceError, ["does not depend on 't'"]),
    (lambda: unused_frame(P, BOX), TraceError, ["does not depend on 'f'"]),
    (lambda: constant(P), TraceError, ["does not depend on any position .x"]),
    (lambda: (keeper(P), borrower(P)), TraceError, ["borrower:", "two different formulas", "# borrow line"]),
    (lambda: too_many(stark.stencils(CLOTH, [range(9)])), TraceError, ["9 points at once", "at most 8"]),
    (lambda: misspelt(P), AttributeError, ["position"]),
]


@pytest.mark.parametrize("case", TRACED, ids=lambda case: case[2][0])
def test_formulas_that_cannot_be_recorded(case: tuple) -> None:
    make, error, words = case
    with pytest.raises(error) as raised:
        make()
    text = str(raised.value) + "".join(getattr(raised.value, "__notes__", []))
    assert all(word in text for word in words), text
    assert __file__ in text


def defined(arguments: str) -> object:
    names: dict = {"stark": stark}
    exec(f"@stark.energy\ndef f({arguments}):\n    return 0.0\n", names)
    return names["f"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("p", "argument 'p' has no annotation: must be stark.Point"),
        ("p: str", "argument 'p' has the annotation"),
        ("k: float", "no argument is a point, a stencil or a frame"),
        ("*p: stark.Point", "number of arguments must be fixed"),
        ("p: stark.Stencil", r"write stark.Stencil\[k\]"),
        ("p: stark.Stencil[0]", "k >= 1"),
        ("p: stark.Point, time: float", "must not be called 'time'.*stark.Time"),
        ("p: stark.Point, forces: float", "must not be called 'forces'"),
    ],
)
def test_signatures_that_are_refused(arguments: str, words: str) -> None:
    with pytest.raises(TraceError, match=words):
        defined(arguments)


@stark.energy
def magnet(p: stark.Point, centre: stark.Vec3):
    return (p.x - centre) @ (p.x - centre)


@stark.energy
def upright(f: stark.Frame):
    return 1.0 - f.z[2]


OTHER = stark.Scene().add_cloth(stark.mesh.grid(1.0, 1.0, cells=2), name="other")

BOUND = [
    (lambda: spring(CLOTH), ["argument 'e'", "the body 'sheet'", "cloth.edges"]),
    (lambda: spring(CLOTH.triangles), ["argument 'e'", "must be an edge of 2 points"]),
    (lambda: spring(CLOTH.faces), ["has 3 points in a stencil", "an edge of 2 points"]),
    (lambda: tie(P, P[:4]), ["<9 points of 'sheet'> and <4 points of 'sheet'>", "equally many"]),
    (lambda: tie(P, P[:0]), ["<0 points of 'sheet'>", "at least one"]),
    (lambda: tie(P, (0.0, 1.0)), ["world points", "shape (2,)"]),
    (lambda: tie(P, "here"), ["tie: 'b' [m]", "'here'"]),
    (lambda: spring(), ["missing a required argument: 'e'", "stark.Edge"]),
    (lambda: spring(CLOTH.edges, stifness=1.0), ["unexpected keyword argument 'stifness'"]),
    (lambda: anchor(P), ["'target' has no value", "must be given"]),
    (lambda: anchor(P, target=(0.0, 1.0)), ["'target'", "shape (2,)", "(3,)", "(9, 3)"]),
    (lambda: anchor(P, target=(0, 0, 0), stiffness=np.ones(8)), ["'stiffness' [N/m]", "(8,)", "(9,)"]),
    (lambda: anchor(P, target=(0, 0, 0), stiffness=-1.0), ["stiffness = -1 N/m", "must be >= 0"]),
    (lambda: anchor(P, target=(0, 0, 0), stiffness=[1.0] * 8 + [-2.0]), ["stiffness[8] of element 8 = -2 N/m"]),
    (lambda: anchor(P, target=(0, math.inf, 0)), ["target[1] = inf", "must be finite"]),
    (lambda: anchor(P, target=(0, 0, 0), stiffness="soft"), ["'soft'", "must be a number"]),
    (lambda: SCENE.add(spring), ["spring is not bound to points", "scene.add(spring("]),
    (lambda: SCENE.add(CLOTH), ["must be an energy on points", "@stark.energy"]),
    (lambda: SCENE.add(spring(OTHER.edges)), ["'other' belongs to another scene"]),
    (lambda: SCENE.add(magnet(CLOTH.mesh.vertices, centre=(0, 0, 1))), ["magnet: 'p' got 9 fixed points of the world, such as (-0.2, -0.2, 0) m", "which nothing moves", "scene['sheet'].vertices"]),
    (lambda: SCENE.add(magnet((0, 0, 1), centre=(0, 0, 1))), ["magnet: 'p' got 1 fixed point of the world", "cloth.vertices or box.points(...)"]),
    (lambda: SCENE.add(spring(((0, 0, 0), (0, 0, 1)))), ["spring: 'e' got fixed points", "points of a body"]),
    (lambda: SCENE.add(upright(stark.world_frame())), ["upright: 'f' got", "which nothing moves"]),
    (lambda: P[[100]], ["out of bounds", "<9 points of 'sheet'>"]),
    (lambda: P[np.ones(8, bool)], ["<9 points of 'sheet'>"]),
    (lambda: stark.stencils(CLOTH, [0, 1]), ["shape (2,)", "(n, k)"]),
    (lambda: stark.stencils(CLOTH, [[0, 9]]), ["vertex 9: must be in [0, 9)"]),
    (lambda: stark.stencils(CLOTH, [[0.0, 1.0]]), ["float64", "must be integers"]),
    (lambda: BOX.points([[0.0, 1.0]]), ["'box': points", "shape (1, 2)", "(n, 3)"]),
    (lambda: CLOTH.embedded([8], (1, 0, 0)), ["element 8: must be in [0, 8)"]),
    (lambda: CLOTH.embedded([0, 1], np.ones((3, 3))), ["weights of shape (3, 3)", "(2, 3) or (3,)"]),
    (lambda: SCENE.add(tie(CLOTH.embedded([0], (0.5, 0.5, 0.5)), P[0])), ["weights of point 0 sum to 1.5"]),
]  # fmt: skip


@pytest.mark.parametrize("case", BOUND, ids=lambda case: case[1][0])
def test_bindings_that_are_refused(case: tuple) -> None:
    make, words = case
    with pytest.raises(InvalidArgument) as raised:
        make()
    assert all(word in str(raised.value) for word in words), raised.value


@stark.energy
def cone(p: stark.Point):
    guarded = stark.where(p.x0[2] > 5.0, 1.0 / (p.x0[2] * 0.0 + p.X[2]), 0.0)  # not taken
    d = p.x - p.x0
    height = p.x[2] + guarded
    return height + stark.norm(d)  # cone line


@stark.energy
def pole(p: stark.Point, k: float):
    z = p.x[2]
    return k / z  # pole line


@stark.energy
def no_length(e: stark.Edge):
    return e.vector[2] / (e.length - e.length)  # difference line


@stark.energy
def well(p: stark.Point, t: stark.Time, m: stark.Mat2):
    return t * stark.log(stark.determinant(m) + p.x[2])  # well line


@stark.energy
def edge_root(e: stark.Edge):
    return (e.length - e.rest_length) ** 1.5  # root line


NOT_FINITE = [
    (lambda: cone(P), ["cone: the force of element 0 is nan at time 0", "8 more", "p = (-0.2, -0.2, 0)", "the square root of 0", "# cone line"]),
    (lambda: no_length(CLOTH.edges[:2]), ["no_length: the energy of element 0 is", "a division by zero", "# difference line"]),
    (lambda: pole(P[3], k=1.0), ["pole: the energy of element 0 is inf at time 0", "a division by zero", "# pole line"]),
    (lambda: well(P[3], m=np.diag([1.0, -2.0])), ["well: the energy", "nan", "the logarithm of -2", "# well line"]),
    (lambda: edge_root(CLOTH.edges[:2]), ["edge_root:", "e[0] =", "e[1] =", "to the power 1.5", "# root line"]),
]  # fmt: skip


@pytest.mark.parametrize("case", NOT_FINITE, ids=lambda case: case[1][0])
def test_energies_that_are_not_finite_at_the_start(case: tuple) -> None:
    make, words = case
    with pytest.raises(InvalidArgument) as raised:
        SCENE.add(make())
    text = str(raised.value)
    assert all(word in text for word in [*words, "must be finite", __file__]), text
    assert SCENE.energies == ()


def test_the_rest_state_counts_too_where_a_body_starts_in_another_shape() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.4, 0.4, cells=2)
    cloth = scene.add_cloth(mesh, initial_positions=mesh.vertices * [1.1, 1.1, 1.0], position=(0, 0, 1.0))
    with pytest.raises(InvalidArgument, match="at rest"):
        scene.add(edge_root(cloth.edges))
    scene.add(spring(cloth.edges))
