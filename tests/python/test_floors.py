"""The house of the Python package: floors, no circles, and a lint that sees what breaks them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import python_floors  # noqa: E402
from python_imports import circles, imports_of_package  # noqa: E402


def test_no_file_imports_itself_by_way_of_others() -> None:
    """Imports inside functions and under TYPE_CHECKING count."""
    imports = imports_of_package(ROOT / "python/stark")
    assert len(imports) > 150
    assert circles(imports) == []


def test_every_import_points_to_the_own_floor_or_down() -> None:
    assert python_floors.check(ROOT) == []


def test_handles_know_neither_scene_nor_simulation() -> None:
    imports = imports_of_package(ROOT / "python/stark")
    handles = ("stark.handle", "stark.selections", "stark.joints.handle", "stark.attachments.handle")
    bodies = [m for m in imports if m.startswith("stark.bodies")]
    for module in (*handles, "stark.formulas.handle", *bodies):
        assert not imports[module] & {"stark.scene", "stark.simulation", "stark"}, module


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """A package of three floors."""
    package = tmp_path / "python/stark"
    (package / "bodies").mkdir(parents=True)
    for name in ("__init__", "arguments", "handle", "scene", "bodies/__init__", "verify"):
        (package / f"{name}.py").write_text("")
    (package / "handle.py").write_text("from stark.arguments import something\n")
    (package / "bodies/body.py").write_text("from ..handle import Handle\nfrom stark import handle\n")
    return tmp_path


def test_a_house_in_order_is_not_complained_about(house: Path) -> None:
    assert python_floors.check(house) == []


@pytest.mark.parametrize(
    ("file", "line", "words"),
    [
        ("handle.py", "from stark.scene import Scene", ["stark.handle (floor 3) may not see stark.scene"]),
        ("handle.py", "import stark.scene", ["stark.handle (floor 3) may not see stark.scene"]),
        ("bodies/body.py", "def f():\n    from .. import scene", ["stark.bodies.body (floor 5) may not see"]),
        (
            "handle.py",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from .bodies.body import Body",
            ["circle of imports: stark.bodies.body, stark.handle", "stark.handle (floor 3) may not see"],
        ),
        ("handle.py", "import stark", ["stark.handle (floor 3) may not see stark (floor"]),
        ("bodies/body.py", "from stark import verify", ["stark.verify stands beside the rest"]),
        ("verify.py", "from .arguments import x", ["stark.verify stands beside the rest"]),
        ("scratch.py", "", ["stark.scratch has no floor"]),
    ],
)
def test_what_breaks_the_house_is_found(house: Path, file: str, line: str, words: list[str]) -> None:
    (house / "python/stark" / file).write_text(line + "\n")
    errors = python_floors.check(house)
    assert len(errors) >= len(words)
    for word in words:
        assert any(word in error for error in errors), errors


def test_every_module_can_be_the_first_that_is_imported() -> None:
    """What has no circle has no order in which it must be imported, either."""
    modules = sorted(m for m in imports_of_package(ROOT / "python/stark") if not m.endswith("__main__"))
    code = (
        "import importlib, sys, stark, numpy\n"
        "kept = {name for name in sys.modules}\n"
        "for name in sys.argv[1:]:\n"
        "    for other in [m for m in sys.modules if m not in kept and m.startswith('stark.')]:\n"
        "        del sys.modules[other]\n"
        "    importlib.import_module(name)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, *modules], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
