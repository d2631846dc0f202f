"""Scenes to documents and back: the same bits; what cannot be saved is refused before anything is written."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from _everything import everything

import stark
from stark import document

SETTINGS = {"time_step": 0.01, "newton.max_seconds": np.inf, "gravity": (0.0, 0.1, -9.0)}


def test_a_scene_of_everything_gives_the_same_bits(tmp_path: Path) -> None:
    scene = everything()
    assert scene.save(tmp_path / "a.json", settings=SETTINGS, until=1.5, description="All.").name == "a.json"
    read = document.read(tmp_path / "a.json")
    assert (read.until, read.description, read.scene.name) == (1.5, "All.", "everything")
    before, after = stark.Simulation(scene, **SETTINGS), stark.Simulation(read.scene, **read.settings)
    assert before.settings.to_dict() == after.settings.to_dict()
    assert before._core.parts() == after._core.parts()
    for _ in range(3):
        assert not before.step().failed
        after.step()
        assert before.state.hash == after.state.hash


def test_a_loaded_scene_can_be_saved_again(tmp_path: Path) -> None:
    everything().save(tmp_path / "a.json")
    once = stark.load_scene(tmp_path / "a.json")
    once.save(tmp_path / "b.json")
    twice = stark.load_scene(tmp_path / "b.json")
    assert stark.Simulation(once)._core.parts() == stark.Simulation(twice)._core.parts()
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_same_scene_makes_the_same_files(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        everything().save(tmp_path / name / "s.json")
    for file in ("s.json", "s.npz"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_values_are_those_of_now(tmp_path: Path) -> None:
    scene = everything()
    tethers = scene.energies[0]
    tethers.stiffness = [3.0, 4.0]
    scene.actuators[2].stiffness = 20.0
    scene.save(tmp_path / "a.json")
    again = stark.load_scene(tmp_path / "a.json")
    assert again.energies[0].stiffness.tolist() == [3.0, 4.0]
    assert again.actuators[2].stiffness == 20.0
    again.energies[0].stiffness = [5.0, 6.0]  # and live as others
    with pytest.raises(stark.InvalidArgument, match="stiffness"):
        again.energies[0].stiffness = -1.0


def small() -> stark.Scene:
    scene = stark.Scene("small")
    scene.add_box(0.1, name="box", motion="scripted")
    return scene


def test_small_scenes_are_one_file(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_rigid(
        stark.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), motion="fixed", name="leaf"
    )
    scene.save(tmp_path / "leaf.json")
    assert [path.name for path in tmp_path.iterdir()] == ["leaf.json"]
    assert stark.load_scene(tmp_path / "leaf.json")["leaf"].motion == "fixed"


def _function_of_time() -> stark.Scene:
    scene = small()
    scene["box"].follow(position=lambda t: (0.0, 0.0, t))
    return scene


def _course() -> stark.Scene:
    scene = small()
    scene.add_force(scene.add_box(0.1, mass=1.0, position=(1, 0, 0)), lambda t: (t, 0, 0), name="tug")
    return scene


@pytest.mark.parametrize(
    ("build", "options", "text"),
    [
        (_function_of_time, {}, "'box': position .* Python function .* stark.motion.linear"),
        (_course, {}, "energy 'tug': force .* Python function"),
        (small, {"until": -1.0}, "until = -1.0 s: must be > 0"),
        (small, {"settings": {"time_step": -1.0}}, "time"),
        (small, {"settings": 7}, "settings = 7"),
        (small, {"description": 7}, "description = 7"),
        (lambda: stark.Scene("none"), {}, "has no bodies"),
    ],
)
def test_what_cannot_be_saved_is_refused(
    build: Callable[[], stark.Scene], options: dict[str, object], text: str, tmp_path: Path
) -> None:
    with pytest.raises(stark.InvalidArgument, match=text):
        build().save(tmp_path / "a.json", **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_functions_can_be_sampled(tmp_path: Path) -> None:
    """At the ends of steps they have the bits of the function."""
    scene = _function_of_time()
    scene["box"].follow(
        position=lambda t: (0.0, np.sin(3.0 * t), t * t), rotation=lambda t: (1.0, 0.0, 0.0, t)
    )
    scene.add_force(scene.add_box(0.1, mass=1.0, position=(1, 0, 0)), lambda t: (np.exp(-t), 0, 0))
    scene.save(tmp_path / "a.json", settings={"time_step": 0.03}, until=0.3, sample_functions=True)
    read = document.read(tmp_path / "a.json")
    sims = [stark.Simulation(each, time_step=0.03) for each in (scene, read.scene)]
    for _ in range(10):
        assert not any([sim.step().failed for sim in sims])
        assert sims[0].state.hash == sims[1].state.hash
    with pytest.raises(document.DocumentError, match="must have an end"):
        scene.save(tmp_path / "b.json", sample_functions=True)


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    with pytest.raises(document.DocumentError, match=r"must end in \.json"):
        small().save(tmp_path / "a.toml")
    with pytest.raises(stark.Error, match="choose a folder that exists"):
        small().save(tmp_path / "none" / "a.json")
    os.mkfifo(tmp_path / "p.npz")
    with pytest.raises(stark.Error, match="pipe"):
        small().save(tmp_path / "p.json")
    assert not (tmp_path / "p.json").exists()


def test_files_of_others_are_not_overwritten(tmp_path: Path) -> None:
    """Checkpoints and meshes end in .npz, as the arrays of a document do."""
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 3))
    sim = stark.Simulation(scene)
    document = tmp_path / "cape.json"
    for write in (sim.save, stark.mesh.sphere(0.1, 1).save, lambda path: path.write_bytes(b"notes")):
        write(document.with_suffix(".npz"))
        before = document.with_suffix(".npz").read_bytes()
        with pytest.raises(stark.DocumentError, match=r"'cape\.npz', which is there already.*another name"):
            scene.save(document)
        assert document.with_suffix(".npz").read_bytes() == before and not document.exists()
        document.with_suffix(".npz").unlink()
    for size in (3, 4):  # one document replaces another, with its arrays or without
        scene = stark.Scene()
        scene.add_cloth(stark.mesh.grid(0.1, 0.1, size))
        scene.save(document)
        assert len(stark.load_scene(document).bodies) == 1
        document.unlink()


def test_the_text_is_plain_json(tmp_path: Path) -> None:
    everything().save(tmp_path / "a.json")
    text = (tmp_path / "a.json").read_text()
    found = json.loads(text)
    assert found["format"] == "stark-scene" and found["units"] == "SI"
    assert '   "position": [0, 0, 1],' in text.splitlines()  # a row is a line
    assert [body["name"] for body in found["bodies"]][:2] == ["cloth", "own cloth"]
