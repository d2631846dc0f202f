"""gripper: the fingers of a Franka hand close on a cylinder and hold it when its support goes away.

What it shows: two fingers on sliders with one drive (a gear couples them as the rack of the real hand does), a motor
with a speed and a limit of force, grip by friction; a rigid object and a soft one in the same scene.
The check: the grip is the limit of the motor, half of it a finger; friction carries the weight of what is held, creep
is that of the friction law; what is heavier than 2 mu N slides with (weight - 2 mu N) / mass.

    python examples/gripper.py          a rigid cylinder of 200 g; leaves recording, plot and picture in out/gripper
    python examples/gripper.py soft     a cylinder of soft foam
    python examples/gripper.py heavy    a rigid cylinder of 300 g, more than the grip can hold
    stark run examples/gripper.py --option object=soft
"""

import sys

import curves
import numpy as np
import robot_parts

import stark
import stark.scenes

until = 1.0  # [s]
options = {"object": "rigid"}
MASS = {"rigid": 0.2, "heavy": 0.3}  # [kg]
FOAM = stark.SolidMaterial(density=500.0, youngs_modulus=4e4, poissons_ratio=0.3, strain_damping=20.0)

RADIUS, HEIGHT = 0.030, 0.100  # of the object [m]
HAND, FINGER_MASS, PAD_HEIGHT, OPENING = (0.202, 0.081, 0.037), 0.1, 0.018, 0.0765  # [m], [kg]; between pads [m]
FORCE, SPEED, RAMP = 5.0, 0.05, 0.005  # of both fingers together [N]; of each finger [m/s]
FRICTION, STICK_VELOCITY, CONTACT_DISTANCE = 0.5, 1e-4, 0.00025  # [1], [m/s], [m]
LOWERED, FALL, LOWER_SPEED = 0.5, 0.040, 0.4  # when [s], how far [m] and how fast [m/s] the table goes down
GRAVITY = 9.81  # [m/s^2]
FINGERS = ("left", "right")

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
    scene.add_box((0.12, 0.12, 0.02), name="table", motion="scripted", position=table)
    behind = min(y for _, y in OUTLINE) - 0.5 * HAND[1] - 0.001
    hand = scene.add_box(HAND, name="hand", motion="fixed", position=(0.0, behind, 0.0))
    sliders = []
    for name, side in zip(FINGERS, (-1.0, 1.0), strict=True):
        place = (0.5 * side * OPENING, 0.0, 0.0)
        finger = scene.add_rigid(
            finger_mesh(side), name=f"finger_{name}", mass=FINGER_MASS, position=place
        )
        sliders.append(scene.add_slider(hand, finger, anchor=place, axis=(1, 0, 0), name=f"slider_{name}"))
    sliders[1].add_gear(sliders[0], ratio=-1.0, name="rack")
    sliders[0].add_motor(SPEED, cap=FORCE, delta=RAMP, name="motor")
    _add_object(scene)
    return scene


def finger_mesh(side):
    """The left finger (side -1) or its mirror image."""
    outline, inside = np.array(OUTLINE) * (-side, 1.0), np.array(INSIDE) * (-side, 1.0)
    return robot_parts.prism(outline if side < 0 else outline[::-1], inside, PAD_HEIGHT)


def _add_object(scene):
    kind = options["object"]
    if kind == "soft":
        mesh = robot_parts.solid_cylinder(RADIUS, HEIGHT, cells=8, layers=12)
        return scene.add_solid(mesh, FOAM, name="object")
    if kind not in MASS:
        raise ValueError(f"option object = '{kind}': must be one of soft, {', '.join(MASS)}")
    facet = stark.rotation(axis="z", angle=np.pi / 64)  # towards the pads
    mesh = stark.mesh.cylinder(RADIUS, HEIGHT, 64).rotated(facet)
    return scene.add_rigid(mesh, name="object", mass=MASS[kind])


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
        series[f"grip_{name}"] = abs(pairs.normal_forces.sum(axis=0)[0])
        series[f"friction_{name}"] = pairs.frictions.sum(axis=0)[2]
    series["support"] = sim.contacts.of("object", "table").forces.sum(axis=0)[2]
    series["height"] = sim["object"].positions[:, 2].mean()
    return series


def main():
    chosen = {"object": sys.argv[1]} if len(sys.argv) > 1 else {}
    result = stark.scenes.run(stark.scenes.load(__file__, chosen))
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
