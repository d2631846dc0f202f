"""Curves of USD files: which points each has, how thick and how stiff it is."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from stark._core import InvalidArgument
from stark.robots.usd_stage import SAME, Frame, Stage, value_of

Floats = NDArray[np.float64]

_DIAMETER = 1e-3  # [m]; the proposal assumes it where a file says nothing
#: Names of the proposal, those of RodMaterial, and the power of metres in their unit, kg m^k/s^2.
_STIFFNESSES = {
    "curvesStretchStiffness": ("axial_stiffness", 1),
    "curvesShearStiffness": ("shear_stiffness", 1),
    "curvesBendStiffness": ("bending_stiffness", 3),
    "curvesTwistStiffness": ("torsional_stiffness", 3),
}


class Curves:
    """Those of a BasisCurves prim; each is a rod. ``count``: of its points."""

    def __init__(self, stage: Stage, prim: Any, count: int, title: str) -> None:
        self._stage, self._prim, self._report, self._title = stage, prim, stage.report, title
        self._is_linear = str(value_of(prim, "type", "cubic")) == "linear"
        counts = np.array(value_of(prim, "curveVertexCounts", []), dtype=np.int64).reshape(-1)
        if len(counts) == 0 or counts.min() < 2:
            self._refuse("curveVertexCounts: must be at least 2 points for each curve; correct them")
        if counts.sum() != count:
            self._refuse(
                f"curveVertexCounts: {counts.sum()} points: must be {count}, as in points; correct them"
            )
        ends = np.cumsum(counts)
        starts = ends - counts
        self.points: list[slice] = [slice(int(a), int(b)) for a, b in zip(starts, ends, strict=True)]
        """Of each curve, among those of the prim."""
        self._groups = {
            1: np.zeros(len(counts), dtype=np.int64),
            len(counts): np.arange(len(counts)),
            int(count - len(counts)): np.concatenate([[0], (ends - np.arange(1, len(counts) + 1))[:-1]]),
            count: starts,
        }
        if not self._is_linear:
            self._report.add("assumed", title, "linear curves through its points; the file has cubic ones")

    def names(self, name: str, taken: set[str]) -> list[str]:
        """Names for the rods: that of the prim, with the number of the curve if there are several."""
        if len(self.points) == 1:
            return [name]
        found = []
        for k in range(len(self.points)):
            free = f"{name}_{k}"
            while free in taken:
                free += "_"
            taken.add(free)
            found.append(free)
        return found

    def lengths(self, x: Floats) -> Floats:
        """Of each curve [m]."""
        found = []
        for k, points in enumerate(self.points):
            steps = np.linalg.norm(np.diff(x[points], axis=0), axis=1)
            if not (steps > 0.0).all():
                at = int(points.start + np.argmin(steps))
                self._refuse(f"curve {k}: points {at} and {at + 1} coincide: must be apart; remove one")
            found.append(float(steps.sum()))
        return np.array(found)

    def diameters(self) -> Floats:
        """Of each curve [m], one along all of it."""
        name, given = "thicknesses", self._numbers("physics:thicknesses") * self._stage.metre
        if len(given) == 0:
            frame: Frame = self._stage.frame(self._prim)
            name, given = "widths", self._numbers("widths") * float(np.cbrt(abs(np.linalg.det(frame.scale))))
            said = "its widths as diameters" if len(given) > 0 else f"diameter {_DIAMETER:g} m"
            self._report.add("assumed", self._title, said)
        if len(given) == 0:
            return np.full(len(self.points), _DIAMETER)
        if not (np.isfinite(given) & (given > 0.0)).all():
            self._refuse(f"{name}: {given.min():g} m: must be positive and finite; correct it")
        if name == "widths" and not self._is_linear and len(given) not in self._groups:
            given = given.mean(keepdims=True)  # one for each segment of a cubic curve
        parts = self._of_curves(given, name)
        if any(np.ptp(part) > SAME * part.max() for part in parts):
            span = f"{given.min():g} to {given.max():g} m"
            self._report.add("assumed", self._title, f"one diameter a curve, the mean; the file has {span}")
        return np.array([float(part.mean()) for part in parts])

    def masses(self, total: float, volumes: Floats) -> list[float]:
        """Of each curve [kg]: as the file spreads them, or by volume."""
        given = self._numbers("physics:masses")
        shares = volumes
        if len(given) > 1:
            shares = np.array([float(part.sum()) for part in self._of_curves(given, "masses")])
        if not (shares > 0.0).all():
            self._refuse(f"masses: {shares.min():g} for a curve: must be positive; correct them")
        return [float(mass) for mass in total * shares / shares.sum()]

    def stiffnesses(self, material: Any) -> dict[str, float]:
        """Those that a material gives, [N] and [N m^2], by the names of RodMaterial."""
        found = {}
        for name, (own, power) in _STIFFNESSES.items():
            value = float(value_of(material, f"physics:{name}", -np.inf))
            if not np.isfinite(value):  # what is infinite is not given
                continue
            if value < 0.0 or (value == 0.0 and power == 1):
                rule = "positive" if power == 1 else "at least 0"
                self._refuse(f"{name} = {value:g}: must be {rule}; correct it")
            found[own] = value * self._stage.kilogram * self._stage.metre**power
        return found

    def _numbers(self, name: str) -> Floats:
        return np.array(value_of(self._prim, name, []), dtype=np.float64).reshape(-1)

    def _of_curves(self, values: Floats, name: str) -> list[Floats]:
        """Values of each curve, where there is one for all, or one a curve, segment or point."""
        starts = self._groups.get(len(values))
        if starts is None:
            counts = sorted(self._groups)
            self._refuse(
                f"{name}: {len(values)} values: must be {', '.join(map(str, counts[:-1]))} or {counts[-1]}, "
                f"for all, by curve, by segment or by point; correct them"
            )
        if len(values) == 1:
            return [values] * len(self.points)
        return np.split(values, starts[1:])

    def _refuse(self, text: str) -> NoReturn:
        raise InvalidArgument(f"{self._report.source}: {self._title}: {text}")
