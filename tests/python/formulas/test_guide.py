"""The code of docs/energies.md runs as it stands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

GUIDE = Path(__file__).resolve().parents[3] / "docs/energies.md"


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 16
    names: dict[str, object] = {}
    for block in blocks:
        shortened = block.replace("until=1.0", "until=0.05")
        exec(compile(shortened, str(GUIDE), "exec"), names)
    assert list(names["pull"].center) == [0.1, 0.0, 0.3]  # type: ignore[attr-defined]
    assert len(names["line"]) == 4 and names["bend"].fold > 0.0  # type: ignore[arg-type, attr-defined]
    assert names["rubber"].c10 == 3e4  # type: ignore[attr-defined]
    assert names["air"].pressure == pytest.approx(7000.0)  # type: ignore[attr-defined]
    assert names["gas"].amount == pytest.approx(1.1)  # type: ignore[attr-defined]
    assert names["pressure"] < 5000.0  # the skin gives way  # type: ignore[operator]
    assert names["tension"] > 0.0  # type: ignore[operator]
    printed = capsys.readouterr().out
    assert "magnet(p, center, strength, core):" in printed and "nothing is wrong" in printed


def test_what_the_wind_of_the_guide_leaves_out() -> None:
    """Along the flow there is no load; a canopy that is given the pressure of the air it catches is pushed by
    that on its opening."""
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    names: dict[str, Any] = {"stark": stark}
    block = next(block for block in blocks if "def wind(" in block)
    exec(compile(block.partition("\n\n\n")[0], str(GUIDE), "exec"), names)
    dynamic = 0.5 * 1.2 * 10.0**2  # [Pa]
    for angle, share in ((90.0, 1.0), (30.0, 0.25), (0.0, 0.0)):
        scene = stark.Scene()
        turned = stark.rotation(axis="y", angle=(90.0 - angle) * stark.deg)
        sheet = scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells=2), rotation=turned, pins=range(9))
        drag = scene.add(names["wind"](sheet.faces, air=(0.0, 0.0, 10.0)))
        sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
        sim.step()
        assert np.linalg.norm(drag.forces.sum(axis=(0, 1))) == pytest.approx(share * dynamic, abs=1e-5)
    sphere = stark.mesh.sphere(1.0, 3)
    triangles = sphere.triangles[(sphere.vertices[sphere.triangles][:, :, 2] > -1e-9).all(axis=1)]
    kept, numbers = np.unique(triangles, return_inverse=True)
    scene = stark.Scene()
    half = (sphere.vertices[kept], numbers.reshape(triangles.shape))
    canopy = scene.add_cloth(half, pins=range(len(kept)))
    air = scene.add_face_pressure(canopy, -dynamic)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    sim.step()
    assert air.forces.sum(axis=(0, 1)) == pytest.approx([0.0, 0.0, np.pi * dynamic], rel=0.01, abs=1e-9)
