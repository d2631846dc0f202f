"""What is fuzzed: functions of drawn values. They return when all is well, and raise AssertionError, or what
Stark should not have raised, when it is not."""

from __future__ import annotations

import math
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from _checkpoints import checkpoints
from _draw import ODD_NUMBERS, Draw
from _energies import energies
from _functions import functions
from _robot_files import robot_files
from _run_folders import run_folders
from _scene_documents import scene_documents
from _world import CALLS, CHAIN, GRID, HEXES, TETS, Call, World

import stark
from stark import materials, mesh

#: Iterations and halvings of the steps that random scenes take.
_SHORT = {"newton.max_iterations": 8, "time.step": 0.01, "time.min_step": 0.004, "execution.threads": 1}
_MEASURES = ("volume", "area", "is_closed", "length", "volumes", "edges")
_ODD_ASSIGNMENTS = ("", "=", "=1", "time.step", "time.step=", "time.step=0x1", "a=b=c")


def refused(draw: Draw, name: str, action: Callable[[], Any]) -> bool:
    """Whether Stark refused it, with an exception of its own that says something."""
    draw.trace.append(name)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            action()
    except stark.InternalError:
        raise
    except stark.Error as error:
        assert len(str(error)) > 10, f"{error!r} says nothing"
        draw.trace[-1] += f" -> {str(error)[:160]}"
        return True
    return False


def scene(draw: Draw) -> None:
    """Calls that add to a scene: those that are refused leave it as it was."""
    world, done = World(), []
    for _ in range(1 + draw.integer(4)):
        name = draw.pick(list(CALLS))
        call = CALLS[name](draw)
        before = world.fingerprint()
        if refused(draw, name, lambda call=call: world.rest.append(call(world))):
            after = world.fingerprint()
            assert after == before, (
                f"{name} was refused and changed the scene:\n{_first_difference(before, after)}"
            )
        else:
            done.append(call)
    _same_as_without(draw, world, done)


def _same_as_without(draw: Draw, world: World, done: list[Call]) -> None:
    """What was refused has left no trace in the model either; the scene can be simulated, or is refused."""
    made: list[Any] = []
    if refused(draw, "simulate", lambda: made.append(stark.Simulation(world.scene, **_SHORT))):
        return
    again = World()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for call in done:
            call(again)
        other = stark.Simulation(again.scene, **_SHORT)
    assert made[0]._core.parts() == other._core.parts()
    _step(made[0])


def _step(sim: Any) -> None:
    time, before = sim.time, [body.positions for body in sim.bodies]
    report = sim.step()
    after = [body.positions for body in sim.bodies]
    if report.failed:
        assert report.message
        assert sim.time == time
        assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))
    else:
        assert math.isfinite(sim.time)
        assert all(np.isfinite(positions).all() for positions in after)


def _first_difference(a: tuple[Any, ...], b: tuple[Any, ...]) -> str:
    return next((f"{x}\n{y}" for x, y in zip(a, b, strict=True) if x != y), "")


