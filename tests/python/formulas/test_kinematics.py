"""Kinematics of points and stencils inside formulas: every quantity against NumPy on bodies that are
deformed at the start."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stark

RANDOM = np.random.default_rng(5)
Array = np.ndarray
STEP = 0.01  # [s]


def values_of(energy: Any, selection: Any, scene: stark.Scene) -> Array:
    """The energy of each element at the start, (n,)."""
    scene.add(energy(selection))
    sim = stark.Simulation(scene, contact={"enabled": False})
    return sim.energies[0].energies


def weighted(quantity: Any) -> Any:
    """A number that every entry of a quantity takes part in, for symbols and for arrays of one element."""
    if isinstance(quantity, stark.Scalar):
        return quantity
    entries = quantity.entries if hasattr(quantity, "entries") else np.ravel(quantity)
    return sum((k + 1.0) * entry for k, entry in enumerate(entries))


@pytest.fixture
def cloth() -> tuple[stark.Scene, stark.Cloth]:
    """A sheet that starts stretched, sheared and folded."""
    scene, mesh = stark.Scene(), stark.mesh.grid(0.4, 0.3, (2, 3))
    start = mesh.vertices @ np.array([[1.2, 0.1, 0], [0.3, 0.9, 0], [0, 0, 1]]) + RANDOM.uniform(
        -0.02, 0.02, mesh.vertices.shape
    )
    return scene, scene.add_cloth(mesh, initial_positions=start)


@pytest.fixture
def solid() -> tuple[stark.Scene, stark.Solid]:
    scene, mesh = stark.Scene(), stark.mesh.tet_box(0.3, 2)
    start = 1.1 * mesh.vertices + RANDOM.uniform(-0.02, 0.02, mesh.vertices.shape)
    return scene, scene.add_solid(mesh, initial_positions=start)


def edges(p: Array) -> Array:
    """Edges from the first point as columns."""
    return np.stack([q - p[0] for q in p[1:]], axis=-1)


def triangle_gradient(x: Array, X: Array) -> Array:
    """F with the first material axis along the first edge at rest."""
    first = edges(X)[:, 0] / np.linalg.norm(edges(X)[:, 0])
    normal = np.cross(*edges(X).T)
    second = np.cross(normal / np.linalg.norm(normal), first)
    return edges(x) @ np.linalg.inv(np.stack([first, second]) @ edges(X))


def area(p: Array) -> float:
    return 0.5 * float(np.linalg.norm(np.cross(*edges(p).T)))


def normal(p: Array) -> Array:
    return np.cross(*edges(p).T) / (2.0 * area(p))


def fold(p: Array) -> float:
    """Angle between the normals of (0, 1, 2) and (1, 0, 3), positive about the edge."""
    edge = (p[1] - p[0]) / np.linalg.norm(p[1] - p[0])
    a, b = normal(p[[0, 1, 2]]), normal(p[[1, 0, 3]])
    return float(np.arctan2(np.cross(a, b) @ edge, a @ b))


EDGES: dict[str, Callable[[Array, Array], Any]] = {
    "length": lambda x, X: np.linalg.norm(x[1] - x[0]),
    "rest_length": lambda x, X: np.linalg.norm(X[1] - X[0]),
    "length_prev": lambda x, X: np.linalg.norm(x[1] - x[0]),
    "vector": lambda x, X: x[1] - x[0],
    "direction": lambda x, X: (x[1] - x[0]) / np.linalg.norm(x[1] - x[0]),
}
TRIANGLES: dict[str, Callable[[Array, Array], Any]] = {
    "edges": lambda x, X: edges(x),
    "F": triangle_gradient,
    "F_prev": triangle_gradient,
    "metric": lambda x, X: edges(x).T @ edges(x),
    "metric_prev": lambda x, X: edges(x).T @ edges(x),
    "rest_metric": lambda x, X: edges(X).T @ edges(X),
    "area": lambda x, X: area(x),
    "rest_area": lambda x, X: area(X),
    "normal": lambda x, X: normal(x),
    "area_vector": lambda x, X: area(x) * normal(x),
    "center": lambda x, X: x.mean(axis=0),
}
HINGES: dict[str, Callable[[Array, Array], Any]] = {
    "angle": lambda x, X: fold(x),
    "rest_angle": lambda x, X: fold(X),
    "angle_prev": lambda x, X: fold(x),
    "edge": lambda x, X: x[1] - x[0],
    "rest_edge": lambda x, X: X[1] - X[0],
    "rest_weight": lambda x, X: 3.0 / (area(X[[0, 1, 2]]) + area(X[[1, 0, 3]])),
}
TETRAHEDRA: dict[str, Callable[[Array, Array], Any]] = {
    "edges": lambda x, X: edges(x),
    "rest_edges": lambda x, X: edges(X),
    "F": lambda x, X: edges(x) @ np.linalg.inv(edges(X)),
    "F_prev": lambda x, X: edges(x) @ np.linalg.inv(edges(X)),
    "volume": lambda x, X: np.linalg.det(edges(x)) / 6.0,
    "rest_volume": lambda x, X: np.linalg.det(edges(X)) / 6.0,
    "center": lambda x, X: x.mean(axis=0),
}


def expected(exact: Callable[[Array, Array], Any], body: stark.Body, indices: Array) -> Array:
    """Values of formulas that add the first coordinates of all points, because they must depend on them."""
    x, X = body.positions, body.mesh.vertices
    return np.array([float(weighted(exact(x[i], X[i])) + x[i, 0].sum()) for i in indices])


@pytest.mark.parametrize("name", EDGES)
def test_edges(name: str, cloth: tuple[stark.Scene, stark.Cloth]) -> None:
    @stark.energy
    def quantity(s: stark.Edge):
        return weighted(getattr(s, name)) + sum(p.x[0] for p in s)

    scene, body = cloth
    indices = stark._core.find_edges(body.triangles)
    exact = expected(EDGES[name], body, indices)
    assert values_of(quantity, body.edges, scene) == pytest.approx(exact, rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("name", TRIANGLES)
def test_triangles(name: str, cloth: tuple[stark.Scene, stark.Cloth]) -> None:
    @stark.energy
    def quantity(s: stark.Triangle):
        return weighted(getattr(s, name)) + sum(p.x[0] for p in s)

    scene, body = cloth
    exact = expected(TRIANGLES[name], body, body.triangles)
    assert values_of(quantity, body.faces, scene) == pytest.approx(exact, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("name", HINGES)
def test_hinges(name: str, cloth: tuple[stark.Scene, stark.Cloth]) -> None:
    @stark.energy
    def quantity(s: stark.Hinge):
        return weighted(getattr(s, name)) + sum(p.x[0] for p in s)

    scene, body = cloth
    exact = expected(HINGES[name], body, stark._core.find_hinges(body.triangles))
    assert values_of(quantity, body.hinges, scene) == pytest.approx(exact, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("name", TETRAHEDRA)
def test_tetrahedra(name: str, solid: tuple[stark.Scene, stark.Solid]) -> None:
    @stark.energy
    def quantity(s: stark.Tetrahedron):
        return weighted(getattr(s, name)) + sum(p.x[0] for p in s)

    scene, body = solid
    exact = expected(TETRAHEDRA[name], body, body.mesh.tets)
    assert values_of(quantity, body.tetrahedra, scene) == pytest.approx(exact, rel=1e-11, abs=1e-12)


def test_points_know_their_places_and_their_velocity(cloth: tuple[stark.Scene, stark.Cloth]) -> None:
    @stark.energy
    def quantity(p: stark.Point):
        return weighted(p.X) + 10.0 * weighted(p.x0) + 100.0 * weighted(p.x_prev) + 1e3 * weighted(p.v)

    scene, body = cloth
    start = body.positions.copy()
    scene.add(quantity(body.vertices))
    sim = stark.Simulation(scene, time_step=STEP, gravity=(0, 0, 0), contact={"enabled": False})
    assert not sim.step().failed
    weights = np.array([1.0, 2.0, 3.0])
    exact = (body.mesh.vertices + 110.0 * start + 1e3 * (body.positions - start) / STEP) @ weights
    assert sim.energies[0].energies == pytest.approx(exact, rel=1e-9, abs=1e-8)


def test_every_quantity_of_the_stencils_is_checked_here() -> None:
    for kind, checked in (
        (stark.Edge, EDGES),
        (stark.Triangle, TRIANGLES),
        (stark.Hinge, HINGES),
        (stark.Tetrahedron, TETRAHEDRA),
    ):
        public = {n for n, member in vars(kind).items() if isinstance(member, property)}
        assert public == set(checked)


def test_points_that_a_stencil_has_not_are_named_with_the_line() -> None:
    @stark.energy
    def beyond(t: stark.Triangle):
        return t[3].x @ t[0].x

    body = stark.Scene().add_cloth(stark.mesh.grid(1, 1, 1))
    text = r"beyond: index 3 of <stark\.Triangle t>: it has 3 points, 0 to 2\n.*in beyond\n.*t\[3\]\.x"
    for kind in (stark.TraceError, IndexError):
        with pytest.raises(kind, match=text):
            beyond(body.faces)


def test_stencils_are_sequences_of_their_points() -> None:
    seen: list[Any] = []

    @stark.energy
    def three(s: stark.Stencil[3]):  # type: ignore[valid-type]
        seen.extend([len(s), repr(s), [repr(p) for p in s], repr(s[2])])
        return s[0].x @ s[1].x + s[2].x[0]

    scene = stark.Scene()
    body = scene.add_cloth(stark.mesh.grid(1, 1, 1))
    scene.add(three(stark.stencils(body, [[0, 1, 2]])))
    stark.Simulation(scene)
    assert seen[0] == 3 and seen[2][2] == seen[3] and "s[2]" in seen[3]


def test_stencils_across_bodies_are_at_rest_as_they_start() -> None:
    """Rest positions of two bodies are in the frames of their meshes, and say nothing of each other."""

    @stark.energy
    def spring(e: stark.Edge, stiffness: float = 100.0):
        return 0.5 * stiffness * (e.length - e.rest_length) ** 2

    @stark.energy
    def film(t: stark.Triangle):
        return stark.trace(t.F.T @ t.F) - 2.0 + t.area / t.rest_area

    turned = stark.rotation(axis="z", angle=0.4)
    scene, grid = stark.Scene(), stark.mesh.grid(0.2, 0.2, 2)
    a = scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, 1.0))
    b = scene.add_box(0.1, mass=1.0, position=(0.5, 0.0, 1.0), rotation=turned)
    low = scene.add_cloth(grid, initial_positions=1.25 * grid.vertices)
    high = scene.add_cloth(grid, position=(0.0, 0.0, 0.3))
    corner = a.points((0.05, 0.0, 0.0))
    mixed = stark.joined(corner, low.vertices[0])
    own = {
        "bodies": scene.add(spring((corner, b.points((-0.05, 0.0, 0.0))))),
        "sheets": scene.add(spring((low.vertices, high.vertices))),
        "the world": scene.add(spring((corner, (0.3, 0.2, 0.1)))),
        "some": scene.add(spring((mixed, stark.joined(a.points((-0.05, 0.0, 0.0)), high.vertices[1])))),
        "triangle": scene.add(film((corner, b.points((0.0, 0.0, 0.0)), low.vertices[4]))),
    }
    stretched = scene.add(spring(low.edges))  # of one body: the rest shape is that of its mesh
    parted = scene.add(spring((mixed, stark.joined(a.points((-0.05, 0, 0)), low.vertices[1]))))
    sim = stark.Simulation(scene)
    assert len(sim.energies) == 7
    assert [energy.energy for name, energy in own.items() if name != "triangle"] == [0.0] * 4
    assert abs(own["triangle"].energy - 1.0) < 1e-12
    lengths = np.linalg.norm(
        np.diff([column.rest_positions for column in low.edges.columns], axis=0)[0], axis=1
    )
    assert np.allclose(stretched.energies, 50.0 * (0.25 * lengths) ** 2, rtol=1e-12)
    assert np.allclose(parted.energies, [0.0, 50.0 * 0.025**2], atol=1e-15)  # each element within a body
