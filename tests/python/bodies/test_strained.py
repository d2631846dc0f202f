"""A word for cloth that starts far beyond its strain limit, and none for cloth that does not."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark

GRID = stark.mesh.grid(0.2, 0.1, cells=(4, 2))


def _told(
    stretch: float, material: stark.ShellMaterial = stark.materials.cotton, **options: Any
) -> list[str]:
    scene = stark.Scene()
    turn = stark.rotation(axis=(1.0, -2.0, 0.5), angle=0.9)
    places = GRID.vertices * (1.0, stretch, 1.0) @ turn.T
    scene.add_cloth(GRID, material, name="sheet", initial_positions=places, **options)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        stark.Simulation(scene)
    return [str(each.message) for each in told if "strain_limit" in str(each.message)]


def test_a_cloth_far_beyond_its_limit_is_named() -> None:
    (text,) = _told(1.5)  # a Green strain of (1.5^2 - 1) / 2
    assert "cloth 'sheet': its initial_positions stretch it to a Green strain of 0.625 (triangle " in text
    assert "far beyond its strain_limit = 0.1" in text


@pytest.mark.parametrize("stretch", [0.2, 1.0, 1.2])
def test_pressed_and_slightly_stretched_cloth_is_not(stretch: float) -> None:
    """A limit holds what is stretched; loads stretch cloth somewhat beyond it."""
    assert not _told(stretch)


def test_nor_is_cloth_without_such_a_limit() -> None:
    cotton = stark.materials.cotton
    assert not _told(2.0, cotton.replace(strain_limit=np.inf))
    assert not _told(2.0, cotton.replace(strain_limit_law="edges"))
    assert not _told(1.03, cotton.replace(strain_limit=0.001))


def test_numpy_says_nothing_of_huge_positions() -> None:
    scene = stark.Scene()
    scene.add_cloth(GRID, stark.materials.cotton, initial_positions=GRID.vertices * (1e149, 1.0, 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("ignore", stark.StarkWarning)
        with pytest.raises(stark.InvalidArgument, match="contact_distance"):
            stark.Simulation(scene)
