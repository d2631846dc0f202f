"""Coefficients of friction of pairs of bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stark._core import InvalidArgument
from stark.arguments import as_array, real_array, real_number
from stark.attributes import AnsweredAttributes
from stark.caller import warn
from stark.handle import BodyHandle, SceneLink

_FIELDS = ("along", "across", "kinetic")


@dataclass(frozen=True)
class Anisotropic:
    """Friction that depends on the direction of sliding: ``scene.friction["ski", "snow"] =
    stark.Anisotropic(along=0.05, across=0.6)``.

    ``along`` and ``across`` are the static coefficients along and across the ``surface_direction`` of the
    first body of the pair, or of the second one where the first has none; sliding contact has the part
    ``kinetic`` of both. The forces that friction can take form an ellipse with these half axes, and a sliding
    contact dissipates the most that the ellipse allows: its force is turned towards the axis of the larger
    coefficient. Where a surface is normal to its direction, the geometric mean of the two holds."""

    along: float
    across: float
    kinetic: float = 1.0


class FrictionTable(AnsweredAttributes):
    """Coefficients of friction of pairs of bodies: ``scene.friction[box, "floor"] = 0.3``, or static and
    kinetic coefficient: ``scene.friction[box, "floor"] = 0.5, 0.4``, or a ``stark.Anisotropic``.

    Contact at rest holds up to the static coefficient times the normal force; once it slides, the kinetic one
    counts until it comes to rest again. Reading gives the static coefficient, :meth:`kinetic` the other: the
    one set for the pair; else the geometric mean of the coefficients of the two bodies, where
    ``scene.default_friction`` stands in for a body that was given none. A body with itself is its
    self-contact."""

    _elsewhere: ClassVar[Mapping[str, str]] = {"default": "scene.default_friction"}

    def __init__(self, scene: SceneLink) -> None:
        self._scene = scene

    def __repr__(self) -> str:
        return "scene.friction"

    def __getitem__(self, pair: tuple[BodyHandle | str, BodyHandle | str]) -> float | Anisotropic:
        static, kinetic, along, across = self._scene._core.friction(*self._scene._pair(pair))
        return static if along == across else Anisotropic(static * along, static * across, kinetic / static)

    def kinetic(self, a: BodyHandle | str, b: BodyHandle | str) -> float | Anisotropic:
        """Coefficient of sliding contact of the pair."""
        _, kinetic, along, across = self._scene._core.friction(*self._scene._pair((a, b)))
        return kinetic if along == across else Anisotropic(kinetic * along, kinetic * across)

    def __setitem__(
        self,
        pair: tuple[BodyHandle | str, BodyHandle | str],
        coefficient: float | tuple[float, float] | Anisotropic,
    ) -> None:
        a, b = self._scene._pair(pair)
        self._warn_of_none(a, b)
        if isinstance(coefficient, Anisotropic):
            owner = f"friction of {pair!r}"
            values = (coefficient.along, coefficient.across, coefficient.kinetic)
            numbers = [
                real_number(value, f"{owner}: {name}") for name, value in zip(_FIELDS, values, strict=True)
            ]
            self._scene._core.set_anisotropic_friction(a, b, *numbers)
            self._scene._note_change("friction", a, b)
            return
        given = coefficient if isinstance(coefficient, (tuple, list)) else [coefficient]
        try:
            if any(as_array(value, "friction").dtype.kind == "b" for value in given):
                raise ValueError
            both = np.broadcast_to(real_array(coefficient, "friction"), (2,))
        except ValueError:
            raise InvalidArgument(
                f"friction of {pair!r} = {coefficient!r}: must be a number >= 0, or two: static, kinetic, or "
                f"stark.Anisotropic(along, across)"
            ) from None
        self._scene._core.set_friction(a, b, *map(float, both))
        self._scene._note_change("friction", a, b)

    def _warn_of_none(self, a: int, b: int) -> None:
        core = self._scene._core
        if a != b or core.contact_enabled(a, a):
            return
        name = core.name(a)
        warn(
            f"friction of '{name}' with itself has no effect, as it has no self-contact; give friction= "
            f"where it is added for contact with all others, or set scene.friction['{name}', other]"
        )
