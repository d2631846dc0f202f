"""Reads a reproducer and makes the simulation again, right before the step."""

from __future__ import annotations

import json
import warnings
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stark import _core
from stark._core import InvalidArgument
from stark.arguments import given_path
from stark.array_file import DamageError, check_format, read_arrays
from stark.bodies import Cloth, RigidBody, Solid
from stark.checkpoint import memory
from stark.mesh import Polyline, SolidMesh, TetMesh, TriangleMesh
from stark.rods import Rod
from stark.scene import Scene, StarkWarning

from .errors import ReproducerError
from .parts import from_data
from .writing import DATA, FORMAT_NAME, FORMAT_VERSION

if TYPE_CHECKING:
    from stark.simulation import Simulation


def load(path: str | PathLike[str]) -> Simulation:
    """The simulation of a reproducer, a folder or its ``step.npz``, right before the step that it holds. Its
    scene has handles of the bodies; other parts act, but have none.

    Energies that could not be written are left out, with a StarkWarning. Raises ReproducerError for files
    that are missing, damaged or of another version, and where other parts could not be written."""
    path = given_path(path, "reproducer: path")
    path = path / DATA if path.is_dir() else path
    owner = f"reproducer '{path}'"
    header, arrays = _read(path, owner)
    try:
        sim = simulation_of(header, arrays, owner)
    except ReproducerError:
        raise
    except (InvalidArgument, KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise ReproducerError(f"{owner} is damaged ({error}); write it again") from error
    if header["missing"]:
        lost = ", ".join(row["what"] for row in header["missing"])
        warnings.warn(f"{owner}: without {lost}: formulas are code and not in it", StarkWarning, stacklevel=2)
    return sim


def _read(path: Path, owner: str) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        arrays: dict[str, Any] = dict(read_arrays(path))
        header = json.loads(arrays.pop("header").astype(np.uint8).tobytes())
    except FileNotFoundError:
        raise ReproducerError(f"{owner}: there is no such file") from None
    except (DamageError, KeyError, ValueError, RecursionError) as error:
        raise ReproducerError(f"{owner} is damaged or no reproducer ({error}); write it again") from error
    try:
        return check_format(header, "reproducer", FORMAT_NAME, FORMAT_VERSION), arrays
    except DamageError as error:
        raise ReproducerError(f"{owner}: {error}") from None


def simulation_of(header: dict[str, Any], arrays: dict[str, Any], owner: str) -> Simulation:
    """The simulation of what a file holds."""
    from stark.simulation import Simulation

    needed = [row["what"] for row in header["missing"] if row["call"] != "add_energy"]
    if needed:
        raise ReproducerError(
            f"{owner}: {', '.join(needed)} could not be written, because formulas are code, and the state "
            f"does not fit a scene without; make the scene with its own script and load a checkpoint"
        )
    scene = Scene(str(header["scene"]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StarkWarning)  # given when the scene was made
        for name, arguments in header["calls"]:
            _repeat(scene, name, from_data(memory.decode(arguments, arrays)))
        sim = Simulation(scene, **header["settings"])
    state = _core.State.of_arrays(
        {n.removeprefix("state/"): a for n, a in arrays.items() if n[:6] == "state/"}
    )
    if state.hash != header["state_hash"]:
        raise ReproducerError(f"{owner} is damaged (state); write it again")
    sim.state = state
    return sim


def _repeat(scene: Scene, name: str, arguments: list[Any]) -> None:
    """A call on the core, and a handle of the body that it adds."""
    if name not in _CALLS:
        raise ValueError(f"unknown call '{name}'")
    if name == "default_friction":
        scene.default_friction = arguments[0]
        return
    index = getattr(scene._core, name)(*arguments)
    if name in _BODIES:
        scene._append(_BODIES[name](scene, index, arguments[0]))


def _mesh_of_solid(given: dict[str, Any]) -> Any:
    elements = np.asarray(given["elements"])
    mesh = TetMesh if elements.shape[1] == 4 else SolidMesh
    return mesh(given["vertices"], elements)


def _surface(given: dict[str, Any]) -> TriangleMesh:
    return TriangleMesh(given["vertices"], given["triangles"])


_BODIES: dict[str, Any] = {
    "add_cloth": lambda scene, index, g: Cloth(scene, index, _surface(g), g["color"]),
    "add_rigid": lambda scene, index, g: RigidBody(scene, index, _surface(g), g["color"]),
    "add_solid": lambda scene, index, g: Solid(scene, index, _mesh_of_solid(g), g["color"]),
    "add_rod": lambda scene, index, g: Rod(scene, index, Polyline(g["vertices"]), g["color"]),
}
_CALLS = {
    *_BODIES,
    *("add_skin", "add_fibres", "add_joint", "add_actuator", "add_attachment"),
    *("set_actuator_value", "set_actuator_enabled", "pin", "clamp"),
    *("set_friction", "set_anisotropic_friction", "set_restitution", "set_surface_directions"),
    *("disable_contact", "enable_contact", "default_friction"),
}
