"""Linear elements lock where solids hardly change their volume: the table of the guide, and the warning."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

MODULUS, LENGTH, WIDTH, LOAD = 1e6, 0.4, 0.04, 0.02  # [Pa, m, m, N]
BEAM = (LENGTH, WIDTH, WIDTH)
DOCS = (Path(__file__).parents[3] / "docs/solids.md").read_text()


def deflection(mesh: Any, ratio: float, formulation: str = "displacement") -> float:
    """Of the loaded end of a clamped beam, over that of Euler and Bernoulli."""
    scene, X = stark.Scene(), mesh.vertices
    material = stark.SolidMaterial(density=1.0, youngs_modulus=MODULUS, poissons_ratio=ratio)
    beam = scene.add_solid(mesh, material, pins=X[:, 0] < 1e-9 - LENGTH / 2, formulation=formulation)
    end = np.flatnonzero(X[:, 0] > LENGTH / 2 - 1e-9)
    for vertex in end.tolist():
        scene.add_force(beam.vertices[[vertex]], (0.0, 0.0, -LOAD / len(end)))
    static = {"time.integrator": "quasistatic"}
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **static)
    assert not sim.step().failed
    expected = LOAD * LENGTH**3 / (3.0 * MODULUS * WIDTH**4 / 12.0)
    return float((X - beam.positions)[end, 2].mean() / expected)


@pytest.mark.filterwarnings("ignore:.*elements lock")
@pytest.mark.parametrize("ratio", ["0.3", "0.45", "0.47", "0.49", "0.499"])
def test_beams_bend_as_the_guide_says(ratio: str) -> None:
    row = re.search(rf"^\| {re.escape(ratio)} \|(.*)\|$", DOCS, re.MULTILINE)
    assert row is not None
    tets, cubes = stark.mesh.tet_box(BEAM, (20, 2, 2)), stark.mesh.box_hexahedra(BEAM, (20, 2, 2))
    nu = float(ratio)
    found = [
        deflection(tets, nu),
        deflection(stark.mesh.tet_box(BEAM, (40, 4, 4)), nu),
        deflection(cubes, nu),
        deflection(cubes, nu, "mean_dilatation"),
        deflection(stark.mesh.to_quadratic(stark.mesh.tet_box(BEAM, (10, 1, 1))), nu),
    ]
    np.testing.assert_allclose(found, [float(cell) for cell in row[1].split("|")], atol=0.0051)


@pytest.mark.parametrize(("slender", "layers"), [(2.5, 1), (2.5, 2), (2.5, 4), (1.0, 1), (1 / 3, 3)])
def test_long_cells_of_thin_parts_shear_instead_of_bending(slender: float, layers: int) -> None:
    """A bent cell of straight edges has the shear strain x/R, whose mean square l^2/(12 R^2) adds to that of
    bending, t^2/(12 R^2): 1 + (G/E) (l/t)^2 of the stiffness, however many cells are across."""
    mesh = stark.mesh.box_hexahedra(BEAM, (round(LENGTH / (slender * WIDTH)), 2, layers))
    expected = 1.0 / (1.0 + 0.5 * slender**2)
    # A beam of ten thicknesses also shears, by 3 E t^2/(12 G 5/6 L^2) of its deflection: 0.006.
    assert deflection(mesh, 0.0) == pytest.approx(expected, rel=0.012)
    text = (Path(__file__).parents[3] / "docs/troubleshooting.md").read_text()
    assert f"{expected:.2f} with l = " in text


def test_quadratic_cells_of_thin_parts_bend() -> None:
    mesh = stark.mesh.to_quadratic(stark.mesh.box_hexahedra(BEAM, (4, 1, 1)))
    assert deflection(mesh, 0.0) == pytest.approx(1.0, abs=0.01)


def test_elements_that_lock_are_warned_of_once_a_body() -> None:
    tets, cubes = stark.mesh.tet_box(0.1, 1), stark.mesh.box_hexahedra(0.1, 1)
    rubber = stark.materials.natural_rubber
    for mesh, remedy in ((tets, "to_quadratic"), (cubes, "mean_dilatation")):
        with pytest.warns(stark.StarkWarning, match=rf"0\.49 with .*elements lock.*{remedy}") as found:
            stark.Scene().add_solid(mesh, rubber, name="pad")
        assert len(found) == 1 and found[0].filename == __file__


@pytest.mark.parametrize(
    ("mesh", "ratio", "formulation"),
    [
        (stark.mesh.tet_box(0.1, 1), 0.47, "displacement"),
        (stark.mesh.to_quadratic(stark.mesh.tet_box(0.1, 1)), 0.49, "displacement"),
        (stark.mesh.box_hexahedra(0.1, 1), 0.499, "mean_dilatation"),
    ],
)
def test_other_solids_are_not_warned_of(mesh: Any, ratio: float, formulation: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        material = stark.materials.natural_rubber.replace(poissons_ratio=ratio)
        stark.Scene().add_solid(mesh, material, formulation=formulation)
