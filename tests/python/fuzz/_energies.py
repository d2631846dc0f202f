"""Energies of users: random formulas of all kinds of elements, with constants that go wrong. Each is refused,
or acts in a step that is accepted or fails with a message."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from _draw import Draw

import stark
from stark import materials, mesh

_CONSTANTS = (0.5, 1.0, 2.0, -1.0, 3, 0, 0.0, 1e-3, 1e3)
_ODD = (1e308, -1e308, 5e-324, float("inf"), float("nan"), 1e16, 2**70, 10**400, True, None, "1", 1j, [1.0])

_UNARY = ("sqrt", "exp", "log", "sin", "cos", "tan", "atan", "tanh", "abs", "neg", "square", "cube")
_BINARY = ("+", "-", "*", "/", "**", "minimum", "maximum", "atan2", "where")


class Formula:
    """A tree of operations, drawn once and applied to whatever it is given."""

    def __init__(self, draw: Draw, depth: int = 4) -> None:
        kind = draw.integer(4) if depth > 0 else 0
        self.parts: list[Formula] = []
        if kind == 0:
            self.operation, self.value = "leaf", draw.integer(16)
        elif kind == 1:
            self.operation = "constant"
            self.value = draw.value(draw.pick(_CONSTANTS), _ODD)
        elif kind == 2:
            self.operation, self.parts = draw.pick(_UNARY), [Formula(draw, depth - 1)]
        else:
            self.operation = draw.pick(_BINARY)
            self.parts = [Formula(draw, depth - 1), Formula(draw, depth - 1)]

    def of(self, leaves: list[Any]) -> Any:
        if self.operation == "leaf":
            return leaves[self.value % len(leaves)]
        if self.operation == "constant":
            return self.value
        a, *rest = (part.of(leaves) for part in self.parts)
        b = rest[0] if rest else None
        return _applied(self.operation, a, b)

    def __repr__(self) -> str:
        if self.operation in ("leaf", "constant"):
            return f"{self.operation} {self.value!r:.40}"
        return f"{self.operation}({', '.join(map(repr, self.parts))})"


def _applied(operation: str, a: Any, b: Any) -> Any:
    plain = {
        "neg": lambda: -a,
        "square": lambda: a * a,
        "cube": lambda: a**3,
        "+": lambda: a + b,
        "-": lambda: a - b,
        "*": lambda: a * b,
        "/": lambda: a / b,
        "**": lambda: a**b,
        "where": lambda: stark.where(a < b, a, b),
    }
    if operation in plain:
        return plain[operation]()
    function = getattr(stark, operation)
    return function(a) if b is None else function(a, b)


def _leaves(element: Any) -> list[Any]:
    """Numbers of an element."""
    if hasattr(element, "length"):
        return [element.length, element.rest_length, element.length_prev, element.vector[2]]
    if hasattr(element, "volume"):
        return [element.volume, element.F[0, 0], stark.determinant(element.F), element.F[1, 2]]
    if hasattr(element, "area"):
        return [element.area, element.normal[2], element.F[0, 1], element.center[0]]
    return [element.x[2], element.x @ element.x, element.v[0], element.X[1], element.x_prev[2]]


_KINDS = (stark.Point, stark.Edge, stark.Triangle, stark.Tetrahedron)


def energies(draw: Draw) -> None:
    """One energy of a cloth or a solid, added to its scene and stepped."""
    kind = draw.pick(_KINDS)
    formula, scale = Formula(draw), draw.value(1e-6)

    def random_energy(element: Any, stiffness: float = 1.0) -> Any:
        return stiffness * formula.of(_leaves(element))

    random_energy.__annotations__ = {"element": kind, "stiffness": float}
    draw.trace.append(f"{kind.__name__}: {formula!r}")
    scene = stark.Scene()
    cloth = scene.add_cloth(mesh.grid(1.0, 1.0, 2), materials.cotton, pins=[0])
    solid = scene.add_solid(mesh.tet_box(0.5, 1), position=(0.0, 0.0, 1.0))
    on = {"Point": cloth.vertices, "Edge": cloth.edges, "Triangle": cloth.faces}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            scene.add(stark.energy(random_energy)(on.get(kind.__name__, solid.tetrahedra), stiffness=scale))
            settings = {"newton.max_iterations": 8, "time.min_step": 0.004, "execution.threads": 1}
            sim = stark.Simulation(scene, settings, time_step=0.01)
            report = sim.step()
            assert (
                report.message if report.failed else np.isfinite(sim.state.arrays()["point_position"]).all()
            )
        except stark.InternalError:
            raise
        except (stark.Error, ZeroDivisionError, OverflowError, TypeError, ValueError) as error:
            # Python computes constants itself, and says what is wrong with them.
            assert isinstance(error, stark.Error) or not _is_traced(error), error
            draw.trace.append(f"-> {str(error)[:160]}")


def _is_traced(error: BaseException) -> bool:
    """Whether the error was raised within Stark, not by Python's own arithmetic in the formula."""
    trace, last = error.__traceback__, ""
    while trace is not None:
        last = trace.tb_frame.f_code.co_filename
        trace = trace.tb_next
    return "_energies.py" not in last