def meshes(draw: Draw) -> None:
    """Constructors and functions of meshes."""
    sizes = [draw.value(0.1), draw.value(0.2)]
    counts = [draw.count(4), draw.count(3)]
    vertices, size = draw.array(GRID.vertices), draw.vector(0.1, 0.2, 0.3)
    made: list[Any] = [GRID]
    makers: dict[str, Callable[[], Any]] = {
        "TriangleMesh": lambda: mesh.TriangleMesh(vertices, draw.array(GRID.triangles)),
        "TetMesh": lambda: mesh.TetMesh(draw.array(TETS.vertices), draw.array(TETS.tets)),
        "SolidMesh": lambda: mesh.SolidMesh(draw.array(HEXES.vertices), draw.array(HEXES.elements)),
        "Polyline": lambda: mesh.Polyline(draw.array(CHAIN)),
        "grid": lambda: mesh.grid(*sizes, draw.value(counts[0], ((2, 3), (0, 1), (1,), "a"))),
        "box": lambda: mesh.box(size, counts[0]),
        "sphere": lambda: mesh.sphere(sizes[0], draw.count(1)),
        "cylinder": lambda: mesh.cylinder(*sizes, *counts),
        "capsule": lambda: mesh.capsule(*sizes, *counts),
        "torus": lambda: mesh.torus(sizes[1], sizes[0], *counts),
        "polyline": lambda: mesh.polyline(size, draw.vector(1.0, 0.0, 0.0), counts[0]),
        "helix": lambda: mesh.helix(*sizes, draw.value(2.0), counts[0]),
        "tet_box": lambda: mesh.tet_box(size, draw.value(counts[1], ((1, 2, 3), (0, 1, 1), (1, 1), "abc"))),
        "box_hexahedra": lambda: mesh.box_hexahedra(size, counts[1]),
        "as pair": lambda: mesh.as_triangle_mesh((vertices, draw.array(GRID.triangles)), "a"),
    }
    name = draw.pick(list(makers))
    if refused(draw, name, lambda: made.append(makers[name]())):
        return
    shape = made[-1]
    changes: dict[str, Callable[[], Any]] = {
        "scaled": lambda: shape.scaled(draw.value(2.0) if draw.byte() % 2 else draw.vector(1.0, 2.0, 3.0)),
        "translated": lambda: shape.translated(size),
        "rotated": lambda: shape.rotated(draw.array(np.eye(3))),
        "centered": lambda: shape.centered(),
        "flipped": lambda: shape.flipped() if hasattr(shape, "flipped") else shape.bounds,
        "measures": lambda: [getattr(shape, name, None) for name in _MEASURES],
        "compact": lambda: mesh.compact(shape),
        "merged": lambda: mesh.merged(shape, draw.value(0.0)),
        "oriented": lambda: mesh.oriented(shape),
        "to_quadratic": lambda: mesh.to_quadratic(shape),
        "surface": lambda: shape.surface() if hasattr(shape, "surface") else None,
        "repr": lambda: repr(shape),
    }  # fmt: skip
    change = draw.pick(list(changes))
    refused(draw, change, changes[change])


def mesh_files(draw: Draw) -> None:
    """Files of meshes: all bytes but the first two are what is in them."""
    suffix = draw.pick((".obj", ".ply", ".stl", ".npz", ".OBJ"))
    base, kind = draw.pick(_files(suffix.lower())), draw.integer(3)
    data = bytearray(base)
    if kind == 1:
        data = bytearray(draw._data[4:])
    elif kind == 2:
        for _ in range(1 + draw.integer(8)):
            at = (draw.byte() * 256 + draw.byte()) % max(1, len(data))
            action = draw.integer(4)
            if action == 0:
                data[at : at + 1] = bytes([draw.byte()])
            elif action == 1:
                del data[at : at + 1 + draw.integer(20)]
            elif action == 2:
                data[at:at] = draw.pick(
                    (b"nan ", b"-1 ", b"1e999 ", b"f 1 2 3\n", b"9" * 12, b"\xff", b"\n", b" ")
                )
            else:
                del data[at:]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        path.write_bytes(bytes(data))
        made: list[Any] = []
        if not refused(draw, f"load {suffix} {bytes(data)[:60]!r}", lambda: made.append(mesh.load(path))):
            refused(draw, "add", lambda: stark.Scene().add_rigid(made[0], mass=1.0))


