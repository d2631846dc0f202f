"""What of bodies has inertia, in groups: points with masses, and axes with second moments.

Rigid bodies are in groups together, with a row for each: there may be thousands. All others are groups of
their own, with a row for each vertex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .files import need
from .run import Body, State, stacked

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Moving:
    """What a state has of a group: n points, and m axes that turn, of as many rows or of fewer."""

    places: Floats  # (n, 3) [m]
    velocities: Floats | None = None  # (n, 3) [m/s], where they are recorded
    lags: Floats | None = None  # (n, 3) [m/s], with bdf2
    rotations: Floats | None = None  # (m, 3, 3) of the principal axes
    rates: Floats | None = None  # (m, 3) angular velocities [rad/s]
    spins: Floats | None = None  # (m, 3, 3) A, p and Q of angular momenta [kg m^2/s], with bdf2
    reach: Floats | None = None  # (n,) of rigid bodies, of the farthest vertex from the centre of mass [m]

    @property
    def turning(self) -> tuple[Floats | None, Floats | None]:
        """Rotations and angular velocities."""
        return self.rotations, self.rates


@dataclass(frozen=True)
class Group:
    """Points and axes whose sums are taken together."""

    masses: Floats  # (n,) [kg]
    moments: Floats  # (m, 3) of inertia about the principal axes [kg m^2]
    is_held: bool  # whether joints or attachments hold it
    is_rigid: bool = False  # whether each row is a body, which rounds on its own

    def moving(self, state: State) -> Moving:
        raise NotImplementedError

    def largest(self, rows: Floats) -> Floats:
        """Largest absolute value of rows (n, 3): of each body of a group, to be broadcast."""
        if self.is_rigid:
            return np.asarray(np.abs(rows).max(axis=1, keepdims=True))
        return np.full((1, 1), np.abs(rows).max(initial=0.0))


@dataclass(frozen=True)
class _Points(Group):
    """A body of points, or of frames that turn on their own."""

    index: int = 0
    turns: NDArray[np.bool_] | None = None  # (n,): rows of the frames that are free

    @classmethod
    def of(cls, body: Body, index: int, is_held: bool) -> _Points:
        assert body.masses is not None
        masses = body.masses.copy()
        masses[body.pins] = 0.0
        if body.second_moments is None:
            return cls(masses, np.zeros((0, 3)), is_held, False, index)
        turns = np.ones(body.vertex_count, dtype=bool)
        turns[body.clamped] = False
        second = np.pad(body.second_moments, ((0, 0), (0, 1)))[turns]
        return cls(masses, second.sum(axis=1, keepdims=True) - second, is_held, False, index, turns)

    def moving(self, state: State) -> Moving:
        i = self.index
        points = state.positions[i], state.velocities[i], state.lags[i]
        if self.turns is None:
            return Moving(*points)
        frames = state.frames[i], state.angular_velocities[i], state.spins[i]
        return Moving(*points, *(None if rows is None else rows[self.turns] for rows in frames))


@dataclass(frozen=True)
class _Rigid(Group):
    """Rigid bodies: their centres of mass and principal axes."""

    bodies: tuple[int, ...] = ()
    centres: Floats | None = None  # (n, 3) of mass, in the frame of the body [m]
    principal: Floats | None = None  # (n, 3, 3)
    vertex_counts: NDArray[np.int64] | None = None  # (n,)

    @classmethod
    def of(cls, bodies: Sequence[Body], numbers: Sequence[int], is_held: bool) -> _Rigid:
        given = [body.inertia or {} for body in bodies]
        tensors = np.array([entry["tensor"] for entry in given], dtype=np.float64)
        counts = np.array([body.vertex_count for body in bodies])
        need(bool((counts > 0).all()), "a rigid body has no vertices")
        # Integral of x x^T dm, diagonal in its own axes.
        half = 0.5 * np.trace(tensors, axis1=1, axis2=2)
        second, principal = np.linalg.eigh(half[:, None, None] * np.eye(3) - tensors)
        return cls(
            np.array([float(entry["mass"]) for entry in given]),
            second.sum(axis=1, keepdims=True) - second,
            is_held,
            True,
            tuple(numbers),
            np.array([entry["center_of_mass"] for entry in given], dtype=np.float64),
            principal,
            counts,
        )

    def moving(self, state: State) -> Moving:
        n = len(self.bodies)
        poses = self._rows(state.poses).reshape(n, 4, 3)
        assert self.centres is not None and self.principal is not None and self.vertex_counts is not None
        places = poses[:, 0] + np.einsum("nij,nj->ni", poses[:, 1:], self.centres)
        arms = self._rows(state.positions).reshape(-1, 3) - np.repeat(places, self.vertex_counts, axis=0)
        firsts = np.cumsum(self.vertex_counts) - self.vertex_counts
        reach = np.maximum.reduceat(np.linalg.norm(arms, axis=1), firsts)
        rotations = poses[:, 1:] @ self.principal
        rates = self._rows(state.angular_velocities).reshape(n, 3)
        if any(state.lags[i] is None for i in self.bodies):
            return Moving(places, rotations=rotations, rates=rates, reach=reach)
        v, lags = (self._rows(rows).reshape(n, 3) for rows in (state.velocities, state.lags))
        return Moving(places, v, lags, rotations, rates, self._rows(state.spins).reshape(n, 3, 3), reach)

    def _rows(self, rows: Sequence[Floats | None]) -> Floats:
        return stacked(rows, self.bodies)


def groups_of(bodies: Sequence[Body], held: set[int]) -> list[Group]:
    """Of what is free and whose masses are known; ``held``: bodies that joints or attachments hold."""
    groups: list[Group] = []
    dynamic = [(i, body) for i, body in enumerate(bodies) if body.motion == "dynamic"]
    for is_held in (False, True):
        rigid = [(i, body) for i, body in dynamic if body.has_pose and (i in held) == is_held]
        if rigid:
            numbers, rows = zip(*rigid, strict=True)
            groups.append(_Rigid.of(rows, numbers, is_held))
    for i, body in dynamic:
        if not body.has_pose and body.masses is not None:
            groups.append(_Points.of(body, i, i in held))
    return groups
