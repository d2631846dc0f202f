"""Surfaces: presets, arguments of bodies, the guide."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import stark

GUIDE = Path(__file__).parents[2] / "docs" / "surfaces.md"
PRESETS = ("rigid", "rubber", "skin", "paper", "terry_towel")


def test_presets_are_those_of_the_guide() -> None:
    rows = re.findall(r"^\| `stark\.surfaces\.(\w+)` \| (.*?) \| (.*?) \| (.*?) \|", GUIDE.read_text(), re.M)
    assert {name: tuple(map(float, numbers)) for name, *numbers in rows} == {
        name: (surface.thickness, surface.stiffness, surface.core)
        for name in PRESETS
        for surface in [getattr(stark.surfaces, name)]
    }
    assert all(getattr(stark.surfaces, name).source for name in PRESETS)


def test_the_curve_of_the_guide() -> None:
    table = re.search(
        r"^\| gap over contact distance \|(.*)\|\n.*\n\| p/P \|(.*)\|$", GUIDE.read_text(), re.M
    )
    assert table is not None
    gaps, pressures = ([float(cell) for cell in row.split("|")] for row in table.groups())
    assert stark.surfaces.relative_pressure(gaps) == pytest.approx(pressures, rel=0.05)
    assert np.isnan(stark.surfaces.relative_pressure([np.nan, 0.5])).tolist() == [True, False]


def test_the_example_of_the_guide() -> None:
    code = re.search(r"```python\n(.*?)```", GUIDE.read_text(), re.S)
    assert code is not None
    names: dict[str, object] = {}
    exec(code[1], names)
    gap = names["gap"]
    assert isinstance(gap, float) and 0.0 < gap < 0.003


def test_a_surface_gives_distance_and_stiffness_unless_they_are_given() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, surface=stark.surfaces.rubber)
    assert (box.contact_distance, box.contact_stiffness) == (5e-4, 1e6)
    other = scene.add_box(
        0.1, mass=1.0, position=(1, 0, 0), surface=stark.surfaces.rubber, contact_stiffness=2e6
    )
    assert (other.contact_distance, other.contact_stiffness) == (5e-4, 2e6)
    assert scene.add_box(0.1, mass=1.0, position=(2, 0, 0)).contact_stiffness is None


def test_a_stack_of_paper_is_as_thick_as_its_sheets() -> None:
    """At 100 kPa, at which ISO 534 measures the thickness of a sheet: 104 um of 80 g/m2."""
    assert stark.surfaces.paper.pressure(104e-6) == pytest.approx(1e5, rel=0.05)
    scene = stark.Scene()
    size, count = 0.05, 6
    scene.add_box(0.1, motion="fixed", position=(0, 0, -0.05), surface=stark.surfaces.paper)
    for k in range(count):
        scene.add_cloth(
            stark.mesh.grid(size, size, 2),
            stark.materials.paper,
            position=(0, 0, 110e-6 * (k + 1)),
            surface=stark.surfaces.paper,
        )
    weight = scene.add_box(
        (size, size, 0.02),
        mass=1e5 * size**2 / 9.81,
        position=(0, 0, 110e-6 * (count + 1) + 0.01),
        surface=stark.surfaces.paper,
    )
    sim = stark.Simulation(scene, time_step=1 / 60)
    for report in sim.run(until=0.2):
        assert not report.failed
    gap = (weight.position[2] - 0.01) / (count + 1)
    assert gap == pytest.approx(104e-6, abs=4e-6)  # the tolerance of office paper


def test_what_is_no_surface_is_refused() -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=r"must be a stark\.Surface"):
        scene.add_box(0.1, mass=1.0, surface="rubber")
    with pytest.raises(stark.InvalidArgument, match="thickness = 0 m"):
        stark.surfaces.rubber.replace(thickness=0)
    with pytest.raises(stark.InvalidArgument, match="contact_stiffness"):
        scene.add_box(0.1, mass=1.0, contact_stiffness=-1.0)


def test_numbers_of_numpy_make_a_surface() -> None:
    """Those that are no floats of Python were no numbers."""
    surface = stark.Surface("foam", np.float32(0.5), np.int64(4000), "measured")
    assert surface == stark.Surface("foam", 0.5, 4000.0, "measured") and type(surface.stiffness) is float
    with pytest.raises(stark.InvalidArgument, match=r"stiffness = array\(.*: must be a number in Pa"):
        stark.Surface("foam", 0.5, np.array([4e3, 5e3]), "measured")  # type: ignore[arg-type]
    with pytest.raises(stark.InvalidArgument, match="surface: name = 5: must be a text"):
        stark.Surface(5, 0.5, 4e3, "measured")  # type: ignore[arg-type]
