"""Programs of the README and the guides run as they stand, block after block in the order of reading, without
a warning, and what they add acts."""

from __future__ import annotations

import re
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import guides  # noqa: E402

#: Tutorials show parts of programs, which test_tutorials.py runs.
GUIDES = sorted(str(path.relative_to(ROOT)) for path in guides.guides(ROOT))
#: Reads the recording of an example.
NEEDS_A_RUN = {"docs/systems.md"}
#: Packages that guides need beside those of Stark.
NEEDS = {
    "docs/meshes.md": ("pytetwild", "fast_simplification", "manifold3d", "coacd"),
    "docs/robots.md": ("yourdfpy",),
    "docs/learning.md": ("gymnasium",),
    "docs/view.md": ("viser",),
    "docs/export.md": ("h5py",),
}


def run_blocks(guide: str, up_to: str = "") -> dict[str, Any]:
    """Names after all blocks of a guide, or the one that makes a name. Only ends of runs come sooner, so that
    stills may lie beyond them; on the way to a name, pictures are drafts."""
    names: dict[str, Any] = {}
    for block in guides.python_blocks(ROOT / guide):
        code = re.sub(r"until=[\d.]+", "until=0.05", block)
        if up_to:
            code = code.replace('quality="best"', 'quality="draft"')
        # Formulas have to be in a file: their annotations are read from there.
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "still: the recording has frames", stark.StarkWarning)
            exec(compile(code, str(ROOT / guide), "exec"), names)
        if up_to in names:
            break
    return names


def test_there_are_guides() -> None:
    assert len(GUIDES) > 15 and set(GUIDES) >= NEEDS_A_RUN


@pytest.mark.parametrize("guide", sorted(set(GUIDES) - NEEDS_A_RUN))
def test_the_programs_of_a_guide_run_in_the_order_of_reading(
    guide: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for package in NEEDS.get(guide, ()):
        pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run_blocks(guide)


@pytest.mark.parametrize("guide", ["README.md", "docs/energies.md"])
def test_the_magnet_pulls_and_does_not_collapse(
    guide: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names = run_blocks(guide, up_to="pull")  # holds the simulation
    pull = names["pull"]
    assert pull.center[1] == 0.1 or pull.center[0] == 0.1  # what the loop has assigned
    forces = pull.forces[:, 0]
    assert np.abs(forces).max() > 1e-5 and forces.sum(axis=0)[2] > 1e-3  # [N], upwards
    nearest = 1.0 / (0.05 * np.sqrt(2.0))  # of the largest force of a core of 5 cm
    assert np.linalg.norm(forces, axis=1).max() <= 2e-5 * nearest**2


def test_the_wind_of_the_guide_is_the_drag_of_a_plate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sheet that is held across the wind feels 1/2 rho A u^2; the formula rounds speeds below 1 mm/s."""
    monkeypatch.chdir(tmp_path)
    names = run_blocks("docs/energies.md", up_to="gale")
    assert names["gale"].forces.sum(axis=(0, 1))[1] > 0.05  # [N], along the wind across the flag
    scene, mesh = stark.Scene(), stark.mesh.grid(1.2, 0.8, cells=(6, 4))
    sheet = scene.add_cloth(mesh, pins=range(len(mesh.vertices)))
    drag = scene.add(names["wind"](sheet.faces, air=(0.0, 0.0, 2.0)))
    sim = stark.Simulation(scene)
    sim.step()
    assert drag.forces.sum(axis=(0, 1)) == pytest.approx(
        [0, 0, 0.5 * 1.2 * 0.96 * 2.0**2], rel=1e-6, abs=1e-9
    )
