"""Layers in Python: handles, order of values, what is refused, recordings and pictures, motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark
from stark.recording import Recorder, Recording

CORD = stark.materials.rubber_cord


def sheet(**options: object) -> tuple[stark.Scene, stark.Cloth]:
    """4 x 4 vertices, numbered row by row along x."""
    scene = stark.Scene()
    return scene, scene.add_cloth(stark.mesh.grid(0.3, 0.3, cells=3), name="sheet", **options)


def test_a_layer_whose_material_expands_with_heat_is_warned_of() -> None:
    """It has no temperature, and would hold back the body that has one without a word."""
    _, cloth = sheet()
    with pytest.warns(stark.StarkWarning, match="skin of 'sheet': thermal_expansion = 0.0001 1/K .* nothing"):
        cloth.add_skin(stark.materials.pet.replace(thermal_expansion=1e-4))
    with pytest.warns(stark.StarkWarning, match="fibres 'cords' of 'sheet': thermal_expansion = 0.001 1/K"):
        cloth.add_fibres(CORD.replace(thermal_expansion=-1e-3), paths=[0, 1, 2], name="cords")


def test_handles_say_what_the_layer_is() -> None:
    scene, cloth = sheet()
    bare = cloth.mass
    skin = cloth.add_skin(stark.materials.pet, cloth.triangles[:4], mass=0.01, color=(1, 0, 0))
    fibres = cloth.add_fibres(CORD, paths=[[0, 1, 2, 3], [4, 5, 9, 8, 4]], name="cords", mass=0.02)
    assert (skin.name, skin.kind, fibres.name, fibres.kind) == ("sheet_skin", "skin", "cords", "fibres")
    assert [layer.name for layer in cloth.layers] == ["sheet_skin", "cords"]
    assert scene.layers == (skin, fibres)
    assert skin.body is cloth and fibres.material.density != CORD.density
    assert skin.mass == pytest.approx(0.01) and fibres.mass == pytest.approx(0.02)
    assert cloth.mass == pytest.approx(bare + 0.03)
    assert len(skin.triangles) == 4 and fibres.bending
    assert fibres.edges.tolist() == [[0, 1], [1, 2], [2, 3], [4, 5], [5, 9], [9, 8], [8, 4]]
    assert fibres.frames.shape == (4 + 4, 3, 3)
    assert fibres.stretches == pytest.approx(np.ones(7))
    assert repr(fibres) == "<stark.Fibres 'cords' of 'sheet'>"
    assert "cords" not in scene


def test_edges_become_paths_that_end_at_crossings() -> None:
    _, cloth = sheet()
    edges = [[6, 5], [0, 1], [5, 1], [9, 5], [3, 2], [3, 7], [7, 6], [6, 2]]
    fibres = cloth.add_fibres(CORD, edges)
    assert fibres.edges.tolist() == edges
    found = sorted(sorted(path.tolist()) for path in fibres.paths)
    # 5 and 6 have three edges: the path 0-1-5, the spokes 5-9 and 5-6, the ring 6-2-3-7-6.
    assert found == [[0, 1, 5], [2, 3, 6, 6, 7], [5, 6], [5, 9]]
    ring = cloth.add_fibres(CORD, [[10, 11], [15, 14], [11, 15], [14, 10]])
    assert len(ring.paths) == 1 and len(ring.paths[0]) == 5 and len(ring.frames) == 4


def test_values_by_edge_are_in_the_order_of_the_edges() -> None:
    """The edge that is a hundred times softer takes up the length, however the rows are sorted."""
    soft = stark.ShellMaterial(youngs_modulus=1e2)
    scene, cloth = sheet(material=soft, pins=[0, 3, *range(8, 16)])
    stiffness = np.array([1e3, 1e1, 1e3])
    fibres = cloth.add_fibres(
        CORD.replace(axial_stiffness=stiffness), [[3, 2], [1, 0], [1, 2]], bending=False
    )
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **{"time.integrator": "quasistatic"})
    targets = cloth.pin_targets.copy()
    targets[1, 0] += 0.03
    cloth.pin_targets = targets
    assert not sim.step().failed
    stretches = fibres.stretches
    assert stretches[1] > 1.2 and stretches[[0, 2]].max() < 1.02
    assert stretches.sum() == pytest.approx(3.3, rel=1e-3)


def test_a_law_in_python_is_a_law_of_fibres() -> None:
    @stark.material
    def slack(stretch, EA: float = stark.parameter(unit="N", above=0.0)):
        """Resists extension only."""
        return 0.5 * EA * stark.maximum(stretch - 1.0, 0.0) ** 2

    energies = []
    for shift in (-0.01, 0.01):
        scene, cloth = sheet(pins=range(16))
        cloth.add_fibres(slack(EA=50.0, base=CORD), paths=[0, 1, 2, 3], bending=False)
        bare, plain = sheet(pins=range(16))
        found = []
        for s, c in ((scene, cloth), (bare, plain)):
            sim = stark.Simulation(s, gravity=(0, 0, 0), **{"time.integrator": "quasistatic"})
            c.pin_targets = c.pin_targets * [1.0 + shift / 0.3, 1.0, 1.0]
            found.append(sim.step().energy["elastic"])
        energies.append(found[0] - found[1])
    assert energies[0] == pytest.approx(0.0, abs=1e-12)
    assert energies[1] == pytest.approx(0.5 * 50.0 * (0.01 / 0.3) ** 2 * 0.3, rel=1e-9)


def test_handles_of_a_simulation_are_its_own() -> None:
    scene, cloth = sheet()
    fibres = cloth.add_fibres(CORD, paths=[0, 1, 2, 3])
    first = stark.Simulation(scene, time_step=0.01)
    late = cloth.add_fibres(CORD, paths=[4, 5], name="late")
    second = stark.Simulation(scene, time_step=0.01)
    for _ in range(3):
        second.step()
    assert [layer.name for layer in first.layers] == ["sheet_fibres"]
    assert [layer.name for layer in second.layers] == ["sheet_fibres", "late"]
    of_first, of_second = first.layers[0], second.layers[0]
    assert np.array_equal(of_first.body.positions, first["sheet"].positions)
    assert of_second.body.positions[0, 2] < -1e-3 == of_first.body.positions[0, 2] - 1e-3
    assert np.array_equal(fibres.frames, of_second.frames)
    assert late.frames.shape == (2, 3, 3)
    with pytest.raises(stark.InvalidArgument, match="'late' were added after the simulation was created"):
        _ = late._bound_to(first).frames


def test_a_falling_composite_keeps_its_momentum_ledger() -> None:
    """Nothing but gravity acts: momentum is mass times the velocity of a falling point, and all energy lost
    by falling is motion, up to what an implicit step loses, m g^2 h^2/2."""
    scene = stark.Scene()
    rubber, film = stark.materials.silicone.replace(mass_damping=0.0), stark.materials.pet
    block = scene.add_solid(stark.mesh.tet_box(0.1, cells=2), rubber, velocity=(1.0, 0.5, 0.0))
    bare = block.mass
    skin = block.add_skin(film.replace(mass_damping=0.0))
    fibres = block.add_fibres(CORD.replace(mass_damping=0.0), paths=[0, 1, 2])
    assert block.mass == pytest.approx(bare + skin.mass + fibres.mass, rel=1e-12)
    sim = stark.Simulation(scene, time_step=0.01)
    before = None
    for step in sim.run(until=0.1):
        velocity = np.array([1.0, 0.5, -9.81 * step.time])
        assert step.momentum == pytest.approx(block.mass * velocity, rel=1e-9)
        assert step.energy["kinetic"] == pytest.approx(0.5 * block.mass * velocity @ velocity, rel=1e-9)
        stored = step.energy["kinetic"] + step.energy["gravity"]
        if before is not None:
            assert before - stored == pytest.approx(0.5 * block.mass * (9.81 * 0.01) ** 2, rel=1e-6)
        before = stored
    assert step.energy["elastic"] < 1e-12


def refused(match: str, **change: object) -> None:
    scene, cloth = sheet()
    kind = change.pop("kind", "fibres")
    with pytest.raises(stark.InvalidArgument, match=match):
        if kind == "skin":
            cloth.add_skin(**{"material": stark.materials.pet, **change})  # type: ignore[arg-type]
        else:
            cloth.add_fibres(**{"material": CORD, **change})  # type: ignore[arg-type]
    assert scene.layers == () and cloth.layers == ()
    stark.Simulation(scene)


@pytest.mark.parametrize(
    ("match", "change"),
    [
        ("must be a stark.RodMaterial", {"material": stark.materials.pet, "paths": [0, 1]}),
        ("none of edges and paths", {}),
        ("both of edges and paths", {"edges": [[0, 1]], "paths": [0, 1]}),
        (r"edges of shape \(3,\)", {"edges": [0, 1, 2]}),
        (r"edges of shape \(0,\)", {"edges": []}),
        ("type float64: must be vertex indices", {"edges": [[0.0, 1.0]]}),
        ("vertex 16: must be in", {"edges": [[0, 16]]}),
        ("vertex -1: must be in", {"edges": [[0, -1]]}),
        ("joins vertex 2 with itself", {"edges": [[0, 1], [2, 2]]}),
        ("vertices 0 and 1 is there twice", {"edges": [[0, 1], [1, 0]]}),
        ("has 0 paths", {"paths": []}),
        ("path 0 has 1 vertices", {"paths": [[3]]}),
        ("path 1 of shape", {"paths": [[0, 1], [[2]]]}),
        ("path 0 of shape .* type float64", {"paths": [0.5, 1.0]}),
        ("must be rows of vertex indices", {"paths": 3}),
        ("turns by", {"paths": [0, 2, 1]}),
        ("rest_shape = 'round': must be 'mesh' or 'straight'", {"paths": [0, 1], "rest_shape": "round"}),
        ("rest_shape = straight is given", {"paths": [0, 1], "rest_shape": "straight", "bending": False}),
        ("along the first edge", {"paths": [0, 1], "normal": (1, 0, 0)}),
        ("must be three numbers", {"paths": [0, 1], "normal": (1, 0)}),
        ("mass = -1", {"paths": [0, 1], "mass": -1}),
        (
            "2 numbers: must be a multiple",
            {"paths": [0, 1, 2, 3], "material": CORD.replace(density=[1.0, 2.0])},
        ),
        ("6 numbers|6 values", {"paths": [0, 1, 2, 3], "material": CORD.replace(density=np.ones(6))}),
        ("is taken", {"paths": [0, 1], "name": "sheet"}),
        ("must be a non-empty text", {"paths": [0, 1], "name": ""}),
        ("color channel = 3", {"paths": [0, 1], "color": (3, 0, 0)}),
        ("must be a stark.ShellMaterial", {"kind": "skin", "material": CORD}),
        (r"triangles of shape \(1, 2\)", {"kind": "skin", "triangles": [[0, 1]]}),
        (r"triangles of shape \(0,\)", {"kind": "skin", "triangles": []}),
        ("refers to vertex 16", {"kind": "skin", "triangles": [[0, 1, 16]], "mass": 1.0}),
        ("uses vertex 1 twice", {"kind": "skin", "triangles": [[0, 1, 1]]}),
        ("must not be degenerate", {"kind": "skin", "triangles": [[0, 1, 2]]}),
        ("triangles 0 and 1 have the same", {"kind": "skin", "triangles": [[0, 1, 4], [4, 0, 1]]}),
        ("rest_angles = 'bent'", {"kind": "skin", "rest_angles": "bent"}),
        ("color channel = -1", {"kind": "skin", "color": (-1, 0, 0)}),
    ],
)
def test_what_cannot_be_is_refused_and_leaves_the_scene_as_it_was(
    match: str, change: dict[str, object]
) -> None:
    refused(match, **change)


def test_triangles_numbered_by_the_vertices_of_the_surface_are_refused() -> None:
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.tet_box(0.1, cells=3), stark.materials.silicone)
    top = (block.mesh.vertices[block.triangles][:, :, 2] > 0.0499).all(axis=1)
    with pytest.raises(stark.InvalidArgument, match=r"choose from body\.triangles"):
        block.add_skin(stark.materials.pet, triangles=block.surface_triangles[top])
    skin = block.add_skin(stark.materials.pet, triangles=block.triangles[top])
    assert abs(skin.mass / (0.01 * stark.materials.pet.density) - 1.0) < 1e-6
    within = scene.add_solid(stark.mesh.tet_box(0.1, cells=1), stark.materials.silicone, position=(1, 0, 0))
    within.add_skin(stark.materials.pet, triangles=[(0, 1, 6)])  # no vertex within: nothing to mistake


def test_rods_and_rigid_bodies_have_no_layers() -> None:
    scene = stark.Scene()
    assert not hasattr(scene.add_box(0.1, mass=1.0), "add_skin")
    rod = scene.add_rod([(1, 0, 0), (2, 0, 0)], CORD)
    assert not hasattr(rod, "add_fibres")
    assert rod.mass == pytest.approx(CORD.section["mass"])


def test_recordings_and_pictures_show_fibres_and_coloured_skins(tmp_path: Path) -> None:
    scene, cloth = sheet(color=(0.9, 0.9, 0.9))
    cloth.add_skin(stark.materials.pet, cloth.triangles[:2])  # without a colour
    cloth.add_skin(stark.materials.pet, cloth.triangles[:4], color=(0.1, 0.8, 0.1), name="patch")
    ribbon = stark.RodMaterial(width=0.02, height=0.004)
    cloth.add_fibres(ribbon, paths=[4, 5, 6, 7], normal=(0, 1, 0), color=(0.9, 0.0, 0.0), name="ribbon")
    cloth.add_fibres(CORD.replace(radius=0.006), paths=[8, 9, 10], bending=False, name="cord")
    sim = stark.Simulation(scene, time_step=0.01)
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
        for step in sim.run(until=0.03):
            recorder.report(step)
            recorder.record(sim)
    run = Recording(tmp_path / "run")
    frame = run.frame(-1)
    assert [(b.name, b.kind) for b in frame.bodies] == [
        ("sheet", "cloth"), ("patch", "skin"), ("ribbon", "fibres"), ("cord", "fibres")
    ]  # fmt: skip
    drop = 9.81 * 0.01**2 * 6  # of three implicit steps, less damping
    size = {b.name: np.ptp(b.positions, axis=0) for b in frame.bodies}
    middle = {b.name: b.positions.mean(axis=0) for b in frame.bodies}
    assert size["ribbon"] == pytest.approx([0.3, 0.02, 0.004], abs=1e-5)
    assert size["cord"] == pytest.approx([0.2, 0.012, 0.012], abs=1e-5)
    assert middle["cord"][2] == pytest.approx(-drop, rel=0.02)
    assert middle["patch"][2] > middle["sheet"][2]
    names = [entry["name"] for entry in stark.replay.encode(run).header["bodies"]]
    assert names == ["sheet", "patch", "ribbon", "cord"]
    picture = stark.render.render(sim, 160, 120, camera="top", quality="draft").astype(int)
    red = (picture[..., 0] > 120) & (picture[..., 1] < 60) & (picture[..., 2] < 60)
    green = (picture[..., 1] > 90) & (picture[..., 0] < 70) & (picture[..., 2] < 70)
    assert red.sum() > 50 and green.sum() > 50


def test_contact_is_that_of_the_body() -> None:
    """A sheet with thick cords lies on a box at its own contact distance."""
    heights = []
    for with_cords in (False, True):
        scene = stark.Scene()
        scene.add_box(0.5, motion="fixed", position=(0, 0, -0.25))
        cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=4), position=(0.003, 0.002, 0.0021))
        if with_cords:
            cloth.add_fibres(CORD.replace(radius=0.01, density=1.0), paths=[10, 11, 12, 13, 14])
        sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3)
        for step in sim.run(until=0.3):
            assert not step.failed
        heights.append(cloth.positions[:, 2].mean())
    assert heights[1] == pytest.approx(heights[0], abs=5e-4)


def test_threads_do_not_change_the_bits() -> None:
    hashes = set()
    for threads in (1, 2, 3):
        scene = stark.Scene()
        scene.add_floor(height=-0.06)
        block = scene.add_solid(stark.mesh.tet_box(0.1, cells=3), stark.materials.silicone)
        block.add_skin(stark.materials.pet)
        block.add_fibres(CORD, paths=[[0, 1, 2, 3], [0, 4, 8, 12]])
        settings = {"execution.threads": threads, "execution.oversubscribe": True}
        sim = stark.Simulation(scene, time_step=0.01, contact_distance=1e-3, **settings)
        for step in sim.run(until=0.15):
            assert not step.failed
        hashes.add(sim.state.hash)
    assert len(hashes) == 1
