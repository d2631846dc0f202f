"""Folds along a line of hinges, by energies and by natural curvature: docs/energies.md, Creases."""

from __future__ import annotations

import numpy as np
import pytest

import stark

_FOLD = 30.0  # [degrees]
_HINGES = stark.materials.paper.replace(flexural_rigidity=0.0, bending_stiffness=1e-4)


@stark.energy
def crease(h: stark.Hinge, fold: float = 0.0, stiffness: float = 1.0):
    return 0.5 * stiffness * stark.norm(h.rest_edge) * (h.angle - fold) ** 2


def fold_of(material: stark.ShellMaterial, rows: int, cells: int = 10, *, curved: bool = False) -> float:
    """Angle [degrees] between the ends of a sheet that is held at one of them, at rest, without gravity."""
    size = 0.2 / cells
    mesh = stark.mesh.grid(0.2, size * rows, cells=(cells, rows))
    x = mesh.vertices[:, 0]
    scene = stark.Scene()
    held = np.flatnonzero(x < -0.1 + 1.1 * size)
    sheet = scene.add_cloth(mesh, material, pins=held, self_contact=False)
    curvature = np.zeros((len(mesh.triangles), 3, 3))
    if curved:
        sheet.natural_curvature = curvature
    else:
        a, b = (end.rest_positions[:, 0] for end in sheet.hinges.columns[:2])
        line = sheet.hinges[(abs(a) < 1e-9) & (abs(b) < 1e-9)]
        assert len(line) == rows
        bend = scene.add(crease(line))
    beside = abs(x[mesh.triangles].mean(axis=1)) < size
    sim = stark.Simulation(scene, time_step=0.02, gravity=(0, 0, 0))
    for report in sim.run(until=8.0):
        assert not report.failed, report.message
        angle = min(report.time, 1.0) * _FOLD * stark.deg
        if curved:
            curvature[beside, 0, 0] = angle / (2.0 * size)
            sheet.natural_curvature = curvature
        else:
            bend.fold = angle
    across = sheet.positions.reshape(rows + 1, cells + 1, 3)[rows // 2]
    end = across[-1] - across[-2]
    return abs(float(np.degrees(np.arctan2(end[2], end[0]))))


def test_a_crease_of_hinges_folds_by_its_angle() -> None:
    """Less what the hinge of the material takes, 3 k |e|^2/(A_a + A_b) = 3 k beside those of 1 J/m |e|."""
    own, material = 1.0 * 0.02, 3.0 * 1e-4
    assert fold_of(_HINGES, 4) == pytest.approx(_FOLD * own / (own + material), abs=0.05)


def test_a_crease_of_a_plate_falls_short_where_few_cells_lie_along_it() -> None:
    for rows, least, most in ((4, 16.5, 18.5), (10, 22.0, 24.0), (16, 28.0, 30.0)):
        assert least < fold_of(stark.materials.paper, rows, 20) < most


@pytest.mark.parametrize(("cells", "rows"), [(10, 4), (20, 10)])
def test_natural_curvature_folds_a_plate(cells: int, rows: int) -> None:
    assert fold_of(stark.materials.paper, rows, cells, curved=True) == pytest.approx(_FOLD, rel=0.03)
