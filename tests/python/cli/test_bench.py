"""``stark bench``: the line of numbers, intersections, the calibration."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from _commands import command

from stark.cli.bench import RULES, calibrate, measure, rule_settings

_BENCH_KEYS = [
    "scene", "rule", "threads", "sim_s", "wall_s", "cpu_s", "calib_s", "ratio", "steps", "newton_iterations",
    "linear_iterations", "factorizations", "rejected_steps", "dofs", "max_residual_n", "min_distance_m",
    "intersections", "state_hash", "phases", "observables",
]  # fmt: skip


def test_bench_line(fall: Path, capsys) -> None:
    assert command("bench", fall, "--json") == 0
    line = json.loads(capsys.readouterr().out)
    assert set(_BENCH_KEYS) <= set(line)
    assert (line["scene"], line["steps"], line["dofs"], line["threads"]) == ("fall", 10, 27, 1)
    assert line["ratio"] == pytest.approx(line["cpu_s"] / line["calib_s"], rel=0.01, abs=0.02)
    assert line["sim_s"] == pytest.approx(0.1)
    assert line["min_distance_m"] is None
    assert re.fullmatch("[0-9a-f]{16}", line["state_hash"])
    assert line["observables"]["z"] == pytest.approx(-0.054, rel=0.01)
    assert command("bench", fall, "--json", "--threads", 2) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["threads"] == 2 and again["state_hash"] == line["state_hash"]
    assert command("bench", fall) == 0
    assert "newton_iterations" in capsys.readouterr().out


def test_rules_say_when_steps_end() -> None:
    """By the residual alone steps are as exact as was asked; by the other rules corrections may end them."""
    scene, step = "hanging_cloth_50", 1.0 / 30.0
    rows = {rule: measure(scene, {}, until=0.2, check=False, rule=rule) for rule in RULES}
    assert rows["residual"]["max_residual_n"] < 1e-6 / step < rows["any"]["max_residual_n"]
    assert rows["any"]["state_hash"] == rows["scene"]["state_hash"]  # the scene's own is that rule
    assert rows["residual"]["newton_iterations"] > rows["any"]["newton_iterations"]
    nudged = measure(scene, {}, until=0.2, check=False, nudges=1)
    assert nudged["state_hash"] != rows["residual"]["state_hash"]
    height = [row["observables"]["z_mean"] for row in (nudged, rows["residual"])]
    assert height[0] == pytest.approx(height[1], abs=1e-8)
    assert rule_settings("scene", step) == {}


def test_bench_takes_options(fall: Path, tmp_path: Path, capsys) -> None:
    path = tmp_path / "chosen.py"
    text = fall.read_text().replace("def build():", "options = {'size': 1}\n\n\ndef build():")
    path.write_text(text)
    assert command("bench", path, "--json", "--no-check", "--option", "size=2") == 0
    assert json.loads(capsys.readouterr().out)["scene"] == "chosen_2"
    assert command("bench", path, "--option", "size") == 2
    assert "must be NAME=VALUE" in capsys.readouterr().err


def test_bench_finds_intersections(tmp_path: Path, capsys) -> None:
    """Two patches that cross without contact: the independent check must see it in every state."""
    pytest.importorskip("ipctk")
    path = tmp_path / "cross.py"
    path.write_text(
        """
import stark
until = 0.03
def build():
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.1, 0.1, cells=2)
    scene.add_cloth(mesh, stark.materials.cotton, name="a")
    turn = stark.rotation(axis="x", angle=80 * stark.deg)
    scene.add_cloth(mesh, stark.materials.cotton, name="b", rotation=turn, position=(0.01, 0.013, 0.0))
    return scene, {"time_step": 0.01, "contact.enabled": False}
"""
    )
    assert command("bench", path, "--json") == 0
    assert json.loads(capsys.readouterr().out)["intersections"] == 3


def test_calibration_is_stable() -> None:
    first, second = calibrate(), calibrate()
    assert 0.01 < first < 5.0
    assert 0.4 < first / second < 2.5
