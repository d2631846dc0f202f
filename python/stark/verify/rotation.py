"""Angular momentum of rigid bodies and frames of rods, and how a step changes it: an implicit Euler step
holds a body against its free motion, sum of m_k (R_free e_k) x (R e_k) / h^2, with the torques that change
its momentum; steps of bdf2 likewise (multistep.py).

Many bodies at once: rotations (n, 3, 3) map principal axes to the world, moments (n, 3) are those of inertia.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SUBSTEP = 0.02  # [rad] of a step of the midpoint rule on the group
_MOST_SUBSTEPS = 2048
_ITERATIONS = 30
_QUARTER_TURN = 0.5 * math.pi  # [rad] by which momentum and turn may differ in a step
_HELD = 1e-3  # change of a momentum over the momentum, from which something holds the body


def axis_and_angle(R: Floats) -> tuple[Floats, float]:
    """Of the shortest turn (3, 3)."""
    axes, angles = axes_and_angles(R[None])
    return axes[0], float(angles[0])


def axes_and_angles(R: Floats) -> tuple[Floats, Floats]:
    """Of the shortest turns (n, 3, 3): unit vectors (n, 3) and [rad] (n,)."""
    off = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    w = 0.5 * off
    sine, cosine = np.linalg.norm(w, axis=1), 0.5 * (np.trace(R, axis1=1, axis2=2) - 1.0)
    rests = sine < 1e-14
    axes = np.where(rests[:, None], [0.0, 0.0, 1.0], w / np.where(rests, 1.0, sine)[:, None])
    return axes, np.where(rests, 0.0, np.arctan2(sine, cosine))


def momentum(rotations: Floats, moments: Floats, angular_velocities: Floats) -> Floats:
    """R J R^T w (n, 3) [kg m^2/s]."""
    turned = np.einsum("nji,nj->ni", rotations, angular_velocities)
    momenta: Floats = np.einsum("nij,nj->ni", rotations, moments * turned)
    return momenta


def impulse(start: Floats, end: Floats, moments: Floats, before: Floats, h: float) -> Floats:
    """Change of the angular momenta ``before`` (n, 3) in an implicit Euler step of length h that brought
    the rotations from ``start`` to ``end`` (n, 3) [kg m^2/s]."""
    return torque(free_rotation(start, moments, before, h), end, moments) / h


def torque(free: Floats, end: Floats, moments: Floats) -> Floats:
    """Sum of m_k (R_free e_k) x (R e_k), (n, 3) [kg m^2]."""
    second = 0.5 * moments.sum(axis=1, keepdims=True) - moments
    torques: Floats = (np.cross(free, end, axis=1).transpose(0, 2, 1) * second[:, :, None]).sum(axis=1)
    return torques


def held_turn(
    start: Floats, end: Floats, moments: Floats, momenta: Floats, change: Floats, h: float
) -> Floats:
    """Angular momenta (n, 3) of the turns from ``start`` to ``end``, of bodies that something holds far from
    their free motion: by more than a quarter turn in the step, with less energy than ``momenta`` have. Those
    keep the rate of the turn (theory, section 3); NaN for all others."""
    axes, angles = axes_and_angles(end @ start.transpose(0, 2, 1))
    rates = angles[:, None] / h * axes
    turned = momentum(end, moments, rates)
    velocities = velocity(end, moments, momenta)
    is_far = np.linalg.norm(velocities - rates, axis=1) * h > _QUARTER_TURN
    is_less = (rates * turned).sum(axis=1) < (velocities * momenta).sum(axis=1)
    is_held = np.linalg.norm(change, axis=1) > _HELD * np.linalg.norm(momenta, axis=1)
    return np.where((is_far & is_less & is_held)[:, None], turned, np.nan)


def free_rotation(rotations: Floats, moments: Floats, momenta: Floats, h: float) -> Floats:
    """Where free motion brings the rotations in h seconds, each in as many substeps as it needs."""
    smallest = moments.min(axis=1)
    velocities = velocity(rotations, moments, momenta)
    slow = np.linalg.norm(velocities, axis=1)
    # Energy stays, so that no rate can get above sqrt(2 E / J_min).
    twice = np.maximum(0.0, (velocities * momenta).sum(axis=1))
    fast = np.minimum(np.sqrt(twice / np.maximum(smallest, 1e-300)), 1e3 * slow)
    counts = np.fmin(np.fmax(np.ceil(fast * h / _SUBSTEP), 1.0), _MOST_SUBSTEPS)
    order = np.argsort(-counts)  # those with more of them first
    R, J, L = rotations[order], moments[order], momenta[order]
    counts = counts[order]
    for done in range(int(counts.max(initial=0.0))):
        n = int(np.searchsorted(-counts, -done))  # of those that are not there yet
        k = (h / counts[:n])[:, None]
        R[:n] = turned(k * _middle_velocity(R[:n], J[:n], L[:n], k), R[:n])
    free = np.empty_like(R)
    free[order] = R
    return free


def _middle_velocity(R: Floats, J: Floats, L: Floats, k: Floats) -> Floats:
    """Angular velocities (n, 3) in the middle of substeps of k seconds (n, 1), to rounding."""
    velocities = velocity(R, J, L)
    rows, w, last = np.arange(len(R)), velocities, np.full(len(R), math.inf)
    for _ in range(_ITERATIONS):
        change = velocity(turned(0.5 * k * w, R), J, L) - w
        w = w + change
        velocities[rows] = w
        size = np.abs(change).max(axis=1)
        # From some iteration on it is rounding.
        is_open = ~((size <= 1e-15 * np.abs(w).max(axis=1)) | (size >= last))
        if not is_open.all():
            rows, w, R, J, L, k = (a[is_open] for a in (rows, w, R, J, L, k))
            size = size[is_open]
        if not len(rows):
            break
        last = size
    return velocities


def velocity(rotations: Floats, moments: Floats, momenta: Floats) -> Floats:
    """Angular velocities (n, 3) [rad/s] of angular momenta; 0 about axes without inertia."""
    own = np.einsum("nji,nj->ni", rotations, momenta)
    with np.errstate(divide="ignore", invalid="ignore"):
        own = np.where(moments > 0.0, own / moments, 0.0)
    velocities: Floats = np.einsum("nij,nj->ni", rotations, own)
    return velocities


def turned(w: Floats, rotations: Floats) -> Floats:
    """exp([w]) R by Rodrigues' formula."""
    angle = np.linalg.norm(w, axis=1)[:, None, None]
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle**2 / 6.0, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    K = np.zeros((len(w), 3, 3))
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -w[:, 2], w[:, 1], -w[:, 0]
    K = K - K.transpose(0, 2, 1)
    turned: Floats = rotations + (a * K + b * (K @ K)) @ rotations
    return turned
