"""vacuum_robot: a vacuum robot of the Kobuki class starts from rest and drives on.

What it shows: seven rigid bodies, wheels on sliders, springs and dampers, motors with a limit,
casters on hinges; contact and friction with the floor; measured series in the telemetry.
The check: acceleration and final speed of the motors' law, torques within the limit, suspension against the
load that it carries, loads of the wheels against the statics.

    python examples/vacuum_robot.py             both floors; recordings, plots, pictures in out/vacuum_robot*
    python examples/vacuum_robot.py polished    one of them
    stark run examples/vacuum_robot.py --option floor=polished
"""

import sys
from typing import Any

import curves
import numpy as np
import pictures
import robot_parts

import stark
import stark.scenes
from stark.recording import Recording

until = 2.0  # [s]
options: dict[str, Any] = {"floor": "carpet", "segments": 128}
FRICTION = {"carpet": 1.0, "polished": 0.2}

BODY_MASS, PART_MASS = 2.951, 0.1  # [kg]; wheels, arms and casters weigh 0.1 kg each
PROFILE = [(0.156, 0.0151), (0.176, 0.026), (0.176, 0.086), (0.172, 0.090)]  # (radius, z) of the body [m]
WHEEL_RADIUS, WHEEL_WIDTH, WHEEL_X = 0.035, 0.020, 0.115  # [m]
CASTER_RADIUS, CASTER_WIDTH, CASTER_Y = 0.0135, 0.012, {"front": 0.115, "rear": -0.136}  # [m]
SPRING, DAMPER, PRELOAD = 2.0 / 0.035**2, 2.0, 0.005  # [N/m], [N s/m], [m] of compression on flat floor
TORQUE, SPEED, RAMP = 0.0666, 7.43, 1.0  # [N m], [rad/s], [rad/s]
START = 0.3  # [s], when the motors, that brake until then, are switched to SPEED
GRAVITY, CONTACT_DISTANCE, STICK_VELOCITY = 9.81, 0.0005, 0.005  # [m/s^2], [m], [m/s]
TOTAL_MASS = BODY_MASS + 6 * PART_MASS
WHEELS, CASTERS = ("left", "right"), tuple(CASTER_Y)
COM_HEIGHT = 0.0135 + 0.035  # of a cylinder of 70 mm above a clearance of 13.5 mm [m]
# Wheels and casters are cylinders that roll: each adds half of its mass.
ACCELERATION = 2 * TORQUE / WHEEL_RADIUS / (TOTAL_MASS + 4 * 0.5 * PART_MASS)  # [m/s^2]
WEIGHT = TOTAL_MASS * GRAVITY  # [N]
# Angular momentum about the floor for unit speed: what loads the rear caster when the robot speeds up.
SHIFT_ARM = BODY_MASS * COM_HEIGHT + PART_MASS * (4 + 2 * 0.5) * WHEEL_RADIUS + PART_MASS * 3 * CASTER_RADIUS
SHELL, TYRE, METAL = (0.42, 0.55, 0.72), (0.24, 0.24, 0.26), (0.91, 0.62, 0.25)


def settings():
    return {
        "time_step": 0.005,
        "contact_distance": CONTACT_DISTANCE,
        "contact.stick_velocity": STICK_VELOCITY,
    }


