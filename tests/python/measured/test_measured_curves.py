"""Treloar's curves as they were published."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import measured


def test_the_curves_of_treloar() -> None:
    uniaxial, equibiaxial, planar = measured.treloar()
    assert [curve.kind for curve in (uniaxial, equibiaxial, planar)] == ["uniaxial", "equibiaxial", "planar"]
    assert [len(curve) for curve in (uniaxial, equibiaxial, planar)] == [25, 17, 14]
    # Treloar 1944: rupture at a stretch of 7.6 and 64.4 kgf/cm^2 in tension.
    assert uniaxial.imposed[-1, 0] == 7.61 and abs(uniaxial.measured[-1, 0] / (64.4 * 98066.5) - 1.0) < 0.005
    for curve in (uniaxial, equibiaxial, planar):
        assert curve.imposed[0, 0] == 1.0 and curve.measured[0, 0] == 0.0
        assert (np.diff(curve.imposed[:, 0]) > 0).all() and (np.diff(curve.measured[:, 0]) > 0).all()
    # All three have one modulus: at small strains 3, 6 and 4 times the shear modulus.
    slopes = [curve.measured[2, 0] / (curve.imposed[2, 0] - 1.0) for curve in (equibiaxial, planar)]
    assert 1.3 < slopes[0] / slopes[1] < 2.0


def test_curves_are_cut_at_a_stretch() -> None:
    assert [len(curve) for curve in measured.treloar(3.05)] == [10, 12, 9]
    assert [len(curve) for curve in measured.treloar(1.06)] == [2, 2, 2]
    with pytest.raises(stark.InvalidArgument, match=r"must be 1\.06 or more"):
        measured.treloar(1.05)
    with pytest.raises(stark.InvalidArgument, match="must be a number"):
        measured.treloar("3")  # type: ignore[arg-type]
