"""What handles of attachments measure and do: forces, breaking, releasing, holding again."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import stark

G = 9.81


LIGHT = stark.materials.cotton.replace(density=0.5)


def simulate(scene: stark.Scene, **settings: object) -> stark.Simulation:
    return stark.Simulation(scene, **{"time_step": 0.01, "contact.enabled": False, **settings})


def run(sim: stark.Simulation, steps: int) -> None:
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message


def weight_of(scene: stark.Scene, cloth: stark.Cloth, density: float) -> float:
    mesh = cloth.mesh
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return density * G * 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_forces_of_a_hung_cloth_add_up_to_its_weight() -> None:
    scene = stark.Scene()
    upright = stark.rotation(axis="x", angle=90 * stark.deg)
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=6), LIGHT, rotation=upright)
    beam = scene.add_box((0.3, 0.02, 0.02), motion="fixed", position=(0.0, 0.0, 0.115))
    glue = scene.attach(cloth, beam, distance=6e-3)
    assert len(glue) == 7
    sim = simulate(scene, time_step=0.1)  # the longer the step, the more implicit Euler damps
    run(sim, 40)
    expected = weight_of(scene, cloth, 0.5)
    # What Newton's method leaves: its residual tolerance.
    np.testing.assert_allclose(glue.force, [0.0, 0.0, expected], atol=2e-3 * expected)
    # Held within joints.length_tolerance.
    moved = cloth.positions[glue.points._columns["vertices"]] - glue.points.positions
    assert np.abs(moved).max() < 1e-6


def test_a_pair_breaks_above_its_force_and_not_below() -> None:
    """A box of 1 kg hangs by one point: the load is m g = 9.81 N."""
    for break_force, breaks in ((9.82, False), (9.80, True)):
        scene = stark.Scene()
        box = scene.add_box(0.1, mass=1.0)
        glue = scene.attach(box.points((0.0, 0.0, 0.05)), None, break_force=break_force)
        sim = simulate(scene)
        run(sim, 1)
        assert glue.broken.tolist() == [breaks]
        # Also of the step in which it broke, as the reaction of a joint.
        np.testing.assert_allclose(glue.force, [0.0, 0.0, G], rtol=1e-4)
        run(sim, 9)
        # The step that breaks it still holds: nine steps of free fall, of implicit Euler.
        fallen = G * 0.01**2 * 9 * 10 / 2 if breaks else 0.0
        np.testing.assert_allclose(box.position[2], -fallen, atol=2e-6)
        assert breaks == (not glue.forces.any())


def test_broken_pairs_stay_broken_and_others_take_over() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    weak = scene.attach(box.points((0.0, 0.0, 0.05)), None, break_force=5.0)
    strong = scene.attach(box.points([(0.05, 0.0, 0.05), (-0.05, 0.0, 0.05)]), None, enabled=False)
    assert not strong.enabled
    sim = simulate(scene)
    run(sim, 1)
    assert weak.broken.all() and weak.enabled and not strong.broken.any()
    weak.enabled = True
    strong.enabled = True
    run(sim, 20)
    assert weak.broken.all()
    np.testing.assert_allclose(strong.force, [0.0, 0.0, G], rtol=0.05)


def test_release_and_hold_again() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    glue = scene.attach(box.points((0.0, 0.0, 0.0)), None)
    sim = simulate(scene)
    run(sim, 1)
    glue.enabled = False
    run(sim, 1)
    assert not glue.enabled and not glue.forces.any() and box.position[2] < -1e-4
    before = sim.state
    refusal = r"'attachment': 1 of 1 released pairs .* pair 0 by 0\.000981 m: .* 1e-06 m .*pull_together\(\)"
    with pytest.raises(stark.InvalidArgument, match=refusal):
        glue.enabled = True
    assert not glue.enabled and sim.state == before
    glue.pull_together()
    assert glue.enabled
    run(sim, 3)
    assert abs(box.position[2]) < 1e-6
    glue.enabled = False
    glue.enabled = True  # where it is at its place
    glue.enabled = True  # held already: nothing to refuse
    run(sim, 1)


def test_a_step_that_pulls_too_far_names_the_attachment() -> None:
    """A box that has turned by a quarter radian is more than two iterations away from where it is to be."""
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, angular_velocity=(3.0, 4.0, 0.0))
    corners = box.points([(0.05, 0.0, 0.0), (0.0, 0.05, 0.0), (0.0, 0.0, 0.05)])
    glue = scene.attach(corners, None, enabled=False, name="weld")
    sim = simulate(scene, **{"newton.max_iterations": 2})
    run(sim, 5)
    glue.pull_together()
    report = sim.step()
    assert report.failed
    assert "when the step began, attachment 'weld', pair " in report.message
    assert "bring both sides together before they are held" in report.message


def test_pulled_together_attachments_go_on_from_a_checkpoint_bit_for_bit() -> None:
    def falling() -> tuple[stark.Simulation, stark.Attachment]:
        scene = stark.Scene()
        box = scene.add_box(0.1, mass=1.0)
        glue = scene.attach(box.points((0.02, 0.0, 0.0)), None, enabled=False)
        return simulate(scene), glue

    sim, glue = falling()
    run(sim, 2)
    glue.pull_together()
    state = sim.state
    run(sim, 3)
    other, _ = falling()
    other.state = state
    run(other, 3)
    assert other.state.first_difference(sim.state) == ""


def peeled(threads: int = 1) -> tuple[stark.Scene, stark.Simulation]:
    """A box is drawn away from under a cloth that is pinned at one edge: glue breaks row by row."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=6), LIGHT, pins=range(7))
    box = scene.add_box((0.3, 0.3, 0.02), motion="scripted", position=(0.0, 0.0, -0.012))
    scene.attach(cloth.vertices[7:], box, break_force=0.1)
    box.follow(position=lambda t: (0.0, 0.0, -0.012 - 0.2 * t))
    return scene, simulate(scene, threads=threads, **{"contact.enabled": True, "contact.distance": 1e-3})


