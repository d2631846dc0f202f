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


def momentum(rotations: Floats, moments: Floats, angular_velocities: Floats) -> Floats:
    """R J R^T w (n, 3) [kg m^2/s]."""
    turned = np.einsum("nji,nj->ni", rotations, angular_velocities)
    return np.einsum("nij,nj->ni", rotations, moments * turned)


def impulse(start: Floats, end: Floats, moments: Floats, before: Floats, h: float) -> Floats:
    """Change of the angular momenta ``before`` (n, 3) in an implicit Euler step of length h that brought
    the rotations from ``start`` to ``end`` (n, 3) [kg m^2/s]."""
    return torque(free_rotation(start, moments, before, h), end, moments) / h


def torque(free: Floats, end: Floats, moments: Floats) -> Floats:
    """Sum of m_k (R_free e_k) x (R e_k), (n, 3) [kg m^2]."""
    second = 0.5 * moments.sum(axis=1, keepdims=True) - moments
    torques: Floats = (np.cross(free, end, axis=1).transpose(0, 2, 1) * second[:, :, None]).sum(axis=1)
    return torques


def free_rotation(rotations: Floats, moments: Floats, momenta: Floats, h: float) -> Floats:
    """Where free motion brings the rotations in h seconds."""
    smallest = moments.min(axis=1)
    slow = np.linalg.norm(_velocity(rotations, moments, momenta), axis=1)
    fast = np.minimum(np.linalg.norm(momenta, axis=1) / np.maximum(smallest, 1e-300), 1e3 * slow)
    count = int(np.clip(math.ceil(fast.max(initial=0.0) * h / _SUBSTEP), 1, _MOST_SUBSTEPS))
    k = h / count
    for _ in range(count):
        w = _velocity(rotations, moments, momenta)
        for _ in range(_ITERATIONS):
            middle = _turned(0.5 * k * w, rotations)
            change = _velocity(middle, moments, momenta) - w
            w = w + change
            if np.abs(change).max(initial=0.0) <= 1e-15 * np.abs(w).max(initial=0.0):
                break
        rotations = _turned(k * w, rotations)
    return rotations


def _velocity(rotations: Floats, moments: Floats, momenta: Floats) -> Floats:
    turned = np.einsum("nji,nj->ni", rotations, momenta)
    with np.errstate(divide="ignore", invalid="ignore"):
        turned = np.where(moments > 0.0, turned / moments, 0.0)
    return np.einsum("nij,nj->ni", rotations, turned)


def _turned(w: Floats, rotations: Floats) -> Floats:
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
