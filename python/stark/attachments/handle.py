"""Attachments of a scene: forces, what has broken, enabling."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.arguments import added_later, needs_simulation
from stark.attributes import KnownAttributes

if TYPE_CHECKING:
    from stark.formulas.points import Points
    from stark.scene import Scene
    from stark.simulation import Simulation

Floats = NDArray[np.float64]


class Attachment(KnownAttributes):
    """Pairs of a scene that are glued: points of ``a``, each carried by ``b``."""

    def __init__(self, scene: Scene, index: int, a: Points, given: Mapping[str, Any]) -> None:
        self._scene = scene
        self._index = index
        self._a = a
        self._given = given  # as the core was given it
        self._simulation: Simulation | None = None

    @property
    def name(self) -> str:
        return self._scene._core.attachment_name(self._index)

    @property
    def points(self) -> Points:
        """The attached points of ``a``, in the order of the pairs."""
        return self._a

    @property
    def break_force(self) -> float:
        """Force [N] above which a pair breaks; inf: none breaks."""
        return float(self._given["break_force"])

    @property
    def forces(self) -> Floats:
        """Forces on the points of ``a`` in the last step (n, 3) [N], zero for pairs that do not hold; what
        carries them gets the opposite. After a rewind, of the multipliers of the state, which differ by what
        residuals below a hundredth of the tolerance hold."""
        return self._core("forces").attachment_forces(self._index)

    @property
    def force(self) -> Floats:
        """Their sum (3,) [N]."""
        return self.forces.sum(axis=0)

    @property
    def broken(self) -> NDArray[np.bool_]:
        """Which pairs have broken (n,)."""
        return self._core("broken").attachment_status(self._index) < 0

    @property
    def enabled(self) -> bool:
        """Whether it holds what is not broken; assign False to release it and True to hold it again, from the
        next step on. What is apart by then is pulled together at once."""
        simulation = self._simulation or self._scene._latest_simulation()
        if simulation is None:
            return bool(self._given["enabled"])
        return not (self._core("enabled").attachment_status(self._index) == 0).any()

    @enabled.setter
    def enabled(self, value: bool) -> None:
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidArgument(f"attachment '{self.name}': enabled = {value!r}: must be True or False")
        self._core("enabled").set_attachment_enabled(self._index, bool(value))

    def __len__(self) -> int:
        """Number of pairs."""
        return len(self._a)

    def __repr__(self) -> str:
        return f"<stark.Attachment '{self.name}' of {len(self)} points>"

    def _core(self, what: str) -> Any:
        simulation = self._simulation or self._scene._latest_simulation()
        if simulation is None:
            raise needs_simulation(f"attachment '{self.name}'", what)
        if self._index >= simulation._core.attachment_count:
            raise added_later(f"attachment '{self.name}'", what)
        return simulation._core

    def _bound_to(self, simulation: Simulation) -> Attachment:
        handle = Attachment(self._scene, self._index, self._a, self._given)
        handle._simulation = simulation
        return handle
