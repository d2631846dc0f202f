"""The larger bench scenes of benchmarks/scenes, small enough for a test: what they are made of, and numbers
that balances of forces, free fall and the geometry of their parts give."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stark import scenes
from stark.cli.bench import measure

FOLDER = Path(__file__).parents[2] / "benchmarks" / "scenes"
NAMES = ("arm_ball", "cloth_sphere_576", "rigid_pile_500", "soft_box_drop_40", "towel_press")
GRAVITY, STEP = 9.81, 1.0 / 30.0


def run(name: str, rule: str = "residual", until: float | None = None, **options: Any) -> dict[str, Any]:
    """Numbers of a run that did not fail; where ipctk is there, without intersections."""
    result = measure(str(FOLDER / f"{name}.py"), {}, until=until, rule=rule, options=options)
    assert (result["failure"], result["intersections"] or 0) == (None, 0)
    return result


def test_all_are_documented() -> None:
    files = {path.stem for path in FOLDER.glob("*.py") if not path.stem.startswith("_")}
    assert files == set(NAMES)
    page = (FOLDER.parent / "README.md").read_text()
    for name in NAMES:
        scene = scenes.load(FOLDER / f"{name}.py")
        assert scene.description and scene.until and scene.module.options
        assert f"`{name}`" in page


def test_pile_of_bodies() -> None:
    """What lies in the bin is carried by the floor, except for friction at the walls; nothing leaves it."""
    found = run("rigid_pile_500", until=0.6, bodies=6, meshes="made")["observables"]
    assert 0.0 < found["lowest"] < 2e-3
    assert found["farthest"] < 0.5 * (2 * 0.13 + 0.02)
    assert found["speed_mean"] < 0.05
    assert 0.85 * found["weight"] < found["floor_force"] < 1.01 * found["weight"]


def test_meshes_of_the_pile() -> None:
    pytest.importorskip("pybullet_data")
    scene = scenes.load(FOLDER / "rigid_pile_500.py")
    meshes = scene.module.meshes()
    assert all(mesh.is_closed and mesh.volume > 0.0 for mesh in meshes)
    assert [np.linalg.norm(mesh.vertices, axis=1).max() for mesh in meshes] == pytest.approx([0.06] * 10)
    count = sum(len(meshes[(7 * k) % 10].triangles) for k in range(500))
    assert 9e5 < count < 1e6
    assert run("rigid_pile_500", until=0.1, bodies=10)["observables"]["lowest"] > 0.0


def test_towel_under_a_press() -> None:
    scene = scenes.load(FOLDER / "towel_press.py")
    mesh = scene.module.mesh()
    assert len(mesh.vertices) == 57 * 101
    bent = scene.module.bent_over()
    edges = np.unique(np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    flat, now = (np.linalg.norm(np.diff(p[edges], axis=1)[:, 0], axis=1) for p in (mesh.vertices, bent))
    assert np.abs(now / flat - 1.0).max() < 0.11  # of layers inside and outside of the bend

    found = run("towel_press", cells=20)["observables"]
    assert found["z_max"] < found["press_height"] == pytest.approx(8 * 1.02 * 0.00325)
    assert found["press_force"] > 0.5 * found["weight"]
    assert found["floor_force"] == pytest.approx(found["press_force"] + found["weight"], rel=0.02)
    # Half of the width and a bulge at the crease; a quarter of the length and the creases.
    assert 0.375 < found["length"] < 0.45
    assert 0.33 < found["width"] < 0.42


def test_soft_box() -> None:
    """The coarse cube says where that of 398,763 unknowns ends: 79.80 mm, it is 1 % stiffer."""
    result = run("soft_box_drop_40", cells=8)
    found = result["observables"]
    assert result["dofs"] == 3 * (9**3 + 8**3)
    assert 0.0 < found["z_min"] < 1e-3
    assert found["z_mean"] == pytest.approx(0.0798, abs=8e-4)
    assert found["floor_force"] > found["weight"]


def test_cloth_on_a_sphere() -> None:
    """Corners fall freely: two steps of implicit Euler from 0.2 m/s, less the mass damping of 0.1/s."""
    result = run("cloth_sphere_576", cells=24)
    found = result["observables"]
    assert result["dofs"] == 3 * 25**2
    free = 0.253 - 0.2 * 2 * STEP - 3 * GRAVITY * STEP**2
    assert found["z_corner"] == pytest.approx(free, abs=3e-4)
    assert free - 3e-3 < found["z_min"] < found["z_corner"]  # the rim of what bends over the sphere
    assert 0.25 < found["radius_min"] < 0.25 + 2 * 0.25 / 24
    assert found["sphere_force"] > 0.05


def test_arm_with_ball() -> None:
    """The ball is where the hand brings it, a little lower as it sags; fingers press with half the grip each,
    and friction carries its weight."""
    pytest.importorskip("yourdfpy")
    found = run("arm_ball", rule="scene", subdivisions=1)["observables"]
    assert [found[f"ball_{axis}"] for axis in "xyz"] == pytest.approx([0.40, 0.20, 0.27], abs=2e-3)
    assert found["slip"] < 2e-3
    assert [found["grip_left"], found["grip_right"]] == pytest.approx([4.0, 4.0], rel=0.01)
    assert found["carried"] == pytest.approx(found["weight"], rel=0.01)
    assert found["path_error"] < 1e-3
