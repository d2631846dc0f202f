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
    """Says whether any two surfaces of a simulation intersect, by ipctk."""

    def __init__(self, sim: stark.Simulation) -> None:
        import ipctk

        self._ipctk = ipctk
        self._core = sim._core
        surface = self._core.surface()
        self._mesh = ipctk.CollisionMesh(
            np.array(surface["positions"]), np.array(surface["edges"]), np.array(surface["triangles"])
        )

    def intersects(self) -> bool:
        return bool(self._ipctk.has_intersections(self._mesh, np.array(self._core.surface()["positions"])))
