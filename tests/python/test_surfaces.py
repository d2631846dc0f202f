"""Surfaces: presets, arguments of bodies, the guide."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stark

GUIDE = Path(__file__).parents[2] / "docs" / "surfaces.md"
PRESETS = ("rigid", "rubber", "skin", "terry_towel")


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


def test_what_is_no_surface_is_refused() -> None:
    scene = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match=r"must be a stark\.Surface"):
        scene.add_box(0.1, mass=1.0, surface="rubber")
    with pytest.raises(stark.InvalidArgument, match="thickness = 0 m"):
        stark.surfaces.rubber.replace(thickness=0)
    with pytest.raises(stark.InvalidArgument, match="contact_stiffness"):
        scene.add_box(0.1, mass=1.0, contact_stiffness=-1.0)
