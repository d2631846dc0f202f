"""Steps that fail say why: each cause is provoked by a scene and named with bodies, vertices, a remedy."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

UNTURNED = np.eye(3)
#: One attempt, no halvings: what fails, fails at the step that was asked for.
ONCE = {"time.min_step": 0.006}


def failed(sim: stark.Simulation, cause: str) -> Any:
    """The diagnosis of the next step, which fails for this cause and leaves the state alone."""
    before = sim.state
    report = sim.step()
    assert report.status == "failed", report.message
    diagnosis = report.diagnosis
    assert diagnosis.cause == cause, diagnosis
    assert sim.state == before or before.time == sim.time
    assert diagnosis.finding in report.message
    assert diagnosis.remedy in report.message
    assert report.to_dict()["diagnosis"]["cause"] == cause
    return diagnosis


def test_a_press_that_meets_an_obstacle() -> None:
    scene = stark.Scene()
    scene.add_box((1.0, 1.0, 0.1), motion="fixed", name="table")
    scene.add_box(0.1, mass=0.1, position=(0, 0, 0.105), name="block")
    press = scene.add_box((0.2, 0.2, 0.1), motion="scripted", position=(0, 0, 0.21), name="press")
    sim = stark.Simulation(scene, time_step=0.01, **ONCE)
    press.pose = (0, 0, 0.1), UNTURNED
    diagnosis = failed(sim, "blocked_motion")
    assert diagnosis.pushing == ["rigid body 'press'"]
    assert "rigid body 'press' cannot get where prescribed" in diagnosis.finding
    assert "rigid body 'block'" in diagnosis.bodies
    assert diagnosis.blocking is not None or diagnosis.gaps
    (attempt,) = diagnosis.attempts
    assert attempt["time_step"] == 0.01
    assert attempt["status"] == sim._core.report.solve_status


def test_pins_that_are_pulled_through_a_table() -> None:
    scene = stark.Scene()
    scene.add_box((1.0, 1.0, 0.1), motion="fixed", name="table")
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), position=(0, 0, 0.06), name="sheet", pins=[0, 1, 2])
    sim = stark.Simulation(scene, time_step=0.01, **ONCE)
    sheet.pin_targets = sheet.pin_targets - (0, 0, 0.2)
    diagnosis = failed(sim, "blocked_motion")
    assert diagnosis.pushing == ["cloth 'sheet'"]
    assert set(diagnosis.bodies) == {"cloth 'sheet'", "rigid body 'table'"}


def test_pins_that_turn_an_element_inside_out() -> None:
    scene = stark.Scene()
    material = stark.materials.neo_hookean(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3)
    cube = scene.add_solid(stark.mesh.tet_box(0.1, 1), material, name="cube")
    cube.pin(np.arange(len(cube.mesh.vertices)))
    loose = scene.add_box(0.1, mass=1.0, position=(1, 0, 0), name="box")
    sim = stark.Simulation(scene, time_step=0.01, **ONCE)
    sim["cube"].pin_targets = cube.mesh.vertices * (1, 1, -0.5)
    diagnosis = failed(sim, "overconstrained_pins")
    assert diagnosis.bodies == ["solid 'cube'"]
    assert diagnosis.elements[0]["size"] < 0.0
    assert loose.name not in diagnosis.finding


def test_pins_that_pull_a_cloth_apart() -> None:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), name="sheet")
    x = sheet.positions[:, 0]
    left, right = np.flatnonzero(x < x.min() + 1e-9), np.flatnonzero(x > x.max() - 1e-9)
    sheet.pin(np.r_[left, right])
    sim = stark.Simulation(scene, time_step=0.01, **ONCE, **{"newton.max_iterations": 2})
    targets = sheet.pin_targets.copy()
    targets[len(left) :, 0] += 0.6
    sheet.pin_targets = targets
    diagnosis = failed(sim, "overconstrained_pins")
    assert "3 times the length" in diagnosis.finding
    assert diagnosis.bodies == ["cloth 'sheet'"]


def test_a_start_that_is_inverted() -> None:
    scene = stark.Scene()
    material = stark.materials.neo_hookean(density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3)
    mesh = stark.mesh.tet_box(0.1, 2)
    scene.add_solid(mesh, material, name="cube", initial_positions=mesh.vertices * (1, 1, -1))
    sim = stark.Simulation(scene, time_step=0.01, **ONCE)
    diagnosis = failed(sim, "inverted_element")
    assert "stable_neo_hookean" in diagnosis.remedy
    assert diagnosis.elements[0]["body"] == "solid 'cube'"
    assert diagnosis.elements[0]["size"] == pytest.approx(-1.0)


def test_an_energy_that_is_not_finite_later() -> None:
    @stark.energy
    def wall(p: stark.Point, t: stark.Time):
        return stark.sqrt(0.035 - t) * p.x[0]

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 3), name="sheet")
    scene.add(wall(sheet.vertices[[4]]), name="countdown")
    sim = stark.Simulation(scene, time_step=0.01, **ONCE)
    for _ in range(3):
        assert not sim.step().failed
    diagnosis = failed(sim, "not_finite")
    assert "countdown" in diagnosis.finding
    assert "vertex 4" in diagnosis.finding


@stark.material
def forgetful(
    F: stark.DeformationGradient,
    modulus: float = stark.parameter(unit="Pa", above=0.0),
    left: float = stark.internal(0.0, doc="root of what is left of the stretch"),
) -> Any:
    """What it remembers has no value beyond a strain of 0.3, where its energy still has one."""
    E = 0.5 * (F.T @ F - stark.identity(3))
    return modulus * (stark.squared_norm(E) + 1e-9 * left), {"left": stark.sqrt(0.3 - E[2, 2])}


def test_what_a_material_remembers_stays_finite() -> None:
    """A step that would leave it without a value was accepted, and all after it failed."""
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.tet_box(0.1, 1), forgetful(modulus=1e5, density=1000.0), name="block")
    block.pin(np.arange(len(block.mesh.vertices)))
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0), **ONCE)
    for k in range(1, 6):  # to a strain of 0.28
        block.pin_targets = block.mesh.vertices * (1, 1, 1 + 0.05 * k)
        assert not sim.step().failed
        assert np.isfinite(sim.state.arrays()["internal_variable"]).all()
    block.pin_targets = block.mesh.vertices * (1, 1, 1.3)
    diagnosis = failed(sim, "not_finite")
    assert "solid 'block'" in diagnosis.finding
    assert "internal variable 'left' of law 'forgetful'" in diagnosis.finding
    assert sim.step().message.count("not finite") == 1
    assert np.isfinite(sim.state.arrays()["internal_variable"]).all()


def test_an_energy_that_pulls_a_vertex_into_a_point() -> None:
    @stark.energy
    def attraction(p: stark.Point, centre: stark.Vec3, strength: float):
        return -strength / stark.norm(p.x - centre)

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 3), name="sheet", position=(0, 0, 0.01))
    centre = sheet.positions[4] - (0, 0, 0.01)
    scene.add(attraction(sheet.vertices[[4]], centre=centre, strength=1.0), name="black hole")
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    for _ in range(200):
        report = sim.step()
        if report.failed:
            break
    assert report.diagnosis.cause == "singular_energy", report.message
    assert "energy 'black hole'" in report.message
    assert "cloth 'sheet' (vertex 4)" in report.message
    assert re.search(r"about \S+ m from where", report.message)


@stark.energy
def bouncing(p: stark.Point):
    return stark.abs(p.x[2] + 0.001)


@stark.energy
def stepping(p: stark.Point):
    return stark.where(p.x[2] < -0.001, 0.1, 0.0 * p.x[2])


def test_an_energy_with_a_kink_that_balances() -> None:
    """A ball that falls into a groove with the force of 1 N on both sides and stays there, with its friction
    of 0.3 N: no tolerances and no parts have anything to do with it."""
    scene = stark.Scene()
    ball = scene.add_sphere(0.05, mass=0.01, name="ball")
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 3), name="sheet", position=(1, 0, 0))
    scene.add(bouncing(ball.points((0, 0, 0))), name="groove")
    scene.add(bouncing(sheet.vertices), name="elsewhere")
    sim = stark.Simulation(scene, time_step=0.01, **{"time.min_step": 0.0005})
    for _ in range(100):
        report = sim.step()
        if report.failed:
            break
    assert report.diagnosis.cause == "rough_energy", report.message
    assert "energy '" in report.message and "has a kink where" in report.message
    assert "energy.check()" in report.diagnosis.remedy
    assert "tolerance" not in report.diagnosis.remedy


def test_an_energy_that_jumps() -> None:
    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.3, 0.3, 3), name="sheet")
    scene.add(stepping(sheet.vertices), name="step up")
    sim = stark.Simulation(scene, time_step=0.01, **{"time.min_step": 0.0005})
    for _ in range(10):
        report = sim.step()
        if report.failed:
            break
    assert report.diagnosis.cause == "rough_energy", report.message
    assert "energy 'step up' jumps by 0.1 J where cloth 'sheet' (vertex" in report.message
    assert report.diagnosis.bodies == ["cloth 'sheet'"]


def test_a_step_taken_again_for_a_kink_names_the_energy() -> None:
    """A force of 0.2 N that ends at a height: steps go on beyond it with half their length."""

    @stark.energy
    def ledge(p: stark.Point):
        return stark.where(p.x[2] < -0.003, -0.2 * (p.x[2] + 0.003), 0.0)

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.4, 0.4, 4), stark.materials.cotton, name="sheet")
    scene.add(ledge(sheet.vertices), name="shelf")
    sim = stark.Simulation(scene, time_step=0.01)
    reports = [sim.step() for _ in range(6)]
    retried = [report.message for report in reports if report.status == "retried"]
    assert retried and not any(report.failed for report in reports)
    for message in retried:
        assert "energy 'shelf' has a kink where cloth 'sheet' (vertex" in message
        assert "its force jumps there by 0.2 N" in message and "energy.check()" in message
        assert "over-constrained" not in message


def test_a_step_taken_again_near_a_singular_place_names_the_energy() -> None:
    @stark.energy
    def well(p: stark.Point):
        return stark.log(p.x[2] + 0.001)

    scene = stark.Scene()
    sheet = scene.add_cloth(stark.mesh.grid(0.4, 0.4, 4), stark.materials.cotton, name="sheet")
    scene.add(well(sheet.vertices), name="well")
    report = stark.Simulation(scene).step()
    assert report.status == "retried"
    assert "energy 'well' is singular: its force on cloth 'sheet' (vertex" in report.message
    assert "from where the energy grows without bound or" in report.message


def test_the_tip_of_a_cone_is_named_as_a_kink() -> None:
    """A force of 10 N in all places, which was said to grow without bound."""

    @stark.energy
    def cone(p: stark.Point):
        return 10.0 * stark.norm(p.x)

    scene = stark.Scene()
    ball = scene.add_box(0.02, mass=0.1, position=(0.05, 0, 0), name="ball")
    scene.add(cone(ball.points((0, 0, 0))), name="cone")
    sim = stark.Simulation(scene, gravity=(0, 0, 0))
    while not (report := sim.step()).failed and report.time < 0.2:
        pass
    assert report.diagnosis.cause == "singular_energy"
    assert "energy 'cone' is singular: its force on" in report.message
    assert "like a norm at zero, has a kink" in report.message


def test_smooth_energies_that_act_where_a_step_fails_are_named() -> None:
    @stark.energy
    def spring(p: stark.Point, k: float):
        return 0.25 * k * (stark.squared_norm(p.x - p.X) - 0.01) ** 2

    scene = stark.Scene()
    ball = scene.add_sphere(0.05, mass=0.01, name="ball")
    scene.add(spring(ball.points((0, 0, 0)), k=1e9), name="well")
    sim = stark.Simulation(scene, time_step=0.01, **ONCE, **{"newton.max_iterations": 1})
    diagnosis = failed(sim, "iteration_budget")
    assert "energy 'well' acts there: print(energy.check())" in diagnosis.remedy


def test_a_ball_between_plates_that_close() -> None:
    """Accepted steps satisfy their tolerances and keep the least distance; the rest is named."""
    scene = stark.Scene()
    scene.default_friction = 1.0
    scene.add_sphere(0.05, subdivisions=2, mass=0.3, position=(0.003, 0.002, 0), name="ball")
    for k, name in ((-1, "lower"), (1, "upper")):
        plate = scene.add_box((0.4, 0.4, 0.02), motion="scripted", name=name, position=(0, 0, k * 0.065))
        plate.follow(stark.motion.linear([0, 0.2], [(0, 0, k * 0.065), (0, 0, k * 0.05)]))
    sim = stark.Simulation(scene)
    for _ in range(60):
        report = sim.step()
        if report.failed:
            break
        assert report.min_distance >= 1e-3 * 2e-3 * (1.0 - 1e-9)
        limit = 0.02 if report.at_rounding else 0.01  # [m/s^2]
        assert report.acceleration < limit or "round_off" in report.caveats
    diagnosis = report.diagnosis
    assert diagnosis.cause == "blocked_motion"
    assert {"rigid body 'lower'", "rigid body 'upper'", "rigid body 'ball'"} <= set(diagnosis.bodies)


def far_beam(place: float, iterations: int = 10) -> stark.Simulation:
    scene = stark.Scene()
    cube = scene.add_solid(
        stark.mesh.tet_box(0.1, 3), stark.materials.steel, position=(place, 0, 0), name="beam"
    )
    cube.pin([0, 1, 2, 3])
    return stark.Simulation(
        scene,
        time_step=0.01,
        **ONCE,
        **{
            "newton.acceleration_tolerance": 1e-12,
            "newton.step_tolerance": 0.0,
            "newton.max_iterations": iterations,
        },
    )


def test_tolerances_below_round_off() -> None:
    # Ten iterations get to where forces are rounding, also where no tolerance of motions tells.
    for place in (1e3, 1e4):
        report = far_beam(place).step()
        assert (report.status, report.at_rounding) == ("accepted", True)
        assert report.newton_iterations < 6
    assert "newton.acceleration_tolerance = 0.6 m/s^2 would fit" in report.message
    diagnosis = failed(far_beam(1e4, iterations=2), "tolerance_below_round_off")
    assert diagnosis.acceleration_rounding > 1e-12
    assert "newton.acceleration_tolerance = 1e-12 m/s^2" in diagnosis.finding
    assert diagnosis.remedy == (
        "move the scene to the origin: its coordinates of 10000 m round by 2.22e-12 m"
    )


@pytest.mark.parametrize(("place", "distance"), [(0.05, 1e-15), (1e7, 1e-6)])
def test_contact_distances_below_the_rounding_of_places_are_refused(place: float, distance: float) -> None:
    """They failed in a later step, with advice about tolerances."""
    scene = stark.Scene()
    scene.add_box(0.1, motion="fixed", name="base")
    scene.add_box(0.1, mass=1.0, position=(place, 0, 0.2), name="box")
    message = r"rigid body '.*': contact_distance = .*must be at least .*move the scene to the origin"
    with pytest.raises(stark.InvalidArgument, match=message):
        stark.Simulation(scene, contact_distance=distance)


def test_a_box_that_nothing_holds_is_told_once_what_quasistatic_steps_cannot_do() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    report = stark.Simulation(scene, **ONCE, **{"time.integrator": "quasistatic"}).step()
    assert report.diagnosis.cause == "singular_system"
    assert report.message.count("could not be solved") == 1
    assert "quasistatic" in report.diagnosis.remedy


def test_a_box_that_friction_alone_could_hold_is_told_to_start_with_inertia() -> None:
    """On a floor, in a first quasistatic step. The advice was another solver, whichever there was."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    box = scene.add_box(0.1, mass=1.0, position=(0, 0, 0.0518))
    sim = stark.Simulation(scene, **ONCE, **{"time.integrator": "quasistatic"})
    remedy = failed(sim, "singular_system").remedy
    assert "friction holds nothing in a first step" in remedy and "cholesky" not in remedy
    assert "go on from the state of a simulation with inertia" in remedy
    start = stark.Simulation(scene, time_step=0.01)
    start.run_until(0.5)
    sim.state = start.state
    assert not sim.step().failed and box.contact_force[2] == pytest.approx(9.81, rel=1e-3)


