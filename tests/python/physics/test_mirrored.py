"""The mirror image of a scene goes as the mirror image of what it does: threads turn left where they turned
right, and nothing else changes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from _worlds import SCENES, Floats, World, farthest

Scene = Callable[[World, str], list[Floats]]


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
@pytest.mark.parametrize("scene", SCENES)
def test_a_mirrored_scene_goes_as_the_mirror_image(scene: Scene, integrator: str) -> None:
    here = scene(World(), integrator)
    for mirror in (np.diag([-1.0, 1.0, 1.0]), -np.eye(3)):
        assert farthest(here, scene(World(axes=mirror), integrator)) < 1e-6
