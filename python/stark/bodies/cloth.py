"""Handles of cloth."""

from __future__ import annotations

from stark import _core
from stark.bodies.layered import LayeredBody
from stark.selections import Stencils


class Cloth(LayeredBody):
    """A sheet of triangles."""

    kind = "cloth"

    def _element_count(self) -> int:
        return len(self.triangles)

    @property
    def hinges(self) -> Stencils:
        """All pairs of triangles with a common edge, as stencils of four points for energies: the edge, then
        the opposite vertices."""
        return self._stencils(lambda: _core.find_hinges(self.triangles), "hinges")
