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
options = {"floor": "carpet", "segments": 128}
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
COM_HEIGHT = 0.0135 + 0.035  # of a cylinder of 70 mm above a clearance of 13.5 mm [m]
# Wheels and casters are cylinders that roll: each adds half of its mass.
ACCELERATION = 2 * TORQUE / WHEEL_RADIUS / (TOTAL_MASS + 4 * 0.5 * PART_MASS)  # [m/s^2]
WEIGHT = TOTAL_MASS * GRAVITY  # [N]
# Angular momentum about the floor for unit speed: what loads the rear caster when the robot speeds up.
SHIFT_ARM = BODY_MASS * COM_HEIGHT + PART_MASS * (4 + 2 * 0.5) * WHEEL_RADIUS + PART_MASS * 3 * CASTER_RADIUS


def settings():
    return {"time_step": 0.005, "contact_distance": CONTACT_DISTANCE, "contact.stick_velocity": 0.005}


def build():
    if options["floor"] not in FRICTION:
        raise ValueError(f"option floor = '{options['floor']}': must be one of {', '.join(FRICTION)}")
    scene = stark.Scene()
    # Off centre, so that no wheel crosses the diagonal of its two triangles, which would lift it by microns.
    scene.add_floor(4.0, name="floor", position=(1.0, 0.0, 0.0))
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
    """Against closed forms; every tolerance is several times what is measured (docs/systems.md)."""
    series = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    time = series["time"]
    still, pull, drive_on = time < START - 0.1, (time > START + 0.04) & (time < START + 0.2), time > 1.0

    def mean(name, when):
        return series[name][when & (time > 0.1)].mean()

    def agrees(what, value, expected, tolerance):
        assert abs(value - expected) <= tolerance, f"{what} is {value:.6g}, expected {expected:.6g}"

    assert max(np.abs(series[f"torque_{name}"]).max() for name in WHEELS) <= TORQUE * (1 + 1e-9), "limit"
    agrees("acceleration", np.polyfit(time[pull], series["speed"][pull], 1)[0], ACCELERATION, 0.02)
    agrees("final speed", mean("speed", drive_on), SPEED * WHEEL_RADIUS, 0.02 * SPEED * WHEEL_RADIUS)
    for name in WHEELS:
        carried = mean(f"load_{name}", still) - 2 * PART_MASS * GRAVITY  # but for wheel and arm
        agrees("compression", mean(f"compression_{name}", still), carried / SPRING, 1e-3 * PRELOAD)
    loads = [f"load_{name}" for name in (*WHEELS, *CASTERS)]
    for when, tolerance in ((still, 1e-3), (drive_on, 5e-3)):
        agrees("weight", sum(mean(name, when) for name in loads), WEIGHT, tolerance * WEIGHT)
    rest = statics(sum(mean(f"compression_{name}", still) for name in WHEELS) / 2)
    shift = SHIFT_ARM * ACCELERATION / (CASTER_Y["front"] - CASTER_Y["rear"])
    for name, sign in (("front", -1), ("rear", 1)):
        agrees(f"{name} load at rest", mean(f"load_{name}", still), rest[name], 0.01)
        agrees(f"{name} load, accelerating", mean(f"load_{name}", pull), rest[name] + sign * shift, 0.1)


def statics(compression):
    """Loads of the casters [N] that balance force and moment about the axles at rest."""
    on_casters = WEIGHT - 2 * (SPRING * compression + 2 * PART_MASS * GRAVITY)
    moment = PART_MASS * GRAVITY * sum(CASTER_Y.values())
    front = (moment - on_casters * CASTER_Y["rear"]) / (CASTER_Y["front"] - CASTER_Y["rear"])
    return {"front": front, "rear": on_casters - front}


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
    """Of a solid cylinder."""
    radius, height = 0.175, 0.070
    across = BODY_MASS * (3.0 * radius**2 + height**2) / 12.0
    tensor = np.diag([across, across, 0.5 * BODY_MASS * radius**2])
    return BODY_MASS, (0.0, 0.0, COM_HEIGHT), tensor


def _gap():
    """Where the robot starts above the floor [m]; it comes to rest a little lower."""
    return 1.5 * CONTACT_DISTANCE


def _actuators(sim, kind):
    """Those of the wheels, left and right."""
    by_name = {actuator.name: actuator for actuator in sim.actuators}
    return [by_name[f"{kind}_{name}"] for name in WHEELS]


def plot(run, path):
    """Writes speed, torque, compression and loads over time."""
    t = run.telemetry
    names = {
        "speed [m/s]": {"speed": "speed"},
        "torque [mN m]": {name: f"torque_{name}" for name in WHEELS},
        "suspension [mm]": {name: f"compression_{name}" for name in WHEELS},
        "load [N]": {name: f"load_{name}" for name in ("left", *CASTERS)},
    }
    panels = {
        label: {key: t[f"measured.{name}"] * (1e3 if "[m" in label and "/" not in label else 1.0)}
        for label, group in names.items()
        for key, name in group.items()
    }
    curves.write(path, t["time"], panels)


def main():
    chosen = {"floor": sys.argv[1]} if len(sys.argv) > 1 else {}
    result = stark.scenes.run(stark.scenes.load(__file__, chosen))
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