def test_a_cloth_that_nothing_holds_has_no_equilibrium() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), name="sheet")
    sim = stark.Simulation(
        scene, time_step=0.01, **ONCE, **{"time.integrator": "quasistatic", "newton.residual_tolerance": 1e-6}
    )
    diagnosis = failed(sim, "no_equilibrium")
    assert "cloth 'sheet'" in diagnosis.finding
    assert sim._core.report.newton_iterations < 20  # it ends early, not by newton.max_iterations


def test_a_bar_that_yields_all_through_is_not_said_to_be_free() -> None:
    """Three times its yield stress: it is pinned, and the remedy was to pin it."""
    mesh = stark.mesh.box_hexahedra((0.1, 0.02, 0.02), (4, 1, 1))
    metal = stark.j2_plasticity(
        shear_modulus=1e6, bulk_modulus=2e6, yield_stress=1e4, hardening_modulus=0.0, density=1000.0
    )
    scene = stark.Scene()
    x = mesh.vertices[:, 0]
    bar = scene.add_solid(mesh, metal, pins=x < -0.0499, formulation="mean_dilatation", name="bar")
    scene.add_traction(bar.faces[(x > 0.0499)[bar.triangles].all(axis=1)], (3e4, 0.0, 0.0))
    quasistatic = {"time.integrator": "quasistatic"}
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings=quasistatic)
    diagnosis = failed(sim, "no_equilibrium")
    assert "nothing balances the forces on solid 'bar'" in diagnosis.finding
    assert "where it is held, the load is more than it can carry" in diagnosis.remedy


