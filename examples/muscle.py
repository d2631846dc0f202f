"""muscle: a soft finger whose upper half is a muscle lifts a load.

What it shows: nearly incompressible flesh without locking, and an active stress that follows the time.
The check: the finger lifts the load by more than 20 mm and keeps its volume within 0.5 %.

    python examples/muscle.py      leaves recording, replay page and picture in out/
"""

import sys

import numpy as np

import stark
import stark.scenes

until = 1.2  # [s]
SIZE, CELLS = np.array([0.12, 0.02, 0.02]), (18, 3, 4)  # [m]
STRESS, RAMP = 5e4, 0.8  # [Pa], reached after [s]

FLESH = stark.SolidMaterial(
    density=1060.0, youngs_modulus=2e5, poissons_ratio=0.495, strain_damping=300.0, mass_damping=2.0
)


def settings():
    return {"time_step": 0.02, "contact_distance": 5e-4}


def build():
    scene = stark.Scene()
    mesh = stark.mesh.box_hexahedra(SIZE, CELLS)
    X, middle = mesh.vertices, mesh.vertices[mesh.elements].mean(axis=1)
    finger = scene.add_solid(
        mesh,
        FLESH,
        formulation="mean_dilatation",
        name="finger",
        pins=X[:, 0] < -0.4999 * SIZE[0],
        color=(0.80, 0.42, 0.38),
    )
    muscle = middle[:, 2] > 0.0
    finger.fiber_direction = (1.0, 0.0, 0.0)
    finger.active_stress = lambda t: np.where(muscle, STRESS * min(1.0, t / RAMP), 0.0)

    # Two threads from the lower side near the tip to a block.
    lower = X[:, 2] < -0.4999 * SIZE[2]
    at = np.unique(X[:, 0].round(9))[-2]
    load = scene.add_box(0.02, mass=0.02, name="load", position=(at, 0, -0.06), color=(0.35, 0.42, 0.5))
    thread = stark.RodMaterial(density=1000.0, youngs_modulus=1e8, radius=4e-4, mass_damping=2.0)
    for vertex in np.flatnonzero(lower & (np.abs(X[:, 0] - at) < 1e-6))[[0, -1]]:
        end = X[vertex] * [1, 1, 0] + [0, 0, -0.05]
        rod = scene.add_rod(stark.mesh.polyline(X[vertex], end, 4), thread, color=(0.9, 0.9, 0.85))
        scene.attach(rod.vertices[[0]], finger.vertices[[vertex]])
        scene.attach(rod.vertices[[-1]], load.points(end - load.position))
    return scene


def measure(sim):
    """Height of the load and of the tip [m], volume of the finger over that at rest."""
    finger, X = sim["finger"], sim["finger"].mesh.vertices
    x = finger.positions
    volume = stark.SolidMesh(x, finger.mesh.elements).volume / np.prod(SIZE)
    tip = x[X[:, 0] > 0.4999 * SIZE[0]].mean(axis=0)
    return {"load": float(sim["load"].position[2]), "tip": float(tip[2]), "volume": float(volume)}


def check(run):
    load, volume = run.telemetry["measured.load"], run.telemetry["measured.volume"]
    lifted = load[-1] - load.min()
    assert lifted > 0.02 and abs(volume[-1] - 1.0) < 0.005, (lifted, volume[-1])


if __name__ == "__main__":
    result = stark.scenes.run(__file__)
    print(f"{result.scene}: {result.status} {result.message}, files in {result.folder}")
    sys.exit(result.exit_code)
