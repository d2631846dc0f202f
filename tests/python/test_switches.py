"""Switches are True or False: any other text, "no" among them, counted as True."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import stark
from stark import motion, scenes
from stark.recording import Recorder

TURNS = [(1, 0, 0, 0), (1, 0.1, 0, 0)]


def simulation() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    return stark.Simulation(scene)


def load(path: Path) -> None:
    sim = simulation()
    sim.step()
    sim.save(path / "state.stark")
    sim.load(path / "state.stark", exact="no")  # type: ignore[arg-type]


def reproduce(path: Path) -> None:
    sim = simulation()
    sim.step()
    sim.write_reproducer(path / "step", reduce="no")  # type: ignore[arg-type]


WRONG: dict[str, Callable[[Path], Any]] = {
    "exact": load,
    "reduce": reproduce,
    "spline: rest": lambda path: motion.spline([0, 1], [0, 1], rest="no"),  # type: ignore[arg-type]
    "rotations: rest": lambda path: motion.rotations([0, 1], TURNS, rest="no"),  # type: ignore[arg-type]
    "rotations: smooth": lambda path: motion.rotations([0, 1], TURNS, smooth="no"),  # type: ignore[arg-type]
    "point_cache: smooth": lambda path: motion.point_cache("x.pc2", smooth="no"),  # type: ignore[arg-type]
    "usd_mesh: smooth": lambda path: motion.usd_mesh("x.usdc", smooth="no"),  # type: ignore[arg-type]
    "objective": lambda path: stark.material(objective="no"),  # type: ignore[call-overload]
    "stress_free": lambda path: stark.material(stress_free="no"),  # type: ignore[call-overload]
    "isotropic": lambda path: stark.material(isotropic="no"),  # type: ignore[call-overload]
    "translation_invariant": lambda path: stark.energy(translation_invariant="no"),  # type: ignore[call-overload]
    "certify": lambda path: Recorder(path / "run", simulation(), certify="no"),  # type: ignore[arg-type]
    "contacts": lambda path: Recorder(path / "run", simulation(), contacts="no"),  # type: ignore[arg-type]
    **{
        f"run: {name}": lambda path, name=name: scenes.run("hello_cloth", out=path / "run", **{name: "no"})
        for name in ("replay", "picture", "check", "certify", "contacts")
    },
}


@pytest.mark.parametrize("name", WRONG)
def test_a_text_is_no_switch(name: str, tmp_path: Path) -> None:
    with pytest.raises(stark.InvalidArgument, match=rf"{name}.* = 'no': must be True or False"):
        WRONG[name](tmp_path)
    assert not (tmp_path / "run").exists() and not (tmp_path / "step").exists()


def test_ones_and_zeros_are_switches() -> None:
    assert motion.spline([0, 1], [0, 1], rest=0)(0.5) == pytest.approx(0.5)  # type: ignore[arg-type]
