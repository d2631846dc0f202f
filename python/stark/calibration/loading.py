"""Strains of the tests that curves come from: what is imposed, what adjusts itself until it is free of
stress."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from stark._core import InvalidArgument
from stark.curves import Curve, Floats
from stark.symbolic import functions as f

#: Entries of a strain by column and component; those left out are 0.
Entries: TypeAlias = dict[tuple[int, int], Any]


@dataclass(frozen=True)
class Loading:
    """A homogeneous test of a law: its strain as a function of what is imposed (c) and what is free (u)."""

    entries: Callable[[Sequence[Any], Sequence[Any]], Entries]
    stretches: int
    """Number of free stretches, which are above 0 and come first."""
    shears: int
    """Number of free shears behind them."""
    guess: Callable[[Floats], Floats]
    """Free stretches without change of volume, of what is imposed (n, m)."""
    factor: float = 1.0
    """What was measured over the derivative of the energy by what is imposed."""

    @property
    def free(self) -> int:
        return self.stretches + self.shears

    def guesses(self, imposed: Floats) -> list[Floats]:
        """Free values (n, k) to start from: without change of volume, without contraction."""
        shears = np.zeros((len(imposed), self.shears))
        isochoric = np.concatenate(
            [self.guess(imposed).reshape(len(imposed), self.stretches), shears], axis=1
        )
        straight = np.concatenate([np.ones((len(imposed), self.stretches)), shears], axis=1)
        return [isochoric, straight] if self.stretches else [isochoric]


def loading_of(kind: str, curve: Curve, sheared: bool) -> Loading:
    """The test of a curve for a law of a ``kind``: solid, shell, rod or plate. ``sheared``: whether it may
    shear freely, as materials with directions do. InvalidArgument where there is none."""
    tests = {"solid": _solid, "shell": _shell, "rod": _rod, "plate": _plate}
    found = tests[kind](curve, sheared)
    if found is None:
        known = {
            "solid": "uniaxial, equibiaxial, biaxial, planar, shear, volumetric and relaxation",
            "shell": "uniaxial, equibiaxial, biaxial, planar, shear, relaxation and bending",
            "rod": "uniaxial, relaxation, bending and torsion",
        }[kind]
        raise InvalidArgument(
            f"fit: curve '{curve.name}' is of the kind {curve.kind}, the law one of {kind}s: must be {known}"
        )
    return found


def _triangular(size: int, stretches: Sequence[Any], shears: dict[tuple[int, int], Any]) -> Entries:
    """A strain whose first axis keeps its direction, whatever shears: what is imposed is the stretch of the
    sample, and free entries mean no stress but along it. In a symmetric stretch tensor they would not. Of
    objective laws rotations do not matter."""
    entries: Entries = {(i, i): stretches[i] for i in range(size)}
    for (i, j), value in shears.items():
        entries[j, i] = value
    return entries


def _none(imposed: Floats) -> Floats:
    return np.empty((len(imposed), 0))


def _simple_shear(size: int, curve: Curve) -> Loading:
    def entries(c: Sequence[Any], u: Sequence[Any]) -> Entries:
        found: Entries = {(i, i): 1.0 for i in range(size)} | {(1, 0): c[0]}
        return found | ({(1, 1): u[0]} if curve.free_height else {})

    if curve.free_height:
        return Loading(entries, 1, 0, lambda c: np.ones_like(c))
    return Loading(entries, 0, 0, _none)


def _solid(curve: Curve, sheared: bool) -> Loading | None:
    out_of_plane = ((0, 2), (1, 2)) if sheared else ()
    all_shears = ((0, 1), *out_of_plane) if sheared else ()

    def test(
        diagonal: Callable[[Any, Any], Sequence[Any]],
        free: int,
        guess: Callable[[Floats], Floats],
        shears: tuple[tuple[int, int], ...],
        factor: float = 1.0,
    ) -> Loading:
        def entries(c: Sequence[Any], u: Sequence[Any]) -> Entries:
            return _triangular(3, diagonal(c, u), dict(zip(shears, u[free:], strict=True)))

        return Loading(entries, free, len(shears), guess, factor)

    def both(c: Floats) -> Floats:
        return np.repeat(c**-0.5, 2, axis=1)

    if curve.kind == "uniaxial":
        return test(lambda c, u: (c[0], u[0], u[1]), 2, both, all_shears)
    if curve.kind == "equibiaxial":
        return test(lambda c, u: (c[0], c[0], u[0]), 1, lambda c: c**-2.0, out_of_plane, 0.5)
    if curve.kind == "biaxial":
        return test(lambda c, u: (c[0], c[1], u[0]), 1, lambda c: 1.0 / c.prod(axis=1), out_of_plane)
    if curve.kind == "planar":
        return test(lambda c, u: (c[0], 1.0, u[0]), 1, lambda c: 1.0 / c, out_of_plane)
    if curve.kind == "volumetric":

        def ball(c: Sequence[Any], u: Sequence[Any]) -> Entries:
            return {(i, i): f.pow(c[0], 1.0 / 3.0) for i in range(3)}

        return Loading(ball, 0, 0, _none, -1.0)
    return _simple_shear(3, curve) if curve.kind == "shear" else None


def _shell(curve: Curve, sheared: bool) -> Loading | None:
    if curve.kind == "uniaxial":
        shears: tuple[tuple[int, int], ...] = ((0, 1),) if sheared else ()

        def strip(c: Sequence[Any], u: Sequence[Any]) -> Entries:
            return _triangular(2, (c[0], u[0]), dict(zip(shears, u[1:], strict=True)))

        return Loading(strip, 1, len(shears), lambda c: c**-0.5)
    if curve.kind == "equibiaxial":
        return Loading(lambda c, u: {(0, 0): c[0], (1, 1): c[0]}, 0, 0, _none, 0.5)
    if curve.kind == "biaxial":
        return Loading(lambda c, u: {(0, 0): c[0], (1, 1): c[1]}, 0, 0, _none)
    if curve.kind == "planar":
        return Loading(lambda c, u: {(0, 0): c[0], (1, 1): 1.0}, 0, 0, _none)
    return _simple_shear(2, curve) if curve.kind == "shear" else None


def _rod(curve: Curve, sheared: bool) -> Loading | None:
    """Entries are (0, 2): stretch, (1, 0) and (1, 1): curvatures, (1, 2): twist."""
    if curve.kind == "uniaxial":
        return Loading(lambda c, u: {(0, 2): c[0]}, 0, 0, _none)
    if curve.kind not in ("bending", "torsion"):
        return None
    place = (1, 2) if curve.kind == "torsion" else (1, curve.axis - 1)
    return Loading(lambda c, u: {(0, 2): u[0], place: c[0]}, 1, 0, lambda c: np.ones_like(c))


def _plate(curve: Curve, sheared: bool) -> Loading | None:
    """Bending of a shell: entries are the two curvatures, of which a narrow strip chooses the second."""
    if curve.narrow:
        return Loading(lambda c, u: {(0, 0): c[0], (0, 1): u[0]}, 0, 1, _none)
    return Loading(lambda c, u: {(0, 0): c[0], (0, 1): 0.0}, 0, 0, _none)