@cache
def _files(suffix: str) -> list[bytes]:
    """Good files of a format, of one triangle; of arrays also a volume."""
    corners = ((0, 0, 0), (1, 0, 0), (0, 1, 0))
    lines = ["{} {} {}".format(*corner) for corner in corners]
    if suffix == ".obj":
        return ["\n".join([*("v " + line for line in lines), "vn 0 0 1", "f 1//1 2//1 -1//1", ""]).encode()]
    if suffix == ".ply":
        axes = [f"property float {axis}" for axis in "xyz"]
        head = [
            "element vertex 3",
            *axes,
            "element face 1",
            "property list uchar int vertex_indices",
            "end_header",
        ]
        text = "\n".join(["ply", "format ascii 1.0", *head, *lines, "3 0 1 2", ""]).encode()
        start = "\n".join(["ply", "format binary_little_endian 1.0", *head, ""]).encode()
        body = np.array(corners, "<f4").tobytes() + b"\3" + np.array([0, 1, 2], "<i4").tobytes()
        return [text, start + body]
    if suffix == ".stl":
        loop = ["outer loop", *("vertex " + line for line in lines), "endloop"]
        text = "\n".join(["solid a", "facet normal 0 0 1", *loop, "endfacet", "endsolid a", ""]).encode()
        body = np.array([(0, 0, 1), *corners], "<f4").tobytes() + bytes(2)
        return [text, bytes(80) + (1).to_bytes(4, "little") + body]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.npz"
        found = []
        for shape in (mesh.box(0.1), TETS, HEXES):
            shape.save(path)
            found.append(path.read_bytes())
    return found


def material(draw: Draw) -> None:
    """Materials: their constructors, functions and replace()."""
    kinds: list[Any] = [
        stark.ShellMaterial, stark.SolidMaterial, stark.RodMaterial, materials.neo_hookean,
        materials.mooney_rivlin, materials.fiber_reinforced, materials.orthotropic_cloth, materials.plate,
    ]  # fmt: skip
    kind = draw.pick(kinds)
    names = [
        "density",
        "youngs_modulus",
        "poissons_ratio",
        "thickness",
        "radius",
        "width",
        "c10",
        "warp_direction",
        "x",
    ]
    if isinstance(kind, type):
        names += [row["name"] for row in kind.parameters()]
    values = {
        draw.pick(names): draw.value(1.0) if draw.byte() % 2 else draw.array(np.ones(8))
        for _ in range(draw.integer(4))
    }
    if kind is materials.plate:
        values = {"youngs_modulus": 1e6, "poissons_ratio": 0.3, "thickness": 1e-3, "density": 1e3} | values
    made: list[Any] = []
    if refused(draw, f"{kind.__name__}({values})", lambda: made.append(kind(**values))):
        return
    refused(draw, "replace", lambda: made[0].replace(**{draw.pick(names): draw.value(2.0)}))
    refused(draw, "to_dict", lambda: (made[0].to_dict(), repr(made[0]), hash(made[0])))
    if isinstance(made[0], stark.ShellMaterial):
        refused(draw, "add", lambda: stark.Scene().add_cloth(GRID, made[0], mass=draw.value(None)))


def settings(draw: Draw) -> None:
    """Settings by name, in groups, as text; those that are refused stay as they were."""
    chosen, names = stark.Settings(), stark.Settings().names()
    for _ in range(1 + draw.integer(3)):
        name = draw.value(draw.pick(names), ("", "newton", "newton.", ".", "x", "time.step.x", "ä", "time"))
        value = draw.value(0.5, (*ODD_NUMBERS, "all", "any", "on", 3, 0.01))
        before = chosen.to_dict()
        actions: dict[str, Callable[[], Any]] = {
            "item": lambda name=name, value=value: chosen.__setitem__(name, value),
            "update": lambda name=name, value=value: chosen.update({"time_step": 0.02, name: value}),
            "nested": lambda name=name, value=value: chosen.update({"time": {name: value}}),
            "text": lambda name=name, value=value: chosen.set_text(f"{name}={value}"),
            "odd text": lambda: chosen.set_text(draw.pick(_ODD_ASSIGNMENTS)),
            "read": lambda name=name: chosen[name],
        }  # fmt: skip
        action = draw.pick(list(actions))
        if refused(draw, f"{action} {name} = {value!r}", actions[action]):
            assert chosen.to_dict() == before
    refused(draw, "validate", chosen.validate)
    refused(draw, "repr", lambda: (repr(chosen), chosen.brief(), stark.Settings(**chosen.to_dict())))


