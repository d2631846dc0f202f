"""Forces of contact over pictures: where they start, where they point, the key."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark.render import Camera, scene_bounds
from stark.render.clipping import Plane
from stark.render.contact_marks import FORCE, draw_contacts, forces_of, round_force
from stark.render.overlay import Overlay

SIZE = (320, 240)
CAMERA = Camera(eye=(0.0, -1.0, 0.1), target=(0.0, 0.0, 0.1))


@pytest.fixture(scope="module")
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box((1.0, 1.0, 0.1), name="table", motion="fixed", position=(0, 0, -0.05))
    scene.add_sphere(0.05, name="ball", mass=1.0, position=(0.1, 0, 0.0515))
    scene.add_box(0.1, name="free", mass=1.0, position=(-0.2, 0, 0.5))
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
    sim.run_until(0.2)
    return sim


def marks(sim, which) -> np.ndarray:
    """Where arrows and dots are (height, width)."""
    overlay = Overlay(np.full((SIZE[1], SIZE[0], 3), 128, dtype=np.uint8))
    draw_contacts(overlay, sim, which, CAMERA, scene_bounds(sim))
    distance = np.abs(overlay.picture - 255.0 * np.array(FORCE)).max(axis=2)
    return distance < 30


def test_the_force_on_the_ball_starts_below_it_and_points_up(sim) -> None:
    red = marks(sim, True)
    red[200:] = False  # the key
    (start,), _ = CAMERA.project([(0.1, 0.0, 0.0005)], SIZE)
    rows, columns = np.nonzero(red)
    assert columns.mean() == pytest.approx(start[0], abs=2.0)
    assert rows.max() == pytest.approx(start[1], abs=5.0)
    length = 0.35 * scene_bounds(sim).radius  # the longest arrow [m]
    (end,), _ = CAMERA.project([(0.1, 0.0, length)], SIZE)
    assert rows.min() == pytest.approx(end[1], abs=3.0)


def test_forces_on_a_body_that_is_named(sim) -> None:
    assert np.array_equal(marks(sim, "ball"), marks(sim, True))  # the table does not move
    rows = np.nonzero(marks(sim, sim["table"])[:200])[0]
    (start,), _ = CAMERA.project([(0.1, 0.0, 0.0005)], SIZE)
    assert rows.max() > start[1] + 20  # downwards
    assert not marks(sim, "free").any()
    with pytest.raises(ValueError, match="contacts: no body is named 'cup'"):
        marks(sim, "cup")


def test_contacts_of_bodies_that_are_not_shown_are_left_out(sim) -> None:
    def drawn(shown) -> bool:
        overlay = Overlay(np.full((SIZE[1], SIZE[0], 3), 128, dtype=np.uint8))
        draw_contacts(overlay, sim, True, CAMERA, scene_bounds(sim), shown)
        return bool((overlay.picture != 128).any())

    assert drawn(None) and drawn({"ball"}) and drawn({"table", "free"})
    assert not drawn({"free"}) and not drawn(set())


def test_of_a_fixed_and_a_free_body_the_free_one_has_the_force() -> None:
    """The pairs of a vertex below with a face above begin with the fixed body."""
    scene = stark.Scene()
    scene.add_sphere(0.05, name="knob", motion="fixed", position=(0, 0, 0))
    scene.add_box((0.2, 0.2, 0.02), name="lid", mass=1.0, position=(0, 0, 0.0612))
    sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
    sim.run_until(0.1)
    assert (sim.contacts.bodies[:, 0] == 0).any()
    red = marks(sim, True)[:200]
    (touch,), _ = CAMERA.project([(0.0, 0.0, 0.0505)], SIZE)
    rows = np.nonzero(red)[0]
    assert rows.max() == pytest.approx(touch[1], abs=5.0) and rows.min() < touch[1] - 15.0


def test_recordings_have_no_contacts(sim) -> None:
    with pytest.raises(
        ValueError, match="contacts = True needs a simulation; a recording has positions only"
    ):
        draw_contacts(Overlay(np.zeros((4, 4, 3), dtype=np.uint8)), object(), True, CAMERA, scene_bounds(sim))


def test_forces_are_in_front_of_bodies(sim) -> None:
    options = {"size": SIZE, "camera": CAMERA, "quality": "draft"}
    changed = np.abs(sim.picture(contacts=True, **options).astype(int) - sim.picture(**options)).max(axis=2)
    inside, _ = CAMERA.project([(0.1, 0.0, 0.03)], SIZE)  # within the ball
    x, y = inside[0].astype(int)
    assert changed[y - 2 : y + 3, x - 2 : x + 3].max() > 60


@pytest.mark.parametrize(("largest", "key"), [(9.81, 5.0), (1.0, 1.0), (0.049, 0.02), (2e4, 2e4), (3.3, 2.0)])
def test_keys_are_round(largest: float, key: float) -> None:
    assert round_force(largest) == pytest.approx(key)


def test_what_a_cut_takes_away_has_no_arrows(sim) -> None:
    """Of all bodies; where one of two is whole, their contacts stay."""
    every = len(forces_of(sim, True)[0])
    with_ball, without_ball = (Plane.of((0.0, 0.0, 0.0), (x, 0.0, 0.0)) for x in (1.0, -1.0))
    assert every > 0
    assert len(forces_of(sim, True, None, dict.fromkeys(("table", "ball"), with_ball))[0]) == 0
    assert len(forces_of(sim, True, None, dict.fromkeys(("table", "ball"), without_ball))[0]) == every
    assert len(forces_of(sim, True, None, {"table": with_ball})[0]) == every
    assert len(forces_of(sim, True, {"table"}, {"table": with_ball})[0]) == 0
