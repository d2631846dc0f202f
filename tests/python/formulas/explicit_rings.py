"""Axisymmetric finite elements with explicit steps, in NumPy and without the engine: a second computation of
Taylor's impact. Quadrilaterals of 4 nodes in (r, z) with a mean volume ratio, lumped masses, central
differences, radial return in principal logarithmic strains."""

from __future__ import annotations

import numpy as np

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
POINTS = CORNERS / np.sqrt(3.0)


def transposed(A: np.ndarray) -> np.ndarray:
    return np.swapaxes(A, -1, -2)


class Rings:
    """Elements q of nodes X (r, z), of a metal whose yield stress is first + slope p."""

    def __init__(
        self, X: np.ndarray, q: np.ndarray, young: float, ratio: float, density: float, first: float, slope: float
    ) -> None:  # fmt: skip
        self.q, self.first, self.slope = q, first, slope
        self.mu, self.bulk = young / (2 * (1 + ratio)), young / (3 * (1 - 2 * ratio))
        self.speed = np.sqrt((self.bulk + 4 / 3 * self.mu) / density)
        N = 0.25 * np.prod(1 + POINTS[:, None] * CORNERS[None], axis=2)  # (point, node)
        dN = 0.25 * CORNERS[None] * (1 + POINTS[:, None] * CORNERS[None])[..., ::-1]
        D = np.einsum("eni,pnj->epij", X[q], dN)
        self.dN = np.einsum("pnj,epji->epni", dN, np.linalg.inv(D))
        radius = np.einsum("pn,en->ep", N, X[q][..., 0])
        self.over_r = N[None] / radius[..., None]
        self.weight = np.linalg.det(D) * radius  # volume of a radian
        self.mass = np.zeros(len(X))
        np.add.at(self.mass, q, density * np.einsum("ep,pn->en", self.weight, N))
        self.G = np.tile(np.eye(3), (*radius.shape, 1, 1))
        self.p = np.zeros(radius.shape)

    def forces(self, x: np.ndarray) -> np.ndarray:
        """Inner forces (n, 2); yields on the way."""
        F = np.zeros((*self.p.shape, 3, 3))
        F[..., :2, :2] = np.einsum("eni,epnj->epij", x[self.q], self.dN)
        F[..., 2, 2] = np.einsum("en,epn->ep", x[self.q][..., 0], self.over_r)
        J = np.linalg.det(F)
        mean = (self.weight * J).sum(1) / self.weight.sum(1)
        isochoric = F * J[..., None, None] ** (-1 / 3)
        squares, axes = np.linalg.eigh(isochoric @ self.G @ transposed(isochoric))
        strain = 0.5 * np.log(squares)
        strain -= strain.mean(-1, keepdims=True)
        size = np.sqrt(2 / 3) * np.linalg.norm(strain, axis=-1)
        slip = 3 * self.mu * size - self.first - self.slope * self.p
        slip = np.maximum(slip, 0.0) / (3 * self.mu + self.slope)
        strain *= (1 - slip / np.maximum(size, 1e-30))[..., None]
        elastic = (axes * np.exp(2 * strain)[..., None, :]) @ transposed(axes)
        back = np.linalg.inv(isochoric)
        flows = slip > 0
        self.G = np.where(flows[..., None, None], back @ elastic @ transposed(back), self.G)
        self.p = self.p + slip
        stress = (axes * (2 * self.mu * strain)[..., None, :]) @ transposed(axes)
        stress = stress + (self.bulk * (np.log(mean) / mean)[:, None] * J)[..., None, None] * np.eye(3)
        P = (stress @ transposed(np.linalg.inv(F))) * self.weight[..., None, None]
        at_nodes = np.einsum("epij,epnj->eni", P[..., :2, :2], self.dN)
        at_nodes[..., 0] += np.einsum("ep,epn->en", P[..., 2, 2], self.over_r)
        result = np.zeros_like(x)
        np.add.at(result, self.q, at_nodes)
        return result

    def longest_step(self, x: np.ndarray) -> float:
        """Half of what waves take through the least height."""
        a = x[self.q]
        across, along = a[:, 2] - a[:, 0], a[:, 3] - a[:, 1]
        area = 0.5 * np.abs(across[:, 0] * along[:, 1] - across[:, 1] * along[:, 0])
        edges = np.linalg.norm(a - np.roll(a, 1, axis=1), axis=2).max(1)
        return float(0.5 * (area / edges).min() / self.speed)


def impact(
    across: int, along: int, radius: float, length: float, speed: float, until: float, **metal: float
) -> tuple[float, float, float]:
    """Length and largest radius [m] of a rod after hitting a rigid wall at z = 0, and its largest plastic
    strain; elements three times as long at the free end as at the wall."""
    r, z = np.linspace(0, 1, across + 1), np.linspace(0, 1, along + 1)
    X = np.stack(np.meshgrid(radius * r, length * z * (0.5 + 0.5 * z), indexing="ij"), -1).reshape(-1, 2)
    n = np.arange(len(X)).reshape(across + 1, along + 1)
    q = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], -1).reshape(-1, 4)
    rings = Rings(X, q, **metal)
    x, v, t = X.copy(), np.zeros_like(X), 0.0
    v[:, 1] = -speed
    foot, axis = n[:, 0], n[0]
    while t < until * (1 - 1e-9):
        h = min(rings.longest_step(x), until - t)
        v -= h * rings.forces(x) / rings.mass[:, None]
        v[axis, 0] = 0.0
        v[foot, 1] = np.maximum(v[foot, 1], -x[foot, 1] / h)  # stops at the wall
        x, t = x + h * v, t + h
    return float(np.ptp(x[:, 1])), float(x[:, 0].max()), float(rings.p.max())
