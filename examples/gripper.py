"""gripper: the fingers of a Franka hand close on a cylinder and hold it when its support goes away.

What it shows: two fingers on sliders with one drive (a gear couples them as the rack of the real hand does),
a motor with a speed and a limit of force, grip by friction on rigid and on soft objects.
The check: the grip is the limit of the motor, half of it a finger; friction carries the weight of what is
held, and nothing creeps; what is heavier than 2 mu N slides with (weight - 2 mu N) / mass.

    python examples/gripper.py          cylinders of 200 g, of 300 g, more than the grip can hold, and foam;
                                        leaves recordings, plots and a picture in out/gripper*
    python examples/gripper.py heavy    one of them
    stark run examples/gripper.py --option object=soft
"""

import sys

import curves
import numpy as np
import pictures
import robot_parts

import stark
import stark.scenes
from stark.recording import Recording

until = 1.0  # [s]
options = {"object": "rigid"}
MASS = {"rigid": 0.2, "heavy": 0.3}  # [kg]
FOAM = stark.SolidMaterial(density=500.0, youngs_modulus=2e4, poissons_ratio=0.3, strain_damping=20.0)

RADIUS, HEIGHT = 0.030, 0.100  # of the object [m]
HAND, FINGER_MASS, PAD_HEIGHT, OPENING = (
    (0.202, 0.081, 0.037),
    0.1,
    0.018,
    0.0765,
)  # [m], [kg]; between pads [m]
FORCE, SPEED, RAMP = 5.0, 0.05, 0.005  # of both fingers together [N]; of each finger [m/s]
FRICTION, STICK_VELOCITY, CONTACT_DISTANCE = 0.5, 1e-4, 0.00025  # [1], [m/s], [m]
LOWERED, FALL, LOWER_SPEED = 0.5, 0.040, 0.4  # when [s], how far [m] and how fast [m/s] the table goes down
GRAVITY = 9.81  # [m/s^2]
FINGERS = ("left", "right")
TABLE, STEEL, PAD, SOFT = (0.62, 0.64, 0.68), (0.88, 0.89, 0.90), (0.28, 0.30, 0.34), (0.20, 0.62, 0.62)
RIGID = {"rigid": (0.91, 0.62, 0.25), "heavy": (0.80, 0.36, 0.30)}

# Section of the left finger seen from above, (x, y) from the middle of its pad, the pad along x = 0 [m].
OUTLINE = [
    (0.0, -0.0175), (0.0, 0.0175), (-0.008, 0.0175), (-0.014, -0.004),
    (-0.025, -0.0175), (-0.025, -0.0365), (-0.003, -0.0365), (-0.003, -0.021),
]  # fmt: skip
INSIDE = (-0.009, -0.017)


def settings():
    return {
        "time_step": 0.005,
        "contact_distance": CONTACT_DISTANCE,
        "contact.stick_velocity": STICK_VELOCITY,
        "newton.step_tolerance": 1e-5,  # a tenth of the stick velocity
    }


def build():
    scene = stark.Scene()
    scene.default_friction = FRICTION
    table = (0.0, 0.0, -0.5 * HEIGHT - 0.01 - 1.5 * CONTACT_DISTANCE)
    scene.add_box((0.12, 0.12, 0.02), name="table", motion="scripted", position=table, color=TABLE)
    add_hand(scene, FORCE)
    _add_object(scene)
    return scene


def add_hand(scene, force):
    """Hand and fingers, open, at the height 0; ``force`` [N] is the limit of both fingers together."""
    behind = min(y for _, y in OUTLINE) - 0.5 * HAND[1] - 0.001
    hand = scene.add_box(HAND, name="hand", motion="fixed", position=(0.0, behind, 0.0), color=STEEL)
    sliders = []
    for name, side in zip(FINGERS, (-1.0, 1.0), strict=True):
        place = (0.5 * side * OPENING, 0.0, 0.0)
        finger = scene.add_rigid(
            finger_mesh(side), name=f"finger_{name}", mass=FINGER_MASS, position=place, color=PAD
        )
        sliders.append(scene.add_slider(hand, finger, anchor=place, axis=(1, 0, 0), name=f"slider_{name}"))
    sliders[1].add_gear(sliders[0], ratio=-1.0, name="rack")
    sliders[0].add_motor(SPEED, cap=force, delta=RAMP, name="motor")


def finger_mesh(side):
    """The left finger (side -1) or its mirror image."""
    outline, inside = np.array(OUTLINE) * (-side, 1.0), np.array(INSIDE) * (-side, 1.0)
    return robot_parts.prism(outline if side < 0 else outline[::-1], inside, PAD_HEIGHT)


def _add_object(scene):
    kind = options["object"]
    if kind == "soft":
        return scene.add_solid(soft_mesh(), FOAM, name="object", color=SOFT)
    if kind not in MASS:
        raise stark.InvalidArgument(f"option object = '{kind}': must be one of soft, {', '.join(MASS)}")
    facet = stark.rotation(axis="z", angle=np.pi / 64)  # towards the pads
    mesh = stark.mesh.cylinder(RADIUS, HEIGHT, 64).rotated(facet)
    return scene.add_rigid(mesh, name="object", mass=MASS[kind], color=RIGID[kind])


