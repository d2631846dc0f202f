"""Errors of reproducers: one kind, with the folder in its message."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

import stark
from stark import reproducer


def stepped() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    sim = stark.Simulation(scene)
    sim.step()
    return sim


def test_a_folder_without_a_reproducer_is_named(tmp_path: Path) -> None:
    for folder in (tmp_path / "nowhere", tmp_path):
        with pytest.raises(stark.ReproducerError, match=folder.name):
            reproducer.load(folder)


def test_every_file_of_the_folder_is_needed(tmp_path: Path) -> None:
    names = [path.name for path in stepped().write_reproducer(tmp_path / "all").parent.iterdir()]
    assert len(names) >= 2
    for name in (name for name in names if not name.endswith(".py")):
        folder = tmp_path / f"without {name}"
        stepped().write_reproducer(folder)
        (folder / name).unlink()
        with pytest.raises(stark.ReproducerError) as caught:
            reproducer.load(folder)
        assert name in str(caught.value) or folder.name in str(caught.value)


def test_a_reproducer_error_is_bad_input_and_can_be_sent_between_processes() -> None:
    assert issubclass(stark.ReproducerError, stark.InvalidArgument)
    assert issubclass(stark.ReproducerError, ValueError)
    again = pickle.loads(pickle.dumps(stark.ReproducerError("'a': no step was taken")))
    assert type(again) is stark.ReproducerError and "no step" in str(again)
