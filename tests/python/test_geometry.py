"""Geometry against an independent implementation, ipctk: closest features, distances, edges."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from stark import InvalidArgument, InvalidMesh
from stark import _core as core

ipctk = pytest.importorskip("ipctk")


def random_stencils(rng: np.random.Generator, n: int) -> np.ndarray:
    """Half generic, half on a small lattice: coincident, collinear, coplanar and parallel configurations."""
    generic = rng.uniform(-1, 1, (n // 2, 4, 3))
    lattice = rng.integers(-2, 3, (n - n // 2, 4, 3)).astype(float)
    return np.concatenate([generic, lattice])


def compare_distances(
    x: np.ndarray, squared: np.ndarray, types: np.ndarray, distance: Callable, type_of: Callable, generic: int
) -> None:
    expected = np.array([distance(*s) for s in x])
    # ipctk cannot be asked about primitives without extent (0 / 0).
    valid = np.isfinite(expected)
    assert valid.mean() > 0.9
    error = np.abs(squared - expected)[valid]
    # Configurations of size one: a few roundings, amplified by thin triangles and small angles.
    assert np.quantile(error, 0.999) < 1e-13
    assert error.max() < 1e-9
    expected_types = np.array([int(type_of(*s)) for s in x[:generic]])
    # Generic closest features are unique, ties have probability zero.
    assert np.mean(types[:generic] != expected_types) < 1e-4


def test_point_triangle_types_and_distances_equal_ipctk() -> None:
    x = random_stencils(np.random.default_rng(1), 100_000)
    types, squared, weights = core.classify_point_triangle(x.reshape(-1, 12))
    compare_distances(
        x, squared, types, ipctk.point_triangle_distance, ipctk.point_triangle_distance_type, 50_000
    )
    closest = np.einsum("nk,nkj->nj", weights, x[:, 1:])
    assert np.allclose(np.sum((x[:, 0] - closest) ** 2, axis=1), squared, atol=1e-12)
    assert weights.min() >= -1e-15
    assert set(types) == set(range(7))


def test_edge_edge_types_and_distances_equal_ipctk() -> None:
    x = random_stencils(np.random.default_rng(2), 100_000)
    types, squared, weights = core.classify_edge_edge(x.reshape(-1, 12))
    signs = np.array([1.0, 1.0, -1.0, -1.0])
    difference = np.einsum("nk,nkj->nj", weights * signs, x)
    assert np.allclose(np.sum(difference**2, axis=1), squared, atol=1e-12)
    extent = np.minimum(np.linalg.norm(x[:, 1] - x[:, 0], axis=1), np.linalg.norm(x[:, 3] - x[:, 2], axis=1))
    good = extent > 0
    generic = 50_000
    assert good[:generic].all()
    compare_distances(
        x[good], squared[good], types[good], ipctk.edge_edge_distance, ipctk.edge_edge_distance_type, generic
    )
    assert set(types) == set(range(9))


def test_nearly_parallel_edges_equal_ipctk() -> None:
    rng = np.random.default_rng(3)
    x = rng.uniform(-1, 1, (20_000, 4, 3))
    angle = 10.0 ** rng.uniform(-7, -1, (20_000, 1))
    x[:, 3] = (
        x[:, 2]
        + (x[:, 1] - x[:, 0]) * rng.uniform(0.2, 2, (20_000, 1))
        + rng.uniform(-1, 1, (20_000, 3)) * angle
    )
    _, squared, _ = core.classify_edge_edge(x.reshape(-1, 12))
    expected = np.array([ipctk.edge_edge_distance(*s) for s in x])
    # The normal of lines at angle a carries a relative error of 1e-16 / a in ipctk.
    assert np.max(np.abs(squared - expected) * angle[:, 0]) < 1e-14


def test_point_edge_equals_ipctk() -> None:
    x = np.random.default_rng(4).uniform(-1, 1, (50_000, 3, 3))
    types, squared, _ = core.classify_point_edge(x.reshape(-1, 9))
    expected = np.array([ipctk.point_edge_distance(*s) for s in x])
    assert np.abs(squared - expected).max() < 1e-12
    assert np.array_equal(types, [int(ipctk.point_edge_distance_type(*s)) for s in x])


def test_edges_and_hinges_of_a_grid() -> None:
    vertices, triangles = core.make_grid(1.0, 2.0, 4, 3)
    assert vertices.shape == (20, 3)
    edges = core.find_edges(triangles)
    expected = {tuple(sorted((t[i], t[(i + 1) % 3]))) for t in triangles.tolist() for i in range(3)}
    assert [tuple(e) for e in edges.tolist()] == sorted(expected)
    assert np.array_equal(ipctk.edges(triangles).shape, edges.shape)
    assert len(core.find_hinges(triangles)) == len(edges) - len(core.find_boundary_edges(triangles))


def test_bad_input_is_refused() -> None:
    with pytest.raises(InvalidMesh, match="vertex 7"):
        core.compute_solid_mass_properties(np.zeros((3, 3)), [[0, 1, 7]], 1.0)
    with pytest.raises(InvalidArgument, match="radius"):
        core.make_icosphere(-1.0, 2)
    with pytest.raises(InvalidArgument, match="triangles"):
        core.find_edges([[0, 1]])
