"""Flexes of MJCF files: shapes, masses and holds are those of mujoco; a block sags as it does there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

mujoco = pytest.importorskip("mujoco")

BLOCK = """
<flexcomp name="block" type="grid" count="3 3 5" spacing=".05 .05 .05" mass="2" dim="3" radius=".002"
  pos="2 0 .5"><pin gridrange="0 0 4 2 2 4"/>
  <elasticity young="1e5" poisson="0.3" damping="0.005"/></flexcomp>
"""
OTHERS = """
<body name="arm" pos="0 0 1" euler="0 0 30"><joint name="h" axis="1 0 0"/>
  <geom type="box" size=".05 .2 .05"/>
  <flexcomp name="flag" type="grid" count="4 4 1" spacing=".05 .05 .05" mass=".1" dim="2" radius=".002"
    pos=".2 0 0"><pin id="0 1 2 3"/><contact selfcollide="none"/>
    <elasticity young="3e4" poisson="0.2" thickness="1e-3" damping="0.01" elastic2d="{bends}"/></flexcomp>
</body>
<flexcomp name="rope" type="grid" count="6 1 1" spacing=".05 .05 .05" mass="0.1" dim="1" pos="1 0 .5">
  <edge equality="true"/></flexcomp>
<flexcomp name="jelly" type="grid" count="3 3 3" spacing=".05 .05 .05" mass="1" dim="3" pos="3 0 .5"
  dof="trilinear"><elasticity young="5e4" poisson="0.495"/></flexcomp>
"""


def written(folder: Path, others: str = OTHERS, bends: str = "both") -> Path:
    file = folder / "soft.xml"
    bodies = others.format(bends=bends) + BLOCK
    file.write_text(f'<mujoco model="soft"><worldbody>{bodies}</worldbody></mujoco>')
    return file


def material(body: stark.Cloth | stark.Solid) -> Any:
    return body._shared["material"]


def at_start(file: Path, name: str) -> np.ndarray:
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    k = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, name)
    first, count = int(model.flex_vertadr[k]), int(model.flex_vertnum[k])
    return np.array(data.flexvert_xpos[first : first + count])


def test_shapes_and_masses_are_those_of_the_file(tmp_path: Path) -> None:
    file = written(tmp_path)
    scene = stark.Scene()
    robot = scene.add_robot(file)
    assert robot.coordinates == ("h",) and list(robot.links) == ["world", "arm"]
    assert list(robot.flexes) == ["flag", "jelly", "block"]
    assert isinstance(robot.flexes["flag"], stark.Cloth) and isinstance(robot.flexes["block"], stark.Solid)
    sim = stark.Simulation(scene)
    for name, mass in (("flag", 0.1), ("block", 2.0), ("jelly", 1.0)):
        body = sim.robots[0].flexes[name]
        np.testing.assert_allclose(body.positions, at_start(file, name), atol=1e-12)
        assert body.mass == pytest.approx(mass, rel=1e-12)
    flag, jelly = material(robot.flexes["flag"]), material(robot.flexes["jelly"])
    assert (flag.youngs_modulus, flag.poissons_ratio, flag.thickness) == (3e4, 0.2, 1e-3)
    assert flag.flexural_rigidity == pytest.approx(3e4 * 1e-9 / 12.0 / (1.0 - 0.04))
    assert flag.strain_damping == pytest.approx(0.01 * 3e4 * 1e-3)
    assert jelly.poissons_ratio == 0.49
    text = str(robot.report)
    for line in (
        "flex 'rope': a line, for which a file has no stiffness of bending: add a rod with scene.add_rod",
        "flex 'flag': 4 vertices are fixed to 'arm'",
        "flex 'jelly': Poisson's ratio 0.49 instead of 0.495",
        "flex 'jelly': all its vertices move",
    ):
        assert line in text


def test_a_line_that_is_left_out_is_warned_of(tmp_path: Path) -> None:
    with pytest.warns(stark.StarkWarning, match="soft.xml': flex 'rope': a line.*scene.add_rod") as caught:
        robot = stark.Scene().add_robot(written(tmp_path))
    assert [warning.filename for warning in caught] == [__file__]
    assert "rope" not in robot.flexes
    # Its jelly is of linear tetrahedra with 0.49, as in the file: that is in the report alone.
    assert any("elements lock" in finding.text for finding in robot.report.suspicious)


def test_what_a_link_holds_goes_with_it(tmp_path: Path) -> None:
    scene = stark.Scene()
    robot = scene.add_robot(written(tmp_path), q={"h": 0.3}, position=(0.0, 0.0, 1.0))
    sim = stark.Simulation(scene, time_step=0.01)
    held = robot.flexes["flag"].positions[:4]
    position, rotation = robot.links["arm"].pose
    local = (held - position) @ rotation
    assert local[:, 0] == pytest.approx(0.125) and local[:, 2] == pytest.approx(0.0, abs=1e-12)
    sim.run_until(0.2)
    position, rotation = robot.links["arm"].pose
    np.testing.assert_allclose((robot.flexes["flag"].positions[:4] - position) @ rotation, local, atol=1e-5)
    assert np.ptp(robot.flexes["flag"].positions[:, 2]) > 0.02  # the rest hangs


def test_a_block_sags_as_in_mujoco(tmp_path: Path) -> None:
    """The same linear tetrahedra, small strains: its end goes down by 1.5 mm, the same within 2 %. mujoco has
    equal masses at all vertices, which moves single ones by more, but not their mean."""
    file = written(tmp_path, others="")
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    model.opt.timestep = 1e-4  # elasticity is explicit there
    for _ in range(15_000):
        mujoco.mj_step(model, data)
        data.qvel *= 0.998  # to rest
    k = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, "block")
    first, count = int(model.flex_vertadr[k]), int(model.flex_vertnum[k])
    start = at_start(file, "block")
    expected = data.flexvert_xpos[first : first + count] - start
    scene = stark.Scene()
    robot = scene.add_robot(file)
    sim = stark.Simulation(scene, time_step=0.01, **{"time.integrator": "quasistatic"})
    sim.step()
    found = robot.flexes["block"].positions - start
    lowest = start[:, 2] < start[:, 2].min() + 1e-9
    assert expected[lowest, 2].mean() < -1e-3
    assert found[lowest, 2].mean() == pytest.approx(expected[lowest, 2].mean(), rel=0.02)


def test_cloth_that_only_stretches_and_ghosts(tmp_path: Path) -> None:
    scene = stark.Scene()
    robot = scene.add_robot(written(tmp_path, bends="stretch"), contact=False)
    assert material(robot.flexes["flag"]).flexural_rigidity == 0.0
    scene.add_box((0.2, 0.2, 0.2), motion="fixed", position=(2.0, 0.0, 0.5))  # inside the block
    stark.Simulation(scene).step()


def test_documents_keep_the_handles(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_robot(written(tmp_path))
    again = stark.load_scene(scene.save(tmp_path / "scene.json"))
    assert {name: body.name for name, body in again.robots[0].flexes.items()} == {
        "flag": "soft.flag",
        "jelly": "soft.jelly",
        "block": "soft.block",
    }
    sims = [stark.Simulation(each, time_step=0.01) for each in (scene, again)]
    for sim in sims:
        sim.step()
    assert sims[0].state.hash == sims[1].state.hash
