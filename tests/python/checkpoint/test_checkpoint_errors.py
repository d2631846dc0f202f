"""Errors of checkpoints: every way to fail raises one kind, with the file in its message."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

import stark


def simulation(boxes: int = 1) -> stark.Simulation:
    scene = stark.Scene()
    for k in range(boxes):
        scene.add_box(0.1, mass=1.0, position=(k, 0, 0))
    return stark.Simulation(scene)


def missing(path: Path) -> None:
    path.unlink()


def empty(path: Path) -> None:
    path.write_bytes(b"")


def shortened(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def other_scene(path: Path) -> None:
    path.unlink()
    simulation(2).save(path)


@pytest.mark.parametrize("spoil", [missing, empty, shortened, other_scene])
def test_what_cannot_be_loaded_raises_a_checkpoint_error_with_the_file(
    spoil: Callable[[Path], None], tmp_path: Path
) -> None:
    path = tmp_path / "settled.stark"
    simulation().save(path)
    spoil(path)
    sim = simulation()
    before = sim["box"].position.tolist()
    with pytest.raises(stark.CheckpointError) as caught:
        sim.load(path)
    assert "settled.stark" in str(caught.value)
    assert sim["box"].position.tolist() == before and not sim.step().failed


def test_a_checkpoint_error_is_bad_input_and_can_be_sent_between_processes() -> None:
    assert issubclass(stark.CheckpointError, stark.InvalidArgument)
    assert issubclass(stark.CheckpointError, ValueError)
    assert not issubclass(stark.CheckpointError, stark.ReproducerError)
    again = pickle.loads(pickle.dumps(stark.CheckpointError("'a.stark': is too short")))
    assert type(again) is stark.CheckpointError and "too short" in str(again)
