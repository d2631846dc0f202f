"""Embedded lattices against tetrahedra: a soft cube falls on a floor, error over CPU time.

What is compared is the motion that a user sees: the height of the top, and how far the sides bulge, over
time. Sharp edges roll onto the floor, so that all meshes converge with the first power of the size of their
elements, and none that one can afford is exact: the reference is extrapolated from two meshes of 27-node
hexahedra, and once more from two of tetrahedra, to see how far it can be trusted. Lattices are turned against
the cube, so that no face follows them, and carry a surface of 4,800 triangles; tetrahedra have theirs along
the faces.

    python -m benchmarks.embedded           six minutes of CPU time, prints the table of docs/meshes.md
    python -m benchmarks.embedded --stiff   the cube four times as stiff
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
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


def run(mesh: Any, material: Any = MATERIAL) -> Run:
    start = time.process_time()
    scene = stark.Scene()
    scene.default_friction = 0.3
    scene.add_floor()
    body = scene.add_solid(mesh, material, position=(0.0, 0.0, 0.5 * SIZE + DROP))
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


def extrapolated(coarse: Run, fine: Run, ratio: float) -> Run:
    """What meshes go to whose errors fall with the size of their elements, smaller by this ratio."""
    share = 1.0 / (ratio - 1.0)
    heights = fine.heights + share * (fine.heights - coarse.heights)
    widths = fine.widths + share * (fine.widths - coarse.widths)
    return Run(heights, widths, coarse.cpu + fine.cpu, 0)


def cost_at(error: float, errors: Sequence[float], costs: Sequence[float]) -> float:
    """CPU time of an error [s], on the straight lines through measured ones in logarithms; nan outside."""
    logs = np.log(errors)[::-1], np.log(costs)[::-1]
    return float(np.exp(np.interp(np.log(error), *logs, left=np.nan, right=np.nan)))


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--stiff", action="store_true", help="the cube four times as stiff")
    stiffness = MATERIAL.youngs_modulus * (4.0 if parser.parse_args().stiff else 1.0)
    material = MATERIAL.replace(youngs_modulus=stiffness)

    def tetrahedra(n: int) -> Run:
        return run(stark.mesh.tet_box(SIZE, cells=n), material)

    def hexahedra(n: int) -> Run:
        return run(stark.mesh.to_quadratic(stark.mesh.box_hexahedra(SIZE, n)), material)

    tets = {n: tetrahedra(n) for n in (6, 10, 14, 20, 28)}
    exact = extrapolated(hexahedra(10), hexahedra(14), 1.4)
    other = extrapolated(tets[20], tets[28], 1.4)
    print(f"squash {1e3 * (SIZE - exact.heights.min()):.1f} mm; reference within {error(other, exact):.2%}")
    errors = {n: error(found, exact) for n, found in tets.items()}

    def tell(name: str, found: Run, against: str) -> None:
        wrong = error(found, exact)
        print(f"| {name} | {found.unknowns:,} | {wrong:.1%} | {found.cpu:.2f} | {against} |", flush=True)

    print("| body | unknowns | error | CPU s | tetrahedra at that error |\n|---|--:|--:|--:|--:|")
    for n, found in tets.items():
        tell(f"tetrahedra {n}³", found, "")
    turned = stark.mesh.tet_box(SIZE, cells=20).surface().rotated(TURN)
    for order, kind, sizes in ((1, "trilinear", (3, 4, 6, 8, 10, 12)), (2, "triquadratic", (1, 2, 3))):
        for n in sizes:
            mesh = upright(stark.mesh.lattice(turned, cell_size=SIZE / n, order=order))
            found = run(mesh, material)
            cost = cost_at(error(found, exact), [*errors.values()], [found.cpu for found in tets.values()])
            against = "" if np.isnan(cost) else f"{cost:.2g} s, {cost / found.cpu:.1f} times"
            tell(f"{kind} cells of 1/{n}", found, against)
    return 0


if __name__ == "__main__":
    sys.exit(main())
