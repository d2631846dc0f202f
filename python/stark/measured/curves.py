"""Measured curves from the literature, as tables."""

from __future__ import annotations

import numpy as np

from stark import curves
from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.curves import Curve

_MPA = 1e6

#: Nominal stress [MPa] by stretch of vulcanised natural rubber with 8 % sulphur: L. R. G. Treloar, Trans.
#: Faraday Soc.
#: 40 (1944) 59-70, in the numbers of P. Steinmann, M. Hossain, G. Possart, Arch. Appl. Mech. 82 (2012)
#: 1183-1217.
_TRELOAR_UNIAXIAL = (
    (1.00, 0.00), (1.01, 0.03), (1.12, 0.14), (1.24, 0.23), (1.39, 0.32), (1.61, 0.41), (1.89, 0.50),
    (2.17, 0.58), (2.42, 0.67), (3.01, 0.85), (3.58, 1.04), (4.03, 1.21), (4.76, 1.58), (5.36, 1.94),
    (5.76, 2.29), (6.16, 2.67), (6.40, 3.02), (6.62, 3.39), (6.87, 3.75), (7.05, 4.12), (7.16, 4.47),
    (7.27, 4.85), (7.43, 5.21), (7.50, 5.57), (7.61, 6.30),
)  # fmt: skip
_TRELOAR_EQUIBIAXIAL = (
    (1.00, 0.00), (1.04, 0.09), (1.08, 0.16), (1.12, 0.24), (1.14, 0.26), (1.20, 0.33), (1.31, 0.44),
    (1.42, 0.51), (1.69, 0.65), (1.94, 0.77), (2.49, 0.96), (3.03, 1.24), (3.43, 1.45), (3.75, 1.72),
    (4.03, 1.96), (4.26, 2.22), (4.44, 2.43),
)  # fmt: skip
_TRELOAR_PLANAR = (
    (1.00, 0.00), (1.06, 0.07), (1.14, 0.16), (1.21, 0.24), (1.32, 0.33), (1.46, 0.42), (1.87, 0.59),
    (2.40, 0.76), (2.98, 0.93), (3.48, 1.11), (3.96, 1.28), (4.36, 1.46), (4.69, 1.62), (4.96, 1.79),
)  # fmt: skip


def treloar(largest_stretch: float = 10.0) -> list[Curve]:
    """Treloar's rubber (1944): the curves uniaxial, equibiaxial and planar, up to a stretch.

    Nominal stresses of vulcanised natural rubber with 8 % sulphur at 20 degrees Celsius, as tabulated by
    Steinmann, Hossain and Possart (2012). InvalidArgument for a stretch below the second point of a curve."""
    tables = (
        (curves.uniaxial, _TRELOAR_UNIAXIAL),
        (curves.equibiaxial, _TRELOAR_EQUIBIAXIAL),
        (curves.planar, _TRELOAR_PLANAR),
    )
    largest = real_number(largest_stretch, "measured.treloar: largest_stretch")
    least = max(table[1][0] for _, table in tables)
    if not largest >= least:
        raise InvalidArgument(
            f"measured.treloar: largest_stretch = {largest:g}: must be {least:g} or more, so that every "
            f"curve has two points"
        )
    found = []
    for make, table in tables:
        stretch, stress = np.array([row for row in table if row[0] <= largest]).T
        found.append(make(stretch, _MPA * stress))
    return found
