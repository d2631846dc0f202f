"""Laws of published fits: invariants, limits, symmetry."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark import curves, measured

FIBRES = {"fibre_exponent": 0.2, "angle": 0.7, "bulk_modulus": 1e9, "shear_modulus": 1e5}


@pytest.mark.parametrize(
    ("law", "values"),
    [
        (measured.carroll, {"a": 1.4e5, "b": 0.3, "c": 1e5, "bulk_modulus": 1e6}),
        (measured.dispersed_fibres, {**FIBRES, "fibre_ratio": 100.0, "dispersion": 0.1}),
    ],
)
def test_they_pass_the_checks_of_laws(law: object, values: dict[str, float]) -> None:
    report = law.check(**values)  # type: ignore[attr-defined]
    assert all(finding.status in ("ok", "note") for finding in report.findings), str(report)


def test_the_shear_modulus_of_carroll() -> None:
    gamma = np.array([1e-5, 2e-5, 3e-5])
    fit = stark.fit(
        measured.carroll,
        curves.shear(gamma, 3e5 * gamma),
        start={"a": 1e4},
        fixed={"b": 0.3, "c": 1e5, "bulk_modulus": 1e9},
    )
    assert 2.0 * fit["a"] + 216.0 * 0.3 + 1e5 / np.sqrt(3.0) == pytest.approx(3e5, rel=1e-6)


def test_fibres_in_all_directions_are_isotropic() -> None:
    fibres = {**FIBRES, "fibre_ratio": 10.0, "dispersion": 1.0 / 3.0}
    assert measured.dispersed_fibres.check(**fibres).findings[4].value < 1e-9
    stretch = np.array([1.1, 1.3])
    along, across = (
        stark.fit(
            measured.dispersed_fibres, curves.uniaxial(stretch, stretch - 1.0), start={"shear_modulus": 1e5},
            fixed={**{k: v for k, v in fibres.items() if k != "shear_modulus"}, "angle": angle},
        )["shear_modulus"]
        for angle in (0.0, 0.5 * np.pi)
    )  # fmt: skip
    assert along == pytest.approx(across, rel=1e-9)
