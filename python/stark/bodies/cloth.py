"""Handles of cloth."""

from __future__ import annotations

from stark import _core
from stark.bodies.layered import LayeredBody
from stark.materials import ShellMaterial
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

    @property
    def hinges(self) -> Stencils:
        """All pairs of triangles with a common edge, as stencils of four points for energies: the edge, then
        the opposite vertices."""
        return self._stencils(lambda: _core.find_hinges(self.triangles), "hinges")
