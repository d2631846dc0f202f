"""Attachments: what they carry, conservation, pairs, contact, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stark

G = 9.81


LIGHT = stark.materials.cotton.replace(density=0.5)


def simulate(scene: stark.Scene, **settings: object) -> stark.Simulation:
    return stark.Simulation(scene, **{"time_step": 0.01, "contact.enabled": False, **settings})


def run(sim: stark.Simulation, steps: int) -> None:
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message


def soft_box(scene: stark.Scene, position: tuple[float, float, float], **options: object) -> stark.Solid:
    material = stark.SolidMaterial(youngs_modulus=2e5, poissons_ratio=0.3, density=1000.0)
    return scene.add_solid(stark.mesh.tet_box(0.1, cells=2), material, position=position, **options)


def heights_on(body: stark.Body, triangles: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights of places above triangles of a body [m], normals."""
    x = body.positions[body.triangles[triangles]]
    normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return np.einsum("ni,ni->n", places - x[:, 0], normals), normals


@pytest.mark.parametrize("kind", ["rigid", "solid", "cloth"])
def test_free_bodies_keep_their_momentum(kind: str) -> None:
    """No gravity, no ground: glue adds neither momentum nor angular momentum, whatever carries it, also where
    points are carried at a distance from the surface."""
    scene = stark.Scene()
    a = soft_box(scene, (0.0, 0.0, 0.104), velocity=(0.1, 0.0, 0.0), angular_velocity=(0.5, 2.0, 1.0))
    if kind == "rigid":
        b: stark.Body = scene.add_box(0.1, mass=0.7)
    elif kind == "solid":
        b = soft_box(scene, (0.0, 0.0, 0.0))
    else:
        stiff = stark.materials.cotton.replace(density=2.0, mass_damping=0.0)  # no drag
        b = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4), stiff, position=(0.0, 0.0, 0.05))
    glue = scene.attach(a, b, distance=5e-3)
    assert len(glue) == 9
    carriers = stark._core.find_closest_triangles(glue.points.positions, b.positions, b.triangles)[0]
    start_heights, start_normals = heights_on(b, carriers, glue.points.positions)
    assert start_heights.max() > 3.9e-3
    tight = {"newton.residual_tolerance": 1e-8, "newton.step_tolerance": 1e-8}
    sim = simulate(scene, time_step=5e-3, gravity=(0.0, 0.0, 0.0), **tight)
    sim.step()
    first = sim.step()
    last = first
    for _ in range(15):
        last = sim.step()
        assert not last.failed, last.message
    assert np.linalg.norm(glue.forces) > 1e-2
    # Momentum to rounding; implicit Euler takes a part of the order (angular velocity * time step)^2 of the
    # angular momentum in each step.
    np.testing.assert_allclose(last.momentum, first.momentum, atol=1e-12)
    scale = np.linalg.norm(first.angular_momentum)
    np.testing.assert_allclose(last.angular_momentum, first.angular_momentum, atol=1e-2 * scale)
    # The points keep their height above their triangles as these turn, within the tolerance.
    heights, normals = heights_on(b, carriers, a.positions[glue.points._columns["vertices"]])
    np.testing.assert_allclose(heights, start_heights, atol=1e-6)
    assert np.abs(normals - start_normals).max() > 0.05


def test_a_pad_on_a_finger() -> None:
    """A soft pad is glued flush to a scripted finger and carried around, in contact with everything else."""
    scene = stark.Scene()
    finger = scene.add_box((0.1, 0.1, 0.02), motion="scripted", position=(0.0, 0.0, 0.06))
    pad = soft_box(scene, (0.0, 0.0, 0.0))
    glue = scene.attach(pad, finger, distance=1e-6)
    floor = scene.add_floor(height=-0.055)
    sim = simulate(scene, **{"contact.enabled": True, "contact.distance": 1e-3})
    finger.follow(position=stark.motion.spline([0.0, 0.1], [(0.0, 0.0, 0.06), (0.0, 0.0, 0.05)]))
    run(sim, 15)
    top = glue.points._columns["vertices"]
    np.testing.assert_allclose(pad.positions[top, 2], 0.04, atol=1e-6)
    # The floor pushes the pad up against the finger: what the glue carries is what the floor gives, less the
    # weight.
    pushed = sim.contacts.of(pad, floor)
    assert len(pushed) > 0 and glue.force[2] < -1.0
    np.testing.assert_allclose(pad.contact_force[2] + glue.force[2], 1e-3 * 1000.0 * G, rtol=0.1)


