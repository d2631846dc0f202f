"""A step written as a folder of its own: what is in it, what is left out, what is refused."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import reproducer
from stark.reproducer.formulas import WrittenFormulas

UNTURNED = np.eye(3)


def pressed(**options: Any) -> stark.Simulation:
    """A press that is about to go deeper than a block is high."""
    scene = stark.Scene("pressed")
    scene.add_box((1.0, 1.0, 0.1), motion="fixed", name="table")
    scene.add_box(0.1, mass=0.1, position=(0, 0, 0.105), name="block")
    press = scene.add_box((0.2, 0.2, 0.1), motion="scripted", position=(0, 0, 0.21), name="press")
    sim = stark.Simulation(scene, time_step=0.01, **{"time.min_step": 0.006, **options})
    for _ in range(2):
        assert not sim.step().failed
    press.pose = (0, 0, 0.1), UNTURNED
    return sim


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_bodies_without_a_part_in_it_are_left_out(tmp_path: Path, integrator: str) -> None:
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box(0.1, 2), position=(3, 0, 0), name="far")
    scene.add_box((1.0, 1.0, 0.1), motion="fixed", name="table")
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), position=(0, 0, 0.06), pins=[0, 1, 2])
    scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 6), position=(-3, 0, 0), name="away")
    scene.add_box(0.1, mass=1.0, position=(0, 3, 0), name="aside")
    settings = {"time.min_step": 0.006, "time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=0.01, **settings)
    for _ in range(2):
        assert not sim.step().failed
    sheet.pin_targets = sheet.pin_targets - (0, 0, 0.2)
    report = sim.step()
    assert report.diagnosis.cause == "blocked_motion"
    script = sim.write_reproducer(tmp_path, reduce=True)
    assert "Without 3 bodies, which have no part in it: far, away, aside" in script.read_text()
    again = reproducer.load(tmp_path)
    assert [body.name for body in again.bodies] == ["table", "cloth"]
    for name in ("table", "cloth"):
        np.testing.assert_array_equal(again[name].positions, sim[name].positions)
    assert again.step().diagnosis.cause == "blocked_motion"


def test_later_changes_of_the_scene_are_not_in_it(tmp_path: Path) -> None:
    sim = pressed()
    sim.scene.add_box(0.1, mass=1.0, position=(5, 5, 5), name="late")
    sim.step()
    sim.write_reproducer(tmp_path)
    assert [body.name for body in reproducer.load(tmp_path).bodies] == ["table", "block", "press"]


def test_what_is_not_recorded_is_left_out_and_named(tmp_path: Path, monkeypatch: Any) -> None:
    @stark.energy
    def pull(p: stark.Point, force: stark.Vec3):
        return -stark.dot(force, p.x)

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 3), name="sheet")
    scene.add(pull(sheet.vertices[[0]], force=(0, 0, 1.0)), name="string")
    sim = stark.Simulation(scene)
    sim.step()
    monkeypatch.setattr(WrittenFormulas, "number", lambda self, core: None)
    script = sim.write_reproducer(tmp_path)
    assert "energy 'string'" in script.read_text()
    with pytest.warns(stark.StarkWarning, match="without energy 'string'"):
        again = reproducer.load(tmp_path)
    assert not again.step().failed


def test_joints_that_are_not_recorded_are_refused_with_their_names(tmp_path: Path, monkeypatch: Any) -> None:
    @stark.joint
    def stick(a: stark.Frame, b: stark.Frame):
        return stark.hold(length=a.x - b.x)

    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    scene.add_joint(stick, None, box, anchor=(0, 0, 0), name="nail")
    sim = stark.Simulation(scene)
    sim.step()
    monkeypatch.setattr(WrittenFormulas, "number", lambda self, core: None)
    sim.write_reproducer(tmp_path)
    with pytest.raises(stark.ReproducerError, match=r"joint 'nail'.*checkpoint"):
        reproducer.load(tmp_path)


def test_nothing_to_write(tmp_path: Path) -> None:
    sim = pressed()
    sim.state = sim.state
    with pytest.raises(stark.ReproducerError, match="must be written after a step"):
        sim.write_reproducer(tmp_path)


def test_runs_keep_the_step_that_failed(tmp_path: Path) -> None:
    scene_file = tmp_path / "press.py"
    scene_file.write_text(
        "import numpy as np, stark\n"
        "until = 0.1\n"
        "def build():\n"
        "    s = stark.Scene()\n"
        "    s.add_box((1.0, 1.0, 0.1), motion='fixed', name='table')\n"
        "    s.add_box(0.1, mass=0.1, position=(0, 0, 0.105), name='block')\n"
        "    s.add_box((0.2, 0.2, 0.1), motion='scripted', position=(0, 0, 0.21), name='press')\n"
        "    return s\n"
        "def settings():\n"
        "    return {'time_step': 0.01, 'time.min_step': 0.006}\n"
        "def drive(sim):\n"
        "    if sim.time > 0.025:\n"
        "        sim['press'].pose = (0, 0, 0.1), np.eye(3)\n"
    )
    result = stark.scenes.run(scene_file, out=tmp_path / "out", replay=False, picture=False)
    assert result.status == "failed"
    assert tmp_path / "out" / "failure" / "reproduce.py" in result.files
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert reproducer.load(tmp_path / "out" / "failure").step().diagnosis.cause == "blocked_motion"
