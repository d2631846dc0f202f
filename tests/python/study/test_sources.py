"""Modules that a scene imports, beside it and elsewhere, are part of the key of its runs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from _studies import FALL

from stark.scenes import load
from stark.study import Plan
from stark.study.sources import scene_hash
from stark.study.task import tasks

HEAD = "import importlib, sys\nsys.path.insert(0, {lib!r})\n"


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "path", list(sys.path))
    path = tmp_path / "scene/fall.py"
    path.parent.mkdir()
    path.write_text(FALL)
    return path


def keys(plan: Plan) -> list[str]:
    return [task.key for task in tasks(plan, Path("/study"))]


def test_modules_beside_a_scene_count(scene: Path) -> None:
    scene.write_text(FALL + "import study_helper_a\n")
    (scene.parent / "study_helper_a.py").write_text("import study_helper_b\n")
    (scene.parent / "study_helper_b.py").write_text("x = 1\n")
    (scene.parent / "unused.py").write_text("x = 1\n")
    first = keys(Plan(str(scene), [{}]))
    (scene.parent / "unused.py").write_text("x = 2\n")
    assert keys(Plan(str(scene), [{}])) == first
    (scene.parent / "study_helper_b.py").write_text("x = 2\n")
    assert keys(Plan(str(scene), [{}])) != first


@pytest.mark.parametrize(
    ("imports", "files", "changed"),
    [
        ("import study_out_a", {"study_out_a.py": "x = 1"}, "study_out_a.py"),
        (
            "import study_out_b",
            {"study_out_b.py": "import study_out_c", "study_out_c.py": "x = 1"},
            "study_out_c.py",
        ),
        (
            "import study_out_d.deep",
            {"study_out_d/__init__.py": "", "study_out_d/deep.py": "x = 1"},
            "study_out_d/__init__.py",
        ),
        (
            "from study_out_e import deep",
            {
                "study_out_e/__init__.py": "",
                "study_out_e/deep.py": "from . import side",
                "study_out_e/side.py": "",
            },
            "study_out_e/side.py",
        ),
        ("importlib.import_module('study_out_f')", {"study_out_f.py": "x = 1"}, "study_out_f.py"),
        ("__import__('study_out_g')", {"study_out_g.py": "x = 1"}, "study_out_g.py"),
        ("def late():\n    import study_out_h", {"study_out_h.py": "x = 1"}, "study_out_h.py"),
    ],
)
@pytest.mark.parametrize("place", ["lib", "scene"])
def test_imported_modules_count_wherever_they_are(
    scene: Path, imports: str, files: dict[str, str], changed: str, place: str
) -> None:
    lib = scene.parents[1] / "lib"
    scene.write_text(HEAD.format(lib=str(lib)) + imports + "\n" + FALL)
    for name, text in {**files, "unused.py": "x = 1"}.items():
        (scene.parents[1] / place / name).parent.mkdir(exist_ok=True, parents=True)
        (scene.parents[1] / place / name).write_text(text)
    first = keys(Plan(str(scene), [{}]))
    (scene.parents[1] / place / "unused.py").write_text("x = 2")
    assert keys(Plan(str(scene), [{}])) == first
    (scene.parents[1] / place / changed).write_text("y = 2")
    assert keys(Plan(str(scene), [{}])) != first


def test_installed_modules_do_not(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = scene_hash(load(scene))
    scene.write_text(FALL + "import json, numpy.linalg, scipy, stark.mesh\n")
    second = scene_hash(load(scene))
    assert first != second
    (scene.parent / "seen.py").write_text("")
    monkeypatch.setattr("stark.study.sources._is_installed", lambda file: True)
    assert scene_hash(load(scene)) == second


def test_functions_of_a_scene_may_import_what_lies_beside_it(scene: Path) -> None:
    """Also where the scene puts other folders first."""
    (scene.parent / "study_late.py").write_text("height = 3.0\n")
    (scene.parents[1] / "lib").mkdir()
    head = HEAD.format(lib=str(scene.parents[1] / "lib"))
    scene.write_text(head + FALL.replace("def build():", "def build():\n    import study_late"))
    before = list(sys.path)
    load(scene).build()
    assert [folder for folder in sys.path if folder not in before] == [
        str(scene.parents[1] / "lib"),
        str(scene.parent),
    ]