def test_cloths_that_start_in_each_other() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), name="lining", contact_distance=5e-3)
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 5), name="coat", contact_distance=5e-3, position=(0, 0, 1e-6))
    sim = stark.Simulation(scene, time_step=0.01, **ONCE, **{"newton.max_iterations": 1})
    diagnosis = failed(sim, "thickness_overlap")
    assert set(diagnosis.bodies) == {"cloth 'lining'", "cloth 'coat'"}
    assert diagnosis.start_gaps[0]["distance"] == pytest.approx(1e-6, rel=1e-3)
    assert "0.01 m" in diagnosis.remedy


def test_units() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(80.0, 3)  # a cube of 80 mm
    scene.add_solid(mesh, stark.materials.silicone, position=(0, 0, 40.01), name="cube", velocity=(0, 0, -9))
    scene.add_floor(200.0)
    sim = stark.Simulation(scene, time_step=0.01, **ONCE, **{"newton.max_iterations": 1})
    diagnosis = failed(sim, "unit_mistake")
    assert "extent of the mesh = 80 m" in diagnosis.finding
    assert "mesh.scaled" in diagnosis.finding


def test_joints_that_contradict_each_other() -> None:
    scene = stark.Scene()
    hand = scene.add_box(0.1, motion="scripted", name="hand")
    box = scene.add_box(0.1, mass=1.0, position=(0.2, 0, 0), name="box")
    scene.add_joint("fixed", hand, box, anchor=(0.1, 0, 0), name="grip")
    scene.add_joint("fixed", None, box, anchor=(0.3, 0, 0), name="anchor")
    sim = stark.Simulation(scene, time_step=0.01, **ONCE)
    sim["hand"].pose = (-0.5, 0, 0), UNTURNED
    diagnosis = failed(sim, "contradicting_joints")
    assert "is apart by" in diagnosis.finding


