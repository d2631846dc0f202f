"""water_balloon: a balloon full of water is pressed flat between a table and a plate.

What it shows: a liquid in a closed skin, with the bulk modulus of water, whose pressure every part of the
skin feels at once.
The check: the volume follows the pressure by the bulk modulus; the plate feels the pressure times the area
that it touches, because the skin leaves it along its plane.

    python examples/water_balloon.py    leaves a recording and a picture in out/water_balloon
"""

import sys

import numpy as np
import pictures
import running

import stark

until = 1.6  # [s]
options = {"subdivisions": 3}
RADIUS, LOWER, STROKE, PRESSED = 0.05, 0.3, 0.045, 1.2  # [m], [s] the plate begins, [m], [s] it stands
WATER, RUBBER = 1000.0, 950.0  # [kg/m^3]
THICKNESS, BULK_MODULUS = 8e-4, 2.2e9  # [m], [Pa]
# The skin has the mass of the water, too: a liquid has none of its own.
SKIN = stark.ShellMaterial(
    density=RUBBER * THICKNESS + WATER * RADIUS / 3.0,
    thickness=THICKNESS,
    youngs_modulus=1e6,
    poissons_ratio=0.45,
    bending_stiffness=1e-5,
    mass_damping=6.0,
)


def settings():
    return {"time_step": 0.01, "contact_distance": 5e-4}


def build():
    scene = stark.Scene()
    scene.add_floor(1.0, name="table", friction=0.3, color=(0.55, 0.45, 0.36))
    mesh = stark.mesh.sphere(RADIUS, options["subdivisions"])
    balloon = scene.add_cloth(
        mesh, SKIN, name="balloon", position=(0, 0, RADIUS + 1e-3), friction=0.3, color=(0.25, 0.50, 0.80)
    )
    scene.add_liquid(
        balloon, 1.02 * mesh.volume, bulk_modulus=BULK_MODULUS, name="water"
    )  # blown up a little
    plate = scene.add_box(
        (0.14, 0.14, 0.008), motion="scripted", name="plate", position=(0, 0, 2 * RADIUS + 0.012),
        friction=0.3, color=(0.82, 0.82, 0.80),
    )  # fmt: skip
    plate.follow(
        stark.motion.spline(
            [0.0, LOWER, PRESSED, until], [plate.position - [0, 0, d] for d in (0, 0, STROKE, STROKE)]
        )
    )
    return scene


def measure(sim):
    """Volume of the water over that at no pressure, pressure [Pa]; force and area of the plate [N, m^2]."""
    water = sim.energies["water"]
    return {
        "volume": water.volume / water.filling,
        "pressure": -water.total_slopes["volume"],
        "force": sim["plate"].contact_force[2],
        "area": sim["balloon"].contact_area("plate"),
    }


def check(run):
    running.assert_close(results(run))


def results(run):
    """What came out, what is expected and how far it may be off, by name."""
    t = running.measured(run)
    change = t["volume"] - 1.0 + t["pressure"] / BULK_MODULUS
    push = t["pressure"][-1] * t["area"][-1]
    return {
        "change of volume beside -p/K": (np.abs(change).max(), 0.0, 1e-10),
        "largest change of volume": (np.abs(t["volume"] - 1.0).max(), 0.0, 1e-5),
        "force on the plate [N]": (t["force"][-1], push, 0.05 * push),
    }


def draw(run, path):
    """Before, half way and pressed, side by side."""
    shown = []
    for place, time in enumerate((0.3, 0.85, until)):
        frame = run.frame(run.nearest(time))
        shift = (0.17 * (place - 1), 0.0, 0.0)
        shown += [pictures.part(body, shift=shift) for body in frame.bodies if body.name != "table"]
    return pictures.compose(path, shown, azimuth=-90, elevation=9, height=380)


if __name__ == "__main__":
    sys.exit(running.main(__file__))
