"""How fine meshes have to be for the force of contact on curved and narrow obstacles: docs/surfaces.md."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stark

_R, _D, _P = 0.03, 1e-3, 1e4  # rollers [m], sum of contact distances [m], stiffness [Pa]
_WIDTH, _LENGTH = 0.05, 0.2  # of the web along the rollers and across [m]


def expected(gap: float) -> float:
    """Force [N] between a flat sheet and a roller: the pressure over the gap along the arc."""
    x = np.linspace(-0.012, 0.012, 4001)
    gaps = gap + _R - np.sqrt(_R**2 - x**2)
    pressures = _P * stark.surfaces.relative_pressure(np.minimum(gaps / _D, 1.0))
    return _WIDTH * float(np.trapezoid(pressures, x))


def nip(gap: float, cells: int, segments: int = 400) -> float:
    """Force [N] of a web on the upper of two rollers, both at this distance."""
    scene = stark.Scene()
    along = stark.rotation(axis="x", angle=90 * stark.deg)
    rollers = []
    for sign in (1.0, -1.0):
        roller = scene.add_cylinder(
            _R,
            0.1,
            segments=segments,
            motion="scripted",
            rotation=along,
            position=(0, 0, sign * (_R + 1.1e-3)),
        )
        path = stark.motion.linear([0.0, 0.1], [(0, 0, sign * (_R + 1.1e-3)), (0, 0, sign * (_R + gap))])
        roller.follow(position=path)
        rollers.append(roller)
    web = stark.mesh.grid(_LENGTH, _WIDTH, cells=(cells, 4))
    scene.add_cloth(web, stark.materials.cotton, self_contact=False)
    settings = {"contact.distance": _D / 2, "contact.stiffness": _P}
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **settings)
    for report in sim.run(until=0.12):
        assert not report.failed, report.message
    return float(rollers[0].contact_force[2])


@pytest.mark.parametrize("gap", [0.8e-3, 0.5e-3, 0.2e-3])
def test_cells_of_half_the_contact_patch_give_the_force_and_of_twice_its_width_do_not(gap: float) -> None:
    half_width = math.sqrt(2.0 * _R * (_D - gap))  # where the gap is the contact distance
    for part, band in ((1.0, 0.25), (0.5, 0.07)):
        cells = math.ceil(_LENGTH / (part * half_width))
        ratios = [nip(gap, cells + odd) / expected(gap) for odd in (0, 1)]  # a row in the nip, and beside it
        assert np.abs(np.array(ratios) - 1.0).max() < band, (part, ratios)
    coarse = [nip(gap, cells) / expected(gap) for cells in (12, 13)]
    assert coarse[0] > 2.5 and coarse[1] < 0.2  # 16.7 and 15.4 mm


def test_facets_of_rollers_count_like_cells() -> None:
    """At 96 segments of 2 mm the force on a fine web is short by a tenth, at a gap of 0.8 of the distance."""
    ratios = [nip(0.8e-3, 145, segments) / expected(0.8e-3) for segments in (96, 192, 400)]
    assert 0.8 < ratios[0] < 0.95 and abs(ratios[1] - 1.0) < 0.05 and abs(ratios[2] - 1.0) < 0.03


def test_a_narrow_jaw_is_off_by_up_to_a_row_of_vertices() -> None:
    """20 mm on cells of 8.3 and 1.04 mm: too strong by 75 and 7 %; a jaw that covers the web is exact."""
    found = []
    for width, cells in ((0.3, 12), (0.02, 12), (0.02, 96)):
        scene = stark.Scene()
        jaws = [
            scene.add_box((width, 0.3, 0.02), motion="scripted", position=(0, 0, sign * 0.0114))
            for sign in (1.0, -1.0)
        ]
        for jaw, sign in zip(jaws, (1.0, -1.0), strict=True):
            jaw.follow(
                position=stark.motion.linear([0.0, 0.1], [(0, 0, sign * 0.0114), (0, 0, sign * 0.0108)])
            )
        scene.add_cloth(
            stark.mesh.grid(0.1, 0.05, cells=(cells, 4)), stark.materials.cotton, self_contact=False
        )
        settings = {"contact.distance": _D / 2, "contact.stiffness": _P}
        sim = stark.Simulation(scene, time_step=0.02, gravity=(0, 0, 0), **settings)
        for report in sim.run(until=0.14):
            assert not report.failed, report.message
        x = np.linspace(0.0, 0.6e-3, 500)  # beside the jaw
        beside = np.trapezoid(stark.surfaces.relative_pressure(np.minimum(np.hypot(0.8e-3, x) / _D, 1.0)), x)
        area = min(width, 0.1) + (
            2.0 * beside / stark.surfaces.relative_pressure(0.8) if width < 0.1 else 0.0
        )
        force = _P * stark.surfaces.relative_pressure(0.8) * 0.05 * area
        found.append(float(jaws[0].contact_force[2]) / float(force))
    assert abs(found[0] - 1.0) < 1e-3 and 1.6 < found[1] < 1.9 and 1.0 < found[2] < 1.1
