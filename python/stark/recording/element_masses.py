"""Masses of the nodes of elements of 4 to 27 nodes, from mesh and density alone (see masses.py).

An element of more than four nodes shares its mass in proportion to the integrals of the squares of its shape
functions (Hinton, Rock, Zienkiewicz 1976, Earthquake Eng. Struct. Dyn. 4, 245-249), a cell of a lattice that
is cut by the surface as its filling lies in it."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh import EmbeddedMesh, TetMesh

Floats = NDArray[np.float64]

#: Least share of a node along an axis of a cell.
_LEAST = 0.01


def solid_masses(mesh: Any, density: Floats) -> Floats:
    """Masses (n,) [kg] of all vertices; density [kg/m^3] of all elements or of each. What a lattice carries
    along has none."""
    if isinstance(mesh, TetMesh):
        elements: Any = mesh.tets
        shares = np.repeat(np.abs(mesh.volumes)[:, None] / 4.0, 4, axis=1)
    else:
        elements = mesh.elements
        shares = _shares(mesh.vertices[elements])
    if isinstance(mesh, EmbeddedMesh):
        cut = mesh.filling[:, 0] < 1.0
        moments = mesh.filling[cut]
        part = moments[:, :1]
        volumes = shares[cut].sum(axis=1) * part[:, 0]
        shares[cut] = volumes[:, None] * _filled(
            moments[:, [1, 3, 9]] / part, moments[:, [2, 6, 18]] / part, elements.shape[1]
        )
    masses = shares * np.broadcast_to(density, len(elements))[:, None]
    sums = np.bincount(np.ravel(elements), weights=masses.ravel(), minlength=len(mesh.vertices))
    return np.asarray(sums, dtype=np.float64)


def _shares(X: Floats) -> Floats:
    """Volumes (m, n) [m^3] of nodes of elements with nodes at X (m, n, 3)."""
    places, weights = _rule(X.shape[1])
    values, slopes = _shapes(X.shape[1], places)
    sizes = np.linalg.det(np.einsum("mna,qnb->mqab", X, slopes)) * weights  # (m, q)
    squares = sizes @ values**2
    return np.asarray(squares * (sizes.sum(axis=1) / squares.sum(axis=1))[:, None])


@functools.cache
def _rule(nodes: int) -> tuple[Floats, Floats]:
    """Places (q, 3) and weights of a quadrature that is exact for squares of the shape functions."""
    points, weights = np.polynomial.legendre.leggauss(3 if nodes in (8, 27) else 4)
    points, weights = 0.5 * (points + 1.0), 0.5 * weights
    u, v, w = (grid.ravel() for grid in np.meshgrid(points, points, points, indexing="ij"))
    product = np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
    if nodes in (8, 27):
        return np.column_stack([u, v, w]), product
    collapsed = np.column_stack([u, v * (1 - u), w * (1 - u) * (1 - v)])
    return collapsed, product * (1 - u) ** 2 * (1 - v)


def _shapes(nodes: int, places: Floats) -> tuple[Floats, Floats]:
    """Shape functions (q, n) and their gradients (q, n, 3)."""
    at, powers = _reference(nodes)
    coefficients = np.linalg.inv(_monomials(at, powers))
    slopes = []
    for axis in range(3):
        lower = powers.copy()
        lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
        slopes.append(powers[:, axis] * _monomials(places, lower) @ coefficients)
    return _monomials(places, powers) @ coefficients, np.stack(slopes, axis=-1)


def _monomials(points: Floats, powers: NDArray[np.int64]) -> Floats:
    return np.asarray((points[:, None, :] ** powers[None]).prod(axis=-1))


_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_EDGES = ((0, 1), (1, 2), (3, 2), (0, 3), (4, 5), (5, 6), (7, 6), (4, 7), (0, 4), (1, 5), (2, 6), (3, 7))
_FACES = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))
_TET_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


@functools.cache
def _reference(nodes: int) -> tuple[Floats, NDArray[np.int64]]:
    """Nodes in the order of VTK (n, 3), in [0, 1], and powers of the monomials (n, 3)."""
    if nodes == 10:
        corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
        every = np.indices((3, 3, 3)).reshape(3, -1).T
        at = np.concatenate([corners, [corners[list(pair)].mean(axis=0) for pair in _TET_EDGES]])
        return at, every[every.sum(axis=1) <= 2]
    corners = np.array(_CORNERS, dtype=np.float64)
    if nodes == 8:
        return corners, np.indices((2, 2, 2)).reshape(3, -1).T
    between = [corners[list(some)].mean(axis=0) for some in (*_EDGES, *_FACES, range(8))]
    return np.concatenate([corners, between]), np.indices((3, 3, 3)).reshape(3, -1).T


def _filled(mean: Floats, mean_square: Floats, nodes: int) -> Floats:
    """Shares (m, n) of nodes of cells whose filling has this mean and mean square (m, 3) of coordinates."""
    at = _reference(nodes)[0]
    shares = np.ones((len(mean), nodes))
    for axis in range(3):
        weights = _along(mean[:, axis], mean_square[:, axis], nodes == 27)  # (m, 2 or 3)
        shares *= weights[:, np.rint(at[:, axis] * (weights.shape[1] - 1)).astype(np.int64)]
    return shares


def _along(mean: Floats, mean_square: Floats, quadratic: bool) -> Floats:
    if not quadratic:
        second = np.clip(mean, _LEAST, 1.0 - _LEAST)
        return np.column_stack([1.0 - second, second])
    variance = mean_square - mean + 0.25  # about the middle
    difference = np.clip(2.0 * mean - 1.0, -1.0 + 3.0 * _LEAST, 1.0 - 3.0 * _LEAST)
    total = np.clip(4.0 * variance, np.abs(difference) + 2.0 * _LEAST, 1.0 - _LEAST)
    return np.column_stack([0.5 * (total - difference), 1.0 - total, 0.5 * (total + difference)])
