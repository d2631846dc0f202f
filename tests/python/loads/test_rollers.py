"""Roller supports against closed forms: bars and sheets in uniaxial tension."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import stark

E, NU = 2e6, 0.3
RUBBER = stark.SolidMaterial(density=1000, youngs_modulus=E, poissons_ratio=NU)
STILL: dict[str, Any] = {"gravity": (0, 0, 0), "time.integrator": "quasistatic"}


@pytest.mark.parametrize("kind", ["hexahedra", "tetrahedra"])
def test_a_bar_in_tension_gets_thinner(kind: str) -> None:
    edges = (0.1, 0.04, 0.03)
    mesh = stark.mesh.box_hexahedra(edges, (5, 2, 2)) if kind == "hexahedra" else stark.mesh.tet_box(edges, 4)
    scene = stark.Scene()
    bar = scene.add_solid(mesh, RUBBER)
    at = bar.mesh.vertices
    for k, axis in enumerate("xyz"):
        scene.add_rollers(bar.vertices[abs(at[:, k] - at[:, k].min()) < 1e-9], axis)
    end = scene.add_rollers(
        bar.vertices[abs(at[:, 0] - 0.05) < 1e-9], (2.0, 0.0, 0.0), shift=lambda t: 1e-4 * t
    )
    sim = stark.Simulation(scene, time_step=0.5, **STILL)
    sim.run_until(1.0)
    strain = np.ptp(bar.positions, axis=0) / np.ptp(at, axis=0) - 1.0
    # Supports give way by a thousandth of a cell; finite strains are 1e-3 of small ones.
    np.testing.assert_allclose(strain, 1e-3 * np.array([1.0, -NU, -NU]), rtol=2e-3)
    pull = end.forces.sum(axis=(0, 1))
    assert pull[0] == pytest.approx(1e-3 * E * edges[1] * edges[2], rel=2e-3)
    assert np.abs(pull[1:]).max() < 1e-9 * pull[0]
    with pytest.raises(stark.InvalidArgument, match="shift"):
        end.shift = np.nan


def test_cloth_slides_in_a_plane_of_symmetry() -> None:
    """Half of a sheet that is pulled, with E t A strain at its middle."""
    sheet = stark.ShellMaterial(density=0.2, thickness=1e-3, youngs_modulus=1e6, poissons_ratio=0.0)
    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.2, 0.1, (8, 4)), sheet)
    x = cloth.mesh.vertices[:, 0]
    middle = scene.add_rollers(cloth.vertices[x < -0.0999], "x")
    scene.add_rollers(cloth.vertices[x > 0.0999], "x", shift=2e-4)
    scene.add_rollers(cloth.vertices[abs(cloth.mesh.vertices[:, 1] + 0.05) < 1e-9], "y")
    scene.add_rollers(cloth.vertices, "z", stiffness=1.0)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    assert middle.forces.sum(axis=(0, 1))[0] == pytest.approx(-1e6 * 1e-3 * 0.1 * 1e-3, rel=3e-3)


@stark.material
def own_neo_hookean(
    F: stark.DeformationGradient,
    mu: float = stark.parameter(unit="Pa", above=0.0),
    bulk: float = stark.parameter(unit="Pa", above=0.0),
) -> Any:
    J = stark.determinant(F)
    return mu / 2 * (stark.trace(F.T @ F) * J ** (-2 / 3) - 3) + bulk / 2 * (J - 1) ** 2


G, K = E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU))
LAWS = {
    "of a user": own_neo_hookean(mu=G, bulk=K, density=1000.0),
    "by element": own_neo_hookean(mu=np.full(20, G), bulk=K, density=1000.0),
    "metal": stark.j2_plasticity(
        shear_modulus=G, bulk_modulus=K, yield_stress=1e5, hardening_modulus=0.0, density=1000.0
    ),
    "built in": stark.SolidMaterial(law="mooney_rivlin", c10=G / 2, c01=0.0, bulk_modulus=K, density=1000.0),
}


@pytest.mark.parametrize("law", list(LAWS))
def test_supports_are_as_stiff_as_the_law_asks_for(law: str) -> None:
    """Not as the Young's modulus of the material, 10 kPa if left out, which these laws do not read."""
    scene = stark.Scene()
    bar = scene.add_solid(stark.mesh.box_hexahedra((0.1, 0.04, 0.03), (5, 2, 2)), LAWS[law])
    at = bar.mesh.vertices
    for k, axis in enumerate("xyz"):
        scene.add_rollers(bar.vertices[abs(at[:, k] - at[:, k].min()) < 1e-9], axis)
    end = scene.add_rollers(bar.vertices[abs(at[:, 0] - 0.05) < 1e-9], "x", shift=1e-4)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    assert np.ptp(bar.positions[:, 0]) == pytest.approx(0.1001, rel=1e-5)
    assert end.forces.sum(axis=(0, 1))[0] == pytest.approx(1e-3 * E * 0.04 * 0.03, rel=4e-3)


