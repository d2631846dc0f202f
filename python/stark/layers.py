"""Layers of composite bodies: skins and fibres on the vertices of a cloth or a solid.

``solid.add_skin(material)`` and ``cloth.add_fibres(material, edges)`` add stiffness and mass to vertices that
are there already: nothing is glued, and contact stays that of the body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array, given_choice, given_flag, given_name
from stark.attributes import KnownAttributes
from stark.fibre_paths import FibrePaths, paths_from
from stark.materials import RodMaterial, ShellMaterial, steel_wire
from stark.mesh import Indices, Points
from stark.tubes import outline, prisms

if TYPE_CHECKING:
    from stark.bodies import Body
    from stark.scene import Scene
    from stark.simulation import Simulation

Floats = NDArray[np.float64]


class Layer(KnownAttributes):
    """What skins and fibres have in common. ``sim.layers`` are the handles of one particular simulation."""

    kind: str = ""

    def __init__(self, body: Body, index: int, material: Any, color: Any) -> None:
        self._body = body
        self._index = index
        self._material = material
        self._color = None if color is None else tuple(float(c) for c in color)

    @property
    def name(self) -> str:
        raise NotImplementedError

    @property
    def body(self) -> Body:
        """The body whose vertices it is on."""
        return self._body

    @property
    def material(self) -> Any:
        return self._material

    @property
    def mass(self) -> float:
        """[kg]; part of the mass of the body."""
        raise NotImplementedError

    @property
    def motion(self) -> str:
        """That of the body."""
        return self._body.motion

    @property
    def color(self) -> tuple[float, ...] | None:
        """Red, green, blue in [0, 1] for pictures, or None."""
        return self._color

    def _is_drawn(self) -> bool:
        raise NotImplementedError

    def _bound_to(self, simulation: Simulation) -> Any:
        return self._on(self._body._bound_to(simulation))

    def _on(self, body: Any) -> Any:
        """The same layer, of another handle of its body."""
        handle = object.__new__(type(self))
        handle.__dict__.update(self.__dict__)
        handle._body = body
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
        return self._body._scene._core.skin_name(self._index)

    @property
    def mass(self) -> float:
        """[kg]; part of the mass of the body."""
        return self._body._scene._core.skin_mass(self._index)

    @property
    def triangles(self) -> Indices:
        """(m, 3) vertices of the body."""
        return self._triangles

    @property
    def surface_positions(self) -> Points:
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
        return x + max(0.5 * self._material.thickness, visible) * normals / np.maximum(lengths, 1e-300)

    @property
    def surface_triangles(self) -> Indices:
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
        return self._body._scene._core.fibres_name(self._index)

    @property
    def mass(self) -> float:
        """[kg]; part of the mass of the body."""
        return self._body._scene._core.fibres_mass(self._index)

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
        return np.linalg.norm(x[self.edges[:, 1]] - x[self.edges[:, 0]], axis=1)

    @property
    def stretches(self) -> Floats:
        """Lengths of the edges over their rest lengths (m,)."""
        X = self._body.mesh.vertices
        return self.lengths / np.linalg.norm(X[self.edges[:, 1]] - X[self.edges[:, 0]], axis=1)

    @property
    def frames(self) -> Floats:
        """Frames of the nodes, path by path (n, 3, 3): axes d1, d2 of the section and d3 along the fibre as
        columns; none without bending."""
        simulation = self._body._simulation()
        if simulation is None:
            return self._body._scene._core.initial_fibre_frames(self._index).reshape(-1, 3, 3)
        if self._index >= simulation._core.fibres_count:
            raise InvalidArgument(
                f"fibres '{self.name}': were added after the simulation was made: frames need one made after "
                f"that; make a new stark.Simulation(scene)"
            )
        return simulation._core.fibre_frames(self._index).reshape(-1, 3, 3)

    @property
    def surface_positions(self) -> Points:
        """Vertices of a tube around each edge (k, 3) [m], for pictures."""
        x = self._body.positions
        normals = self.frames[self._paths.edge_nodes][..., 0].sum(axis=1) if self._bending else None
        return prisms(x[self.edges[:, 0]], x[self.edges[:, 1]], normals, outline(self._material))[0]

    @property
    def surface_triangles(self) -> Indices:
        x = self._body.mesh.vertices
        return prisms(x[self.edges[:, 0]], x[self.edges[:, 1]], None, outline(self._material))[1]

    def _is_drawn(self) -> bool:
        return True


class LayeredBody:
    """Cloth and solids: layers on their vertices."""

    _scene: Scene
    _index: int

    def add_skin(
        self,
        material: ShellMaterial,
        triangles: ArrayLike | None = None,
        *,
        mass: float | None = None,
        rest_angles: str = "mesh",
        name: str | None = None,
        color: ArrayLike | None = None,
    ) -> Skin:
        """Adds a sheet on vertices of this body, without unknowns of its own: its energy and its mass are
        added to those of the body. Before the simulation is made.

        ``triangles`` (m, 3) are vertices of the body, of its surface or within it; all of the surface if left
        out. ``mass`` [kg] replaces the density of the material. ``rest_angles`` is "mesh" (the angles of the
        mesh are at rest) or "flat". Pictures show it if it has a ``color``. The surface for contact stays
        that of the body."""
        owner = _owner("skin", self, name, material, ShellMaterial, "stark.materials.pet")
        given = {"name": given_name(name), "body": self._index, "color": color}
        chosen = None if triangles is None else _integers(triangles, 3, f"{owner}: triangles", "(m, 3)")
        shown = self.triangles if chosen is None else chosen  # type: ignore[attr-defined]
        if mass is not None:
            material = material._with_mass(mass, _area(self, shown), owner)
        given_choice(rest_angles, ("flat", "mesh"), f"{owner}: rest_angles")
        given |= {"triangles": chosen, "rest_angles": rest_angles, **material._description()}
        skin = Skin(self, self._scene._core.add_skin(given, material._core), material, color)  # type: ignore[arg-type]
        skin._triangles = np.array(shown, dtype=np.int32)
        skin._triangles.setflags(write=False)
        self._scene._append_layer(skin)
        return skin

    def add_fibres(
        self,
        material: RodMaterial = steel_wire,
        edges: ArrayLike | None = None,
        *,
        paths: Any = None,
        bending: bool = True,
        rest_shape: str = "mesh",
        normal: ArrayLike | None = None,
        mass: float | None = None,
        name: str | None = None,
        color: ArrayLike | None = None,
    ) -> Fibres:
        """Adds rods along vertices of this body: their energy and their mass are added to those of the body.
        Before the simulation is made.

        ``edges`` (m, 2) are vertices of the body, in any order: where two edges meet they are one fibre,
        where more meet all of them end, as at a ball joint. Or ``paths``: vertices along each fibre, a row
        or a list of rows; one that ends where it starts is a ring, and paths that cross turn freely against
        each other. With ``bending`` they resist stretch, bending and twist, and each node gets a material
        frame, three unknowns; without, they resist stretch only, and there are none. ``rest_shape``
        ("mesh" or "straight") and ``normal`` as in ``scene.add_rod``. ``mass`` [kg] of all replaces the
        density of the material. Values by edge are in the order of ``edges``, or path by path. Fibres do not
        touch anything: contact stays that of the body."""
        owner = _owner("fibres", self, name, material, RodMaterial, "stark.materials.steel_wire")
        given = {"name": given_name(name), "body": self._index, "color": color}
        given_choice(rest_shape, ("mesh", "straight"), f"{owner}: rest_shape")
        if (edges is None) == (paths is None):
            raise InvalidArgument(
                f"{owner}: {'none' if edges is None else 'both'} of edges and paths given: give one of them"
            )
        lines = paths_from(edges, paths, owner)
        if mass is not None:
            area = material.section["mass"] / material.density
            material = material._with_mass(mass, area * _length(self, lines.edges), owner)
        described = material._description()
        given |= {
            "vertices": np.concatenate([*lines.paths, np.empty(0, dtype=np.int32)]).astype(np.int32),
            "counts": [len(path) for path in lines.paths],
            "bending": given_flag(bending, f"{owner}: bending"),
            "rest_shape": rest_shape,
            "normal": normal,
            "law": described["law"],
            "fields": lines.by_path(described["fields"], owner),
        }
        fibres = Fibres(self, self._scene._core.add_fibres(given, material._core), material, color)  # type: ignore[arg-type]
        fibres._paths, fibres._bending = lines, bool(bending)
        self._scene._append_layer(fibres)
        return fibres

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Its skins and fibres, in the order of adding."""
        return tuple(layer._on(self) for layer in self._scene._layers if layer._body == self)


