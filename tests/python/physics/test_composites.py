"""Composite bodies against closed forms: patches where stiffnesses add exactly, a sandwich beam, a beam of
fibres."""

from __future__ import annotations

import numpy as np
import pytest

import stark

STATIC = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-10,
    "newton.acceleration_tolerance": 1e-8,
}
CORD = stark.RodMaterial(density=1000.0, youngs_modulus=5e7, radius=2e-3)


def ends(points: np.ndarray) -> np.ndarray:
    """Vertices of the end faces along x."""
    x = points[:, 0]
    return np.flatnonzero((x < x.min() + 1e-9) | (x > x.max() - 1e-9))


def lines_along_x(points: np.ndarray) -> list[np.ndarray]:
    """Vertices of each line of the mesh along x, in order."""
    _, line = np.unique(points[:, 1:].round(9), axis=0, return_inverse=True)
    rows = [np.flatnonzero(line.reshape(-1) == k) for k in range(line.max() + 1)]
    return [row[np.argsort(points[row, 0])] for row in rows]


def elastic_energy(scene: stark.Scene, body: stark.Body, targets: np.ndarray, **settings: object) -> float:
    """[J] with the pins of the body at their targets and the rest in equilibrium."""
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **{**STATIC, **settings})
    body.pin_targets = targets
    report = simulation.step()
    assert not report.failed, report.message
    return float(report.energy["elastic"])


@pytest.mark.parametrize("bending", [True, False])
@pytest.mark.parametrize("strain", [-0.02, 0.1])
def test_stiffness_of_axial_fibres_adds_to_that_of_a_bar(strain: float, bending: bool) -> None:
    """Without lateral contraction the bar stretches uniformly, whatever lines the fibres are on: the energy
    is that of Saint Venant and Kirchhoff plus EA strain^2 L/2 for each fibre, to rounding."""
    mesh = stark.mesh.box_hexahedra((1.0, 0.1, 0.1), (8, 2, 2))
    solid = stark.materials.st_venant_kirchhoff(youngs_modulus=2e5, poissons_ratio=0.0)
    scene = stark.Scene()
    bar = scene.add_solid(mesh, solid, pins=ends(mesh.vertices))
    lines = lines_along_x(mesh.vertices)
    assert len(lines) == 9
    bar.add_fibres(CORD, paths=lines[:3], bending=bending)  # off the middle
    bar.add_fibres(CORD.replace(radius=1e-3), paths=lines[4], bending=bending)
    targets = mesh.vertices[bar.pins] * [1.0 + strain, 1.0, 1.0]
    of_solid = 0.5 * 2e5 * (strain + 0.5 * strain**2) ** 2 * 0.01
    of_fibres = 0.5 * 5e7 * np.pi * (3 * 4e-6 + 1e-6) * strain**2
    assert of_fibres > 0.9 * of_solid
    assert elastic_energy(scene, bar, targets) == pytest.approx(of_solid + of_fibres, rel=1e-9)


def test_membrane_of_a_coat_adds_to_a_block() -> None:
    """Uniaxial strain of a block of 1 m: four of its faces stretch, both ends keep their shape."""
    mesh = stark.mesh.tet_box(1.0, cells=3)
    strain = 0.05
    green = strain + 0.5 * strain**2
    solid = stark.materials.st_venant_kirchhoff(youngs_modulus=2e5, poissons_ratio=0.0)
    coat = stark.materials.membrane_st_venant_kirchhoff(
        youngs_modulus=1e8, poissons_ratio=0.0, thickness=1e-3, bending_stiffness=0.0
    )
    scene = stark.Scene()
    block = scene.add_solid(mesh, solid, pins=ends(mesh.vertices))
    block.add_skin(coat)
    energy = elastic_energy(scene, block, mesh.vertices[block.pins] * [1.0 + strain, 1.0, 1.0])
    assert energy == pytest.approx(0.5 * green**2 * (2e5 + 4 * 1e8 * 1e-3), rel=1e-9)


@pytest.mark.parametrize("kind", ["tet4", "tet10", "hex27"])
def test_energies_of_layers_add_under_any_affine_map(kind: str) -> None:
    """All vertices of the surface follow a shear with stretches: the energy of the composite is the sum of
    those of its parts as bodies of their own."""
    mesh = stark.mesh.tet_box(0.2, cells=2)
    if kind != "tet4":
        mesh = stark.mesh.to_quadratic(
            mesh if kind == "tet10" else stark.mesh.box_hexahedra(0.2, cells=(2, 1, 1))
        )
    F = np.array([[1.1, 0.05, 0.0], [0.0, 0.95, 0.1], [0.03, 0.0, 1.02]])
    rubber, film = stark.materials.soft_rubber, stark.materials.pet
    triangles = np.asarray(mesh.surface_triangles())
    used, renumbered = np.unique(triangles, return_inverse=True)
    skin = stark.TriangleMesh(mesh.vertices[used], renumbered.reshape(-1, 3))

    def energy(coated: bool) -> float:
        scene = stark.Scene()
        block = scene.add_solid(mesh, rubber, pins=used)
        if coated:
            block.add_skin(film)
        return elastic_energy(scene, block, mesh.vertices[block.pins] @ F.T)

    scene = stark.Scene()
    sheet = scene.add_cloth(skin, film, pins=np.arange(len(used)), rest_angles="mesh")
    of_skin = elastic_energy(scene, sheet, skin.vertices[sheet.pins] @ F.T)
    assert energy(True) == pytest.approx(energy(False) + of_skin, rel=1e-10)
    assert of_skin > 1.0


