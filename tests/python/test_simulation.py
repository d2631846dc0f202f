"""Simulations: runs, closed forms of single steps, rewinding, what is refused at the start."""

from __future__ import annotations

import subprocess
import sys
import warnings

import numpy as np
import pytest

import stark
from stark import mesh


def falling(**settings: object) -> tuple[stark.Simulation, stark.RigidBody]:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 10))
    return stark.Simulation(scene, **settings), box


def test_a_run_ends_at_the_time_it_was_given() -> None:
    sim, _ = falling(time_step=1 / 30)
    assert len(list(sim.run(until=0.1))) == 3
    assert sim.time == pytest.approx(0.1, abs=1e-12)
    assert list(sim.run(until=0.1)) == []
    reports = list(sim.run(until=0.15))  # a step and a half
    assert sim.time == pytest.approx(0.15, abs=1e-12)
    assert [report.time_step for report in reports] == pytest.approx([0.025, 0.025])
    assert len(list(sim.run(until=1.0))) == 26  # 25.5 steps
    assert sim.time == pytest.approx(1.0, abs=1e-12)


def test_free_fall_has_the_closed_form_of_implicit_euler() -> None:
    sim, box = falling(time_step=0.01)
    last = sim.run_until(0.5)
    n, h = 50, 0.01
    # x_n = -g h^2 n (n + 1) / 2, to the tolerance of 1e-2 m/s^2 on the acceleration at most; a linear problem
    # has none.
    assert box.position[2] - 10 == pytest.approx(-9.81 * h * h * n * (n + 1) / 2, rel=1e-9)
    assert box.velocity[2] == pytest.approx(-9.81 * n * h, rel=1e-9)
    assert (
        last is not None
        and last.status == "accepted"
        and last.energy["kinetic"] == pytest.approx(0.5 * 4.905**2)
    )


def test_rewinding_gives_the_same_bits() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(mesh.grid(0.2, 0.2, 4), position=(0, 0, 0.011))
    scene.add_floor()
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.05)
    before = sim.state
    first = [sim.step().to_dict()["residual"] for _ in range(3)]
    after, positions = sim.state, cloth.positions
    sim.state = before
    assert sim.time == pytest.approx(0.05)
    assert [sim.step().to_dict()["residual"] for _ in range(3)] == first
    assert sim.state == after and sim.state.hash == after.hash and after != 3
    assert hash(sim.state) == hash(after) and len({sim.state, after}) == 1
    assert np.array_equal(cloth.positions, positions)
    assert before != after and before.first_difference(after)


def test_contact_distances_of_bodies_without_their_own_are_those_of_the_simulation() -> None:
    scene = stark.Scene()
    box, other = (
        scene.add_box(0.05, mass=1.0),
        scene.add_box(0.1, mass=1.0, contact_distance=2e-3, position=(1, 0, 0)),
    )
    assert box.contact_distance is None and other.contact_distance == 2e-3
    sim = stark.Simulation(scene)
    assert box.contact_distance == sim.contact_distance(box) == pytest.approx(0.01 * 0.05 * 3**0.5)
    assert other.contact_distance == 2e-3
    coarse = stark.Simulation(scene, contact_distance=3e-4)
    assert coarse["box"].contact_distance == 3e-4 and sim["box"].contact_distance > 3e-4


def test_automatic_contact_distances_above_half_a_flat_triangle_say_that_they_are_automatic() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.TriangleMesh([(0, 0, 0), (0.1, 0, 0), (0.05, 2e-5, 0)], [(0, 1, 2)]))
    with pytest.warns(
        stark.StarkWarning, match="its automatic contact_distance of 1e-04 m is more than half"
    ):
        stark.Simulation(scene)


def test_a_simulation_does_not_see_later_changes_of_its_scene() -> None:
    sim, _ = falling()
    sim.scene.add_floor()
    assert [body.name for body in sim.bodies] == ["box"]
    sim.step()


def test_initial_intersections_name_both_bodies() -> None:
    scene = stark.Scene()
    scene.add_box(1.0, mass=1.0, position=(0, 0, 0.3))
    scene.add_floor()
    with pytest.raises(
        stark.InitialIntersection, match=r"'box' and 'floor' intersect|'floor' and 'box' intersect"
    ):
        stark.Simulation(scene)
    scene.disable_contact("box", "floor")
    stark.Simulation(scene)


def test_a_body_inside_another_is_an_initial_intersection() -> None:
    scene = stark.Scene()
    scene.add_box(1.0, mass=1.0)
    scene.add_sphere(0.1, mass=1.0, name="pea")
    with pytest.raises(stark.InitialIntersection, match="'pea' is inside 'box'"):
        stark.Simulation(scene)


def test_a_contact_distance_above_half_the_mesh_is_warned_about() -> None:
    scene = stark.Scene()
    scene.add_cloth(mesh.grid(0.4, 0.4, 64))
    with pytest.warns(
        stark.StarkWarning, match=r"'cloth': contact_distance = 0.0025 m is more than half the smallest"
    ):
        stark.Simulation(scene, contact_distance=0.0025)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Simulation(scene, contact_distance=0.00125)


@pytest.mark.alone
def test_ctrl_c_stops_a_long_step_within_a_second(tmp_path: object) -> None:
    script = """
import os, signal, threading, time
import stark

scene = stark.Scene()
cloth = scene.add_cloth(stark.mesh.grid(1, 1, 40), pins=[0])
sim = stark.Simulation(scene, time_step=1/30)
sent = []
def interrupt():
    sent.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)
threading.Timer(0.3, interrupt).start()
try:
    for step in sim.run(until=1e6):
        pass
except KeyboardInterrupt:
    print(time.monotonic() - sent[0] < 1.0, bool((cloth.positions == cloth.positions).all()))
"""
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.stdout.split() == ["True", "True"], run.stderr


def test_a_run_to_a_time_that_has_passed_warns() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    sim = stark.Simulation(scene, time_step=0.01)
    sim.run_until(0.1)
    with pytest.warns(
        stark.StarkWarning, match=r"until = 0\.05 s has passed.*run\(until=sim\.time \+ 0\.05\)"
    ):
        assert list(sim.run(0.05)) == []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert list(sim.run(0.1)) == []  # where it is


def test_steps_that_look_like_milliseconds_warn() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    with pytest.warns(stark.StarkWarning, match=r"time_step = 10 s.*write 0\.01 if 10 ms are meant"):
        stark.Simulation(scene, time_step=10)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stark.Simulation(scene, time_step=1.0)
        stark.Simulation(scene, time_step=10.0, **{"time.integrator": "quasistatic"})


def test_a_state_says_what_it_is_of() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=1))
    scene.add_box(0.1, mass=1.0, position=(0, 0, 1))
    sim = stark.Simulation(scene, time_step=0.125)
    sim.step()
    assert repr(sim.state) == "<stark.State at 0.125 s, after 1 steps>"
