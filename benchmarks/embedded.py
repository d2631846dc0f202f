"""Embedded lattices against tetrahedra: a soft cube falls on a floor, error over CPU time.

What is compared is the motion that a user sees: the height of the top, and how far the sides bulge, over
time. The reference has 27-node hexahedra. Lattices are turned against the cube, so that no face follows
them, and carry a surface of 1,200 triangles; tetrahedra have theirs along the faces.

    python -m benchmarks.embedded           a few minutes of CPU time, prints the table of docs/meshes.md
"""

from __future__ import annotations

import sys
import time
from typing import Any, NamedTuple

import numpy as np

import stark

SIZE, DROP, UNTIL, STEP = 0.2, 0.03, 0.25, 1 / 100
MATERIAL = stark.materials.soft_rubber.replace(youngs_modulus=8e3, strain_damping=20.0)
#: Turn of the cube against the lattice [rad].
TURN = stark.rotation(axis=(1.0, 2.0, 3.0), angle=0.6)


class Run(NamedTuple):
    heights: np.ndarray  #: of the top [m], at each step
    widths: np.ndarray  #: from side to side [m]
    cpu: float  #: [s]
    unknowns: int


def upright(mesh: Any) -> Any:
    """A lattice that was made around the turned cube, turned back."""
    return mesh.rotated(TURN.T)


def run(mesh: Any) -> Run:
    start = time.process_time()
    scene = stark.Scene()
    scene.default_friction = 0.3
    scene.add_floor()
    body = scene.add_solid(mesh, MATERIAL, position=(0.0, 0.0, 0.5 * SIZE + DROP))
    sim = stark.Simulation(scene, time_step=STEP, contact_distance=1e-3, threads=1)
    surface = mesh.surface().vertices
    top = surface[:, 2] > 0.49999 * SIZE
    sides = np.abs(surface[:, 0]) > 0.49999 * SIZE
    right = surface[:, 0] > 0.0
    heights, widths = [], []
    for report in sim.run(until=UNTIL):
        assert not report.failed, report.message
        x = body.surface_positions
        heights.append(x[top, 2].mean())
        widths.append(x[sides & right, 0].mean() - x[sides & ~right, 0].mean())
    nodes = mesh.node_count if isinstance(mesh, stark.mesh.EmbeddedMesh) else len(mesh.vertices)
    return Run(np.array(heights), np.array(widths), time.process_time() - start, 3 * nodes)


def error(found: Run, exact: Run) -> float:
    """Root mean square of the differences of heights and widths over the largest squash."""
    squash = SIZE - exact.heights.min()
    both = np.concatenate([found.heights - exact.heights, found.widths - exact.widths])
    return float(np.sqrt((both**2).mean()) / squash)


def main() -> int:
    cube = stark.mesh.tet_box(SIZE, cells=10).surface()
    turned = cube.rotated(TURN)
    fine = stark.mesh.to_quadratic(stark.mesh.box_hexahedra(SIZE, 7))
    exact = run(fine)
    print(f"reference: {exact.unknowns} unknowns, {exact.cpu:.1f} CPU-s, lowest {exact.heights.min():.4f} m")
    print("| body | unknowns | error | CPU s |\n|---|--:|--:|--:|")
    rows: list[tuple[str, Any]] = [
        (f"tetrahedra {n}³", stark.mesh.tet_box(SIZE, cells=n)) for n in (6, 10, 14, 20)
    ]
    for order, sizes in ((1, (3, 4, 6, 8)), (2, (1, 2, 3))):
        for n in sizes:
            mesh = upright(stark.mesh.lattice(turned, cell_size=SIZE / n, order=order))
            rows.append((f"lattice, order {order}, cells of 1/{n}", mesh))
    for name, mesh in rows:
        found = run(mesh)
        print(
            f"| {name} | {found.unknowns} | {100 * error(found, exact):.1f} % | {found.cpu:.1f} |", flush=True
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
