"""Types as users meet them: tools/check_types.py passes, and it finds what is wrong."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import check_types  # noqa: E402

WRONG = """import stark
scene = stark.Scene()
box = scene.add_box(0.1, mass=1.0)
box.positon
stark.Simulaton
cloth = scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells='many'))
"""


def test_all_that_users_copy_is_checked() -> None:
    scripts = check_types.user_scripts(ROOT)
    examples = {path.name for path in (ROOT / "examples").glob("*.py")}
    assert examples < set(scripts) and "readme_md.py" in scripts and "docs_energies_md.py" in scripts
    guides = [path for path in (ROOT / "docs").glob("*.md") if "```python" in path.read_text()]
    assert len(scripts) == len(examples) + len(guides) + 1
    # Line by line: what stands in the document at a line of code stands there in the script.
    script, document = (scripts["docs_rods_md.py"], (ROOT / "docs/rods.md").read_text().splitlines())
    places = [k for k, line in enumerate(script.splitlines()) if line]
    assert places and all(script.splitlines()[k] == document[k] for k in places)


@pytest.mark.slow
def test_readme_guides_and_examples_pass_type_checkers() -> None:
    pytest.importorskip("mypy")
    assert check_types.check_scripts(check_types.user_scripts(ROOT)) == []


@pytest.mark.slow
def test_type_checkers_find_what_is_wrong() -> None:
    pytest.importorskip("mypy")
    found = check_types.check_scripts({"wrong.py": WRONG})
    for pattern in (r"^wrong\.py:(\d+): error", r"^wrong\.py:(\d+):\d+ - error"):  # mypy, basedpyright
        lines = [int(match[1]) for line in found if (match := re.match(pattern, line))]
        assert lines == [4, 5, 6], found