def live(draw: Draw) -> None:
    """Assignments to a simulation between its steps."""
    world = World()
    sim = stark.Simulation(world.scene, **_SHORT)
    three, value, axes, flag = (
        draw.vector(1.0, 0.0, 1.0),
        draw.value(0.01),
        draw.array(np.eye(3)),
        draw.value(True),
    )
    places = draw.array(GRID.vertices + np.array([0.0, 1.0, 1.1]))
    pins, name = draw.array(GRID.vertices[:2] + np.array([0.0, 1.0, 1.0])), draw.text("cloth")
    actions: dict[str, Callable[[], Any]] = {
        "position": lambda: setattr(world.lift, "position", three),
        "rotation": lambda: setattr(world.lift, "rotation", axes),
        "pose": lambda: setattr(world.lift, "pose", (three, axes)),
        "velocity": lambda: setattr(world.lift, "velocity", three),
        "angular_velocity": lambda: setattr(world.lift, "angular_velocity", three),
        "place": lambda: setattr(world.box, draw.pick(("position", "velocity", "angular_velocity")), three),
        "turn": lambda: setattr(world.box, "rotation", axes),
        "place cloth": lambda: setattr(world.cloth, draw.pick(("positions", "velocities")), places),
        "place joint": lambda: setattr(world.hinge, draw.pick(("coordinates", "rates")), {"angle": value}),
        "angle": lambda: setattr(world.hinge, "angle", value),
        "place together": lambda: _place_together(sim, world, three, value),
        "reset": lambda: sim.reset(None if flag is True else flag),
        "pin_targets": lambda: setattr(world.cloth, "pin_targets", pins),
        "follow": lambda: world.lift.follow(lambda t: three),
        "follow pins": lambda: world.cloth.follow(displacement=lambda t: three),
        "motor": lambda: setattr(world.motor, draw.pick(("target", "cap", "delta")), value),
        "motor enabled": lambda: setattr(world.motor, "enabled", flag),
        "joint enabled": lambda: setattr(world.hinge, "enabled", flag),
        "load": lambda: setattr(world.load, "force", three),
        "step": lambda: sim.step(max_time_step=value),
        "run": lambda: sim.run(value),
        "body": lambda: sim[name],
        "state": lambda: setattr(sim, "state", sim.state if flag is True else flag),
        "load file": lambda: sim.load(str(name) + "/nowhere"),
    }  # fmt: skip
    for _ in range(1 + draw.integer(3)):
        action, before = draw.pick(list(actions)), sim.state
        if refused(draw, action, actions[action]) and action != "step":
            assert sim.state == before, f"{action} was refused and changed the state"
        refused(draw, "then step", lambda: _step(sim))


def _place_together(sim: stark.Simulation, world: World, three: Any, value: Any) -> None:
    with sim.placing():
        world.box.position = three
        world.hinge.angle = value


#: Targets by name, with the longest input that makes sense.
TARGETS: dict[str, Callable[[Draw], None]] = {
    f.__name__: f
    for f in (
        scene,
        meshes,
        mesh_files,
        material,
        settings,
        live,
        functions,
        run_folders,
        checkpoints,
        scene_documents,
        robot_files,
        energies,
    )
}
INPUT_SIZE = 160


def seeds(target: str, count: int, seed: int = 0) -> list[bytes]:
    """Inputs to begin with: good ones, in which a few values go wrong."""
    rng = np.random.default_rng([seed, sum(target.encode())])
    found = [bytes(INPUT_SIZE)]
    for _ in range(count - 1):
        data = rng.integers(0, 256, INPUT_SIZE, dtype=np.uint8)
        data[data % 8 == 1] += 1
        odd = rng.random(INPUT_SIZE) < rng.choice([0.0, 0.03, 0.15])
        data[odd] = 8 * rng.integers(0, 32, odd.sum()) + 1
        found.append(data.tobytes())
    return found
