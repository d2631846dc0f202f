"""Energies that are in a scene twice, and others that only look so."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark
from stark.formulas.twins import twin_warnings


@stark.energy
def lift(p: stark.Point, force: float = 1.0):
    return -force * p.x[2]


@stark.energy
def tie(p: stark.Point, f: stark.Frame, stiffness: float = 10.0):
    return 0.5 * stiffness * stark.squared_norm(p.x - f.origin)


def said(scene: stark.Scene) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        stark.Simulation(scene)
    return [str(each.message) for each in caught if "once more" in str(each.message)]


def box() -> tuple[stark.Scene, stark.RigidBody]:
    scene = stark.Scene()
    return scene, scene.add_box(0.1, mass=1.0, name="box")


def test_a_cell_that_ran_twice_doubles_the_force() -> None:
    accelerations = []
    for runs in (1, 2):
        scene, body = box()
        for _ in range(runs):
            scene.add(lift(body.points((0, 0, 0)), force=3.0))
        texts = said(scene)
        sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
        sim.step()
        accelerations.append(sim[body].velocity[2] / 0.01)
        assert len(texts) == runs - 1
    assert accelerations == pytest.approx([3.0, 6.0])
    assert "energy 'lift_2' is 'lift' once more" in texts[0] and "leave one out" in texts[0]


def test_the_formula_may_be_defined_anew() -> None:
    scene, body = box()
    for _ in range(2):

        @stark.energy
        def lift(p: stark.Point, force: float = 1.0):
            return -force * p.x[2]

        scene.add(lift(body.points([(0, 0, 0), (0.01, 0, 0)]), force=[1.0, 2.0]))
    assert len(said(scene)) == 1


def test_loads_and_frames() -> None:
    scene, body = box()
    other = scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    for _ in range(2):
        scene.add_force(body, (0, 0, 1.0))
        scene.add(tie(body.points((0, 0, 0.05)), other.frame((0, 0, 0.1))))
    texts = said(scene)
    assert len(texts) == 2 and all("once more" in text for text in texts)


def test_those_that_differ_are_not_warned_of() -> None:
    scene, body = box()
    other = scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    scene.add(lift(body.points((0, 0, 0))))
    scene.add(lift(body.points((0, 0, 0)), force=2.0))
    scene.add(lift(body.points((0, 0, 0.01))))
    scene.add(lift(other.points((0, 0, 0))))
    scene.add(lift(body.points((0, 0, 0))), name="meant")
    scene.add(tie(body.points((0, 0, 0)), other.frame((0, 0, 0.1))))
    scene.add(tie(body.points((0, 0, 0)), other.frame((0, 0, 0.2))))
    for _ in range(2):
        scene.add_force(body, (0, 0, 0))  # to be set in the loop
    for axis in range(2):
        wind = scene.add_force(body, (0, 0, 0))
        wind.force = lambda t, axis=axis: np.eye(3)[axis] * np.cos(t)
    assert said(scene) == []
    assert twin_warnings([], ()) == []
