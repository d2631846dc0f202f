"""Bodies that carry layers: ``add_skin`` and ``add_fibres`` of cloth and solids."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array, given_choice, given_flag, given_name
from stark.bodies.body import Body
from stark.bodies.deformable import DeformableBody
from stark.bodies.fibre_paths import paths_from
from stark.bodies.layers import Fibres, Layer, Skin
from stark.bodies.rest_state import ActiveFibres
from stark.caller import warn
from stark.materials import RodMaterial, ShellMaterial, steel_wire
from stark.mesh import Indices
from stark.readings import named_readings, reading

Floats = NDArray[np.float64]


class LayeredBody(DeformableBody, ActiveFibres):
    """Cloth and solids: layers on their vertices."""

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

        ``triangles`` (m, 3) are vertices of the body, of its surface (rows of ``body.triangles``) or within
        it; all of the surface if left out. ``mass`` [kg] replaces the density of the material.
        ``rest_angles`` is "mesh" (the angles of the mesh are at rest) or "flat". Pictures show it if it has a
        ``color``. The surface for contact stays that of the body."""
        owner = _owner("skin", self, name, material, ShellMaterial, "stark.materials.pet")
        given = {"name": given_name(name), "body": self._index, "color": color}
        chosen = None if triangles is None else _integers(triangles, 3, f"{owner}: triangles", "(m, 3)")
        shown = self.triangles if chosen is None else chosen
        if chosen is not None and self._numbered_by_surface(chosen):
            raise InvalidArgument(
                f"{owner}: triangles: are rows of surface_triangles, which count the vertices of the surface "
                f"only, and would connect other vertices of the body: choose from body.triangles"
            )
        if mass is not None:
            material = material._with_mass(mass, _area(self, shown), owner)
        given_choice(rest_angles, ("flat", "mesh"), f"{owner}: rest_angles")
        given |= {"triangles": chosen, "rest_angles": rest_angles, **material._description()}
        skin = Skin(self, self._scene._core.add_skin(given, material._core), material, color)
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
        fibres = Fibres(self, self._scene._core.add_fibres(given, material._core), material, color)
        fibres._paths, fibres._bending = lines, bool(bending)
        self._scene._append_layer(fibres)
        return fibres

    def _numbered_by_surface(self, triangles: Indices) -> bool:
        """Whether all are rows of ``surface_triangles`` and not all of ``triangles``, which differ where
        the body has vertices within."""
        inner, outer = self.surface_triangles, self.triangles
        if inner is outer or np.array_equal(inner, outer):
            return False
        chosen, of_body = set(map(tuple, triangles.tolist())), set(map(tuple, outer.tolist()))
        return chosen <= set(map(tuple, inner.tolist())) and not chosen <= of_body

    @property
    def internal_variables(self) -> dict[str, Floats]:
        """What the law of its elements remembers, of cloth that of the membrane, by name: (m, k) of numbers,
        (m, k, n) of vectors, (m, k, 3, 3) of matrices of three rows, in the elements of the mesh at their k
        quadrature points; k = 1 where the strain is constant. Empty where it remembers nothing. Between steps
        those of the present state (docs/inelastic.md)."""
        found = self._require_simulation("internal_variables")._core.internal_variables(self._index)
        arrays = {
            name: reading(_shaped(numbers, points, width), self, f"internal_variables['{name}']")
            for name, (points, width, numbers) in found.items()
        }
        return named_readings(arrays, self, "internal_variables")

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Its skins and fibres, in the order of adding."""
        return tuple(layer._on(self) for layer in self._scene._layers if layer._body == self)


def _shaped(numbers: Floats, points: int, width: int) -> Floats:
    of_value = {1: (), 9: (3, 3)}.get(width, (width,))
    return numbers.reshape(-1, points, *of_value)


def _owner(kind: str, body: Body, name: Any, material: Any, wanted: type[Any], example: str) -> str:
    given_name(name)
    owner = f"{kind} of '{body.name}'" if name is None else f"{kind} '{name}' of '{body.name}'"
    if not isinstance(material, wanted):
        raise InvalidArgument(
            f"{owner}: material = {material!r}: must be a stark.{wanted.__name__}, for instance {example}"
        )
    if np.any(material.thermal_expansion):
        shown = float(np.max(np.abs(material.thermal_expansion)))
        warn(
            f"{owner}: thermal_expansion = {shown:g} 1/K of its material changes nothing: layers have no "
            f"temperature and do not grow, they are at rest in the size of the mesh and hold back what does; "
            f"for a strip of two metals give the elements of one solid two expansions"
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


def _inside(body: Body, indices: Indices) -> Floats | None:
    """Rest positions of vertices, None if some do not exist: the core refuses them, and says which."""
    X = body.mesh.vertices
    return X[indices] if indices.size and indices.min() >= 0 and indices.max() < len(X) else None


def _area(body: Body, triangles: Indices) -> float:
    X = _inside(body, triangles)
    if X is None:
        return 0.0
    return float(0.5 * np.linalg.norm(np.cross(X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]), axis=1).sum())


def _length(body: Body, edges: Indices) -> float:
    X = _inside(body, edges)
    return 0.0 if X is None else float(np.linalg.norm(X[:, 1] - X[:, 0], axis=1).sum())
