"""Checkpoints in Python: what is compared, what is refused, memories, states as arrays, files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from _zoo import CASES, LIGHT, advance, pull

import stark
from stark import CheckpointError
from stark.checkpoint import Checkpoint

RUBBER = stark.materials.soft_rubber.replace(youngs_modulus=5e4)


def build(
    *,
    cells: int = 2,
    size: float = 0.05,
    material: stark.SolidMaterial = RUBBER,
    friction: float = 0.3,
    ball: bool = True,
    pins: tuple[int, ...] = (),
    stiffness: float = 0.1,
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0),
    break_force: float = 1.0,
    name: str = "cube",
    contact: bool = True,
    law: Callable = pull,
) -> stark.Scene:
    scene = stark.Scene("kitchen")
    scene.default_friction = friction
    floor = scene.add_floor(1.0)
    cube = scene.add_solid(stark.mesh.tet_box(size, cells), material, position=(0, 0, 0.1), name=name)
    if pins:
        cube.pin(pins)
    arm = scene.add_box(0.1, mass=1.0, position=(0.5, 0.0, 0.5), name="arm")
    scene.add_hinge(None, arm, anchor=(0.4, 0.0, 0.5), axis=axis, name="hinge")
    if ball:
        scene.add_sphere(0.03, subdivisions=1, mass=0.05, position=(0.3, 0.3, 0.2), name="ball")
    scene.add(law(cube.vertices, target=(0.0, 0.0, 0.05), stiffness=stiffness))
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), LIGHT, position=(-0.3, 0.0, 0.2), name="cloth")
    scene.attach(cloth.vertices[0], None, break_force=break_force, name="glue")
    if not contact:
        scene.disable_contact(floor, cube)
    return scene


def simulate(scene: stark.Scene, **settings: object) -> stark.Simulation:
    return stark.Simulation(scene, **{"time_step": 0.01, **settings})


@stark.energy
def other_pull(
    p: stark.Point,
    target: stark.Vec3,
    stiffness: float = stark.parameter(unit="N/m", min=0.0),
    time: stark.Time = 0.0,
):
    d = p.x - target - stark.vec([0.02 * stark.sin(20.0 * time), 0.0, 0.0])
    return 0.5 * stiffness * d @ d


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "a.stark"
    sim = simulate(build())
    for _ in range(2):
        sim.step()
    sim.save(path)
    return path


@pytest.mark.parametrize(
    ("change", "difference"),
    [
        ({"cells": 3}, "topology or pins of solid 'cube'"),
        ({"pins": (0,)}, "topology or pins of solid 'cube'"),
        ({"size": 0.051}, "rest shape of solid 'cube'"),
        ({"material": RUBBER.replace(youngs_modulus=6e4)}, "values of the energy '[a-z_]+' of 'cube'"),
        ({"material": RUBBER.replace(density=900.0)}, "mass of solid 'cube'"),
        ({"friction": 0.31}, "coefficients of friction"),
        ({"ball": False}, r"kind, motion, topology or pins of rigid 'ball' \(only in the checkpoint\)"),
        ({"name": "dice"}, r"solid 'dice' \(not in the checkpoint\)"),
        ({"stiffness": 0.2}, "values of the energy 'pull'"),
        ({"law": other_pull}, r"the energy 'other_pull' \(not in the checkpoint\)"),
        ({"axis": (0.0, 0.0, 1.0)}, "points of joints, actuators and attachments of the kind 'hinge'"),
        ({"break_force": 2.0}, "breaking force of attachment 'glue'"),
        ({"contact": False}, "pairs of bodies without contact"),
    ],
)
def test_other_scenes_are_refused_with_what_differs(change: dict, difference: str, saved: Path) -> None:
    sim = simulate(build(**change))
    sim.step()
    before = sim.state
    with pytest.raises(CheckpointError, match=f"is of another scene: it differs in .*{difference}"):
        sim.load(saved)
    assert sim.state == before


def test_formulas_are_compared_not_only_their_names(saved: Path) -> None:
    other_pull.name = "pull"
    try:
        with pytest.raises(CheckpointError, match="differs in formula of the energy 'pull'"):
            simulate(build(law=other_pull)).load(saved)
    finally:
        other_pull.name = "other_pull"


def test_other_settings_are_refused_with_both_values(saved: Path) -> None:
    with pytest.raises(
        CheckpointError, match=r"setting contact.distance \(0.0 in the checkpoint, 0.002 here\)"
    ):
        simulate(build(), contact_distance=0.002).load(saved)
    with pytest.raises(CheckpointError, match=r"time.integrator \(implicit_euler in the checkpoint, bdf2 h"):
        simulate(build(), **{"time.integrator": "bdf2"}).load(saved)
    simulate(build(), threads=2, **{"execution.backend": "interpreter"}).load(saved)


def test_loading_into_another_scene_on_purpose(saved: Path) -> None:
    expected = Checkpoint.read(saved).state
    sim = simulate(build(friction=0.9, material=RUBBER.replace(youngs_modulus=9e4)), contact_distance=5e-4)
    sim.load(saved, exact=False)
    assert sim.state == expected and not sim.step().failed
    for change in ({"cells": 3}, {"ball": False}, {"pins": (0,)}):
        with pytest.raises(CheckpointError, match="make a scene with the same bodies and joints"):
            simulate(build(**change)).load(saved, exact=False)
    other = simulate(build(), **{"time.integrator": "bdf2"})
    other.load(saved, exact=False)
    assert other.step().integrator == "implicit_euler" and other.step().integrator == "bdf2"


def test_a_stark_that_computes_differently_warns(saved: Path, tmp_path: Path) -> None:
    """What another version would do: the same scene, another step."""
    checkpoint = Checkpoint.read(saved)
    assert checkpoint.last is not None
    arrays = checkpoint.last.before.arrays()
    arrays["point_velocity"] = arrays["point_velocity"] * (1 + 1e-12)
    before = stark._core.State.of_arrays(arrays)
    other = Checkpoint(**{**vars(checkpoint), "last": checkpoint.last._replace(before=before)})
    other.write(tmp_path / "b.stark")
    sim = simulate(build())
    with pytest.warns(stark.StarkWarning, match="taken again, has other bits"):
        sim.load(tmp_path / "b.stark")
    assert sim.state == checkpoint.state and len(sim.contacts) == 0


MEMORY = {
    "none": None,
    "flag": True,
    "count": 3,
    "large": 2**130,
    "pi": 0.1 + 0.2,
    "nan": float("nan"),
    "text": "Ω\n'\"",
    "list": [1, [2.5, None]],
    "tuple": (1, ("a",)),
    "nested": {"a": {"b": [{"c": 1}]}},
    "random": np.random.default_rng(1).bit_generator.state,
    "mersenne": np.random.RandomState(1).get_state(legacy=False),
    **{kind: np.arange(6).reshape(2, 3).astype(kind) for kind in ("f8", "f4", "i8", "u2", "?")},
    "empty": np.zeros((0, 3)),
    "scalar": np.array(2.5),
    "fortran": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
}


def test_memories_come_back_as_they_were(tmp_path: Path) -> None:
    sim = CASES["energies"].simulate()
    sim.save(tmp_path / "a.stark", memory=MEMORY)
    recalled = sim.load(tmp_path / "a.stark")

    def same(a: object, b: object) -> bool:
        if isinstance(a, dict):
            return list(a) == list(b) and all(same(a[k], b[k]) for k in a)
        if isinstance(a, (list, tuple)):
            return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
        if isinstance(a, np.ndarray):
            return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
        return type(a) is type(b) and (a == b or a != a)

    assert same(MEMORY, recalled)


@pytest.mark.parametrize(
    ("memory", "message"),
    [
        ({"a": object()}, r"memory\['a'\] is a object: must be a number, text"),
        ({"a": [1, {2: 3}]}, r"memory\['a'\]\[1\]: key 2: must be a text"),
        ({"$array": 1}, r"key '\$array': must be a text that does not start with"),
        ({"a": np.array([{}])}, r"memory\['a'\] is a ndarray"),
        ({"a": {1, 2}}, r"memory\['a'\] is a set"),
    ],
)
def test_memories_that_cannot_be_kept(memory: dict, message: str, tmp_path: Path) -> None:
    sim = CASES["energies"].simulate()
    with pytest.raises(CheckpointError, match=message):
        sim.save(tmp_path / "a.stark", memory=memory)
    assert not (tmp_path / "a.stark").exists()
    endless: dict = {}
    endless["self"] = endless
    with pytest.raises(CheckpointError, match="nested deeper than 50 levels, or holds itself"):
        sim.save(tmp_path / "a.stark", memory=endless)


def test_equal_states_make_equal_files_that_numpy_reads(tmp_path: Path) -> None:
    for name in ("a", "b"):
        sim = CASES["mechanism"].simulate()
        advance(CASES["mechanism"], sim, {}, 3)
        sim.save(tmp_path / f"{name}.stark")
    assert (tmp_path / "a.stark").read_bytes() == (tmp_path / "b.stark").read_bytes()
    with np.load(tmp_path / "a.stark") as arrays:
        header = json.loads(arrays["header"].tobytes())
        assert (header["format"], header["version"]) == ("stark-checkpoint", 3)
        np.testing.assert_array_equal(arrays["state/point_position"], sim.state.point_positions)
        names = {f["name"] for f in stark._core.State.fields()}
        assert {n.partition("/")[2] for n in arrays.files if n.startswith("state/")} == names


def test_files_are_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sim = CASES["energies"].simulate()
    sim.save(tmp_path / "a.stark")
    before = (tmp_path / "a.stark").read_bytes()
    sim.step()

    def full(*_: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(CheckpointError, match=r"cannot be written: No space left on device"):
        sim.save(tmp_path / "a.stark")
    assert (tmp_path / "a.stark").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.stark"]
    with pytest.raises(CheckpointError, match="cannot be written"):
        sim.save(tmp_path / "nowhere/a.stark")


def test_another_process_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    case = CASES["clutter"]
    sim = case.simulate()
    advance(case, sim, {}, 3)
    sim.save(tmp_path / "a.stark")
    hashes = [state for state, _ in advance(case, sim, {}, 3)]
    code = (
        "import sys; from _zoo import CASES, advance; case = CASES['clutter']; sim = case.simulate();"
        "sim.load(sys.argv[1]); print(*(state for state, _ in advance(case, sim, {}, 3)))"
    )
    paths = [str(Path(stark.__file__).parent.parent), str(Path(__file__).parent)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    command = [sys.executable, "-c", code, str(tmp_path / "a.stark")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == hashes


def test_values_of_the_file_reach_every_simulation_of_the_scene(tmp_path: Path) -> None:
    case = CASES["energies"]
    sim = case.simulate()
    energy = sim.scene.energies[1]
    energy.stiffness = 0.4
    sim.save(tmp_path / "a.stark")
    energy.stiffness = 0.5
    handed_out = sim.scene.energies[0].stiffness
    handed_out[:] = 0.9
    sim.load(tmp_path / "a.stark")
    assert energy.stiffness == 0.4 and (handed_out == 0.1).all()


def test_loading_leaves_no_warning_and_a_repr(saved: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(build()).load(saved)
    checkpoint = Checkpoint.read(saved)
    assert checkpoint.time == pytest.approx(0.02) and checkpoint.scene == "kitchen"
    assert "kitchen" in repr(checkpoint) and len(repr(checkpoint)) < 300


# --- states as arrays ---


def test_states_are_values_of_named_arrays() -> None:
    sim = CASES["mechanism"].simulate()
    sim.step()
    state = sim.state
    copy = state.copy()
    assert copy == state and copy is not state
    sim.step()
    assert sim.state != state and copy == state
    arrays = state.arrays()
    assert stark._core.State.of_arrays(arrays) == state
    assert [f["name"] for f in stark._core.State.fields()] == list(arrays)
    assert arrays["time"].shape == () and arrays["step_count"].dtype == np.int64
    assert arrays["body_rotation"].shape == (3, 3, 3) and arrays["body_position"].shape == (3, 3)
    arrays["body_position"][:] = 0.0  # a copy
    assert state == copy


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": None}, "field 'time' is missing"),
        ({"tme": np.array(0.0)}, "unknown field 'tme'.*did you mean 'time'"),
        ({"time": np.zeros(1)}, "'time' has real numbers in 1 dimensions: must have real numbers in 0"),
        ({"step_count": np.array(1.0)}, "'step_count' has real numbers in 0 dimensions: must have integers"),
        ({"body_position": np.zeros((3, 2))}, "'body_position'.*with the last ones of 3"),
        ({"body_position": np.zeros((3, 3), dtype="f4")}, "'body_position' must be a contiguous array"),
        ({"body_position": "no"}, "'body_position' must be a contiguous array"),
    ],
)
def test_arrays_that_are_no_state(change: dict, message: str) -> None:
    sim = CASES["mechanism"].simulate()
    arrays = {**sim.state.arrays(), **change}
    with pytest.raises(stark.InvalidArgument, match=message):
        stark._core.State.of_arrays({k: v for k, v in arrays.items() if v is not None})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("body_position", np.zeros((4, 3)), "has 0 points, 4 rigid bodies.*'body_position' is not as long"),
        ("body_velocity", np.zeros((2, 3)), "'body_velocity' is not as long"),
        ("body_position", np.full((3, 3), np.nan), r"body_position\[0\] = nan m: must be finite"),
        ("time_step", np.array(0.0), r"time_step = 0 s: must be > 0"),
        ("step_count", np.array(-1), r"step_count = -1: must be >= 0"),
        ("joint_enabled", np.array([1.0, 2.0, 1.0]), r"joint_enabled\[1\] = 2.*must be 1, 0 or -1"),
        ("actuator_value", None, r"actuator_value\[0\] = nan.*must be a number"),
    ],
)
def test_states_that_no_simulation_can_be_in(name: str, value: np.ndarray | None, message: str) -> None:
    sim = CASES["mechanism"].simulate()
    before = sim.state
    arrays = before.arrays()
    arrays[name] = np.full_like(arrays[name], np.nan) if value is None else value
    with pytest.raises(stark.InvalidArgument, match=message):
        sim.state = stark._core.State.of_arrays(arrays)
    assert sim.state == before