def tip_deflection(skinned: bool, cells: int) -> float:
    """Of a cantilever of 1 m x 0.05 m x 0.05 m under 0.01 N at its end [m]."""
    mesh = stark.mesh.to_quadratic(stark.mesh.box_hexahedra((1.0, 0.05, 0.05), (cells, 1, 2)))
    X = mesh.vertices
    core = stark.SolidMaterial(youngs_modulus=1e6, poissons_ratio=0.0)
    scene = stark.Scene()
    beam = scene.add_solid(mesh, core, pins=X[:, 0] < -0.5 + 1e-9)
    if skinned:
        foil = stark.ShellMaterial(
            youngs_modulus=1e9, poissons_ratio=0.0, thickness=1e-4, bending_stiffness=0.0
        )
        height = X[beam.triangles][:, :, 2]
        faces = (height > 0.025 - 1e-9).all(axis=1) | (height < -0.025 + 1e-9).all(axis=1)
        beam.add_skin(foil, beam.triangles[faces])
    tip = np.flatnonzero(X[:, 0] > 0.5 - 1e-9)
    scene.add_force(beam.vertices[tip], (0.0, 0.0, -0.01 / len(tip)))
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC)
    assert not simulation.step().failed
    return float(-beam.positions[tip, 2].mean())


def test_a_sandwich_bends_as_a_beam() -> None:
    """Faces of E t at distances h/2 add 2 E t b (h/2)^2 to E b h^3/12 of the core; the shear of the core,
    P L / (G b h), is 1.6 % of it. Tolerance 1 %: shear is not constant over the height, and elements of a
    twentieth of the length."""
    b = h = 0.05
    core, faces = 1e6 * b * h**3 / 12.0, 2 * 1e9 * 1e-4 * b * (h / 2) ** 2
    shear = 0.01 / (0.5e6 * b * h)
    assert tip_deflection(True, 20) == pytest.approx(0.01 / (3.0 * (core + faces)) + shear, rel=0.01)
    assert tip_deflection(False, 20) == pytest.approx(0.01 / (3.0 * core) + 1.2 * shear, rel=0.01)


def test_a_sheet_with_fibres_sags_as_their_beam() -> None:
    """A limp strip of 1 m on its two ends, with a fibre along each edge: 5 w L^4 / (384 EI) of both fibres
    under the weight of strip and fibres. Tolerance 1 %: the sheet's own stiffness, 40 segments."""
    strip = stark.mesh.grid(1.0, 0.05, cells=(40, 1))
    limp = stark.ShellMaterial(density=0.1, youngs_modulus=1.0, thickness=1e-4, bending_stiffness=0.0)
    scene = stark.Scene()
    sheet = scene.add_cloth(strip, limp, pins=ends(strip.vertices))
    rods = stark.RodMaterial(density=1000.0, youngs_modulus=1e9, radius=3e-3)
    sheet.add_fibres(rods, paths=lines_along_x(strip.vertices))
    weight = sheet.mass * 0.01
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, -0.01), **STATIC)
    assert not simulation.step().failed
    stiffness = 2 * rods.section["bending_stiffness_1"]
    middle = np.abs(strip.vertices[:, 0]) < 1e-9
    sag = -sheet.positions[middle, 2]
    assert sag == pytest.approx(5.0 * weight / (384.0 * stiffness), rel=0.01)


def test_a_ring_of_fibre_resists_pressure_as_a_hoop() -> None:
    """A limp cylinder under pressure p with rings that carry all of it: p r s = EA strain, with the spacing
    s of the rings. Tolerance 2 %: a polygon of 48 corners, and what the sheet carries."""
    radius, segments, stacks = 0.1, 48, 8
    angle = np.arange(segments) * 2.0 * np.pi / segments
    height = np.linspace(0.0, 0.2, stacks + 1)
    vertices = np.array([(radius * np.cos(a), radius * np.sin(a), z) for z in height for a in angle])
    near = np.arange(segments * stacks)
    far = near // segments * segments + (near + 1) % segments
    triangles = np.concatenate(
        [
            np.column_stack([near, far, near + segments]),
            np.column_stack([far, far + segments, near + segments]),
        ]
    )
    limp = stark.ShellMaterial(density=0.1, youngs_modulus=100.0, poissons_ratio=0.0, thickness=1e-4)
    scene = stark.Scene()
    hose = scene.add_cloth(
        stark.TriangleMesh(vertices, triangles), limp, rest_angles="mesh", pins=np.arange(segments)
    )
    rings = [np.append(k * segments + np.arange(segments), k * segments) for k in range(stacks + 1)]
    fibres = hose.add_fibres(CORD, paths=rings)
    pressure, spacing = 20.0, 0.2 / stacks
    # Forces of pressure on the polygon: that of each face to its corners, inner rings
    # carry a whole spacing.
    outward = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    chord = 2.0 * radius * np.sin(np.pi / segments)
    share = np.where(np.isin(np.arange(stacks + 1), (0, stacks)), 0.5, 1.0)
    force = pressure * chord * np.cos(np.pi / segments) * spacing
    scene.add_force(hose.vertices, (share[:, None, None] * force * outward).reshape(-1, 3))
    simulation = stark.Simulation(scene, gravity=(0.0, 0.0, 0.0), **STATIC | {"newton.step_tolerance": 1e-8})
    report = simulation.step()
    assert not report.failed, report.message
    strain = fibres.stretches.reshape(stacks + 1, segments)[2:-2].mean() - 1.0
    hoop = pressure * radius * spacing / CORD.section["axial_stiffness"]
    assert strain == pytest.approx(hoop, rel=0.02)
