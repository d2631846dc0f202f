"""Numbers of NumPy wherever a number is taken: scalars and arrays without dimensions count, flags do not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark


@pytest.mark.parametrize("number", [np.array(2), np.array(2.0), np.float32(2.0), np.longdouble(2.0)])
def test_numbers_of_numpy_count_everywhere(number: Any) -> None:
    """Arrays without dimensions were numbers here, and none there."""
    scene = stark.Scene()
    ball = scene.add_sphere(0.1, mass=number)
    scene.default_friction = number
    scene.friction[ball, scene.add_floor(height=-1.0)] = number
    material = stark.SolidMaterial(youngs_modulus=number)
    assert ball.mass == scene.default_friction == material.youngs_modulus == 2.0
    assert stark.Simulation(scene, time_step=number).time_step == 2.0
    if np.asarray(number).dtype.kind == "i":
        assert stark.mesh.grid(1.0, 1.0, cells=number).vertices.shape == (9, 3)


@pytest.mark.parametrize("flag", [True, np.True_, np.array(True), 10**400])
def test_flags_and_endless_numbers_are_no_numbers(flag: Any) -> None:
    with pytest.raises(stark.InvalidArgument, match=r"mass = .*must be a number or None"):
        stark.Scene().add_sphere(0.1, mass=flag)
    with pytest.raises(stark.InvalidArgument, match=r"default_friction = .*must be a number"):
        stark.Scene().default_friction = flag
    with pytest.raises(stark.InvalidArgument, match="youngs_modulus"):
        stark.SolidMaterial(youngs_modulus=flag)