@pytest.mark.parametrize("law", ["stable_neo_hookean", "neo_hookean"])
@pytest.mark.parametrize("ratio", [0.3, 0.49, 0.499])
def test_a_block_between_walls_is_as_stiff_as_its_bulk(ratio: float, law: str) -> None:
    """Of rubber that nothing lets get thicker; supports of its Young's modulus took a fifth of the force."""
    rubber = stark.SolidMaterial(law=law, density=1000, youngs_modulus=E, poissons_ratio=ratio)
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.box_hexahedra(0.1, 3), rubber, formulation="mean_dilatation")
    at = block.mesh.vertices
    for k, axis in enumerate("xyz"):
        scene.add_rollers(block.vertices[at[:, k] < -0.0499], axis)
        scene.add_rollers(block.vertices[at[:, k] > 0.0499], axis, shift=-1e-5 if axis == "z" else 0.0)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    report = sim.step()
    assert not report.failed and not report.caveats
    confined = E * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio))
    push = sim.energies[-1].forces.sum(axis=(0, 1))[2]
    assert push == pytest.approx(-confined * 1e-4 * 0.01, rel=3e-3)


def test_a_frame_of_rods_stays_in_its_plane() -> None:
    """A column under less than Euler's load about its weak axis in the plane, and more than that across."""
    strip = stark.RodMaterial(density=1000.0, youngs_modulus=1e9, width=0.002, height=0.01)
    scene = stark.Scene()
    nodes = stark.mesh.polyline((0, 0, 0), (0, 0, 0.5), 20)
    column = scene.add_rod(nodes, strip, clamps=[0], normal=(0, 1, 0))
    scene.add_rollers(column.vertices, "y")
    euler = np.pi**2 * 1e9 * 0.01 * 0.002**3 / 12 / (2 * 0.5) ** 2
    scene.add_force(column.vertices[[20]], (0.0, 1e-3 * euler, -5.0 * euler))
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    assert np.abs(column.positions[:, 1]).max() < 1e-6


PLATE = stark.ShellMaterial(
    density=13.0,
    thickness=5e-3,
    youngs_modulus=7e10,
    poissons_ratio=0.3,
    flexural_rigidity=7e10 * 5e-3**3 / 12 / 0.91,
    mass_damping=0.0,
)


@pytest.mark.parametrize(
    ("clamped", "factor", "error"), [(False, 0.00406235, 0.01), (True, 0.00126532, 0.04)]
)
def test_a_quarter_of_a_plate_sags_as_the_whole(clamped: bool, factor: float, error: float) -> None:
    """Timoshenko's series for a square plate of 1 m under 100 Pa. Rollers alone, which leave the slopes free,
    give 2.6 times the first one."""
    scene = stark.Scene()
    plate = scene.add_cloth(stark.mesh.grid(0.5, 0.5, 24), PLATE, self_contact=False)
    x, y, _ = plate.mesh.vertices.T
    scene.add_rollers(plate.vertices[(x < -0.2499) | (y < -0.2499)], "z")
    for axis, along in (("x", x), ("y", y)):
        scene.add_symmetry(plate.vertices[along > 0.2499], axis)
        if clamped:
            scene.add_symmetry(plate.vertices[along < -0.2499], axis)
    scene.add_face_pressure(plate, 100.0)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    sag = -plate.positions[(x > 0.2499) & (y > 0.2499), 2].item()
    assert sag == pytest.approx(factor * 100.0 / float(PLATE.flexural_rigidity), rel=error)


def test_a_part_of_a_shell_is_at_rest_at_its_planes_of_symmetry() -> None:
    grid = stark.mesh.grid(np.pi / 2, 0.5, (12, 4)).vertices
    bent = np.column_stack((np.cos(grid[:, 0] + np.pi / 4), np.sin(grid[:, 0] + np.pi / 4), grid[:, 1]))
    mesh = stark.mesh.TriangleMesh(bent, stark.mesh.grid(np.pi / 2, 0.5, (12, 4)).triangles)
    scene = stark.Scene()
    shell = scene.add_cloth(mesh, PLATE.replace(flexural_rigidity=np.full(96, 800.0)), rest_angles="mesh")
    for axis, along in (("x", bent[:, 0]), ("y", bent[:, 1])):
        handle = scene.add_symmetry(shell.vertices[along < 1e-9], axis, name=axis)
        assert handle.name == axis
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    assert np.abs(shell.positions - bent).max() < 1e-9
    assert [len(scene.energies[f"{axis} slopes"].forces) for axis in "xy"] == [4, 4]


