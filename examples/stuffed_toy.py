"""stuffed_toy: a stuffed animal falls into a hammock of cotton. It is a surface of 5,120 triangles in a
lattice of some hundred cells: the lattice is elastic, the surface touches.

python examples/stuffed_toy.py             simulates 0.8 s, checks itself, prints what it costs
python examples/stuffed_toy.py stuffed_toy.png and saves a picture
"""

from __future__ import annotations

import sys
import time

import numpy as np

import stark

LENGTH, WIDTH, CELLS = 0.9, 0.5, (36, 20)  # of the cloth


def animal() -> stark.TriangleMesh:
    """A body with four legs, a head and a tail, 0.3 m long: a sphere pushed outwards along them."""
    ball = stark.mesh.sphere(1.0, 4)
    radius = np.full(len(ball.vertices), 0.75)
    limbs = {
        (1.0, 0.0, 0.35): 0.75,
        (-1.0, 0.0, 0.5): 0.35,
        **{(x, y, -0.9): 0.6 for x in (-0.75, 0.75) for y in (-0.6, 0.6)},
        (0.8, 0.35, 0.9): 0.35,
        (0.8, -0.35, 0.9): 0.35,
    }
    for direction, reach in limbs.items():
        unit = np.array(direction) / np.linalg.norm(direction)
        radius += reach * np.exp(14.0 * (ball.vertices @ unit - 1.0))
    return stark.TriangleMesh(0.1 * ball.vertices * radius[:, None] * (1.25, 0.85, 0.85), ball.triangles)


def main() -> None:
    report = stark.mesh.MeshReport()
    mesh = stark.mesh.lattice(animal(), cells=10, report=report)
    print(report)
    scene = stark.Scene("stuffed_toy")
    scene.default_friction = 0.4
    sheet = stark.mesh.grid(LENGTH, WIDTH, cells=CELLS)
    # It hangs through before it is loaded: the ends are closer together than it is long.
    x, y, _ = sheet.vertices.T
    sag = np.column_stack([0.93 * x, y, 0.9 * (x**2 - 0.25 * LENGTH**2)])
    ends = np.flatnonzero(np.abs(x) > 0.499 * LENGTH)
    scene.add_cloth(sheet, stark.materials.cotton, initial_positions=sag, pins=ends, color=(0.75, 0.3, 0.25))
    stuffing = stark.materials.foam.replace(youngs_modulus=2e4, density=120.0, strain_damping=50.0)
    toy = scene.add_solid(mesh, stuffing, position=(0.0, 0.0, 0.12), color=(0.85, 0.68, 0.4))
    sim = stark.Simulation(scene, time_step=1 / 100)
    start = time.process_time()
    for step in sim.run(until=0.8):
        assert not step.failed, step.message
    cost = time.process_time() - start
    print(f"{len(mesh.triangles)} triangles in {len(mesh.elements)} cells: {cost:.1f} CPU-s")
    low = toy.surface_positions[:, 2].min()
    mass = stuffing.density * mesh.volume
    print(f"the toy of {mass:.3f} kg hangs {-low:.3f} m below the ends")
    assert -0.6 < low < -0.1 and np.linalg.norm(toy.surface_positions.mean(axis=0)[:2]) < 0.1
    weight = 9.81 * mass
    assert 0.2 * weight < toy.contact_force[2] < 5.0 * weight
    if len(sys.argv) > 1:
        sim.picture(sys.argv[1], camera=(0.75, -1.0, 0.35), grid=False)
    print("check: passed")


if __name__ == "__main__":
    main()