def soft_mesh():
    return robot_parts.solid_cylinder(RADIUS, HEIGHT, cells=8, layers=12)


def drive(sim):
    lowered = LOWER_SPEED * (sim.time + sim.time_step - LOWERED)
    table = sim["table"]
    x, y, _ = table.position
    start = -0.5 * HEIGHT - 0.01 - 1.5 * CONTACT_DISTANCE
    table.position = (x, y, start - min(max(lowered, 0.0), FALL))


def measure(sim):
    """After every step: force [N] and gap [m] of the drive, forces on the object [N], its height [m]."""
    motor = next(actuator for actuator in sim.actuators if actuator.name == "motor")
    series = {"motor": motor.force, "gap": OPENING - 2.0 * motor.joint.displacement}
    for name in FINGERS:
        pairs = sim.contacts.of("object", f"finger_{name}")
        force = pairs.forces.sum(axis=0)
        series[f"grip_{name}"], series[f"friction_{name}"] = abs(force[0]), force[2]
    series["support"] = sim.contacts.of("object", "table").forces.sum(axis=0)[2]
    series["height"] = sim["object"].positions[:, 2].mean()
    return series


def check(run):
    want = expected()
    for name, value in results(run).items():
        reference, tolerance = want[name]
        assert abs(value - reference) <= tolerance, f"{name} is {value:.6g}, expected {reference:.6g}"


def results(run):
    """What came out, by name, in SI units."""
    series = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    time, height = series["time"], series["height"]
    gripped = (time > LOWERED - 0.1) & (time < LOWERED)
    found = {
        "motor": max(series["motor"]),
        "grip": float(0.5 * (series["grip_left"] + series["grip_right"])[gripped].mean()),
    }
    if options["object"] == "heavy":
        held = (time > LOWERED + 0.05) & (time < LOWERED + 0.2)  # nothing touches it but the pads
        found["acceleration"] = -2.0 * np.polyfit(time[held], height[held], 2)[0]
    else:
        held = time > until - 0.2
        found["creep"] = -np.polyfit(time[held], height[held], 1)[0]
    found["balance"] = max(np.abs(series["grip_left"] - series["grip_right"])[held])
    found["friction"] = float((series["friction_left"] + series["friction_right"])[held].mean())
    found["slid"] = height[gripped][-1] - height[-1]
    return found


def expected():
    """What statics and the law of friction say: value and tolerance by name."""
    weight, limit = _mass() * GRAVITY, FRICTION * FORCE
    want = {
        "motor": (FORCE, 1e-9 * FORCE),
        "grip": (0.5 * FORCE, 1e-3 * 0.5 * FORCE),
        "balance": (0.0, 1e-3 * FORCE),  # once the table, which carries some of the difference, is gone
        "friction": (min(weight, limit), 1e-3 * limit),
    }
    if weight > limit:
        acceleration = GRAVITY - limit / _mass()
        return want | {"acceleration": (acceleration, 0.01 * acceleration), "slid": (FALL, 5e-4)}
    if options["object"] == "soft":
        # Foam sags by a millimetre or two where it hangs, and its shear relaxes slowly.
        return want | {"creep": (0.0, 1.65e-5), "slid": (0.0, 3e-3)}
    return want | {"creep": (0.0, 1e-8), "slid": (0.0, 1e-4)}


def _mass():
    """Of the object [kg]."""
    return MASS[options["object"]] if options["object"] in MASS else soft_mesh().volume * FOAM.density


def plot(run, path):
    """Forces of drive and friction, height of the object over time."""
    t = {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
    panels = {
        "drive [N]": {"": t["motor"]},
        "grip [N]": {name: t[f"grip_{name}"] for name in FINGERS},
        "carried by [N]": {"pads": t["friction_left"] + t["friction_right"], "table": t["support"]},
        "height [mm]": {"": 1e3 * t["height"]},
    }
    return curves.write(path, t["time"], panels)


def draw(runs, path):
    """The ends of several runs side by side."""
    shown = []
    for k, run in enumerate(runs):
        shift = (-0.25 * k, 0.0, 0.0)
        shown += [pictures.part(body, shift=shift) for body in run.frame(-1).bodies]
    return pictures.compose(path, shown, azimuth=90, elevation=26)


def main():
    runs = []
    for kind in sys.argv[1:] or ("rigid", "soft", "heavy"):
        result = stark.scenes.run(stark.scenes.load(__file__, {"object": kind}))
        print(
            f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s"
        )
        if result.exit_code:
            return result.exit_code
        runs.append(Recording(result.folder))
        print(plot(runs[-1], runs[-1].folder / "curves.svg"))
    print(draw(runs, runs[-1].folder / "gripper.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
