"""The experiments of the paper, made small: a hand with a cup and two balls, a robot and a coarse towel."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import scenes
from stark.recording import Recording
from stark.study import Plan

EXAMPLES = Path(__file__).parents[3] / "examples"


def run(example: str, folder: Path, until: float, **options: Any) -> tuple[Any, Recording]:
    """The module of an example and a recording of its run."""
    scene = scenes.load(EXAMPLES / f"{example}.py", options)
    result = scenes.run(scene, out=folder, until=until, replay=False, picture=False, fps=20)
    assert result.status == "complete", result.message
    return scene.module, Recording(folder)


@pytest.mark.slow
def test_the_hand_holds_a_cup_with_two_balls(tmp_path: Path) -> None:
    cup, recording = run("cup", tmp_path / "run", 3.75, balls=2, cells=8)
    cup.check(recording)  # grip, balance, weight that the pads carry, balls inside, no creep
    assert cup.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 5
    assert cup.draw(recording, tmp_path / "cup.png").stat().st_size > 10_000


@pytest.mark.slow
def test_the_robot_meets_a_towel(tmp_path: Path) -> None:
    robot_towel, recording = run("robot_towel", tmp_path / "run", 2.1, cells=26)
    series = {name.removeprefix("measured."): recording.telemetry[name] for name in recording.telemetry.names}
    met = int(np.argmax(np.abs(series["push"]) > 0.01))
    # Until then it has reached the speed of its motors; the front caster is the first to touch the edge.
    robot = robot_towel.robot
    assert series["speed"][met - 1] == pytest.approx(robot.SPEED * robot.WHEEL_RADIUS, rel=0.01)
    reach = robot.CASTER_Y["front"] + robot.CASTER_RADIUS
    assert robot_towel.FRONT - reach - 0.01 < series["y"][met] < robot_towel.FRONT - robot.CASTER_Y["front"]
    # Carpet holds the towel: 4.75 N of friction against 3.8 N of the motors.
    assert abs(series["towel_y"][-1] - series["towel_y"][0]) < 1e-3
    assert robot_towel.results(recording)["torque"] <= robot.TORQUE * (1.0 + 1e-9)
    assert robot_towel.plot(recording, tmp_path / "curves.svg").read_text().count("<polyline") == 8


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")  # of curves that stay at 0
def test_a_study_of_robot_and_towel_is_drawn_and_tabled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    module = runpy.run_path(str(EXAMPLES / "robot_towel_sheet.py"))
    plan = Plan(
        str(EXAMPLES / "robot_towel.py"), [{"towel": "flat", "floor": "carpet", "cells": 26}], until=0.12
    )
    study = stark.study.run(plan, tmp_path / "study", processes=1)
    # At the start it stands in front of the towel, at a speed of zero.
    assert module["table"](study).splitlines()[2].startswith("| flat | carpet | over | stuck | -0.")
    picture = stark.render.read_png(module["sheet"](study, tmp_path / "outcomes.png"))
    assert picture.shape[:2] == (module["HEIGHT"], 2 * module["WIDTH"])
    half = picture[:, : module["WIDTH"]].reshape(-1, 3)
    assert len(np.unique(half, axis=0)) > 100  # floor, towel, robot, title; the other floor is left blank
    assert (picture[:, module["WIDTH"] :] == 255).all()
    shown, curves = module["sequence"](study, "flat", "carpet", tmp_path)
    assert stark.render.read_png(shown).shape[:2] == (2 * module["HEIGHT"], 2 * module["WIDTH"])
    assert curves.read_text().count("<polyline") == 8


@pytest.mark.parametrize("cells", [52, 100])
def test_the_towel_folded_three_times_is_that_of_its_program(cells: int) -> None:
    """The file is what the sources beside it make: eight layers that do not intersect, with the area of the
    towel."""
    towel = scenes.load(EXAMPLES / "robot_towel.py").module.towel
    assert str(np.load(towel.folded_file(cells))["made_by"]) == towel.recipe()
    mesh = towel.mesh(cells)
    folded, open_side = (towel.placed(cells, f"three_folds_{side}") for side in ("folded", "open"))
    assert np.ptp(folded, axis=0) == pytest.approx(np.ptp(open_side, axis=0))
    across, deep, high = np.ptp(folded, axis=0)
    assert 0.36 < across < 0.40 and 0.35 < deep < 0.40  # [m], a half of 0.75 and about a quarter of 1.35
    assert 7.0 * towel.PITCH * 0.9 < high < 0.06
    middle = folded[np.linalg.norm(folded[:, :2] - [0.0, 0.5 * deep], axis=1) < 0.04, 2]
    layers = np.split(np.sort(middle), np.flatnonzero(np.diff(np.sort(middle)) > 2e-3) + 1)
    assert len(layers) == 8  # a tenth nearer than without their weight
    assert np.diff([layer.mean() for layer in layers]) == pytest.approx(0.91 * towel.PITCH, rel=0.05)
    areas = [
        np.linalg.norm(np.cross(*np.diff(x[mesh.triangles], axis=1).transpose(1, 0, 2)), axis=1).sum() / 2.0
        for x in (mesh.vertices, folded)
    ]
    assert areas[1] == pytest.approx(areas[0], rel=0.02)
    ipctk = pytest.importorskip("ipctk")
    faces = np.asarray(mesh.triangles, dtype=np.int32)
    surface = ipctk.CollisionMesh(mesh.vertices, ipctk.edges(faces), faces)
    for points in (folded, open_side):
        assert not ipctk.has_intersections(surface, points)


@pytest.mark.parametrize(
    ("configuration", "cells"),
    [
        *((name, cells) for name in ("flat", "one_fold", "two_folds") for cells in (52, 100)),
        *((name, 100) for name in ("roll_rolled", "roll_open", "roll_side")),
    ],
)
def test_folding_keeps_lengths(configuration: str, cells: int) -> None:
    towel = scenes.load(EXAMPLES / "robot_towel.py").module.towel
    mesh, points = towel.mesh(cells), towel.placed(cells, configuration)
    edges = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    lengths = [np.linalg.norm(np.diff(x[edges], axis=1)[:, 0], axis=1) for x in (mesh.vertices, points)]
    assert lengths[1] == pytest.approx(lengths[0], rel=1e-6)
    assert points[:, 1:].min(axis=0) == pytest.approx(0.0)
