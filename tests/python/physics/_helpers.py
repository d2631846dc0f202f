"""Shared by the physical tests: running, momentum, surfaces checked with an independent judge (ipctk)."""

from __future__ import annotations

from typing import Any

import numpy as np

import stark

G = 9.81  # [m/s^2]


def advance(sim: stark.Simulation, until: float) -> list[Any]:
    """Reports of all steps up to the time ``until``; none of them may fail."""
    reports = []
    for report in sim.run(until):
        assert not report.failed, report.message
        reports.append(report)
    return reports


def inclined_floor(scene: stark.Scene, angle: float, *, cells: int = 1, turn: float = 0.0) -> np.ndarray:
    """Adds a fixed square of 3 m, inclined by ``angle`` [deg] about y, its mesh of ``cells`` x ``cells``
    turned in its own plane by ``turn`` [deg]. Returns the columns downhill, across, normal."""
    slope = stark.rotation(axis="y", angle=angle * stark.deg)
    grid = stark.mesh.grid(3.0, 3.0, cells).rotated(stark.rotation(axis="z", angle=turn * stark.deg))
    scene.add_rigid(grid, motion="fixed", name="floor", rotation=slope)
    return slope


def lumped_masses(body: Any, density: float) -> np.ndarray:
    """Masses of the vertices of a solid [kg]: a quarter of each tetrahedron."""
    masses = np.zeros(len(body.mesh.vertices))
    np.add.at(masses, body.mesh.tets, (body.mesh.volumes * density / 4.0)[:, None])
    return masses


def mean_velocity(body: Any, density: float) -> np.ndarray:
    """Velocity of the centre of mass of a solid [m/s]."""
    masses = lumped_masses(body, density)
    return masses @ body.velocities / masses.sum()


def barrier_force_over_energy(distance: float, contact_distance: float) -> float:
    """|b'(d)| / b(d) [1/m] of the barrier b = -k (d - dh)^2 ln(d / dh): the stiffness k drops out."""
    d, dh = distance, contact_distance
    log = np.log(d / dh)
    slope = -2.0 * (d - dh) * log - (d - dh) ** 2 / d
    return abs(slope) / (-((d - dh) ** 2) * log)


class Judge:
    """Looks at all surfaces of a simulation with the eyes of ipctk, which knows nothing of Stark's own
    collision detection."""

    def __init__(self, sim: stark.Simulation) -> None:
        import ipctk

        self._ipctk = ipctk
        self._core = sim._core
        surface = self._core.surface()
        edges, triangles = np.array(surface["edges"]), np.array(surface["triangles"])
        # Only what touches: frames of rods and centres of mass are points of the simulation too.
        self._touching, index = np.unique(np.append(edges.ravel(), triangles.ravel()), return_inverse=True)
        edges, triangles = np.split(index.astype(np.int32), [edges.size])
        self._last = self._positions()
        self._mesh = ipctk.CollisionMesh(self._last, edges.reshape(-1, 2), triangles.reshape(-1, 3))

    def intersects(self) -> bool:
        """Whether an edge is in a triangle now. Rods that cross each other are not seen, see ``crossed``."""
        return bool(self._ipctk.has_intersections(self._mesh, self._positions()))

    def crossed(self) -> bool:
        """Whether anything, rods included, collides on the straight way from where it was at the last call
        (at first: at the start) to where it is. Ask after each step: the straight way of many steps is no
        longer the way that was taken."""
        before, self._last = self._last, self._positions()
        return not self._ipctk.is_step_collision_free(self._mesh, before, self._last)

    def _positions(self) -> np.ndarray:
        return np.array(self._core.surface()["positions"])[self._touching]
