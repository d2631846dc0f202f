"""Random calls with random arguments: each gives what it should, or an exception of Stark and a scene as it
was before. Always the same ones here; ``tools/fuzz.py`` goes on with new ones for as long as one likes."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _draw import Draw
from _targets import INPUT_SIZE, TARGETS, refused, seeds
from _world import GRID, World

import stark

ROOT = Path(__file__).resolve().parents[3]

#: Inputs of each target, a second of them.
_COUNTS = {
    "scene": 12,
    "meshes": 500,
    "mesh_files": 250,
    "material": 400,
    "settings": 500,
    "live": 12,
    "functions": 150,
    "run_folders": 100,
    "checkpoints": 100,
    "scene_documents": 150,
    "robot_files": 100,
    "energies": 60,
}


@pytest.mark.parametrize("name", TARGETS)
def test_random_input(name: str) -> None:
    for k, data in enumerate(seeds(name, _COUNTS[name])):
        draw = Draw(data)
        try:
            TARGETS[name](draw)
        except Exception as error:
            trace = "\n  ".join(draw.trace)
            raise AssertionError(f"{name}, input {k} ({data.hex()}):\n  {trace}\n{error!r}") from error


@pytest.mark.parametrize("name", TARGETS)
def test_zeros_are_good_input(name: str) -> None:
    """Otherwise most random input would be refused at its first value, and what comes after never run."""
    draw = Draw(bytes(INPUT_SIZE))
    TARGETS[name](draw)
    assert draw.trace
    assert not any("->" in line for line in draw.trace), draw.trace


def test_what_is_wrong_is_found() -> None:
    """The harness itself: raw exceptions and empty messages pass through it as failures."""
    draw = Draw(b"")

    def raises(error: Exception) -> Callable[[], None]:
        def action() -> None:
            raise error

        return action

    assert refused(draw, "good", raises(stark.InvalidArgument("x = 3 m: must be > 4"))) is True
    assert refused(draw, "nothing", lambda: None) is False
    for error in (TypeError("raw"), stark.InternalError("a defect of Stark"), RuntimeError("std::bad_cast")):
        with pytest.raises(type(error)):
            refused(draw, "bad", raises(error))
    with pytest.raises(AssertionError, match="says nothing"):
        refused(draw, "short", raises(stark.InvalidArgument("no")))


def test_changed_scenes_are_found() -> None:
    world = World()
    before = world.fingerprint()
    assert World().fingerprint() == before
    world.cloth.pin([5])
    assert world.fingerprint() != before


# --- what it found ---


@pytest.mark.parametrize(
    "call",
    [
        lambda w: w.scene.add_cloth(GRID, pins=np.empty(0, bool)),
        lambda w: w.scene.add_cloth(GRID, pins=np.array([[0, 1]])),
        lambda w: w.scene.add_cloth(GRID, pins=[[0], [1, 2]]),
        lambda w: w.scene.add_cloth(GRID, rest_angles=None),
        lambda w: w.scene.add_cloth(GRID, self_contact=np.zeros(3)),
        lambda w: w.scene.add_cloth(GRID, mass=10**400),
        lambda w: w.scene.add_box(0.1, motion="scripted", angular_velocity=(1e308, 0.0, 0.0)),
        lambda w: w.scene.add_floor(name="a\0b"),
        lambda w: w.scene.add_floor(name="\ud800"),
        lambda w: w.scene.add_rod(np.eye(3), rest_shape=np.array(["mesh", "straight"])),
        lambda w: w.scene.add_hinge(None, w.box, (0, 0, 0), (0, 0, 1), limits=(-np.inf, np.inf)),
        lambda w: w.scene.add_hinge(None, w.box, (0, 0, 0), (0, 0, 1), limits=([], 1)),
        lambda w: w.scene.add_hinge(None, w.box, (0, 0, 0), (0, 0, 1), contact=np.zeros(2)),
        lambda w: w.scene.add_slider(None, w.box, (0, 0, 0), (0, 0, 1), limits=(0.0, np.nan)),
        lambda w: w.scene.add_spring(None, w.box, (0, 0, 0), (0, 0, 1), stiffness=-1.0),
        lambda w: w.scene.add_spring(None, w.box, (0, 0, 0), (0, 0, 1), stiffness=1.0, name=7),
        lambda w: w.scene.add_tilt(None, w.box, (0, 0, 0), (0, 0, 1), limit=np.nan),
        lambda w: w.scene.attach(w.cloth, w.box, distance=10**400),
        lambda w: w.cloth.pin([[0], [1, 2]]),
        lambda w: setattr(w.cloth, "surface_direction", [[1, 0, 0], [0, 1]]),
        lambda w: w.cloth.frame([[0], [1, 2]]),
        lambda w: w.lift.follow(lambda t: [[0], [1, 2]]),
        lambda w: w.hinge.add_limit(object(), 1.0),
    ],
)
def test_refused_calls_leave_the_scene_as_it_was(call: Callable[[World], Any]) -> None:
    world = World()
    before = world.fingerprint()
    with pytest.raises(stark.InvalidArgument):
        call(world)
    assert world.fingerprint() == before
    world.scene.add_hinge(None, world.box, (0, 0, 0), (0, 0, 1), limits=(-1.0, 1.0))
    stark.Simulation(world.scene)


@pytest.mark.parametrize(
    "call",
    [
        lambda: stark.mesh.grid(1.0, 1.0, (2,)),
        lambda: stark.mesh.grid(1.0, 1.0, 2.5),
        lambda: stark.mesh.grid(1.0, 1.0, 90_000),
        lambda: stark.mesh.box(1.0, 90_000),
        lambda: stark.mesh.cylinder(1.0, 1.0, 90_000, 90_000),
        lambda: stark.mesh.tet_box([[1.0], [2.0, 3.0]], 1),
        lambda: stark.mesh.box_hexahedra(1.0, 1.5),
        lambda: stark.mesh.helix(1.0, [], 1.0, 4),
        lambda: stark.mesh.compact(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 2)),
        lambda: stark.mesh.oriented(stark.mesh.box_hexahedra(1.0, 1)),
        lambda: stark.mesh.merged(GRID, np.nan),
        lambda: stark.mesh.Polyline(np.empty((0, 3))).bounds,
        lambda: stark.TetMesh(np.eye(3), [[0, 1, 2, 12]]).volume,
        lambda: stark.TriangleMesh(np.eye(3), [[0, 1, -1]]).area,
        lambda: GRID.scaled({}),
        lambda: stark.materials.plate(youngs_modulus=1e6, poissons_ratio=1.0, thickness=1e-3, density=1e3),
        lambda: stark.materials.plate(youngs_modulus=b"0.1", poissons_ratio=0.3, thickness=1e-3, density=1e3),
        lambda: stark.RodMaterial(shear_stiffness=[1.0, [2.0]]),
    ],
)
def test_bad_arguments_are_refused(call: Callable[[], Any]) -> None:
    with pytest.raises(stark.InvalidArgument):
        call()


@stark.energy
def fall(p: stark.Point, weight: float = 1.0):
    return weight * p.x[2]


def test_scenes_and_simulations_say_why_they_cannot_be_copied() -> None:
    world = World()
    sim = stark.Simulation(world.scene)
    for thing, remedy in (
        (world.scene, "build it again"),
        (sim, "assign its state"),
        (world.box, "build it again"),
        (fall(world.box.points((0, 0, 0))), "pickle the energy itself"),
    ):
        for action in (copy.deepcopy, pickle.dumps):
            with pytest.raises(stark.InvalidArgument, match=f"cannot be copied or pickled: .*{remedy}"):
                action(thing)
    with pytest.raises(TypeError):  # as code that knows nothing of Stark expects
        copy.copy(world.scene)


def test_states_can_be_copied_and_pickled() -> None:
    sim = stark.Simulation(World().scene, time_step=0.01)
    sim.step()
    for state in (copy.deepcopy(sim.state), pickle.loads(pickle.dumps(sim.state))):
        assert state == sim.state


def test_states_of_another_kind_are_refused() -> None:
    sim = stark.Simulation(World().scene)
    with pytest.raises(stark.InvalidArgument, match=r"state = 3: must be"):
        sim.state = 3  # type: ignore[assignment]
    for until in ("soon", 10**400, None):
        with pytest.raises(stark.InvalidArgument, match="until"):
            sim.run(until)  # type: ignore[arg-type]


def test_the_tool_runs_and_reports(tmp_path: Path) -> None:
    command = [
        sys.executable,
        str(ROOT / "tools/fuzz.py"),
        "settings",
        "--seconds",
        "0.1",
        "--seed",
        "1",
        "--out",
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "settings: " in done.stdout and "0 failures" in done.stdout
