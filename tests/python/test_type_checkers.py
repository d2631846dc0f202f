"""Types as users meet them: the README and the examples pass a type checker."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stark

ROOT = Path(__file__).resolve().parents[2]

# Sizes in annotations, Vector[5], are no types for checkers; the others use other packages in loose ways.
WITHOUT = {"fit_ellipse.py", "curves.py"}


def complaints(folder: Path, files: list[Path]) -> str:
    """What mypy says of scripts of users."""
    pytest.importorskip("mypy")
    environment = os.environ | {"PYTHONPATH": str(Path(stark.__file__).parents[1])}
    environment |= {"MYPYPATH": environment["PYTHONPATH"]} if "site-packages" not in stark.__file__ else {}
    options = ["--config-file=", "--follow-imports=silent", "--ignore-missing-imports"]
    command = [sys.executable, "-m", "mypy", f"--cache-dir={folder}", *options, *map(str, files)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else done.stdout + done.stderr


@pytest.mark.slow
def test_readme_and_examples_pass_a_type_checker(tmp_path: Path) -> None:
    snippets = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert snippets
    readme = tmp_path / "readme.py"
    readme.write_text("\n".join(snippets))
    examples = [path for path in sorted((ROOT / "examples").glob("*.py")) if path.name not in WITHOUT]
    assert complaints(tmp_path, [readme, *examples]) == ""


@pytest.mark.slow
def test_a_type_checker_finds_what_is_wrong(tmp_path: Path) -> None:
    script = tmp_path / "wrong.py"
    script.write_text(
        "import stark\n"
        "scene = stark.Scene()\n"
        "box = scene.add_box(0.1, mass=1.0)\n"
        "box.positon\n"
        "stark.Simulaton\n"
        "cloth = scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells='many'))\n"
    )
    found = complaints(tmp_path, [script])
    assert [int(n) for n in re.findall(r"wrong\.py:(\d+): error", found)] == [4, 5, 6], found
