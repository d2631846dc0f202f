"""Coefficients of restitution of pairs of rigid bodies."""

from __future__ import annotations

from stark.arguments import real_number
from stark.attributes import AnsweredAttributes
from stark.handle import BodyHandle, SceneLink


class RestitutionTable(AnsweredAttributes):
    """How rigid bodies bounce: ``scene.restitution[ball, "floor"] = 0.8``, the relative speed along the
    normal after an impact over that before, between 0 and 1 (theory eq. 19b).

    Impacts slower than gravity makes bodies in two steps are not told from rest and give nothing back. A pair
    without a coefficient, ``None``, bounces as its contact layer and the integrator have it, which depends on
    the time step. Deformable bodies give back what their materials do not damp."""

    def __init__(self, scene: SceneLink) -> None:
        self._scene = scene

    def __repr__(self) -> str:
        return "scene.restitution"

    def __getitem__(self, pair: tuple[BodyHandle | str, BodyHandle | str]) -> float | None:
        return self._scene._core.restitution(*self._scene._pair(pair))

    def __setitem__(self, pair: tuple[BodyHandle | str, BodyHandle | str], coefficient: float) -> None:
        a, b = self._scene._pair(pair)
        self._scene._core.set_restitution(a, b, real_number(coefficient, f"restitution of {pair!r}"))
        self._scene._note_change("restitution", a, b)