def test_joints_of_a_chain_on_one_scripted_body_do_not_contradict_each_other() -> None:
    """It could follow its base, which moves by half of the tolerance in the shortest step: 10 MN on
    1 g force its joints apart."""
    scene = stark.Scene()
    base = scene.add_box(0.02, motion="scripted", velocity=(0.5, 0, 0), name="base")
    near = scene.add_box(0.02, mass=1e-3, position=(0.03, 0, 0), name="near")
    far = scene.add_box(0.02, mass=1e-3, position=(0.06, 0, 0), name="far")
    scene.add_hinge(base, near, anchor=(0.015, 0, 0), axis=(0, 1, 0), contact=False)
    slider = scene.add_slider(near, far, anchor=(0.045, 0, 0), axis=(1, 0.3, 0), contact=True)
    slider.add_motor(target=-100.0, cap=1e7, delta=1.0)
    diagnosis = failed(stark.Simulation(scene, time_step=0.01, contact_distance=1e-4), "overload")
    assert "joint 'hinge' is apart by" in diagnosis.finding
    assert "actuator 'velocity_motor'" in diagnosis.finding


def test_too_few_iterations() -> None:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.3, 0.3, 6), position=(0, 0, 0.05), name="sheet", velocity=(0, 0, -10))
    scene.add_box((1.0, 1.0, 0.05), motion="fixed", name="table")
    sim = stark.Simulation(scene, time_step=0.01, **ONCE, **{"newton.max_iterations": 1})
    diagnosis = failed(sim, "iteration_budget")
    force = diagnosis.forces[0]
    assert force["body"] == "cloth 'sheet'"
    assert len(force["vertices"]) == 1
    assert force["force"] > 0.0
    assert f"vertex {force['vertices'][0]}" in diagnosis.finding
    assert sim._core.report.message.startswith("Newton's method was still on its way"), "and says so once"


