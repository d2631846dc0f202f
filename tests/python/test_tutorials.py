"""Tutorials: their programs pass their own checks, are short, and are what the documents show."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stark

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("magnet", "mooney_rivlin", "woven_cloth", "thermal_shell", "gear")


def program(name: str) -> Path:
    return ROOT / "examples" / f"energies_{name}.py"


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_program_checks_itself_and_draws_its_picture(name: str, tmp_path: Path) -> None:
    package = str(Path(stark.__file__).resolve().parents[1])
    done = subprocess.run(
        [sys.executable, program(name)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": package},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("check: passed\n")
    picture = stark.render.read_png(tmp_path / f"out/energies_{name}.png")
    # Not compared by pixels: folds of cloth differ by rounding on another processor.
    assert picture.shape == stark.render.read_png(ROOT / f"docs/images/{name}.png").shape
    assert picture.std() > 10.0


@pytest.mark.parametrize("name", NAMES)
def test_the_document_shows_the_program(name: str) -> None:
    document, code = (ROOT / f"docs/tutorials/{name}.md").read_text(), program(name).read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", document, re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 3
    assert [block for block in blocks if block not in code] == []
    assert f"(../../examples/energies_{name}.py)" in document
    assert f"(../images/{name}.png)" in document
    assert f"(tutorials/{name}.md)" in (ROOT / "docs/README.md").read_text()


@pytest.mark.parametrize("name", NAMES)
def test_the_program_is_short(name: str) -> None:
    assert len(program(name).read_text().splitlines()) < 80
