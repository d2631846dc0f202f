"""Arguments of energies: what annotations make of them, clocks, names that are taken."""

from __future__ import annotations

import functools
from typing import Annotated, Any

import numpy as np
import pytest
from _scenes import sheet

import stark
from stark.formulas.arguments import ClockArgument, FrameArgument, PointArgument, read_arguments
from stark.formulas.parameters import Parameter

ZEROS = np.zeros((2, 3))
NAMES = {"stark": stark, "Annotated": Annotated, "ZEROS": ZEROS}


def read(function: Any) -> list[Any]:
    return read_arguments(function, "sample", NAMES, frozenset({"forces"}))[1]


def test_annotations_say_what_arguments_are() -> None:
    def sample(
        p: stark.Point,
        e: stark.Edge,
        s: Annotated[stark.Stencil, 5],
        f: stark.Frame,
        t: stark.Time,
        h: stark.TimeStep,
        k: float,
        n: int,
        v: stark.Vec3,
        A: Annotated[stark.Mat, 2, 3] = stark.parameter(ZEROS, unit="N"),
    ): ...

    p, e, s, f, t, h, k, n, v, A = read(sample)
    assert all(isinstance(a, PointArgument) for a in (p, e, s))
    assert [a.noun for a in (p, e)] == ["a point", "an edge of 2 points"] and s.kind.point_count == 5
    assert f == FrameArgument("f")
    assert (t, h) == (ClockArgument("t", "time"), ClockArgument("h", "time_step"))
    assert all(isinstance(a, Parameter) for a in (k, n, v, A))
    assert [(a.shape, a.width) for a in (k, n, v, A)] == [((), 1), ((), 1), ((3,), 3), ((2, 3), 6)]
    assert (k.unit, A.unit) == ("1", "N") and k.declaration.default is None
    assert A.declaration.default is ZEROS


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("p: stark.Point, k", "'k' has no annotation: must be stark.Point"),
        ("p: stark.Point, k: str", "annotation <class 'str'>"),
        ("p: stark.Point, s: stark.Stencil", r"write stark\.Stencil\[k\]"),
        ("p: stark.Point, forces: float", "must not be called 'forces'"),
        ("p: stark.Point, *k: float", "number of arguments must be fixed"),
        ("k: float", "no argument is a point, a stencil or a frame"),
        ("p: stark.Point, k: missing", "'missing' is not defined"),
    ],
)
def test_arguments_that_cannot_be_read_are_refused(arguments: str, message: str) -> None:
    names = dict(NAMES)
    exec(f"from __future__ import annotations\ndef sample({arguments}): ...", names)
    with pytest.raises(stark.TraceError, match=message):
        read(names["sample"])


@pytest.mark.parametrize("what", [3, "magnet", dict, functools.partial(max, 1)])
@pytest.mark.parametrize(
    "decorator", [stark.energy, stark.joint, stark.actuator, stark.material, stark.symbolic.function]
)
def test_decorators_of_anything_but_functions_say_so(decorator: Any, what: object) -> None:
    with pytest.raises(stark.InvalidArgument, match="must be a function; write the decorator above a def"):
        decorator(what)


def test_time_and_time_step_are_those_of_the_step() -> None:
    """An energy linear in x whose factor is the clock: its force is minus the clock."""

    @stark.energy
    def clocks(p: stark.Point, t: stark.Time, h: stark.TimeStep):
        return t * p.x[0] + h * p.x[1]

    scene, cloth = sheet(1)
    handle = scene.add(clocks(cloth.vertices))
    sim = stark.Simulation(scene, time_step=0.004)
    for k in (1, 2, 3):
        sim.step()
        expected = np.tile([-0.004 * k, -0.004, 0.0], (4, 1))
        assert np.allclose(handle.forces[:, 0], expected, rtol=1e-12, atol=1e-16)
