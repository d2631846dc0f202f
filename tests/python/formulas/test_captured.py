"""Numbers that formulas take from around their functions, and what happens where they change."""

from __future__ import annotations

import functools
import warnings
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stark
from stark.formulas.captured import captured, changed

STIFFNESS = 1.0
TABLE: dict[str, Any] = {"k": [1.0, 2.0]}
MODULUS = 1e4


def stiffness() -> float:
    return STIFFNESS


@stark.energy
def well(p: stark.Point):
    return stiffness() * TABLE["k"][0] * (p.x @ p.x)


@stark.material
def law(F: stark.DeformationGradient, bulk: float = 1e5):
    J = stark.determinant(F)
    return MODULUS / 2 * (stark.squared_norm(F) - 3) - MODULUS * stark.log(J) + bulk / 2 * stark.pow(J - 1, 2)


def energy_of_sheet(bind: Any) -> float:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.4, 0.4, 2), pins=range(9))
    energy = scene.add(bind(sheet.vertices))
    sim = stark.Simulation(scene)
    sim.step()
    return float(energy.energy)


def test_an_energy_takes_the_numbers_of_the_time_when_it_is_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also those of functions that it calls, and in lists."""
    first = energy_of_sheet(well)
    monkeypatch.setitem(globals(), "STIFFNESS", 5.0)
    assert energy_of_sheet(well) == pytest.approx(5.0 * first, rel=1e-12)
    monkeypatch.setitem(TABLE, "k", [3.0, 2.0])
    assert energy_of_sheet(well) == pytest.approx(15.0 * first, rel=1e-12)


def test_an_energy_keeps_what_it_was_bound_with() -> None:
    factor = 1.0

    @stark.energy
    def pull(p: stark.Point):
        return factor * (p.x @ p.x)

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.4, 0.4, 2), pins=range(9))
    weak = scene.add(pull(sheet.vertices))
    factor = 5.0
    strong = scene.add(pull(sheet.vertices))
    sim = stark.Simulation(scene)
    sim.step()
    assert strong.energy == pytest.approx(5.0 * weak.energy, rel=1e-12)


def test_nothing_is_recorded_again_without_a_change() -> None:
    assert well.trace() is well.trace()


def test_a_law_says_that_it_keeps_its_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        law(density=1000.0)
        law(density=900.0)
    monkeypatch.setitem(globals(), "MODULUS", 5e4)
    with pytest.warns(stark.StarkWarning, match="law: 'MODULUS' changed after the law was recorded"):
        law(density=1000.0)


def test_what_is_told_apart() -> None:
    held = SimpleNamespace(k=1.0, table=np.ones(3))
    later: Any

    def function() -> Any:
        return [held.k * held.table[i] for i in range(3)], later, np.pi

    before = captured(function)
    assert before == captured(function)
    held.table[1] = 2.0
    assert changed(before, captured(function)) == ["held"]
    later = {"a": (1.0, True)}
    assert changed(before, captured(function)) == ["held", "later"]


@stark.actuator
def coil(c: stark.Coordinate):
    return stiffness() / 2 * c.q**2


@stark.joint
def distance(a: stark.Frame, b: stark.Frame):
    return stark.hold(length=stark.norm(b.origin - a.origin) - STIFFNESS)


def test_actuators_and_joints_say_that_they_keep_their_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are recorded where they are defined, and kept what they found there without a word."""
    scene = stark.Scene()
    wheel = scene.add_box(0.1, mass=1.0, position=(1.0, 0.0, 0.0))
    axle = scene.add_hinge(None, wheel, anchor=(1.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        axle.add_actuator(coil)
        scene.add_joint(distance, stark.world_frame(), wheel.frame())
    monkeypatch.setitem(globals(), "STIFFNESS", 5.0)
    with pytest.warns(stark.StarkWarning, match="coil: 'stiffness' changed after the actuator was recorded"):
        axle.add_actuator(coil)
    with pytest.warns(stark.StarkWarning, match="distance: 'STIFFNESS' changed after the joint was recorded"):
        scene.add_joint(distance, stark.world_frame(), wheel.frame())


class Numbers:
    modulus = 1.0


class Slotted:
    __slots__ = ("modulus",)


@stark.energy
def of_a_class(p: stark.Point):
    return Numbers.modulus * (p.x @ p.x)


@pytest.mark.parametrize("kind", ["class", "module", "slots", "within another"])
def test_an_energy_takes_the_attributes_of_the_time_when_it_is_bound(kind: str) -> None:
    """Of classes, modules and whatever has no `__dict__`, later bindings kept the first numbers."""
    module, slotted = ModuleType("numbers_of_the_user"), Slotted()
    owner: Any = {"class": type("Owner", (), {}), "module": module, "slots": slotted}.get(kind, Numbers())
    holder = SimpleNamespace(part=SimpleNamespace(owner=owner))
    owner.modulus = 1.0

    @stark.energy
    def direct(p: stark.Point):
        return owner.modulus * (p.x @ p.x)

    @stark.energy
    def nested(p: stark.Point):
        return holder.part.owner.modulus * (p.x @ p.x)

    law = nested if kind == "within another" else direct
    first = energy_of_sheet(law)
    owner.modulus = 5.0
    assert energy_of_sheet(law) == pytest.approx(5.0 * first, rel=1e-12)


def test_an_energy_takes_what_callables_hold() -> None:
    """Of partial functions and objects with lists, later bindings kept the first numbers."""

    class Table:
        def __init__(self) -> None:
            self.values = [1.0]

        def __call__(self, x: Any) -> Any:
            return self.values[0] * x

    table, scaled = Table(), functools.partial(lambda k, x: k * x, 1.0)

    @stark.energy
    def both(p: stark.Point):
        return scaled(table(p.x @ p.x))

    first = energy_of_sheet(both)
    table.values[0] = 2.0
    assert energy_of_sheet(both) == pytest.approx(2.0 * first, rel=1e-12)
    scaled = functools.partial(lambda k, x: k * x, 3.0)
    assert energy_of_sheet(both) == pytest.approx(6.0 * first, rel=1e-12)


def test_names_of_attributes_are_not_those_of_variables(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that writes `F.T` warned of changes of a variable `T`, which it does not use."""

    @stark.material
    def transposed(F: stark.DeformationGradient, mu: float = 1e4, bulk: float = 1e5):
        J = stark.determinant(F)
        return mu / 2 * (stark.trace(F.T @ F) - 3) - mu * stark.log(J) + bulk / 2 * stark.pow(J - 1, 2)

    monkeypatch.setitem(globals(), "T", 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        transposed(density=1000.0)
        monkeypatch.setitem(globals(), "T", 2.0)
        transposed(density=1000.0)
    monkeypatch.setattr(Numbers, "modulus", 1.0)
    before = captured(of_a_class.function)
    monkeypatch.setattr(Numbers, "modulus", 2.0)
    assert changed(before, captured(of_a_class.function)) == ["Numbers.modulus"]
