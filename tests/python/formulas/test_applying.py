"""Formulas called as functions: within other formulas, and with numbers."""

from __future__ import annotations

import numpy as np
import pytest
from _scenes import sheet

import stark


@stark.energy
def pull(p: stark.Point, k: float = stark.parameter(3.0, unit="N/m"), center: stark.Vec3 = (0.0, 0.0, 1.0)):
    return 0.5 * k * stark.squared_norm(p.x - center)


@stark.material
def swelling(
    F: stark.DeformationGradient,
    a: float = stark.parameter(1e4, unit="Pa"),
    b: float = stark.parameter(unit="Pa"),
):
    J = stark.determinant(F)
    return a * (stark.trace(F.T @ F) - 3.0 - 2.0 * stark.log(J)) + b * (J - 1.0) ** 2


def test_declared_values_hold_in_other_formulas() -> None:
    """They were what stark.parameter makes, with which nothing can be calculated."""

    @stark.energy
    def twice(p: stark.Point):
        return 2.0 * pull(p)

    @stark.material
    def outer(F: stark.DeformationGradient):
        return swelling(F, b=2e4)

    _, cloth = sheet(2)
    report = twice.check(cloth.vertices)
    assert report["gradient"].status == "ok"
    F = np.diag([1.1, 1.0, 0.9])
    assert float(outer(F)) == float(swelling(F, a=1e4, b=2e4)) != float(swelling(F, a=1.0, b=2e4))
    assert outer(density=1000.0).density == 1000.0


def test_what_has_no_declared_value_must_be_given() -> None:
    F = np.eye(3)
    with pytest.raises(stark.TraceError, match=r"swelling: 'b' \[Pa\] has no value: must be given where"):
        swelling(F)
    with pytest.raises(stark.TraceError, match="'plastic_metric' has no value: must be given where"):
        stark.j2_plasticity(F, shear_modulus=1.0, bulk_modulus=1.0, yield_stress=1.0)
    with pytest.raises(stark.TraceError, match="swelling: got an unexpected keyword argument 'c': its arg"):
        swelling(F, c=1.0)

    @stark.material
    def outer(F: stark.DeformationGradient):
        return swelling(F)

    with pytest.raises(stark.TraceError, match=r"(?s)'b' .Pa. has no value: must be given.*swelling.F."):
        outer()


def test_values_without_a_name_are_no_strain() -> None:
    rule = "j2_plasticity: got 200000000000.0 without a name: must be values by name for a material, such as"
    with pytest.raises(stark.InvalidArgument, match=rule):
        stark.j2_plasticity(2e11, 0.3, 1e8)
    with pytest.raises(stark.InvalidArgument, match=r"such as swelling.a=....*, or the strain F"):
        swelling("steel")


def test_a_strain_has_the_shape_of_the_law() -> None:
    """A smaller one gave an energy, or an error of NumPy."""
    rows = [[1.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.9]]
    assert float(swelling(rows, b=2e4)) == float(swelling(np.array(rows), b=2e4))
    for strain in (np.eye(2), [[1.0]], np.ones(3), np.eye(3, 2)):
        with pytest.raises(stark.InvalidArgument, match=r"the strain F has the shape \(.*must be \(3, 3\)"):
            swelling(strain, b=2e4)


def test_a_law_of_rods_is_called_with_its_strains() -> None:
    @stark.material
    def wire(stretch: float, twist: float, k: float = stark.parameter(2.0, unit="N")):
        return k * (stretch - 1.0) ** 2 + k * twist**2

    assert float(wire(1.5, 0.5)) == 1.0


def test_points_that_are_no_numbers_are_named_once() -> None:
    with pytest.raises(stark.InvalidArgument, match=r"^pull: 'p' \[m\] = 'x': must be 3 numbers"):
        pull("x")
