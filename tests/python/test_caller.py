"""Every warning points to the line of the user that it is about, however deep it was found."""

import warnings
from pathlib import Path

import pytest

import stark

ROOT = Path(__file__).parents[2]


def hinged(scene: stark.Scene) -> stark.Joint:
    arm = scene.add_box(0.1, mass=0.5)
    return scene.add_hinge(None, arm, anchor=(0.0, 0.0, 0.0), axis="z")


def late_hinge():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=0.5)
    sim = stark.Simulation(scene)
    scene.add_hinge(None, box, anchor=(0.0, 0.0, 0.0), axis="z")
    assert sim.time == 0.0


def late_slider_of_any_kind():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=0.5)
    sim = stark.Simulation(scene)
    scene.add_joint("slider", None, box, anchor=(0.0, 0.0, 0.0), axis="z")
    assert sim.time == 0.0


def late_actuators():
    scene = stark.Scene()
    joint = hinged(scene)
    sim = stark.Simulation(scene)
    joint.add_motor(1.0, cap=1.0, delta=0.1)
    joint.add_limit(-1.0, 1.0)
    joint.add_actuator("armature", inertia=0.1)
    scene.add_actuator("armature", joint, inertia=0.1)
    assert sim.time == 0.0


def late_spring_and_force():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=0.5)
    sim = stark.Simulation(scene)
    scene.add_spring(None, box, (0, 0, 1), (0, 0, 0), stiffness=1.0)
    scene.add_force(box, (0.0, 0.0, 1.0))
    assert sim.time == 0.0


def late_body_before_run_until():
    scene = stark.Scene()
    scene.add_box(0.1, mass=0.5)
    sim = stark.Simulation(scene)
    scene.add_box(0.1, mass=0.5, position=(1, 0, 0))
    sim.run_until(0.02)


def late_body_before_a_loop():
    scene = stark.Scene()
    scene.add_box(0.1, mass=0.5)
    sim = stark.Simulation(scene)
    scene.add_box(0.1, mass=0.5, position=(1, 0, 0))
    for _ in sim.run(until=0.02):
        pass


def motion_that_starts_elsewhere():
    scene = stark.Scene()
    box = scene.add_box(0.1, motion="scripted")
    box.follow(position=lambda t: (5.0, 0.0, 0.0))
    stark.Simulation(scene).run_until(0.02)


def degrees():
    scene = stark.Scene()
    joint = hinged(scene)
    joint.add_limit(-90, 90)
    stark.rotation(axis="z", angle=90)
    scene.add_hinge(None, scene.add_box(0.1, mass=1), anchor=(0.0, 0.0, 0.0), axis="z", limits=(-90, 90))


def degrees_of_servos():
    servo = hinged(stark.Scene()).add_servo(90, stiffness=1.0, damping=1.0, cap=1.0)
    servo.target = 180


def second_servo():
    joint = hinged(stark.Scene())
    joint.add_servo(0.0, stiffness=1.0, damping=1.0, cap=1.0)
    joint.add_servo(0.0, stiffness=1.0, damping=1.0, cap=1.0)
    joint.add_actuator("position_servo", target=0.0, stiffness=1.0, damping=1.0, cap=1.0)


def second_servo_of_a_robot():
    robot = stark.Scene().add_robot(ROOT / "examples/robot_arm.urdf")
    robot.add_servos("turn", stiffness=1.0, damping=1.0)
    robot.add_servos("turn", stiffness=1.0, damping=1.0)


def flat_solid():
    rubber = stark.SolidMaterial(youngs_modulus=1e5, poissons_ratio=0.49)
    stark.Scene().add_solid(stark.mesh.tet_box(0.1, cells=2), rubber)


def temperature_without_expansion():
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2))
    cloth.temperature = 5.0


def steps_that_nobody_takes():
    scene = stark.Scene()
    scene.add_box(0.1, mass=0.5)
    stark.Simulation(scene).run(until=1.0)


@pytest.mark.parametrize(
    ("program", "count"),
    [
        (late_hinge, 1),
        (late_slider_of_any_kind, 1),
        (late_actuators, 4),
        (late_spring_and_force, 2),
        (late_body_before_run_until, 1),
        (late_body_before_a_loop, 1),
        (motion_that_starts_elsewhere, 1),
        (degrees, 3),
        (degrees_of_servos, 2),
        (second_servo, 2),
        (second_servo_of_a_robot, 1),
        (flat_solid, 1),
        (temperature_without_expansion, 1),
        (steps_that_nobody_takes, 1),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_a_warning_points_to_the_line_of_the_user(program, count):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ResourceWarning)  # of whatever is collected meanwhile
        program()
    lines = range(
        program.__code__.co_firstlineno, max(line for *_, line in program.__code__.co_lines() if line) + 1
    )
    assert len(found) >= count, [str(warning.message) for warning in found]
    for warning in found:
        assert warning.filename == __file__ and warning.lineno in lines, (
            f"{warning.filename}: {warning.message}"
        )


def test_no_depth_of_a_warning_is_written_by_hand():
    files = (ROOT / "python/stark").rglob("*.py")
    assert [
        str(file) for file in files if "stacklevel=" in file.read_text() and file.name != "caller.py"
    ] == []
