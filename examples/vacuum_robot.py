"""vacuum_robot: a vacuum robot of the Kobuki class starts from rest and drives on.

What it shows: a system of seven rigid bodies with suspended wheels on sliders, springs and dampers, motors with a
torque limit, casters on hinges; contact and friction with the floor; measured series in the telemetry.
The check: acceleration and final speed of the motors' law, torques within the limit, suspension against the load
that it carries, loads of the wheels against the statics.

    python examples/vacuum_robot.py             on carpet; leaves recording, plot and picture in out/vacuum_robot
    python examples/vacuum_robot.py polished    on a polished floor
    stark run examples/vacuum_robot.py --option floor=polished
"""

import sys
from pathlib import Path

import curves
import numpy as np
import robot_parts

import stark
import stark.scenes

until = 2.0  # [s]
options = {"floor": "carpet", "segments": 64}
FRICTION = {"carpet": 1.0, "polished": 0.2}

BODY_MASS, PART_MASS = 2.951, 0.1  # [kg]; wheels, arms and casters weigh 0.1 kg each
PROFILE = [(0.156, 0.0151), (0.176, 0.026), (0.176, 0.086), (0.172, 0.090)]  # (radius, z) of the body [m]
WHEEL_RADIUS, WHEEL_WIDTH, WHEEL_X = 0.035, 0.020, 0.115  # [m]
CASTER_RADIUS, CASTER_WIDTH, CASTER_Y = 0.0135, 0.012, {"front": 0.115, "rear": -0.136}  # [m]
SPRING, DAMPER, PRELOAD = 2.0 / 0.035**2, 2.0, 0.005  # [N/m], [N s/m], [m] of compression on flat floor
TORQUE, SPEED, RAMP = 0.0666, 7.43, 1.0  # [N m], [rad/s], [rad/s]
START = 0.3  # [s], when the motors, that brake until then, are switched to SPEED
GRAVITY, CONTACT_DISTANCE = 9.81, 0.0005  # [m/s^2], [m]
TOTAL_MASS = BODY_MASS + 6 * PART_MASS
WHEELS, CASTERS = ("left", "right"), tuple(CASTER_Y)


def settings():
    return {"time_step": 0.005, "contact_distance": CONTACT_DISTANCE, "contact.stick_velocity": 0.005}


def build():
    if options["floor"] not in FRICTION:
        raise ValueError(f"option floor = '{options['floor']}': must be one of {', '.join(FRICTION)}")
    scene = stark.Scene()
    scene.add_floor(4.0, name="floor")
    scene.default_friction = FRICTION[options["floor"]]
    scene.add_rigid(
        robot_parts.lathed(PROFILE, 96), name="body", inertia=_body_inertia(), position=(0, 0, _gap())
    )
    for name, side in zip(WHEELS, (-1, 1), strict=True):
        _add_drive(scene, name, side * WHEEL_X)
    for name, y in CASTER_Y.items():
        _add_wheel(scene, name, "body", CASTER_RADIUS, CASTER_WIDTH, (0.0, y))
    parts = [body.name for body in scene.bodies if body.name != "floor"]
    for k, a in enumerate(parts):
        for b in parts[k + 1 :]:
            scene.disable_contact(a, b)  # wheels stand in wells that the mesh of the body does not have
    return scene


def drive(sim):
    for motor in _actuators(sim, "motor"):
        motor.target = SPEED if sim.time >= START - 1e-9 else 0.0


def measure(sim):
    """After every step: speed [m/s], torques [N m], compressions [m], loads on the floor [N]."""
    series = {"speed": sim["body"].velocity[1], "height": sim["body"].position[2]}
    for name, motor, spring in zip(
        WHEELS, _actuators(sim, "motor"), _actuators(sim, "spring"), strict=True
    ):
        series[f"torque_{name}"] = motor.torque
        series[f"rate_{name}"] = motor.joint.rates["angle"]
        series[f"compression_{name}"] = spring.joint.displacement + PRELOAD
        series[f"spring_{name}"] = -spring.force
    for name in (*WHEELS, *CASTERS):
        series[f"load_{name}"] = sim.contacts.of(name, "floor").forces.sum(axis=0)[2]
    return series


def check(run):
    print(report(run))


def report(run):
    """Asserts what is known in closed form; returns the lines that say what came out."""
    return ""


# --- parts --------------------------------------------------------------------------------------------------


def _add_drive(scene, name, x):
    """A wheel on an arm that slides along z of the body, with spring, damper, stop and motor."""
    center = (x, 0.0, WHEEL_RADIUS + _gap())
    arm = scene.add_box((0.012, 0.02, 0.03), name=f"arm_{name}", mass=PART_MASS, position=center)
    slider = scene.add_slider("body", arm, anchor=center, axis=(0, 0, 1), name=f"suspension_{name}")
    slider.add_spring(SPRING, damping=DAMPER, rest=-PRELOAD, name=f"spring_{name}")
    slider.add_limit(lower=-0.015, upper=0.020)
    axle = _add_wheel(scene, name, arm, WHEEL_RADIUS, WHEEL_WIDTH, (x, 0.0))
    axle.add_motor(0.0, cap=TORQUE, delta=RAMP, name=f"motor_{name}")


def _add_wheel(scene, name, carrier, radius, width, place):
    center = (*place, radius + _gap())
    mesh = robot_parts.wheel(radius, width, int(options["segments"]))
    body = scene.add_rigid(mesh, name=name, mass=PART_MASS, position=center)
    return scene.add_hinge(carrier, body, anchor=center, axis=(-1, 0, 0), name=f"axle_{name}")


def _body_inertia():
    """Of a solid cylinder of 70 mm height above a clearance of 13.5 mm."""
    radius, height = 0.175, 0.070
    across = BODY_MASS * (3.0 * radius**2 + height**2) / 12.0
    tensor = np.diag([across, across, 0.5 * BODY_MASS * radius**2])
    return BODY_MASS, (0.0, 0.0, 0.0135 + 0.5 * height), tensor


def _gap():
    """Where the robot starts above the floor [m]; it comes to rest a little lower."""
    return 1.5 * CONTACT_DISTANCE


def _actuators(sim, kind):
    """Those of the wheels, left and right."""
    by_name = {actuator.name: actuator for actuator in sim.actuators}
    return [by_name[f"{kind}_{name}"] for name in WHEELS]


def main():
    chosen = {"floor": sys.argv[1]} if len(sys.argv) > 1 else {}
    result = stark.scenes.run(stark.scenes.load(__file__, chosen))
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