def test_contact_beyond_what_is_glued() -> None:
    """A cloth is glued to a box by one corner; its other end falls on the box and stays on it."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=5), LIGHT, position=(0.0, 0.0, 0.004))
    box = scene.add_box((0.3, 0.3, 0.02), motion="fixed", position=(0.0, 0.0, -0.01))
    glue = scene.attach(cloth.vertices[0], box)
    sim = simulate(scene, **{"contact.enabled": True, "contact.distance": 1e-3})
    run(sim, 12)
    assert len(glue) == 1
    assert cloth.positions[:, 2].min() > 0.0
    assert len(sim.contacts.of(cloth, box)) > 0


def test_a_shell_on_a_solid_with_common_places() -> None:
    """A skin: the vertices of a cloth at those of the surface of a solid."""
    scene = stark.Scene()
    core = soft_box(scene, (0.0, 0.0, 0.0))
    used, triangles = np.unique(core.triangles, return_inverse=True)
    skin = stark.TriangleMesh(core.mesh.vertices[used], triangles.reshape(-1, 3).astype(np.int32))
    shell = scene.add_cloth(skin, LIGHT, rest_angles="mesh", self_contact=False)
    glue = scene.attach(shell.vertices, core.vertices[used])
    sim = simulate(scene, **{"contact.enabled": True, "contact.distance": 1e-3})
    run(sim, 5)
    assert len(glue) == len(used)
    assert np.abs(shell.positions - core.positions[used]).max() < 1e-6


def test_rods_and_points_of_all_kinds() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(
        stark.mesh.polyline((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), segments=6),
        stark.RodMaterial(radius=2e-3, youngs_modulus=1e7),
    )
    box = scene.add_box(0.04, mass=0.05, position=(0.3, 0.0, -0.03))
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), LIGHT, position=(0.15, 0.06, 0.0))
    scene.attach(rod.vertices[[0, 1]], None)
    on_rod = scene.attach(box.points([(0.0, 0.01, 0.03), (0.0, -0.01, 0.03)]), rod)
    hung = scene.attach(cloth, rod, distance=0.011)
    middle = scene.attach(cloth.embedded([0], (1 / 3, 1 / 3, 1 / 3)), rod)
    sim = simulate(scene)
    run(sim, 10)
    assert (len(on_rod), len(hung), len(middle)) == (2, 3, 1)
    assert [a.name for a in sim.attachments] == ["attachment", "attachment_2", "attachment_3", "attachment_4"]
    # Two points on one node hold the box against turning about the line between them only.
    ends = box.position + np.array([(0.0, 0.01, 0.03), (0.0, -0.01, 0.03)]) @ box.rotation.T
    tip = rod.positions[-1] + np.array([(0.0, 0.01, 0.0), (0.0, -0.01, 0.0)]) @ rod.frames[-1].T
    assert rod.positions[-1][2] < -1e-3
    turned = rod.frames[-1] @ rod._scene._core.initial_frames(rod._index).reshape(-1, 3, 3)[-1].T
    tip = rod.positions[-1] + np.array([(0.0, 0.01, 0.0), (0.0, -0.01, 0.0)]) @ turned.T
    np.testing.assert_allclose(ends, tip, atol=2e-6)


def test_pairs_by_index_and_nearest_points() -> None:
    scene = stark.Scene()
    a = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), LIGHT)
    b = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), LIGHT, position=(0.0, 0.0, 0.01))
    box = scene.add_box(0.1, mass=1.0, position=(0.0, 0.0, -0.06))
    by_index = scene.attach(a, b, pairs=[(0, 0), (4, 4)])
    nearest = scene.attach(a.vertices, b.vertices[[8, 6]], distance=0.0101)
    rigid = scene.attach(a, box, pairs=[(0, 3)])
    faces = scene.attach(b.faces[[0, 1]], box, contact=False)
    assert (len(by_index), len(nearest), len(rigid), len(faces)) == (2, 2, 1, 4)
    assert nearest.points._columns["vertices"].tolist() == [6, 8]
    assert not scene.contact_enabled(b, box) and scene.contact_enabled(a, box)
    sim = simulate(scene)
    apart = b.positions - a.positions
    run(sim, 5)
    now = b.positions - a.positions
    for k in (0, 4, 6, 8):
        np.testing.assert_allclose(np.linalg.norm(now[k]), np.linalg.norm(apart[k]), atol=2e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "say which of its points"),
        ({"distance": -1.0}, "distance = -1.0 m: must be a finite number >= 0"),
        ({"distance": 1e-4}, "no point is within distance = 0.0001 m of 'box': the nearest is 0.01 m away"),
        ({"distance": 1.0, "pairs": [(0, 0)]}, "pairs and distance are both given"),
        ({"pairs": [(0, 99)]}, "vertex 99 of 'box': must be in \\[0, 8\\)"),
        ({"pairs": [0, 1]}, "must be integers of shape \\(n, 2\\)"),
        ({"distance": 1.0, "break_force": 0.0}, "break_force = 0.0 N: must be a number > 0"),
        ({"distance": 1.0, "break_force": [[1], [2, 3]]}, r"break_force = .* N: must be a number > 0"),
    ],
)
def test_refusals(options: dict[str, object], message: str) -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), LIGHT, name="sheet")
    box = scene.add_box(0.1, motion="fixed", name="box", position=(0.0, 0.0, -0.06))
    with pytest.raises(stark.InvalidArgument, match=message):
        scene.attach(cloth, box, **options)  # type: ignore[arg-type]
    assert scene.attachments == ()


def test_more_refusals() -> None:
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), LIGHT, name="sheet")
    line = stark.mesh.polyline((0.0, 0.0, 1.0), (0.3, 0.0, 1.0), segments=2)
    rod = scene.add_rod(line, stark.RodMaterial(radius=2e-3, youngs_modulus=1e7), name="string")
    other = stark.Scene().add_box(0.1, mass=1.0, name="stranger")
    for a, b, message in [
        (cloth.vertices, other, "'stranger' belongs to another scene"),
        (3.0, cloth, "side a = 3.0: must be a body or points"),
        (
            rod.points([1], (0.01, 0, 0)),
            None,
            r"side a = <1 points of 'string'>: .* scene\.add_ball\(rod\.frame",
        ),
        (
            cloth,
            stark.joined([rod.vertices, cloth.vertices]),
            "side b = .*: must be points of one body; those",
        ),
        (cloth.vertices, cloth, "both sides are 'sheet'"),
        (cloth.vertices, cloth.vertices[:2], "9 points on 2 points: must be as many, or one"),
        (cloth.vertices[[0, 1]], cloth.vertices[[0, 1]], "pair 0 attaches 'sheet' to itself, at vertex 0"),
        (cloth.vertices[:3], cloth.vertices[0], "attaches 'sheet' to itself"),
        (rod.vertices[1], rod, "pair 0 attaches 'string' to itself, at node 1"),
        (stark.world_points((0, 0, 0)), None, "both sides are of the world"),
        (cloth.vertices[0], stark.world_points((0, 0, 1)), "points of the world are up to"),
    ]:
        with pytest.raises(stark.InvalidArgument, match=message):
            scene.attach(a, b)
    glue = scene.attach(cloth.vertices[0], None, name="nail")
    with pytest.raises(stark.InvalidArgument, match="the name is taken"):
        scene.attach(cloth.vertices[1], None, name="nail")
    with pytest.raises(stark.InvalidArgument, match="forces need a simulation"):
        _ = glue.forces
    sim = simulate(scene)
    with pytest.raises(stark.InvalidArgument, match="must be True or False"):
        glue.enabled = 1  # type: ignore[assignment]
    with pytest.warns(stark.StarkWarning, match="'attachment' was added after"):
        late = scene.attach(cloth.vertices[1], None)
    with pytest.raises(stark.InvalidArgument, match="was added after the simulation"):
        _ = late.forces
    assert "1 points" in repr(glue) and len(sim.attachments) == 1


def test_what_prescribed_bodies_pull_apart_is_named() -> None:
    scene = stark.Scene()
    a = scene.add_box(0.1, motion="scripted")
    b = scene.add_box(0.1, motion="fixed", position=(0.2, 0.0, 0.0))
    scene.attach(a.points((0.1, 0.0, 0.0)), b, name="contradiction")
    sim = simulate(scene, **{"time.min_step": 5e-3})
    run(sim, 1)
    a.position = (0.1, 0.0, 0.0)
    report = sim.step()
    assert report.failed and "attachment 'contradiction', pair 0, is apart by" in report.message


@pytest.mark.parametrize("how", [{"distance": 1.0}, {"pairs": np.zeros((0, 2), dtype=int)}, {}])
def test_selections_without_points_are_named(how: dict[str, Any]) -> None:
    """NumPy complained about arrays of no size."""
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=1), name="c")
    solid = scene.add_solid(stark.mesh.tet_box(0.1, cells=1), position=(0, 0, 1))
    sides: list[Any] = [(cloth, solid)] if "pairs" in how else [(cloth.vertices[[]], solid)]
    if "distance" in how:
        sides += [(cloth, solid.vertices[[]]), (cloth.vertices[[]], solid.vertices)]
    for a, b in sides:
        with pytest.raises(stark.InvalidArgument, match=r"side [ab] has 0 points: must have at least one"):
            scene.attach(a, b, **how)


@pytest.mark.parametrize("count", [4, 12, 41])
def test_points_of_a_lattice_carry_its_weight_however_many_are_held(count: int) -> None:
    """41 points, whose places 16 nodes say. Weights of nodes that are rounding errors, of points on faces of
    cells, swamped the others: forces were zero, and the block crept down by a nanometre a step."""
    mesh = stark.mesh.lattice(stark.mesh.box(0.1), cells=3)
    scene = stark.Scene()
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6, mass_damping=5.0)
    block = scene.add_solid(mesh, rubber)
    upper = np.flatnonzero(mesh.vertices[:, 2] > 0.0499)
    glue = scene.attach(block.vertices[upper[upper >= mesh.node_count][:count]], None)
    sim = stark.Simulation(scene, time_step=0.02)
    for _ in range(50):
        assert not sim.step().failed
    assert glue.force == pytest.approx([0.0, 0.0, 9.81], abs=1e-3)
    assert np.abs(glue.forces).max() < 9.81
