"""Every packaged scene has the same bits with 1, 2 and 5 threads, stopped and resumed or not."""

from __future__ import annotations

from pathlib import Path

import pytest

import stark
from stark import scenes

#: The last step, taken again when a checkpoint is loaded, must have the same bits.
pytestmark = pytest.mark.filterwarnings("error:the last step:stark.StarkWarning")

#: Steps to the checkpoint and after it: into contact, as far as that does not take minutes.
_SHORT = {"rigid_pile_27": (10, 5), "stack": (3, 2), "hello_cloth": (4, 3), "spinning_box_cloth_32": (4, 3)}
_LONG = {
    "cloth_sphere_floor_60": (4, 3),
    "drape": (12, 3),
    "drop": (10, 3),
    "hanging_cloth_50": (10, 5),
    "hello_cloth": (30, 10),
    "rigid_pile_27": (30, 20),
    "soft_box_drop_20": (3, 2),
    "soft_column": (2, 2),
    "soft_column_6": (2, 2),
    "soft_drop": (4, 2),
    "spinning_box_cloth_128": (1, 1),
    "spinning_box_cloth_32": (15, 10),
    "spinning_box_cloth_64": (3, 2),
    "stack": (10, 10),
}


def make(name: str, threads: int) -> tuple[scenes.SceneFile, stark.Simulation]:
    scene_file = scenes.load(name)
    try:
        built, settings = scene_file.build()
    except ImportError as error:
        pytest.skip(str(error))
    return scene_file, stark.Simulation(built, **{**settings, "threads": threads})


def advance(scene_file: scenes.SceneFile, sim: stark.Simulation, steps: int) -> list[str]:
    hashes = []
    for _ in range(steps):
        scene_file.drive(sim)
        report = sim.step()
        assert not report.failed, report.message
        hashes.append(sim.state.hash)
    return hashes


def compare(name: str, steps: tuple[int, int], folder: Path) -> None:
    path = folder / "half.stark"
    scene_file, sim = make(name, 1)
    start = advance(scene_file, sim, steps[0])
    sim.save(path)
    rest = advance(scene_file, sim, steps[1])
    for threads in (1, 2, 5):
        scene_file, resumed = make(name, threads)
        resumed.load(path)
        assert advance(scene_file, resumed, steps[1]) == rest, f"resumed with {threads} threads"
    for threads in (2, 5):
        assert advance(*make(name, threads), steps[0]) == start, f"with {threads} threads"


@pytest.mark.parametrize("name", _SHORT)
def test_bits(name: str, tmp_path: Path) -> None:
    compare(name, _SHORT[name], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", scenes.names())
def test_bits_of_all(name: str, tmp_path: Path) -> None:
    compare(name, _LONG[name], tmp_path)
