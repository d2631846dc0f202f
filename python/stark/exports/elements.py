"""The elements of solids and cloths with what is in them, as VTU: what is inside can be cut open."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import given_path
from stark.array_file import naming, write_atomically
from stark.bodies import Cloth, Solid
from stark.recording.export import vtu_of
from stark.render.fields import field_values, von_mises
from stark.render.tensors import tensor_values

Array = NDArray[Any]

#: By the nodes of an element: its type in VTK, whose order of nodes is that of Stark.
_TYPES = {3: 5, 4: 10, 8: 12, 10: 24, 27: 29}


def write_elements(path: str | PathLike[str], sim: Any) -> Path:
    """Writes the elements of all solids and cloths of a simulation, as they are now, to a VTU file for
    ParaView, meshio or PyVista; files with numbers, ``part_0001.vtu``, are a series for ParaView. At nodes,
    in double precision: ``displacement`` [m] since time 0, ``velocity`` [m/s], ``stress`` [Pa] of von Mises,
    ``strain``, ``plastic_strain``, ``stress_tensor`` (9) [Pa], the Cauchy stress in the axes of the world. Of
    cells: ``body``, its number in the scene."""
    file = given_path(path, "write_elements: path")
    if file.suffix != ".vtu":
        raise InvalidArgument(f"write_elements: path = '{file}': must end with .vtu")
    bodies = [(k, body) for k, body in enumerate(sim.bodies) if isinstance(body, (Cloth, Solid))]
    if not bodies:
        raise InvalidArgument("write_elements: the simulation has neither solids nor cloths")
    cells, owners, start = [], [], 0
    for k, body in bodies:
        elements = _elements(body)
        cells.append((elements + start, _TYPES[elements.shape[1]]))
        owners.append(np.full(len(elements), k))
        start += len(body.positions)
    stresses = tensor_values(sim, "stress")
    fields: dict[str, Callable[[Any], Array]] = {
        "displacement": lambda body: body.positions - body.vertices.positions,
        "velocity": lambda body: body.velocities,
        "stress": lambda body: von_mises(stresses[body.name]),
        "strain": lambda body: field_values(sim, "strain", body)[body.name],
        "plastic_strain": lambda body: field_values(sim, "plastic_strain", body)[body.name],
        "stress_tensor": lambda body: stresses[body.name].reshape(-1, 9),
    }
    data = vtu_of(
        np.concatenate([body.positions for _, body in bodies]),
        cells,
        np.concatenate(owners),
        {
            name: np.concatenate([np.asarray(value(body), dtype=np.float64) for _, body in bodies])
            for name, value in fields.items()
        },
    )
    with naming(file):
        write_atomically(file, lambda out: out.write(data))
    return file


def _elements(body: Any) -> Array:
    """(m, nodes), of what the body is made of: of lattices their cells."""
    mesh = body.mesh
    return np.asarray(mesh.triangles if isinstance(body, Cloth) else mesh.elements)
