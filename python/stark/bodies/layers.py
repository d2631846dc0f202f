"""Layers of composite bodies: skins and fibres on the vertices of a cloth or a solid.

``solid.add_skin(material)`` and ``cloth.add_fibres(material, edges)`` add stiffness and mass to vertices that
are there already: nothing is glued, and contact stays that of the body."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.attributes import KnownAttributes
from stark.bodies.body import Body
from stark.bodies.fibre_paths import FibrePaths
from stark.handle import Handle, SimulationLink
from stark.mesh import Indices
from stark.tubes import outline, prisms

Floats = NDArray[np.float64]


class Layer(Handle, KnownAttributes):
    """What skins and fibres have in common. ``sim.layers`` are the handles of one particular simulation."""

    kind: str = ""

    def __init__(self, body: Body, index: int, material: Any, color: Any) -> None:
        super().__init__(body._scene, index)
        self._body = body
        self._material = material
        self._color = None if color is None else tuple(float(c) for c in color)

    @property
    def body(self) -> Body:
        """The body whose vertices it is on."""
        return self._body

    @property
    def material(self) -> Any:
        """What the layer is made of."""
        return self._material

    @property
    def mass(self) -> float:
        """[kg]; part of the mass of the body."""
        raise NotImplementedError

    @property
    def motion(self) -> str:
        """``motion`` of the body that has the layer."""
        return self._body.motion

    @property
    def color(self) -> tuple[float, ...] | None:
        """Red, green, blue in [0, 1] for pictures, or None."""
        return self._color

    def _is_drawn(self) -> bool:
        raise NotImplementedError

    def _bound_to(self, simulation: SimulationLink) -> Self:
        return self._on(self._body._bound_to(simulation))

    def _on(self, body: Body) -> Self:
        """The same layer, of another handle of its body."""
        handle = object.__new__(type(self))
        handle.__dict__.update(self.__dict__, _body=body, _of=body._of)
        return handle

    def __repr__(self) -> str:
        return f"<stark.{type(self).__name__} '{self.name}' of '{self._body.name}'>"


class Skin(Layer):
    """A sheet on vertices of a body: membrane and bending of a ``ShellMaterial``. Pictures show it when it
    has a colour, in front of the surface."""

    kind = "skin"
    _triangles: Indices

    @property
    def name(self) -> str:
        """Name of the layer, unique among bodies and layers of its scene."""
        return self._scene._core.skin_name(self._index)

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._core.skin_count

    @property
    def mass(self) -> float:
        """[kg]; part of the mass of the body."""
        return self._scene._core.skin_mass(self._index)

    @property
    def triangles(self) -> Indices:
        """(m, 3) vertices of the body."""
        return self._triangles

    @property
    def surface_positions(self) -> Floats:
        """Its vertices (k, 3) [m], half of its thickness in front of the body but at least so far that
        pictures tell them apart."""
        used, triangles = self._used()
        x = self._body.positions[used]
        corners = x[triangles]
        normals = np.zeros_like(x)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        for k in range(3):
            np.add.at(normals, triangles[:, k], across)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        visible = 2e-3 * float(np.ptp(self._body.mesh.vertices, axis=0).max())
        shown: Floats = x + max(0.5 * self._material.thickness, visible) * normals / np.maximum(
            lengths, 1e-300
        )
        return shown

    @property
    def surface_triangles(self) -> Indices:
        """Triangles for pictures (m, 3), as indices of ``surface_positions``."""
        return self._used()[1]

    def _used(self) -> tuple[Indices, Indices]:
        used, renumbered = np.unique(self._triangles, return_inverse=True)
        return used, renumbered.reshape(self._triangles.shape).astype(np.int32)

    def _is_drawn(self) -> bool:
        return self._color is not None


class Fibres(Layer):
    """Rods along vertices of a body. Pictures show them as tubes."""

    kind = "fibres"
    _paths: FibrePaths
    _bending: bool

    @property
    def name(self) -> str:
        """Name of the layer, unique among bodies and layers of its scene."""
        return self._scene._core.fibres_name(self._index)

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._core.fibres_count

    @property
    def mass(self) -> float:
        """[kg]; part of the mass of the body."""
        return self._scene._core.fibres_mass(self._index)

    @property
    def bending(self) -> bool:
        """Whether they resist bending and twist besides stretch."""
        return self._bending

    @property
    def paths(self) -> list[Indices]:
        """Vertices of the body along each fibre; a ring ends where it starts."""
        return list(self._paths.paths)

    @property
    def edges(self) -> Indices:
        """(m, 2) vertices of the body: as they were given, or path by path."""
        return self._paths.edges

    @property
    def lengths(self) -> Floats:
        """Of the edges (m,) [m]."""
        x = self._body.positions
        lengths: Floats = np.linalg.norm(x[self.edges[:, 1]] - x[self.edges[:, 0]], axis=1)
        return lengths

    @property
    def stretches(self) -> Floats:
        """Lengths of the edges over their rest lengths (m,)."""
        X = self._body.mesh.vertices
        stretches: Floats = self.lengths / np.linalg.norm(X[self.edges[:, 1]] - X[self.edges[:, 0]], axis=1)
        return stretches

    @property
    def frames(self) -> Floats:
        """Frames of the nodes, path by path (n, 3, 3): axes d1, d2 of the section and d3 along the fibre as
        columns; none without bending."""
        simulation = self._body._simulation()
        if simulation is None:
            return self._scene._core.initial_fibre_frames(self._index).reshape(-1, 3, 3)
        if self._index >= simulation._core.fibres_count:
            raise InvalidArgument(
                f"fibres '{self.name}' were added after the simulation was created, so they have no frames "
                f"there: create a new stark.Simulation(scene)"
            )
        return simulation._core.fibre_frames(self._index).reshape(-1, 3, 3)

    @property
    def surface_positions(self) -> Floats:
        """Vertices of a tube around each edge (k, 3) [m], for pictures."""
        x = self._body.positions
        normals = self.frames[self._paths.edge_nodes][..., 0].sum(axis=1) if self._bending else None
        return prisms(x[self.edges[:, 0]], x[self.edges[:, 1]], normals, outline(self._material))[0]

    @property
    def surface_triangles(self) -> Indices:
        """Triangles for pictures (m, 3), as indices of ``surface_positions``."""
        x = self._body.mesh.vertices
        return prisms(x[self.edges[:, 0]], x[self.edges[:, 1]], None, outline(self._material))[1]

    def _is_drawn(self) -> bool:
        return True
