"""States in other simulations than their own: what stands in the way, moved walls, shorter steps."""

from __future__ import annotations

from pathlib import Path

import pytest

import stark
from stark import CheckpointError


def box_and_wall(wall: float, *, time_step: float = 0.01, **settings: object) -> stark.Simulation:
    scene = stark.Scene()
    scene.add_floor(4.0)
    scene.add_box(0.1, mass=0.5, position=(0, 0, 0.0519), velocity=(2.0, 0, 0), friction=0.0, name="box")
    scene.add_box((0.1, 1.0, 1.0), motion="fixed", position=(wall, 0, 0.6), name="wall")
    return stark.Simulation(scene, time_step=time_step, **settings)


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """After a tenth of a second, with a box that is 0.2 m on its way to a wall at 1 m."""
    sim = box_and_wall(1.0)
    sim.run_until(0.1)
    sim.save(tmp_path / "state.stark")
    return tmp_path / "state.stark"


def test_moved_walls_are_another_scene(saved: Path) -> None:
    with pytest.raises(CheckpointError, match="place of rigid 'wall'"):
        box_and_wall(0.6).load(saved)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_fixed_bodies_stand_where_the_scene_has_them(integrator: str) -> None:
    settings = {"time.integrator": integrator}
    before = box_and_wall(1.0, **settings)
    before.run_until(0.1)
    sim = box_and_wall(0.6, **settings)
    sim.state = before.state
    sim.run_until(0.35)
    assert sim["wall"].position[0] == 0.6
    assert 0.4 < sim["box"].position[0] < 0.5  # it has met that wall, and not passed it


def test_states_with_something_in_the_way_are_refused(saved: Path) -> None:
    sim = box_and_wall(0.25)
    before = sim.state
    with pytest.raises(CheckpointError, match="'box' and 'wall' intersect in this state"):
        sim.load(saved, exact=False)
    assert sim.state == before


def test_states_of_simulations_without_contact_are_looked_at() -> None:
    def falling(**settings: object) -> stark.Simulation:
        scene = stark.Scene()
        scene.add_floor(1.0)
        scene.add_box(0.1, mass=0.5, position=(0, 0, 0.06), name="box")
        return stark.Simulation(scene, time_step=0.01, **settings)

    through = falling(**{"contact.enabled": False})
    through.run_until(0.1)
    sim = falling()
    with pytest.raises(stark.InitialIntersection, match="'box' and 'floor' intersect in this state"):
        sim.state = through.state
    assert sim.time == 0.0


def test_shorter_steps_hold_from_the_first_on(saved: Path) -> None:
    sim = box_and_wall(1.0, time_step=0.001)
    sim.load(saved, exact=False)
    assert sim.step().time_step == pytest.approx(0.001, rel=1e-12)
