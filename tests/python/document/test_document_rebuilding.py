"""Packaged scenes and examples as documents: the same model and the same steps, bit for bit."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import stark
from stark import document, scenes

ROOT = Path(__file__).resolve().parents[3]
EXAMPLES = ROOT / "examples"
#: Examples without a scene of their own.
WITHOUT = {
    **dict.fromkeys(
        ("drape", "drop", "hello_cloth", "soft_column", "soft_drop", "stack"), "a packaged scene"
    ),
    **dict.fromkeys(
        ("curves", "hand_paths", "pictures", "robot_parts", "running", "three_fingers", "towel"),
        "functions for other examples",
    ),
    "robot_towel_sheet": "pictures of a study",
    "learning": "environments, whose scenes are below",
    "fit_ellipse": "derivatives without a scene",
    "fold_towel": "a program of two simulations",
}
#: Examples that need other packages.
PACKAGES = {
    "hammock": ["pybullet_data", "pytetwild"],
    "panda_ball": ["yourdfpy"],
    "robot_arm": ["yourdfpy"],
}
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.py"))


@pytest.fixture(autouse=True)
def _examples_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.syspath_prepend(str(EXAMPLES))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stark.StarkWarning)
        yield


def same_steps(scene: Any, settings: Any, steps: int, folder: Path) -> None:
    """The scene and what is loaded from its document: one model, one state after these steps."""
    try:
        scene.save(folder / "scene.json", settings=settings)
    except document.DocumentError as error:
        assert "sample_functions" in str(error)
        scene.save(folder / "scene.json", settings=settings, until=0.1, sample_functions=True)
    read = document.read(folder / "scene.json")
    chosen = stark.Settings()
    chosen.update(settings if isinstance(settings, dict) else settings.to_dict())
    before, after = stark.Simulation(scene, chosen), stark.Simulation(read.scene, **read.settings)
    assert before._core.parts() == after._core.parts()
    for _ in range(steps):
        before.step()
        after.step()
    assert before.state.hash == after.state.hash


def scene_of(name: str) -> tuple[Any, Any]:
    """Scene and settings of an example; skips where packages or files that it reads are missing."""
    for package in PACKAGES.get(name, []):
        pytest.importorskip(package)
    module = importlib.import_module(name)
    try:
        if hasattr(module, "settings"):
            return scenes.load(EXAMPLES / f"{name}.py").build()
        if hasattr(module, "scene"):
            return module.scene, stark.Settings()
        return scene_of_program(name, module.main)
    except ImportError as missing:  # of files that it reads
        pytest.skip(str(missing))


def scene_of_program(name: str, main: Any) -> tuple[Any, Any]:
    """Scene and settings of a program, run up to its first simulation."""
    found: list[Any] = []

    class Reached(Exception):  # noqa: N818 (no error)
        pass

    def take(scene: Any, settings: Any = None, **options: Any) -> Any:
        chosen = stark.Settings() if settings is None else settings.copy()
        chosen.update(options)
        found.extend((scene, chosen))
        raise Reached

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stark, "Simulation", take)
        patch.setattr(sys, "argv", [name])
        with pytest.raises(Reached):
            main()
    return found[0], found[1]


@pytest.mark.parametrize("name", [name for name in NAMES if name not in WITHOUT])
def test_examples(name: str, tmp_path: Path) -> None:
    same_steps(*scene_of(name), steps=0, folder=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name not in WITHOUT])
def test_steps_of_examples(name: str, tmp_path: Path) -> None:
    same_steps(*scene_of(name), steps=2, folder=tmp_path)


@pytest.mark.parametrize("name", [name for name in scenes.names() if name not in ("drop", "drape")])
def test_packaged_scenes(name: str, tmp_path: Path) -> None:
    same_steps(*scenes.load(name).build(), steps=0, folder=tmp_path)


@pytest.mark.parametrize("name", ["DragClothTask", "GraspBallTask"])
def test_scenes_of_environments(name: str, tmp_path: Path) -> None:
    pytest.importorskip("gymnasium")
    module = "drag_cloth" if name == "DragClothTask" else "grasp_ball"
    task = getattr(importlib.import_module(f"stark.gym.{module}"), name)()
    same_steps(*task.build(), steps=2, folder=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", scenes.names())
def test_steps_of_packaged_scenes(name: str, tmp_path: Path) -> None:
    if name == "drop":
        pytest.importorskip("pyvista")
    same_steps(*scenes.load(name).build(), steps=2, folder=tmp_path)