def test_rewinding_resuming_and_threads_give_the_same_bits() -> None:
    scene, sim = peeled()
    (glue,) = scene.attachments
    run(sim, 8)
    state, broken = sim.state, glue.broken
    run(sim, 3)
    end = sim.state
    assert 0 < broken.sum() < glue.broken.sum() < len(glue)  # some break in between, some hold
    sim.state = state
    np.testing.assert_array_equal(glue.broken, broken)
    run(sim, 3)
    assert sim.state.first_difference(end) == ""
    other = peeled(threads=2)[1]
    other.state = state
    run(other, 3)
    assert other.state.first_difference(end) == ""


def test_pairs_that_may_break_and_are_there_twice_are_said() -> None:
    """They share their force: an attachment of one place, given twice, broke at twice its break_force."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4))
    other = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4), position=(0, 0, 0.01))
    box = scene.add_box(0.1, mass=1.5 / 9.81, position=(1, 0, 0))
    with pytest.warns(stark.StarkWarning, match="pair 0 is there 2 times, and 1 of 3 pairs repeat others"):
        scene.attach(cloth.vertices[[0, 0, 3]], None, break_force=1.0, enabled=False)
    with pytest.warns(stark.StarkWarning, match="give each pair once"):
        glue = scene.attach(box.points([(0, 0, 0.05), (0, 0, 0.05)]), None, break_force=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.attach(cloth.vertices[[0, 0]], None, enabled=False)  # nothing breaks
        scene.attach(cloth.vertices[[7, 7]], other.vertices[[7, 8]], break_force=1.0)
        scene.attach(cloth.vertices[[1, 2]], other.vertices[0], break_force=1.0)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.3)
    np.testing.assert_allclose(glue.forces[:, 2], 0.75, rtol=1e-3)  # of a weight of 1.5 N
    assert not glue.broken.any()
