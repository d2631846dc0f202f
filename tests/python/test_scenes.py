"""Packaged scenes: they exist under their names, are what benchmarks compare, and their first steps work."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import stark
from stark import scenes

_BENCH = {
    "spinning_box_cloth_32": (1.0, 0.0025),
    "spinning_box_cloth_64": (0.5, 0.00125),
    "spinning_box_cloth_128": (0.25, 0.000625),
    "hanging_cloth_50": (3.0, None),
    "soft_box_drop_20": (0.5, 0.001),
    "rigid_pile_27": (2.0, 0.001),
    "cloth_sphere_floor_60": (0.5, 0.002),
    "soft_column_6": (1.0, 0.0005),
}
_EXAMPLES = ("hello_cloth", "drop", "stack", "drape", "soft_column", "soft_drop")
_HAS_MESH_EXTRA = all(importlib.util.find_spec(name) for name in ("pyvista", "pytetwild"))


def test_all_scenes_are_there() -> None:
    assert set(scenes.names()) == {*_BENCH, *_EXAMPLES}


@pytest.mark.parametrize("name", _EXAMPLES)
def test_examples_check_themselves_and_have_a_script(name: str) -> None:
    scene = scenes.load(name)
    assert scene.has_check and scene.description and scene.until
    script = Path(__file__).parents[2] / "examples" / f"{name}.py"
    assert f'scenes.run("{name}"' in script.read_text()


@pytest.mark.parametrize("name", _BENCH)
def test_bench_scenes_have_the_agreed_parameters(name: str) -> None:
    until, contact_distance = _BENCH[name]
    scene = scenes.load(name)
    assert scene.until == until
    _, settings = scene.build()
    assert settings["time_step"] == 1 / 30
    assert settings.get("contact_distance") == contact_distance
    assert settings["newton.termination"] == "any"
    # 1e-6 N s over a step of 1/30 s.
    assert settings["newton.residual_tolerance"] == pytest.approx(3e-5)
    assert settings["newton.step_tolerance"] == 1e-3


@pytest.mark.parametrize("cells", [32, 64, 128])
def test_spinning_box(cells: int) -> None:
    scene, _ = scenes.load(f"spinning_box_cloth_{cells}").build()
    cloth, box = scene["cloth"], scene["box"]
    assert len(cloth.positions) == (cells + 1) ** 2
    assert len(cloth.triangles) == 2 * cells**2
    assert np.ptp(cloth.positions, axis=0) == pytest.approx([0.4, 0.4, 0.0])
    assert box.motion == "scripted"
    assert box.positions[:, 2].max() == pytest.approx(-0.04)
    assert scene.friction[cloth, box] == 0.0 and scene.friction[cloth, cloth] == 0.0
    assert scene.contact_enabled(cloth, cloth)


def test_hanging_cloth() -> None:
    scene, settings = scenes.load("hanging_cloth_50").build()
    cloth = scene["cloth"]
    pinned = cloth.positions[cloth.pins]
    assert sorted(map(tuple, pinned.round(9))) == [(-0.5, 0.5, 0.0), (0.5, 0.5, 0.0)]
    assert settings["contact.enabled"] is False


def test_soft_box_drop() -> None:
    scene, _ = scenes.load("soft_box_drop_20").build()
    cube = scene["cube"]
    assert len(cube.positions) == 17_261
    assert cube.positions.min(axis=0) == pytest.approx([-0.1, -0.1, 0.03])
    assert scene["floor"].positions[:, 2].max() == pytest.approx(0.0)
    assert scene.friction["cube", "floor"] == 0.5


def test_rigid_pile() -> None:
    scene, _ = scenes.load("rigid_pile_27").build()
    cubes = [b for b in scene.bodies if b.name != "floor"]
    assert len(cubes) == 27
    assert all(cube.mass == pytest.approx(1.0) for cube in cubes)
    # k = 5: ix = 2, iy = 1, iz = 0; 25 mod 7 = 4, 15 mod 7 = 1; yaw = 185 mod 23 - 11 = -10 degrees.
    center = cubes[5].positions.mean(axis=0)
    assert center == pytest.approx([0.135 + 0.004, 0.004 * -2, 0.06])
    edge = np.deg2rad(-10.0)
    turned = cubes[5].rotation @ [1.0, 0.0, 0.0]
    assert turned == pytest.approx([np.cos(edge), np.sin(edge), 0.0])


def test_cloth_sphere_floor() -> None:
    scene, _ = scenes.load("cloth_sphere_floor_60").build()
    cloth, sphere = scene["cloth"], scene["sphere"]
    assert len(cloth.positions) == 61**2
    assert cloth.positions.mean(axis=0) == pytest.approx([0.01, 0.02, 0.53])
    assert len(sphere.triangles) == 20 * 4**3
    assert np.linalg.norm(sphere.positions - [0, 0, 0.26], axis=1) == pytest.approx(0.25)
    assert scene.friction[cloth, sphere] == 0.3 and scene.friction[cloth, "floor"] == 0.3
    assert scene.friction[cloth, cloth] == 0.0


def test_soft_column() -> None:
    scene, _ = scenes.load("soft_column_6").build()
    cubes = [scene[f"cube_{i}"] for i in range(5)]
    for i, cube in enumerate(cubes):
        middle = 0.5 * (cube.positions.min(axis=0) + cube.positions.max(axis=0))
        assert middle == pytest.approx([0.002 * (i % 2), 0.001 * (i % 3), 0.0515 + 0.1015 * i])
    gap = scene["plate"].positions[:, 2].min() - cubes[-1].positions[:, 2].max()
    assert gap == pytest.approx(0.003)


_SMALL = (
    "hello_cloth",
    "spinning_box_cloth_32",
    "hanging_cloth_50",
    "rigid_pile_27",
    "stack",
    "soft_column_6",
)


@pytest.mark.parametrize("name", _SMALL)
def test_first_step(name: str, tmp_path: Path) -> None:
    result = scenes.run(name, out=tmp_path / name, until=0.02, replay=False, picture=False)
    assert (result.status, result.steps >= 1) == ("complete", True), result.message


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*_BENCH, *_EXAMPLES} - {*_SMALL, "drop", "spinning_box_cloth_128"}))
def test_first_step_of_larger_scenes(name: str, tmp_path: Path) -> None:
    test_first_step(name, tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not _HAS_MESH_EXTRA, reason="needs the extra 'samples'")
def test_first_step_of_drop(tmp_path: Path) -> None:
    test_first_step("drop", tmp_path)


@pytest.mark.skipif(_HAS_MESH_EXTRA, reason="the extra 'samples' is installed")
def test_drop_names_the_extra_it_needs() -> None:
    with pytest.raises(ImportError, match=r"pip install 'stark-sim\[samples\]'"):
        scenes.load("drop").build()


def test_scene_lookup_suggests_names() -> None:
    with pytest.raises(stark.InvalidArgument, match="did you mean 'soft_drop'"):
        scenes.load("sof_drop")


def test_an_end_may_be_a_number_of_numpy(tmp_path: Path) -> None:
    """It was refused: must be a positive number."""
    file = tmp_path / "short.py"
    file.write_text(
        "import numpy as np\nimport stark\nuntil = np.float32(0.5)\ndef build():\n    return stark.Scene()\n"
    )
    assert scenes.load(file).until == 0.5
    file.write_text(file.read_text().replace("np.float32(0.5)", "np.int64(2)"))
    assert scenes.load(file).until == 2.0


CHECKED = """
import numpy as np
import stark

