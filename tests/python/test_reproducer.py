"""A step as a folder of its own: taken again in another process, it fails in the same way."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import reproducer
from stark.reproducer import rebuilding
from stark.scene_record import RecordedScene

UNTURNED = np.eye(3)


def everything() -> stark.Scene:
    """One of each kind of body and of what connects them."""
    scene = stark.Scene("everything")
    scene.default_friction = 0.3
    table = scene.add_box((2.0, 2.0, 0.1), motion="fixed", name="table", color=(0.5, 0.5, 0.5))
    sheet = scene.add_cloth(
        stark.mesh.grid(0.3, 0.3, 4),
        stark.materials.membrane_st_venant_kirchhoff(
            density=0.2, thickness=1e-3, youngs_modulus=np.linspace(4e3, 6e3, 32), poissons_ratio=0.3
        ),
        position=(0, 0, 0.06),
        name="sheet",
        pins=[0],
        friction=0.7,
    )
    cube = scene.add_solid(
        stark.mesh.tet_box(0.1, 2), position=(0.5, 0, 0.11), name="cube", velocity=(0, 0, -1)
    )
    quadratic = stark.mesh.to_quadratic(stark.mesh.tet_box(0.1, 1))
    scene.add_solid(
        quadratic,
        stark.materials.neo_hookean(density=900.0, youngs_modulus=1e5, poissons_ratio=0.3),
        position=(0.8, 0, 0.11),
        name="block",
    )
    cord = scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 6), position=(-0.5, 0, 0.2), name="cord")
    cord.clamp([0])
    box = scene.add_box(0.1, mass=1.0, position=(0, 0.5, 0.12), name="box")
    hand = scene.add_box(0.1, motion="scripted", position=(0, 0.7, 0.12), name="hand")
    hinge = scene.add_hinge(hand, box, anchor=(0, 0.6, 0.12), axis=(1, 0, 0), name="elbow")
    motor = hinge.add_motor(target=1.0, cap=0.1, delta=1.0)
    motor.target = 2.0
    cube.add_skin(stark.materials.pet, name="film")
    cube.add_fibres(stark.materials.rubber_cord, paths=[[0, 1, 2]], name="threads")
    scene.attach(
        sheet.vertices[[24]], scene.add_box(0.02, mass=0.01, position=(0.15, 0.15, 0.08), name="weight")
    )
    scene.friction[box, table] = 0.5, 0.4
    scene.disable_contact(hand, table)
    return scene


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


def test_a_failed_step_fails_again_in_another_process(tmp_path: Path) -> None:
    sim = pressed()
    report = sim.step()
    assert report.failed
    script = sim.write_reproducer(tmp_path / "failure")
    assert script.name == "reproduce.py"
    text = script.read_text()
    assert "Step 3 of the scene 'pressed' at t = 0.02 s, which failed." in text
    assert "rigid 'press'" in text or "rigid body 'press'" in text
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert report.brief() in done.stdout
    assert "blocked_motion" in done.stdout
    assert report.diagnosis.finding in done.stdout


def test_a_failed_step_of_a_copy_has_the_same_bits(tmp_path: Path) -> None:
    sim = pressed()
    report = sim.step()
    sim.write_reproducer(tmp_path)
    again = reproducer.load(tmp_path)
    assert again.state == sim.state
    copy = again.step()
    assert copy.message == report.message
    assert copy.residual == report.residual
    assert copy.newton_iterations == report.newton_iterations
    assert copy.diagnosis.to_dict() == report.diagnosis.to_dict()


def test_scenes_of_all_kinds_of_parts_go_on_with_the_same_bits(tmp_path: Path) -> None:
    sim = stark.Simulation(everything(), time_step=0.005, contact_distance=1e-3)
    for _ in range(3):
        assert not sim.step().failed
    sim.step()
    sim.write_reproducer(tmp_path)
    after = sim.state
    again = reproducer.load(tmp_path)
    assert again.state.step_count == 3
    assert not again.step().failed
    assert again.state == after
    assert [body.name for body in again.bodies] == [body.name for body in sim.bodies]
    for ours, theirs in zip(sim.bodies, again.bodies, strict=True):
        np.testing.assert_array_equal(ours.positions, theirs.positions)
    assert again._parts == sim._parts


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


def test_short_steps_and_settings_come_along(tmp_path: Path) -> None:
    sim = pressed(**{"newton.max_iterations": 37, "gravity": (0, 0, -1.62)})
    sim.step(max_time_step=0.0071)
    script = sim.write_reproducer(tmp_path)
    assert "sim.step(max_time_step=0.0071)" in script.read_text()
    again = reproducer.load(tmp_path)
    assert again.settings == sim.settings


def test_formulas_are_left_out_and_named(tmp_path: Path) -> None:
    @stark.energy
    def pull(p: stark.Point, force: stark.Vec3):
        return -stark.dot(force, p.x)

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 3), name="sheet")
    scene.add(pull(sheet.vertices[[0]], force=(0, 0, 1.0)), name="string")
    sim = stark.Simulation(scene)
    sim.step()
    script = sim.write_reproducer(tmp_path)
    assert "energy 'string'" in script.read_text()
    with pytest.warns(stark.StarkWarning, match="without energy 'string'"):
        again = reproducer.load(tmp_path)
    assert not again.step().failed


def test_joints_of_ones_own_are_refused_with_their_names(tmp_path: Path) -> None:
    @stark.joint
    def stick(a: stark.Frame, b: stark.Frame):
        return stark.hold(length=a.x - b.x)

    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="box")
    scene.add_joint(stick, None, box, anchor=(0, 0, 0), name="nail")
    sim = stark.Simulation(scene)
    sim.step()
    sim.write_reproducer(tmp_path)
    with pytest.raises(stark.ReproducerError, match=r"joint 'nail'.*checkpoint"):
        reproducer.load(tmp_path)


def test_nothing_to_write(tmp_path: Path) -> None:
    sim = pressed()
    sim.state = sim.state
    with pytest.raises(stark.ReproducerError, match="must be written after a step"):
        sim.write_reproducer(tmp_path)


def test_damaged_files(tmp_path: Path) -> None:
    sim = pressed()
    sim.step()
    sim.write_reproducer(tmp_path)
    with pytest.raises(stark.ReproducerError, match="no such file"):
        reproducer.load(tmp_path / "elsewhere")
    data = tmp_path / "step.npz"
    whole = data.read_bytes()
    data.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(stark.ReproducerError, match="damaged"):
        reproducer.load(tmp_path)
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(stark.ReproducerError, match="cannot be written"):
        sim.write_reproducer(blocked)


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


def test_friction_with_a_direction_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    scene = stark.Scene()
    scene.add_rigid(stark.mesh.grid(1.0, 1.0, 2), motion="fixed", name="floor")
    box = scene.add_box(0.1, mass=1.0, name="box", position=(0, 0, 0.0515), velocity=(1.0, 0.5, 0.0))
    box.surface_direction = (1.0, 0.0, 0.0)
    scene.friction[box, "floor"] = stark.Anisotropic(along=0.1, across=0.4)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    sim.write_reproducer(tmp_path)
    again = stark.reproducer.load(tmp_path)
    again.step()
    assert again.state.hash == sim.state.hash


def test_every_recorded_call_can_be_repeated() -> None:
    recorded = {
        call
        for call in vars(RecordedScene)
        if call.startswith(("add_", "set_", "pin", "clamp", "disable_", "enable_"))
    }
    assert recorded - {"add_energy"} | {"default_friction"} == rebuilding._CALLS  # formulas are code
