"""Paths that users give, and memories that no file can hold: refused before anything is written."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import stark
from stark import reproducer


@pytest.fixture
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    made = stark.Simulation(scene)
    made.step()
    return made


@pytest.mark.parametrize("path", [None, 3, b"a", "", "a\0b", "a\ud800b", ["a"]])
@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda sim, path: sim.save(path), "save: path"),
        (lambda sim, path: sim.load(path), "load: path"),
        (lambda sim, path: sim.write_reproducer(path), "write_reproducer: folder"),
        (lambda sim, path: reproducer.load(path), "reproducer: path"),
        (lambda sim, path: stark.checkpoint.Checkpoint.read(path), "checkpoint: path"),
        (lambda sim, path: stark.checkpoint.Checkpoint.of(sim).write(path), "checkpoint: path"),
    ],
)
def test_what_is_no_path_is_refused(
    call: Callable[[Any, Any], Any],
    what: str,
    path: Any,
    sim: stark.Simulation,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(stark.InvalidArgument) as raised:
        call(sim, path)
    assert str(raised.value).startswith(f"{what} = {path!r}: must be ")
    assert list(tmp_path.iterdir()) == []


def test_the_current_folder_can_be_named(
    sim: stark.Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    sim.write_reproducer(".")
    sim.save("a b.stark")
    assert reproducer.load(tmp_path).time == 0.0 and sim.load(Path("a b.stark")) == {}


def _nested(depth: int) -> list[Any]:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


@pytest.mark.parametrize(
    ("memory", "message"),
    [
        ({"x": _nested(3000)}, r"nested deeper than 50 levels"),
        ({"x": threading.Lock()}, r"memory\['x'\] is a lock: must be a number"),
        ({"x": 10**5000}, r"memory\['x'\]: is an integer of 16610 bits"),
        ([1.0], r"memory is a list: must be a dictionary"),
        (0.0, r"memory is a float: must be a dictionary"),
    ],
)
def test_memories_that_no_file_can_hold(
    memory: Any, message: str, sim: stark.Simulation, tmp_path: Path
) -> None:
    with pytest.raises(stark.CheckpointError, match=message):
        sim.save(tmp_path / "a.stark", memory=memory)
    assert list(tmp_path.iterdir()) == []


def test_memories_may_hold_large_integers(sim: stark.Simulation, tmp_path: Path) -> None:
    sim.save(tmp_path / "a.stark", memory={"x": 10**4000})
    assert sim.load(tmp_path / "a.stark") == {"x": 10**4000}
