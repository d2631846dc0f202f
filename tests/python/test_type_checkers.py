"""Types as users meet them: tools/check_types.py passes, and it finds what is wrong."""

from __future__ import annotations

import re
import sys
import tomllib
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

STRICT = """from typing import assert_type
import stark
from stark import symbolic

@stark.energy
def magnet(p: stark.Point, center: stark.Vec3, strength: float = 2e-5, core: float = 0.05) -> stark.Scalar:
    d = p.x - center
    assert_type(d @ d, stark.Scalar)
    assert_type(0.5 * d, stark.Vec)
    assert_type(strength * stark.norm(d) * d, stark.Vec)
    assert_type(d[0] + 2, stark.Scalar)
    assert_type(stark.sqrt(d), stark.Vec)
    assert_type(stark.where(d[0] > 0.0, d, 0.0), stark.Vec)
    assert_type(stark.clip(d[0], 0.0, 1.0), stark.Scalar)
    assert_type(stark.total(stark.norm(d), "length"), stark.Scalar)
    return -strength / stark.sqrt(d @ d + core**2)

def first_invariant(F: symbolic.Mat) -> stark.Scalar:
    C = F.T @ F
    assert_type(C, symbolic.Mat)
    return C[0, 0] + C[1, 1] + C[2, 2]

def solids(mesh: stark.TetMesh) -> stark.TriangleMesh:
    return stark.mesh.oriented(stark.mesh.compact(mesh)).surface()

def rewound(sim: stark.Simulation, states: list[stark.State]) -> stark.Diagnosis | None:
    states.append(sim.state)
    report = sim.step()
    sim.state = states[-1]
    return report.diagnosis

def wrong(F: symbolic.Mat) -> stark.Scalar:
    return F[0]
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


@pytest.mark.slow
def test_formulas_pass_mypy_in_strict_mode(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    from mypy import api

    file = tmp_path / "formulas.py"
    file.write_text(STRICT)
    found, _, _ = api.run(["--strict", "--config-file=", f"--cache-dir={tmp_path / 'cache'}", str(file)])
    lines = [line for line in found.splitlines() if "error:" in line]
    assert len(lines) == 1 and f"formulas.py:{STRICT.count(chr(10))}: error" in lines[0], found


def test_nothing_weakens_strict_checks_of_the_package() -> None:
    mypy = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mypy"]
    assert {name: value for name, value in mypy.items() if name != "overrides"} == {
        "strict": True,
        "packages": ["stark"],
    }
    for override in mypy["overrides"]:
        assert not any(name.startswith("stark") for name in override["module"])