def _owner(kind: str, body: Any, name: Any, material: Any, wanted: type[Any], example: str) -> str:
    given_name(name)
    owner = f"{kind} of '{body.name}'" if name is None else f"{kind} '{name}' of '{body.name}'"
    if not isinstance(material, wanted):
        raise InvalidArgument(
            f"{owner}: material = {material!r}: must be a stark.{wanted.__name__}, for instance {example}"
        )
    return owner


def _integers(values: ArrayLike, columns: int, what: str, shape: str) -> Indices:
    array = as_array(values, what)
    if array.ndim != 2 or array.shape[1] != columns or array.dtype.kind not in "iu" or not len(array):
        raise InvalidArgument(
            f"{what} of shape {array.shape} and type {array.dtype}: must be vertex indices of shape {shape}, "
            f"at least one row"
        )
    return np.ascontiguousarray(array.astype(np.int32))


def _inside(body: Any, indices: Indices) -> Points | None:
    """Rest positions of vertices, None if some do not exist: the core refuses them, and says which."""
    X = body.mesh.vertices
    return X[indices] if indices.size and indices.min() >= 0 and indices.max() < len(X) else None


def _area(body: Any, triangles: Indices) -> float:
    X = _inside(body, triangles)
    if X is None:
        return 0.0
    return float(0.5 * np.linalg.norm(np.cross(X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]), axis=1).sum())


def _length(body: Any, edges: Indices) -> float:
    X = _inside(body, edges)
    return 0.0 if X is None else float(np.linalg.norm(X[:, 1] - X[:, 0], axis=1).sum())
