"""Handles of bodies and the life of their simulation."""

from __future__ import annotations

import gc

import pytest

import stark


def test_a_handle_that_outlives_its_simulation_says_so() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, name="crate")
    start = box.positions
    simulation = stark.Simulation(scene)
    simulation.step()
    assert not (box.positions == start).all()
    del simulation
    gc.collect()
    with pytest.raises(stark.InvalidArgument, match=r"'crate'.*simulation is gone.*keep"):
        _ = box.positions
    with pytest.raises(stark.InvalidArgument, match="gone"):
        _ = box.velocity
