"""Handles of soft volumes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark._core import InvalidArgument
from stark.bodies.layered import LayeredBody
from stark.caller import warn
from stark.materials import SolidMaterial
from stark.mesh import EmbeddedMesh, Indices, SolidMesh, TetMesh
from stark.mesh.repair import doubles
from stark.selections import Stencils

Floats = NDArray[np.float64]

#: Elements that lock, by their nodes, and the ratio from which on it is said: there slender beams of
#: linear ones bend by half of what they should, and less, and a thick ring of 27-node hexahedra widens by a
#: tenth too little under pressure (docs/solids.md).
LINEAR = {4: "linear tetrahedra", 8: "hexahedra of 8 nodes"}
_LOCKING = {nodes: (name, 0.48) for nodes, name in LINEAR.items()} | {27: ("hexahedra of 27 nodes", 0.499)}


class Solid(LayeredBody):
    """A soft volume."""

    kind = "solid"
    _mesh_arrays = ("vertices", "elements", "embedding")

    @classmethod
    def _mesh_of(cls, given: Mapping[str, Any]) -> TetMesh | SolidMesh:
        elements = np.asarray(given["elements"])
        if given.get("embedding") is not None:
            return EmbeddedMesh(given["vertices"], elements, **given["embedding"])
        mesh = TetMesh if elements.shape[1] == 4 else SolidMesh
        return mesh(given["vertices"], elements)

    @property
    def material(self) -> SolidMaterial:
        """What it is made of, as it was added; it stays so."""
        material: SolidMaterial = self._shared["material"]
        return material

    def _warn_of_locking(self, formulation: str) -> None:
        """Those of robots are in the report of the robot."""
        text = self._locking() if formulation == "displacement" else ""
        if text and not self._scene._adds_a_whole:
            warn(f"solid '{self.name}': {text}")

    def _warn_of_doubles(self) -> None:
        """Elements that fill the same place, as of two overlapping groups of a mesher."""
        pairs = doubles(self._all_elements())
        if len(pairs) and not self._scene._adds_a_whole:
            first, second = pairs[0]
            count = "1 element is" if len(pairs) == 1 else f"{len(pairs)} elements are"
            warn(
                f"solid '{self.name}': {count} there twice, such as {second}, whose nodes are those of "
                f"{first}: mass and stiffness count twice there; leave one out"
            )

    def _locking(self) -> str:
        """What is said of elements that are much too stiff, as they have too few motions that keep
        volumes; empty for others."""
        nodes = self._element_nodes()
        ratio = float(np.max(getattr(self.material, "poissons_ratio", 0.0)))
        name, least = _LOCKING.get(nodes, ("", np.inf))
        if ratio < least:
            return ""
        remedy = "write stark.mesh.to_quadratic(mesh)" if nodes == 4 else 'pass formulation="mean_dilatation"'
        return (
            f"Poisson's ratio {ratio:.6g} with {name} as they are: elements lock from "
            f"{least} on, so that it is too stiff, even with a fine mesh (docs/solids.md); "
            f"{remedy}, or take a smaller ratio"
        )

    def _element_nodes(self) -> int:
        return int(self._all_elements().shape[1])

    def _all_elements(self) -> Indices:
        """Those of any number of nodes."""
        mesh: Any = self._mesh
        found: Indices = mesh.tets if isinstance(mesh, TetMesh) else mesh.elements
        return found

    @property
    def tetrahedra(self) -> Stencils:
        """All elements of a mesh of linear tetrahedra, as stencils of four points for energies."""
        return self._stencils(self._elements, "tetrahedra")

    def _elements(self) -> Indices:
        elements = self._all_elements()
        if elements.shape[1] != 4:
            raise InvalidArgument(
                f"'{self.name}': its elements have {elements.shape[1]} nodes: must be tetrahedra of 4; "
                f"choose points with vertices, faces or stark.stencils(body, indices)"
            )
        return elements

    def _edge_indices(self) -> Indices:
        return _core.find_tet_edges(self._elements())

    def _surface(self) -> tuple[Indices, Indices, Indices]:
        """Boundary triangles, the sorted vertices they use, the triangles renumbered to those."""
        if "surface" not in self._shared:
            assert isinstance(self._mesh, (TetMesh, SolidMesh))
            triangles = self._mesh.surface_triangles()
            used, renumbered = np.unique(triangles, return_inverse=True)
            renumbered = renumbered.reshape(triangles.shape).astype(np.int32)
            self._shared["surface"] = triangles, used, renumbered
        surface: tuple[Indices, Indices, Indices] = self._shared["surface"]
        return surface

    # --- rest state ---

    def _rest_shapes(self, name: str) -> tuple[tuple[int, ...], ...]:
        return ((), (3, 3)) if name == "growth" else super()._rest_shapes(name)

    def _element_count(self) -> int:
        return len(self._all_elements())

    @property
    def triangles(self) -> Indices:
        """Triangles of the surface (m, 3), as indices of ``positions``, counterclockwise from outside."""
        return self._surface()[0]

    @property
    def surface_positions(self) -> Floats:
        """Positions of the vertices of the surface (k, 3) [m]."""
        return self.positions[self._surface()[1]]

    @property
    def surface_triangles(self) -> Indices:
        """Triangles of the surface (m, 3), as indices of ``surface_positions``, counterclockwise from
        outside."""
        return self._surface()[2]
