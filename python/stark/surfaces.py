"""Surfaces: how thick and how stiff what covers a body is in contact.

``scene.add_cloth(mesh, surface=stark.surfaces.terry_towel)``; ``rigid``, ``rubber``, ``skin``, ``paper``
and ``terry_towel``, each with its origin in ``.source``, and ``terry_towel.replace(stiffness=2e3)`` for a
changed copy.

Two bodies act on each other where the gap between them is below the sum of their thicknesses; at the pressure
``stiffness`` half of that is left. ``contact_distance`` and ``contact_stiffness`` of a body, where given,
replace the values of its surface (docs/surfaces.md)."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import given_word, real_array, real_number
from stark.attributes import own_names

__all__ = ["Surface", "paper", "relative_pressure", "rigid", "rubber", "skin", "terry_towel"]


#: Gap at which the pressure on a core has no bound, over the core.
_CORE_POLE = 0.9999


def relative_pressure(gap: ArrayLike) -> NDArray[np.float64]:
    """Pressure over contact stiffness at a gap over the contact distance: 1 at 1/2, 0 from 1 on, without
    bound towards 0 (theory eq. 16a)."""
    r = real_array(gap, "relative_pressure: gap")
    near = np.clip(r, np.finfo(np.float64).tiny, 1.0)
    slope = 2.0 * (near - 1.0) * np.log(near) + (1.0 - near) ** 2 / near
    return np.where(r >= 1.0, 0.0, slope / (math.log(2.0) + 0.5))


@dataclass(frozen=True)
class Surface:
    """What covers a body, as contact feels it."""

    name: str
    """Of the surface, in messages."""
    thickness: float
    """Contact distance of the body [m]: a gap to another body of this surface closes from twice this on."""
    stiffness: float
    """Pressure at which half of the contact distance is left [Pa]."""
    source: str
    """Where the numbers come from."""
    core: float = 0.0
    """Part of the thickness that no pressure takes [m], as the fibres of a fabric; at most half of it."""

    def __post_init__(self) -> None:
        given_word(self.name, "surface: name")
        for field, unit in (("thickness", "m"), ("stiffness", "Pa"), ("core", "m")):
            value = getattr(self, field)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
                raise InvalidArgument(
                    f"surface '{self.name}': {field} = {value!r}: must be a number in {unit}"
                )
            value = real_number(value, f"surface '{self.name}': {field}")
            object.__setattr__(self, field, value)
            if field == "core" and not 0.0 <= value <= 0.5 * self.thickness:
                raise InvalidArgument(
                    f"surface '{self.name}': core = {value:g} m: must be between 0 and half of its "
                    f"thickness, {0.5 * self.thickness} m"
                )
            if field != "core" and not 0.0 < value < math.inf:
                raise InvalidArgument(
                    f"surface '{self.name}': {field} = {value:g} {unit}: must be positive and finite"
                )

    def replace(self, **changes: Any) -> Self:
        """A copy with other values."""
        return dataclasses.replace(self, **changes)

    def pressure(self, gap: ArrayLike) -> NDArray[np.float64]:
        """Pressure [Pa] at a gap [m] to a body of the same surface (theory eq. 16a, 16d)."""
        distance, pole = 2.0 * self.thickness, _CORE_POLE * 2.0 * self.core
        gap = np.asarray(gap, dtype=np.float64)
        pressure = self.stiffness * relative_pressure(gap / distance)
        if pole > 0.0:
            pressure += self.stiffness * distance / pole * relative_pressure(gap / pole - 1.0)
        return pressure


rigid: Surface = Surface(
    "rigid",
    0.1e-3,
    1e6,
    "a choice: hard enough to give way by less than 0.1 mm under what people and robots press",
)
rubber: Surface = Surface(
    "rubber",
    0.5e-3,
    1e6,
    "a layer of rubber of 1.5 MPa under uniaxial compression: E ln 2 at half of its thickness",
)
skin: Surface = Surface(
    "skin",
    1e-3,
    5e4,
    "epidermis and dermis of a finger, 1 mm of 70 kPa under uniaxial compression: E ln 2; an estimate, skin "
    "differs by a factor of several from person to person and with the method",
)
paper: Surface = Surface(
    "paper",
    60e-6,
    2e6,
    "office paper of 80 g/m2: sheets 104 um apart at the 100 kPa of ISO 534, 120 um where nothing presses "
    "them, an estimate; core: of fibres alone, 1540 kg/m3",
    core=26e-6,
)
terry_towel: Surface = Surface(
    "terry_towel",
    1.625e-3,
    1e3,
    "layers of a stack lie 3.25 mm apart under their own weight; compression to half is estimated between "
    "0.3 kPa (loops that bend) and 5 kPa, the largest pressure of fabric compression tests (KES-FB3); core: "
    "0.48 kg/m2 of cotton, 1540 kg/m3, of which fibres fill a third as in pressed fabrics",
    core=0.47e-3,
)


def __dir__() -> list[str]:
    return own_names(__name__, globals())