def test_a_budget_of_seconds() -> None:
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box(0.2, 6), position=(0, 0, 0.1005), name="cube")
    scene.add_floor()
    sim = stark.Simulation(scene, time_step=0.01, **{"newton.max_seconds": 1e-6})
    report = sim.step()
    assert report.failed
    assert report.solve_status == "time_budget"
    assert report.rejected_steps == 1  # it is not tried again
    assert report.diagnosis.cause == "time_budget"
    assert "newton.max_seconds" in report.message
    with_time = stark.Simulation(scene, time_step=0.01, **{"newton.max_seconds": 600.0})
    without = stark.Simulation(scene, time_step=0.01)
    assert not with_time.step().failed
    without.step()
    assert with_time.state == without.state


def test_steps_that_succeed_have_no_diagnosis() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    report = stark.Simulation(scene).step()
    assert report.diagnosis is None
    assert report.caveats == []
    assert "diagnosis" not in report.to_dict()


def test_a_step_whose_forces_are_rounding_has_converged_and_says_so() -> None:
    scene = stark.Scene()
    cube = scene.add_solid(stark.mesh.tet_box(0.1, 3), position=(0, 0, 0.052), name="cube")
    cube.pin([0])
    sim = stark.Simulation(scene, time_step=0.02, **{"newton.residual_tolerance": 1e-25})
    report = sim.step()
    assert report.status == "accepted"
    assert report.caveats == []
    assert report.solve_status == "converged"
    assert report.at_rounding
    assert report.to_dict()["at_rounding"] is True
    assert 1e-25 < report.residual < 1e-9


def test_the_guide_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (Path(__file__).resolve().parents[2] / "docs/failures.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(code, {})


def test_the_guide_lists_every_cause() -> None:
    text = (Path(__file__).resolve().parents[2] / "docs/failures.md").read_text()
    names = re.findall(r"'(\w+)'", stark._core.Diagnosis.cause.__doc__ or "")
    assert len(names) > 10
    assert [name for name in names if f"`{name}`" not in text] == []


def test_a_control_loop_that_swings_up_fails_by_name_with_the_last_good_state() -> None:
    scene = stark.Scene()
    block = scene.add_box(0.05, mass=0.02, name="block", velocity=(1.0, 0, 0))
    brake = scene.add_force(block, (0, 0, 0))
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    with pytest.raises(stark.StepFailed, match="'block' would move faster than light, at") as caught:
        for _ in sim.run(until=5.0):
            brake.force = -30.0 * block.velocity  # 15 times mass over time step
    diagnosis = caught.value.report.diagnosis
    assert diagnosis.cause == "overload" and diagnosis.bodies == ["rigid body 'block'"]
    assert "control loop" in diagnosis.remedy
    assert np.linalg.norm(block.velocity) < 3e8
