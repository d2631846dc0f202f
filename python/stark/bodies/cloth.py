"""Handles of cloth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stark import _core
from stark.bodies.layered import LayeredBody
from stark.caller import warn
from stark.materials import ShellMaterial
from stark.mesh.repair import turned_edge
from stark.selections import Stencils


class Cloth(LayeredBody):
    """A sheet of triangles."""

    kind = "cloth"

    @property
    def material(self) -> ShellMaterial:
        """What it is made of, as it was added; it stays so."""
        material: ShellMaterial = self._shared["material"]
        return material

    def _element_count(self) -> int:
        return len(self.triangles)

    # --- rest state ---

    @property
    def natural_curvature(self) -> NDArray[np.float64]:
        """Curvature of each triangle without load (n, 3, 3) [1/m], a tensor in the axes of the mesh, beside
        that of the rest shape; what of it lies in the triangle. Positive values bend each triangle towards
        its normal. Numbers (n,) are the same in all directions. Assign it as ``growth``; of materials with a
        ``flexural_rigidity``."""
        return self._rest_value("natural_curvature")

    @natural_curvature.setter
    def natural_curvature(self, value: Any) -> None:
        if "natural_curvature" not in self._rest_values:
            edge = turned_edge(self.triangles)
            if edge is not None:
                warn(
                    f"'{self.name}': natural_curvature: bends triangles to opposite sides, as those at the "
                    f"edge between the vertices {edge[0]} and {edge[1]} and others are oriented differently: "
                    f"turn them with stark.mesh.oriented, or give each triangle its own sign"
                )
        self._set_rest_value("natural_curvature", value)

    def _rest_shapes(self, name: str) -> tuple[tuple[int, ...], ...]:
        return ((), (3, 3)) if name == "natural_curvature" else super()._rest_shapes(name)

    @property
    def hinges(self) -> Stencils:
        """All pairs of triangles with a common edge, as stencils of four points for energies: the edge, then
        the opposite vertices."""
        return self._stencils(lambda: _core.find_hinges(self.triangles), "hinges")
