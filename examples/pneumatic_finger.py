"""pneumatic_finger: a hollow silicone finger that air curls up.

What it shows: a composite of solid, shell and rods on one mesh. Rings of thread keep the finger from
ballooning, a strip of fabric keeps its upper side from stretching, so pressure can only bend it.
The check: the tip turns by more than 60 degrees; the rings hold the girth and the fabric its area within 1 %.

    python examples/pneumatic_finger.py      leaves recording, replay page and picture in out/
"""

import sys

import numpy as np

import stark
import stark.scenes

until = 0.8  # [s]
SIZE, CELLS = np.array([0.12, 0.02, 0.02]), (20, 4, 4)  # [m]
PRESSURE, RAMP = 50e3, 0.6  # [Pa], reached after [s]

SILICONE = stark.materials.silicone.replace(youngs_modulus=1.5e5, strain_damping=200.0, mass_damping=2.0)
FABRIC = stark.ShellMaterial(density=0.15, youngs_modulus=5e8, thickness=2e-4, bending_stiffness=1e-5)
THREAD = stark.RodMaterial(density=1400.0, youngs_modulus=1e9, radius=3e-4)


def settings():
    return {"time_step": 0.02, "contact_distance": 5e-4}


def hollow_box():
    """A box of hexahedra without those in the middle of its section, but for both ends."""
    box = stark.mesh.box_hexahedra(SIZE, CELLS)
    middle = box.vertices[box.elements].mean(axis=1) / SIZE
    chamber = (np.abs(middle[:, 0]) < 0.5 - 1.5 / CELLS[0]) & (np.abs(middle[:, 1:]) < 0.25).all(axis=1)
    return stark.mesh.compact(stark.SolidMesh(box.vertices, box.elements[~chamber]))


def build():
    scene = stark.Scene()
    finger = scene.add_solid(hollow_box(), SILICONE, name="finger", color=(0.86, 0.80, 0.72))
    X = finger.mesh.vertices / SIZE
    finger.pin(X[:, 0] < -0.499)
    corners = X[finger.triangles]
    above = (corners[:, :, 2] > 0.499).all(axis=1)
    finger.add_skin(FABRIC, finger.triangles[above], name="fabric", color=(0.25, 0.42, 0.70))
    rings = []
    for x in np.unique(X[:, 0].round(6))[1:-1]:  # every section of the chamber
        ring = np.flatnonzero((np.abs(X[:, 0] - x) < 1e-6) & (np.abs(X[:, 1:]).max(axis=1) > 0.499))
        ring = ring[np.argsort(np.arctan2(X[ring, 2], X[ring, 1]))]
        rings.append(np.append(ring, ring[0]))
    finger.add_fibres(THREAD, paths=rings, name="rings")
    scene.add_pressure(finger.faces[(np.abs(corners) < 0.499).all(axis=(1, 2))], 0.0, name="air")
    return scene


def drive(sim):
    sim.energies[0].pressure = PRESSURE * min(1.0, (sim.time + 0.02) / RAMP)


def measure(sim):
    """Turn of the tip [rad], stretch of the rings, area of the fabric over that at rest."""
    x, X = sim["finger"].positions, sim["finger"].mesh.vertices
    tip, before = (x[np.abs(X[:, 0] - at) < 1e-6].mean(axis=0) for at in (SIZE[0] / 2, SIZE[0] * 9 / 20))
    area = stark.TriangleMesh(x, sim.layers[0].triangles).area / (SIZE[0] * SIZE[1])
    turn = float(np.arctan2(tip[2] - before[2], tip[0] - before[0]))
    return {"turn": turn, "area": area, "rings": float(sim.layers[1].stretches.mean())}


def check(run):
    turn, area, rings = (run.telemetry[f"measured.{name}"][-1] for name in ("turn", "area", "rings"))
    assert turn > np.deg2rad(60.0) and abs(area - 1.0) < 0.01 and abs(rings - 1.0) < 0.01, (turn, area, rings)


if __name__ == "__main__":
    result = stark.scenes.run(__file__)
    print(f"{result.scene}: {result.status} {result.message}, files in {result.folder}")
    sys.exit(result.exit_code)