def test_a_skin_that_bends_is_held_at_a_plane_of_symmetry_as_its_sheet_is() -> None:
    """Half of a strip on two supports, of one plate and of a weak plate with a stiff skin, its triangles in
    another order: with a slope that only the weak one holds it would be a mechanism."""
    mesh = stark.mesh.grid(0.5, 0.05, (10, 2))
    x = mesh.vertices[:, 0]
    order = np.random.default_rng(0).permutation(len(mesh.triangles))

    def sag(share: float) -> float:
        scene = stark.Scene()
        strip = scene.add_cloth(mesh, PLATE.replace(flexural_rigidity=(1.0 - share) * 1e-2))
        if share > 0.0:
            limp = PLATE.replace(youngs_modulus=1e-3, flexural_rigidity=share * 1e-2)
            strip.add_skin(limp, np.roll(mesh.triangles[order], 1, axis=1))
        scene.add_rollers(strip.vertices[x < -0.2499], "z")
        scene.add_symmetry(strip.vertices[x > 0.2499], "x")
        scene.add_rollers(strip.vertices, "y")
        scene.add_force(strip.vertices[x > 0.2499], (0.0, 0.0, -1e-7))
        sim = stark.Simulation(scene, time_step=1.0, **STILL)
        assert not sim.step().failed
        return float(strip.positions[x > 0.2499, 2].mean())

    assert sag(0.99) == pytest.approx(sag(0.0), rel=1e-3)


def test_a_skin_of_a_solid_that_bends_is_held_at_a_plane_of_symmetry() -> None:
    """A soft bar with a stiff skin on two supports, whole and half, which sagged 4 times as far."""

    def sag(length: float) -> float:
        mesh = stark.mesh.box_hexahedra((length, 0.02, 0.005), (round(240 * length), 2, 1))
        mesh = type(mesh)(mesh.vertices - (0.1 - 0.5 * length, 0, 0), mesh.elements)
        x = mesh.vertices
        scene = stark.Scene()
        bar = scene.add_solid(
            mesh, stark.SolidMaterial(density=100.0, youngs_modulus=1e3, poissons_ratio=0.0)
        )
        top = (x[bar.triangles][:, :, 2] > 0.0024).all(axis=1)
        skin = stark.ShellMaterial(
            youngs_modulus=1e3, thickness=1e-4, poissons_ratio=0.0, flexural_rigidity=1e-3
        )
        bar.add_skin(skin, bar.triangles[top])
        ends, middle = (np.abs(x[:, 0]) > 0.0999) & (x[:, 2] > 0.0024), np.abs(x[:, 0]) < 1e-9
        scene.add_rollers(bar.vertices[ends], "z", stiffness=1e3)
        scene.add_rollers(bar.vertices[np.abs(x[:, 1]) < 1e-9], "y")
        scene.add_symmetry(bar.vertices[middle], "x") if length < 0.2 else None
        scene.add_face_pressure(bar.faces[top], 0.05)
        sim = stark.Simulation(scene, time_step=1.0, **STILL)
        assert not sim.step().failed
        return float((bar.positions - x)[middle, 2].mean())

    assert sag(0.1) == pytest.approx(sag(0.2), rel=0.02)


def test_fibres_that_bend_at_a_plane_of_symmetry_are_warned_of() -> None:
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.tet_box(0.1, 2), RUBBER)
    x = block.mesh.vertices
    edge = np.flatnonzero((x[:, 1:] < -0.0499).all(axis=1))
    wire = stark.RodMaterial()
    block.add_fibres(wire, paths=edge[np.argsort(x[edge, 0])][None], bending=False, name="thread")
    scene.add_symmetry(block.vertices[x[:, 0] < -0.0499], "x")  # not of these
    block.add_fibres(wire, paths=edge[np.argsort(x[edge, 0])][None], name="wire")
    with pytest.warns(stark.StarkWarning, match="nothing holds the slopes of the fibres 'wire' at the plane"):
        scene.add_symmetry(block.vertices[x[:, 0] > 0.0499], "x")