def build():
    if options["floor"] not in FRICTION:
        raise stark.InvalidArgument(
            f"option floor = '{options['floor']}': must be one of {', '.join(FRICTION)}"
        )
    scene = stark.Scene()
    # Off centre, so that no wheel crosses the diagonal of its two triangles, which would lift it by microns.
    scene.add_floor(4.0, name="floor", position=(1.0, 0.0, 0.0))
    scene.default_friction = FRICTION[options["floor"]]
    scene.add_rigid(
        robot_parts.lathed(PROFILE, 96),
        name="body",
        inertia=_body_inertia(),
        position=(0, 0, _gap()),
        color=SHELL,
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
    for name, motor, spring in zip(WHEELS, _actuators(sim, "motor"), _actuators(sim, "spring"), strict=True):
        series[f"torque_{name}"] = motor.torque
        series[f"rate_{name}"] = motor.joint.rates["angle"]
        series[f"compression_{name}"] = spring.joint.displacement + PRELOAD
        series[f"spring_{name}"] = -spring.force
    for name in (*WHEELS, *CASTERS):
        series[f"load_{name}"] = sim.contacts.of(name, "floor").forces.sum(axis=0)[2]
    return series


def check(run):
    want = expected()
    for name, value in results(run).items():
        reference, tolerance = want[name]
        assert abs(value - reference) <= tolerance, f"{name} is {value:.6g}, expected {reference:.6g}"


def results(run):
    """What came out, by name, in SI units."""
    series = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    time = series["time"]
    still, pull, end = time < START, (time > START + 0.04) & (time < START + 0.2), time > 1.0
    still &= time > 0.1

    def mean(name, when):
        return float(series[name][when].mean())

    found = {
        "torque": max(np.abs(series[f"torque_{name}"]).max() for name in WHEELS),
        "acceleration": np.polyfit(time[pull], series["speed"][pull], 1)[0],
        "slip": mean("rate_left", pull) * WHEEL_RADIUS - mean("speed", pull),
        "speed": mean("speed", end),
        "compression": mean("compression_left", still),
    }
    carried = mean("load_left", still) - 2 * PART_MASS * GRAVITY  # by the spring: all but wheel and arm
    found["imbalance"] = found["compression"] - carried / SPRING
    loads = [f"load_{name}" for name in (*WHEELS, *CASTERS)]
    for moment, when in (("rest", still), ("pull", pull), ("end", end)):
        found[f"weight_{moment}"] = sum(mean(name, when) for name in loads)
        if moment != "end":
            found |= {f"{name}_{moment}": mean(f"load_{name}", when) for name in CASTERS}
    return found


def expected():
    """What statics and the laws of motor and friction say: value and tolerance by name."""
    pushed = TORQUE / WHEEL_RADIUS - 0.5 * PART_MASS * ACCELERATION  # less what spins up the wheel
    limit = FRICTION[options["floor"]] * (SPRING * PRELOAD + 2 * PART_MASS * GRAVITY)
    bent = STICK_VELOCITY * (1 - np.sqrt(max(0.0, 1 - pushed / limit)))
    casters, shift = statics(), SHIFT_ARM * ACCELERATION / (CASTER_Y["front"] - CASTER_Y["rear"])
    want = {
        "torque": (TORQUE, 1e-9 * TORQUE),
        "acceleration": (ACCELERATION, 0.01 * ACCELERATION),
        # Bristles bend by theory eq. 20 while they pass below a wheel, so it slips by less than that in every
        # time step; corners of the wheels add to it.
        "slip": (0.5 * bent, 0.5 * bent + 2e-4),
        "speed": (SPEED * WHEEL_RADIUS, 0.005 * SPEED * WHEEL_RADIUS),
        # Wheels and casters float on gaps that differ by microns with their loads.
        "compression": (PRELOAD, 0.01 * PRELOAD),
        "imbalance": (0.0, 1e-3 * PRELOAD),
    }
    for moment, tilt, tolerance in (("rest", 0.0, 1e-3), ("pull", shift, 1e-2), ("end", 0.0, 5e-3)):
        want[f"weight_{moment}"] = (WEIGHT, tolerance * WEIGHT)
        want[f"front_{moment}"] = (casters["front"] - tilt, 0.1)
        want[f"rear_{moment}"] = (casters["rear"] + tilt, 0.1)
    return want


def statics():
    """Loads of the casters [N] that balance force and moment about the axles at rest."""
    on_casters = WEIGHT - 2 * (SPRING * PRELOAD + 2 * PART_MASS * GRAVITY)
    moment = PART_MASS * GRAVITY * sum(CASTER_Y.values())
    front = (moment - on_casters * CASTER_Y["rear"]) / (CASTER_Y["front"] - CASTER_Y["rear"])
    return {"front": front, "rear": on_casters - front}


# --- parts --------------------------------------------------------------------------------------------------


def _add_drive(scene, name, x):
    """A wheel on an arm that slides along z of the body, with spring, damper, stop and motor."""
    center = (x, 0.0, WHEEL_RADIUS + _gap())
    inside = (x * (1.0 - 0.020 / WHEEL_X), *center[1:])
    arm = scene.add_box(
        (0.012, 0.024, 0.050), name=f"arm_{name}", mass=PART_MASS, position=inside, color=METAL
    )
    slider = scene.add_slider("body", arm, anchor=center, axis=(0, 0, 1), name=f"suspension_{name}")
    slider.add_spring(SPRING, damping=DAMPER, rest=-PRELOAD, name=f"spring_{name}")
    slider.add_limit(lower=-0.015, upper=0.020)
    axle = _add_wheel(scene, name, arm, WHEEL_RADIUS, WHEEL_WIDTH, (x, 0.0))
    axle.add_motor(0.0, cap=TORQUE, delta=RAMP, name=f"motor_{name}")


def _add_wheel(scene, name, carrier, radius, width, place):
    center = (*place, radius + _gap())
    mesh = robot_parts.wheel(radius, width, int(options["segments"]))
    tyre = stark.surfaces.rubber.replace(thickness=CONTACT_DISTANCE)
    body = scene.add_rigid(mesh, name=name, mass=PART_MASS, position=center, surface=tyre, color=TYRE)
    return scene.add_hinge(carrier, body, anchor=center, axis=(-1, 0, 0), name=f"axle_{name}")


def _body_inertia():
    """Of a solid cylinder."""
    radius, height = 0.175, 0.070
    across = BODY_MASS * (3.0 * radius**2 + height**2) / 12.0
    tensor = np.diag([across, across, 0.5 * BODY_MASS * radius**2])
    return BODY_MASS, (0.0, 0.0, COM_HEIGHT), tensor


def _gap():
    """Where the robot starts above the floor [m]; it comes to rest a little lower."""
    return 2.0 * CONTACT_DISTANCE


def _actuators(sim, kind):
    """Those of the wheels, left and right."""
    by_name = {actuator.name: actuator for actuator in sim.actuators}
    return [by_name[f"{kind}_{name}"] for name in WHEELS]


def plot(run, path):
    """Speed, torque, suspension and loads over time."""
    settled = run.telemetry["time"] > 0.1
    t = {name.removeprefix("measured."): run.telemetry[name][settled] for name in run.telemetry.names}
    panels = {
        "speed [m/s]": {"": t["speed"]},
        "torque [mN m]": {name: 1e3 * t[f"torque_{name}"] for name in WHEELS},
        "suspension [mm]": {name: 1e3 * t[f"compression_{name}"] for name in WHEELS},
        "load [N]": {name: t[f"load_{name}"] for name in ("left", *CASTERS)},
    }
    return curves.write(path, t["time"], panels)


def draw(run, path):
    """The robot at the start, and cut open at the end."""
    whole, cut = run.frame(0).bodies, run.frame(-1).bodies
    shown = [pictures.part(body) for body in whole if body.name != "floor"]
    for body in cut:
        middle = body.positions[body.triangles].mean(axis=1)
        rest = (middle[:, 2] < 0.024) | ((middle[:, 0] < 0.0) & (middle[:, 2] < 0.085))
        shown.append(pictures.part(body, keep=rest if body.name == "body" else None))
    return pictures.compose(path, shown, azimuth=32, elevation=24)


def main():
    for floor in sys.argv[1:] or FRICTION:
        result = stark.scenes.run(stark.scenes.load(__file__, {"floor": floor}))
        print(
            f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s"
        )
        if result.exit_code:
            return result.exit_code
        run = Recording(result.folder)
        print(plot(run, result.folder / "curves.svg"), draw(run, result.folder / "robot.png"), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
