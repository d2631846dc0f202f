"""Points of several bodies as one selection: order, indexing, energies on them, files."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import stark

STILL = (0.0, 0.0, 0.0)


@stark.energy
def springs(p: stark.Point, q: stark.Point, stiffness: float = 80.0, length: float = 0.1):
    return 0.5 * stiffness * (stark.norm(p.x - q.x) - length) ** 2


@stark.energy
def tendon(p: stark.Point, q: stark.Point, rest: float = 1.0, stiffness: float = 500.0):
    slack = stark.total(stark.norm(p.x - q.x), "length") - rest
    return 0.5 * stiffness * stark.maximum(slack, 0.0) ** 2


def parts(scene: stark.Scene) -> list[Any]:
    return [
        scene.add_box(0.04, mass=0.1, position=(0, 0, 0)),
        scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=1), position=(0.2, 0, 0)),
        scene.add_rod(stark.mesh.polyline((0.4, 0, 0), (0.5, 0, 0), segments=2)),
    ]


def corners(body: Any) -> Any:
    return body.points((0, 0, 0.02)) if isinstance(body, stark.RigidBody) else body.vertices[:2]


def test_points_keep_their_order_and_are_indexed_like_arrays() -> None:
    scene = stark.Scene()
    box, cloth, rod = parts(scene)
    all_of_them = stark.joined(box.points((0, 0, 0.02)), cloth.vertices, rod.vertices)
    expected = np.concatenate(
        [box.points((0, 0, 0.02)).positions, cloth.vertices.positions, rod.vertices.positions]
    )
    assert len(all_of_them) == len(expected) == 8
    np.testing.assert_array_equal(all_of_them.positions, expected)
    assert all_of_them.bodies == [box, cloth, rod]
    for key in (3, slice(None, None, -1), [5, 0, 0, 7, 2], np.arange(8) % 2 == 0, slice(6, 2)):
        np.testing.assert_array_equal(
            all_of_them[key].positions,
            np.atleast_2d(expected[key]) if not isinstance(key, slice) else expected[key],
        )
    assert repr(all_of_them) == "<8 points of 'box' and 'cloth' and 'rod'>"
    with pytest.raises(stark.InvalidArgument, match="out of bounds"):
        all_of_them[8]
    again = stark.joined([all_of_them[:2], cloth.vertices])
    assert len(again) == 6
    np.testing.assert_array_equal(again.rest_positions[2:], cloth.vertices.rest_positions)


def test_one_energy_on_many_bodies_is_the_sum_of_one_each() -> None:
    def run(at_once: bool) -> np.ndarray:
        scene = stark.Scene()
        bodies = parts(scene)
        scene.contact_enabled = False
        ends = [corners(body) for body in bodies]
        pairs = [(a[:1], b[1:] if len(b) > 1 else b) for a, b in pairwise(ends)]
        if at_once:
            scene.add(springs(*(stark.joined(side) for side in zip(*pairs, strict=True))))
        else:
            for a, b in pairs:
                scene.add(springs(a, b))
        sim = stark.Simulation(scene, time_step=0.01, gravity=STILL)
        for _ in range(20):
            assert not sim.step().failed
        return np.concatenate([sim.state.point_positions, sim.state.body_positions])

    np.testing.assert_allclose(run(True), run(False), rtol=0, atol=1e-12)


def test_a_tendon_through_links_has_one_tension() -> None:
    """Three boxes on a line, the ends held by springs of the world: sections of a cable pull all alike."""
    scene = stark.Scene()
    links = [scene.add_box(0.04, mass=0.1, position=(0.2 * i, 0.05 * i * (2 - i), 0)) for i in range(3)]
    scene.contact_enabled = False
    for link, place in zip((links[0], links[2]), ((-0.1, 0, 0), (0.5, 0, 0)), strict=True):
        scene.add(springs(link.points((0, 0, 0)), place, stiffness=300.0))
    eyes = stark.joined(link.points((0, 0, 0)) for link in links)
    cable = scene.add(tendon(eyes[:-1], eyes[1:], rest=0.3))
    sim = stark.Simulation(scene, time_step=0.05, gravity=STILL)
    for _ in range(400):
        assert not sim.step().failed
    x = eyes_now(links)
    assert cable.length == pytest.approx(np.linalg.norm(np.diff(x, axis=0), axis=1).sum(), rel=1e-12)
    tension = cable.total_slopes["length"]
    forces = np.linalg.norm(cable.forces, axis=2)
    np.testing.assert_allclose(forces, tension, rtol=1e-9)
    # Springs and cable in a row: 300 (0.1 - d) = ... in equilibrium each end spring carries the tension.
    assert np.linalg.norm(x[0] - [-0.1, 0, 0]) - 0.1 == pytest.approx(tension / 300.0, abs=1e-6)
    assert abs(x[1, 1]) < 1e-3  # straightened


def eyes_now(links: list[Any]) -> np.ndarray:
    return np.array([link.position for link in links])


def test_documents_and_reproducers_keep_them(tmp_path: Any) -> None:
    scene = stark.Scene()
    bodies = parts(scene)
    ends = stark.joined(corners(body) for body in bodies)
    scene.add(springs(ends[:-1], ends[1:], length=0.05))
    again = None
    scene.save(tmp_path / "scene.json")
    again = stark.load_scene(tmp_path / "scene.json")
    sims = [stark.Simulation(s, time_step=0.01) for s in (scene, again)]
    for _ in range(3):
        for sim in sims:
            assert not sim.step().failed
    assert sims[0].state.hash == sims[1].state.hash
    np.testing.assert_array_equal(again.energies[0].forces, scene.energies[0].forces)


def test_stencils_are_joined_column_by_column() -> None:
    scene = stark.Scene()
    first = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2))
    second = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=1), position=(1, 0, 0))
    both = stark.joined(first.faces, second.faces)
    assert len(both) == len(first.faces) + len(second.faces)
    assert both.point_count == 3
    np.testing.assert_array_equal(
        both.columns[1].positions,
        np.concatenate([first.faces.columns[1].positions, second.faces.columns[1].positions]),
    )


def test_what_does_not_fit_is_refused() -> None:
    scene = stark.Scene()
    box, cloth, _ = parts(scene)
    with pytest.raises(stark.InvalidArgument, match=r"stark\.joined: got"):
        stark.joined(cloth.vertices, cloth.edges)
    with pytest.raises(stark.InvalidArgument, match=r"stark\.joined: got"):
        stark.joined(box)
    with pytest.raises(stark.InvalidArgument, match=r"stark\.joined: got"):
        stark.joined()
    with pytest.raises(stark.InvalidArgument, match="all points or all directions"):
        stark.joined(cloth.vertices, box.frame().columns[1])
    with pytest.raises(stark.Error):
        scene.attach(stark.joined(cloth.vertices), box)
    with pytest.raises(stark.InvalidArgument, match="must be a cloth or a solid with a closed surface"):
        scene.add_gas(stark.joined(cloth.faces))
    balls = [scene.add_cloth(stark.mesh.sphere(0.1, 1), position=(3 * k, 0, 9)) for k in (1, 2)]
    with pytest.raises(stark.InvalidArgument, match=r"are parts of one body.*stark\.mesh\.joined"):
        scene.add_gas(stark.joined([ball.faces for ball in balls]))
    other = stark.Scene()
    with pytest.raises(stark.InvalidArgument, match="belongs to another scene"):
        other.add(springs(stark.joined(cloth.vertices[:1]), (0, 0, 0)))