def test_symmetry_of_solids_is_rollers() -> None:
    scene = stark.Scene()
    block = scene.add_solid(stark.mesh.tet_box(0.1, 2), RUBBER)
    scene.add_symmetry(block.vertices[block.mesh.vertices[:, 0] < -0.0499], "x")
    soft = scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, 2), PLATE.replace(flexural_rigidity=0.0, bending_stiffness=0.0)
    )
    scene.add_symmetry(soft.vertices[soft.mesh.vertices[:, 0] < -0.0499], "x")
    assert len(scene.energies) == 2


def test_what_cannot_roll_is_refused() -> None:
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0)
    soft = scene.add_solid(stark.mesh.tet_box(0.1, 1), RUBBER, position=(1, 0, 0))
    count = len(scene.energies)
    for points, normal, message in (
        (soft, "x", r"rollers: points = .*: must be points of a body, such as solid\.vertices"),
        (soft.vertices[[0]], "up", r"rollers: normal = 'up': must be 'x', 'y', 'z' or a vector"),
        (soft.vertices[[0]], (0, 0, 0), r"rollers: normal = \(0, 0, 0\): must be"),
        (box.points((0, 0, 0)), "x", r"has no Young's modulus that says how stiff .* give stiffness="),
    ):
        with pytest.raises(stark.InvalidArgument, match=message):
            scene.add_rollers(points, normal)  # type: ignore[arg-type]
    assert len(scene.energies) == count


@pytest.mark.parametrize(("height", "cells"), [(0.002, 1), (0.002, 2), (0.0002, 1)])
@pytest.mark.parametrize("turned", [False, True])
def test_flat_pads_take_the_force_of_their_law(height: float, cells: int, turned: bool) -> None:
    """Their cells are much stiffer across than a cube; supports of one took an eighth to three quarters."""
    sides = (0.4, 0.4, height)
    scene = stark.Scene()
    rotation = stark.rotation(axis="x", angle=0.5) if turned else np.eye(3)
    pad = scene.add_solid(
        stark.mesh.box_hexahedra(sides, (10, 10, cells)),
        stark.SolidMaterial(density=1000.0, youngs_modulus=E, poissons_ratio=0.0),
        rotation=rotation,
    )
    at = pad.mesh.vertices
    for k in range(3):
        scene.add_rollers(pad.vertices[at[:, k] < -0.499 * sides[k]], rotation[:, k])
    top = scene.add_rollers(pad.vertices[at[:, 2] > 0.499 * height], rotation[:, 2], shift=-1e-3 * height)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    report = sim.step()
    assert not report.failed and not report.caveats
    push = top.forces.sum(axis=(0, 1)) @ rotation[:, 2]
    assert push == pytest.approx(-E * 1e-3 * 0.16, rel=4e-3)


def test_sheets_of_narrow_cells_take_the_force_of_their_law() -> None:
    scene = stark.Scene()
    stuff = stark.ShellMaterial(density=1.0, youngs_modulus=E, poissons_ratio=0.0, strain_limit=np.inf)
    sheet = scene.add_cloth(stark.mesh.grid(0.01, 1.0, cells=(1, 2)), stuff)
    at = sheet.mesh.vertices
    scene.add_rollers(sheet.vertices, "z")
    scene.add_rollers(sheet.vertices[at[:, 1] < -0.499], "y")
    scene.add_rollers(sheet.vertices[at[:, 0] < 0.0], "x")
    end = scene.add_rollers(sheet.vertices[at[:, 0] > 0.0], "x", shift=1e-5)
    sim = stark.Simulation(scene, time_step=1.0, **STILL)
    assert not sim.step().failed
    assert end.forces.sum(axis=(0, 1))[0] == pytest.approx(E * stuff.thickness * 1e-3, rel=4e-3)


def test_points_of_a_plane_of_symmetry_lie_in_one() -> None:
    """A mask that finds too much held both sides of the body, silently."""
    scene = stark.Scene()
    soft = scene.add_solid(stark.mesh.tet_box(0.1, 2), RUBBER)
    with pytest.warns(
        stark.StarkWarning, match="symmetry: its points are 0.1 m apart along the normal: must"
    ):
        scene.add_symmetry(soft.vertices, "x")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.add_symmetry(soft.vertices[soft.mesh.vertices[:, 0] < -0.0499], "x")
    with pytest.raises(stark.InvalidArgument, match=r"symmetry: points = .*: must be points of a body"):
        scene.add_symmetry(soft, "x")  # type: ignore[arg-type]
    with pytest.raises(stark.InvalidArgument, match=r"symmetry 'cut': normal = 'up': must be"):
        scene.add_symmetry(soft.vertices[[0]], "up", name="cut")