until = 0.02


def build():
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    return scene


def check(run):
    return VALUE
"""


@pytest.mark.parametrize("value", ["False", "np.float64(1.0) > 2.0"])
def test_a_check_that_returns_false_has_failed(tmp_path: Path, value: str) -> None:
    """It had passed."""
    file = tmp_path / "checked.py"
    file.write_text(CHECKED.replace("VALUE", value))
    result = scenes.run(file, out=tmp_path / "run", replay=False, picture=False)
    assert result.status == "wrong" and "check failed: it returned False; write assert" in result.message


@pytest.mark.parametrize("value", ["None", "True", "np.zeros(3)", "0"])
def test_what_else_a_check_returns_does_not_count(tmp_path: Path, value: str) -> None:
    file = tmp_path / "checked.py"
    file.write_text(CHECKED.replace("VALUE", value))
    result = scenes.run(file, out=tmp_path / "run", replay=False, picture=False)
    assert (result.status, result.message) == ("complete", "check passed")


def test_ends_and_settings_of_a_run_are_checked(tmp_path: Path) -> None:
    file = tmp_path / "checked.py"
    file.write_text(CHECKED)
    with pytest.raises(stark.InvalidArgument, match="run: until = 'x': must be a number"):
        scenes.run(file, out=tmp_path / "run", until="x")  # type: ignore[arg-type]
    with pytest.raises(scenes.SceneFileError, match="run: settings = 5; must be a dictionary"):
        scenes.run(file, out=tmp_path / "run", settings=5)  # type: ignore[arg-type]
    assert not (tmp_path / "run").exists()
