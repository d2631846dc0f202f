"""Rest states that change, against closed forms: expansion, growth, active stress, natural curvature."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import reproducer

STATIC: dict[str, Any] = {
    "time_step": 1.0,
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "gravity": (0, 0, 0),
    "newton.step_tolerance": 1e-11,
}
ALPHA, YOUNG = 2e-4, 1e6  # [1/K], [Pa]
MATERIAL = stark.SolidMaterial(
    youngs_modulus=YOUNG, poissons_ratio=0.3, density=1000.0, thermal_expansion=ALPHA
)
BAR = (0.1, 0.02, 0.02)  # [m]


def bar(kind: str) -> Any:
    hexahedra = stark.mesh.box_hexahedra(BAR, (5, 1, 1))
    return {
        "tetrahedra": lambda: stark.mesh.tet_box(BAR, (5, 1, 1)),
        "hexahedra": lambda: hexahedra,
        "quadratic": lambda: stark.mesh.to_quadratic(hexahedra),
        "mean": lambda: hexahedra,
    }[kind]()


def add_bar(scene: stark.Scene, kind: str, material: stark.SolidMaterial = MATERIAL, **options: Any) -> Any:
    formulation = "mean_dilatation" if kind == "mean" else "displacement"
    return scene.add_solid(bar(kind), material, formulation=formulation, **options)


KINDS = ["tetrahedra", "hexahedra", "quadratic", "mean"]


@stark.energy
def support(p: stark.Point, held: stark.Vec3):
    """Holds the directions in which ``held`` is 1."""
    d = p.x - p.X
    return 0.5e6 * sum(held[k] * d[k] ** 2 for k in range(3))


def rest_on_corners(scene: stark.Scene, body: Any) -> None:
    """Six directions of three corners, which leave a body free to change its shape and nothing else."""
    X = body.mesh.vertices
    low, high = X.min(axis=0), X.max(axis=0)
    places = [low, [high[0], low[1], low[2]], [low[0], high[1], low[2]]]
    corners = [int(np.argmin(np.linalg.norm(X - place, axis=1))) for place in places]
    scene.add(support(body.vertices[corners], held=np.array([[1.0, 1, 1], [0, 1, 1], [0, 0, 1]])))


@pytest.mark.parametrize("kind", KINDS)
def test_free_expansion_is_without_stress(kind: str) -> None:
    """A heated bar grows by alpha T in all directions, with no energy."""
    scene = stark.Scene()
    body = add_bar(scene, kind)
    X = body.mesh.vertices
    rest_on_corners(scene, body)
    body.temperature = 0.0
    sim = stark.Simulation(scene, **STATIC)
    body.temperature = 100.0
    report = sim.step()
    assert not report.failed
    x, stretch = body.positions, 1 + 100.0 * ALPHA
    low = X.min(axis=0)
    assert np.abs(x - (low + (X - low) * stretch)).max() < 1e-9 * BAR[0]
    assert report.energy["elastic"] < 1e-9 * YOUNG * np.prod(BAR) * (stretch - 1) ** 2


@pytest.mark.parametrize("kind", KINDS)
def test_clamped_bar_has_the_stress_e_alpha_t(kind: str) -> None:
    """Between two walls that hold its length but not its section: energy E (alpha T)^2 / 2 per volume."""
    scene = stark.Scene()
    body = add_bar(scene, kind)
    X = body.mesh.vertices
    scene.add(walls(body.vertices[np.abs(X[:, 0]) > 0.0499]))
    rest_on_corners(scene, body)
    body.temperature = 0.0
    sim = stark.Simulation(scene, **STATIC)
    body.temperature = 1.0
    report = sim.step()
    assert not report.failed
    stress = 2 * report.energy["elastic"] / (ALPHA * np.prod(BAR))
    assert stress == pytest.approx(YOUNG * ALPHA, rel=2e-3)  # of order alpha T from small strains


@stark.energy
def walls(p: stark.Point):
    return 0.5 * 1e10 * (p.x[0] - p.X[0]) ** 2


@stark.energy
def wall(p: stark.Point, normal: stark.Vec3):
    return 0.5 * 1e8 * ((p.x - p.X) @ normal) ** 2


def test_bimetal_bends_as_timoshenko_says() -> None:
    """A strip of two layers of equal thickness and stiffness bends to 3/2 dalpha T / h [Timoshenko 1925]."""
    length, height, kelvin, difference = 0.2, 4e-3, 50.0, 1e-4
    mesh = stark.mesh.to_quadratic(stark.mesh.box_hexahedra((length, 2e-3, height), (20, 1, 2)))
    upper = mesh.vertices[mesh.elements].mean(axis=1)[:, 2] > 0
    metal = stark.SolidMaterial(
        youngs_modulus=1e9,
        poissons_ratio=0.3,
        density=1000.0,
        thermal_expansion=np.where(upper, difference, 0.0),
    )
    scene = stark.Scene()
    X = mesh.vertices
    strip = scene.add_solid(mesh, metal, pins=X[:, 0] < -length / 2 + 1e-9)
    strip.temperature = 0.0
    sim = stark.Simulation(scene, **STATIC)
    for fraction in (0.5, 1.0):
        strip.temperature = fraction * kelvin
        assert not sim.step().failed
    middle = np.abs(X[:, 1:]).max(axis=1) < 1e-9
    order = np.argsort(X[middle, 0])
    x = strip.positions[middle][order]
    angle = np.arctan2(x[-2, 2] - x[-1, 2], x[-1, 0] - x[-2, 0]) - np.arctan2(
        x[5, 2] - x[6, 2], x[6, 0] - x[5, 0]
    )
    along = X[middle, 0][order]
    curvature = angle / (0.5 * (along[-1] + along[-2]) - 0.5 * (along[5] + along[6]))
    assert curvature == pytest.approx(1.5 * difference * kelvin / height, rel=0.02)


def test_a_sphere_grows() -> None:
    """Free growth by g multiplies the radius by g and leaves no energy."""
    cube = stark.mesh.tet_box(2.0, 4)
    squares = np.asarray(cube.vertices) ** 2  # concentric cubes become spheres [Nowell's map]
    y, z = squares[:, [1, 2, 0]], squares[:, [2, 0, 1]]
    mesh = stark.TetMesh(0.05 * cube.vertices * np.sqrt(1 - y / 2 - z / 2 + y * z / 3), cube.tets)
    scene = stark.Scene()
    body = scene.add_solid(mesh, MATERIAL.replace(mass_damping=5.0))
    body.growth = 1.0
    sim = stark.Simulation(scene, **STATIC | {"time.integrator": "implicit_euler", "time_step": 0.5})
    for growth in (1.1, 1.2, 1.3):
        body.growth = growth
        assert not sim.step().failed
    for _ in range(30):
        report = sim.step()
    x = body.positions
    radii = np.linalg.norm(x - x.mean(axis=0), axis=1).max()
    assert radii == pytest.approx(1.3 * np.linalg.norm(mesh.vertices, axis=1).max(), rel=1e-3)
    assert report.energy["elastic"] < 1e-9


def test_growth_is_a_tensor() -> None:
    scene = stark.Scene()
    body = add_bar(scene, "mean")
    X = body.mesh.vertices
    rest_on_corners(scene, body)
    body.growth = np.eye(3)
    sim = stark.Simulation(scene, **STATIC)
    body.growth = np.diag([1.2, 1.0, 0.9])
    assert not sim.step().failed
    size = np.linalg.svd(
        np.linalg.lstsq(X - X.mean(0), body.positions - body.positions.mean(0), rcond=None)[0]
    )[1]
    assert size == pytest.approx([1.2, 1.0, 0.9], abs=1e-8)
    body.growth = 1.1  # the same in all directions
    assert body.growth.shape == (5, 3, 3)
    body.growth[0] = np.diag([1.0, 1.0, 1.0])  # in place
    assert not sim.step().failed


@pytest.mark.parametrize("kind", KINDS)
def test_isometric_muscle_pulls_with_stress_times_area(kind: str) -> None:
    """Held at its length, free at its sides (Poisson's ratio 0): the force on the wall is S A."""
    scene = stark.Scene()
    body = add_bar(scene, kind, MATERIAL.replace(poissons_ratio=0.0))
    X = body.mesh.vertices
    left, right = X[:, 0] < -0.0499, X[:, 0] > 0.0499
    springs = scene.add(walls(body.vertices[right]))
    body.pin(left)
    body.fiber_direction = (2.0, 0.0, 0.0)
    body.active_stress = 0.0
    sim = stark.Simulation(scene, **STATIC)
    body.active_stress = 3e4
    assert not sim.step().failed
    assert springs.forces[:, 0, 0].sum() == pytest.approx(3e4 * BAR[1] * BAR[2], rel=1e-6)


def test_isotonic_muscle_shortens_until_it_balances() -> None:
    """Free, with Poisson's ratio 0, Neo-Hookean: E/2 (s - 1/s) = -S."""
    scene = stark.Scene()
    law = stark.materials.neo_hookean(youngs_modulus=YOUNG, poissons_ratio=0.0, density=1000.0)
    body = add_bar(scene, "hexahedra", law)
    rest_on_corners(scene, body)
    body.fiber_direction = (1.0, 0.0, 0.0)
    body.active_stress = lambda t: 2e5 * min(1.0, t / 4.0)
    sim = stark.Simulation(scene, **STATIC)
    for _ in range(5):
        assert not sim.step().failed
    stretch = np.ptp(body.positions[:, 0]) / BAR[0]
    assert YOUNG / 2 * (stretch - 1 / stretch) == pytest.approx(-2e5, rel=1e-6)


def test_a_sheet_of_muscle_pulls_with_stress_times_section() -> None:
    """Held at its length, Poisson's ratio 0, on a mesh that lies obliquely: its ends carry S t w."""
    scene = stark.Scene()
    grid = stark.mesh.grid(0.1, 0.04, cells=(5, 2))
    turn = stark.rotation(axis=(1.0, 2.0, 0.5), angle=0.7)
    sheet = stark.ShellMaterial(youngs_modulus=1e6, poissons_ratio=0.0, density=0.2, thickness=2e-3)
    cloth = scene.add_cloth(grid.rotated(turn), sheet)
    left, right = grid.vertices[:, 0] < -0.0499, grid.vertices[:, 0] > 0.0499
    cloth.pin(left)
    springs = scene.add(wall(cloth.vertices[right], normal=turn[:, 0]))
    cloth.fiber_direction = turn @ [3.0, 0.0, 1.0]  # what points out of the sheet does not count
    cloth.active_stress = 0.0
    sim = stark.Simulation(scene, **STATIC)
    cloth.active_stress = 3e4
    assert not sim.step().failed
    pull = springs.forces[:, 0].sum(axis=0)
    assert pull == pytest.approx(3e4 * 2e-3 * 0.04 * turn[:, 0], abs=2.4e-5)
    with pytest.raises(stark.InvalidArgument, match=r"fiber_direction\[0\].*normal to its triangle"):
        cloth.fiber_direction = turn[:, 2]


def test_a_rod_pulls_with_its_active_force() -> None:
    """Held at its ends it carries EA (s - 1) + F, loose at one it shortens by F over EA."""
    wire = stark.RodMaterial(youngs_modulus=1e6, radius=2e-3, density=1000.0)
    stiffness, force = np.pi * 4e-6 * 1e6, 2.0
    for loose in (False, True):
        scene = stark.Scene()
        line = stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 6)
        rod = scene.add_rod(line, wire, clamps=[0])
        springs = scene.add(walls(rod.vertices[[6]])) if not loose else None
        rod.active_force = lambda t: 0.5 * force * min(t, 2.0)
        sim = stark.Simulation(scene, **STATIC)
        for _ in range(3):
            assert not sim.step().failed
        stretch = rod.positions[-1, 0] / 0.3
        if springs is None:
            assert stretch == pytest.approx(1 - force / stiffness, rel=1e-9)
        else:
            carried = stiffness * (stretch - 1) + force
            assert springs.forces[0, 0, 0] == pytest.approx(carried, rel=1e-6)
            assert carried == pytest.approx(force, rel=1e-3)


def test_cloth_grows_and_expands() -> None:
    scene = stark.Scene()
    sheet = stark.ShellMaterial(
        youngs_modulus=1e6, density=0.2, bending_stiffness=1e-4, thermal_expansion=ALPHA
    )
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=4), sheet)
    X = cloth.mesh.vertices
    cloth.pin([0])
    cloth.temperature, cloth.growth = 0.0, 1.0
    sim = stark.Simulation(scene, **STATIC)
    cloth.temperature, cloth.growth = 50.0, 1.05
    report = sim.step()
    assert not report.failed
    area = stark.TriangleMesh(cloth.positions, cloth.triangles).area
    assert area == pytest.approx(0.01 * (1.05 * (1 + 50 * ALPHA)) ** 2, rel=1e-9)
    assert report.energy["elastic"] < 1e-12 and len(X) == len(cloth.positions)


@pytest.mark.parametrize("law", [None, "orthotropic_cloth"])
def test_growth_of_one_is_no_growth(law: str | None) -> None:
    """A sheet with a growth of 1 has the energy of one without."""
    material = stark.ShellMaterial(youngs_modulus=1e4, density=0.2)
    if law is not None:
        material = stark.materials.orthotropic_cloth(
            warp_modulus=1e4, weft_modulus=5e3, shear_modulus=1e3, poissons_ratio=0.2, density=0.2
        )
    energies = []
    for grows in (False, True):
        scene = stark.Scene()
        cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=3), material)
        if grows:
            cloth.growth = 1.0
        cloth.pin(range(16))
        sim = stark.Simulation(scene, **STATIC)
        X = cloth.mesh.vertices
        cloth.pin_targets = X * [1.1, 0.95, 1.0] + np.outer(X[:, 0] ** 2, [0, 0, 2.0])
        energies.append(sim.step().energy["elastic"])
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)


def test_rod_curls_into_a_ring() -> None:
    """A straight rod with the natural curvature 2 pi / L closes without stress."""
    n, length = 24, 0.5
    scene = stark.Scene()
    wire = stark.RodMaterial(youngs_modulus=1e8, radius=2e-3, density=1000.0)
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (length, 0, 0), n), wire, clamps=[0])
    rod.natural_curvature = (0.0, 0.0)
    sim = stark.Simulation(scene, **STATIC)
    for fraction in np.linspace(0.1, 1.0, 10):
        rod.natural_curvature = (2 * np.pi / length * fraction, 0.0)
        report = sim.step()
        assert not report.failed
    x = rod.positions
    assert np.linalg.norm(x[-1] - x[0]) < 1e-6
    centre = x[:-1].mean(axis=0)
    polygon = length / n / (2 * np.sin(np.pi / n))  # corners of a polygon of n sides
    assert np.linalg.norm(x - centre, axis=1) == pytest.approx(polygon, rel=1e-6)
    assert report.energy["elastic"] < 1e-12


def test_rod_grows_and_twists() -> None:
    n, length = 10, 0.5
    scene = stark.Scene()
    wire = stark.RodMaterial(youngs_modulus=1e8, radius=2e-3, density=1000.0, thermal_expansion=1e-3)
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (length, 0, 0), n), wire, clamps=[0])
    rod.growth, rod.temperature, rod.natural_twist = 1.0, 0.0, 0.0
    sim = stark.Simulation(scene, **STATIC)
    rod.growth, rod.temperature, rod.natural_twist = 1.2, 100.0, 2.0
    for _ in range(2):
        report = sim.step()
        assert not report.failed
    grown = length * 1.2 * 1.1
    assert rod.positions[-1, 0] == pytest.approx(grown, rel=1e-9)
    turn = rod.frames[0].T @ rod.frames[-1]
    assert np.arctan2(turn[1, 0], turn[0, 0]) == pytest.approx(2.0 * grown, abs=1e-8)
    assert report.energy["elastic"] < 1e-12


def test_values_are_live_per_simulation_and_in_checkpoints(tmp_path: Path) -> None:
    def made() -> tuple[stark.Simulation, Any]:
        scene = stark.Scene()
        body = add_bar(scene, "mean", pins=[0, 1, 2, 3], name="bar")
        body.growth = np.ones(5)
        body.temperature = lambda t: 100.0 * t
        return stark.Simulation(scene, time_step=0.02, **{"contact.enabled": False}), body

    sim, body = made()
    for step in range(10):
        body.growth[step % 5] += 0.02
        if step == 5:
            sim.save(tmp_path / "middle")
        assert not sim.step().failed
    other, copy = made()
    other.load(tmp_path / "middle")
    assert copy.growth == pytest.approx([1.04, 1.02, 1.02, 1.02, 1.02])
    for step in range(5, 10):
        if step > 5:
            copy.growth[step % 5] += 0.02
        other.step()
    assert other.state.hash == sim.state.hash
    assert sim.energies == [] and body.temperature == pytest.approx(20.0)


def test_documents_hold_rest_states(tmp_path: Path) -> None:
    scene = stark.Scene()
    body = add_bar(scene, "hexahedra", name="bar", pins=[0, 1, 2, 3])
    body.growth = np.linspace(1.0, 1.2, 5)
    body.fiber_direction, body.active_stress = (1, 0, 0), stark.motion.linear([0.0, 1.0], [0.0, 1e4])
    scene.save(tmp_path / "scene.json")
    loaded = stark.load_scene(tmp_path / "scene.json")
    assert loaded["bar"].growth == pytest.approx(body.growth)
    hashes = []
    for each in (scene, loaded):
        sim = stark.Simulation(each, time_step=0.01)
        for _ in range(3):
            sim.step()
        hashes.append(sim.state.hash)
    assert hashes[0] == hashes[1]


def test_reproducers_hold_the_values_of_the_step(tmp_path: Path) -> None:
    scene = stark.Scene()
    body = add_bar(scene, "mean", name="bar", pins=[0, 1, 2, 3])
    body.growth, body.temperature = np.eye(3), 0.0
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    body.growth[2] = np.diag([1.1, 1.0, 1.0])
    body.temperature = 20.0
    sim.step()
    sim.write_reproducer(tmp_path)
    again = reproducer.load(tmp_path)
    again.step()
    assert again.state.hash == sim.state.hash


def test_energy_that_a_change_brings_is_in_the_ledger() -> None:
    scene = stark.Scene()
    body = add_bar(scene, "hexahedra", name="bar")
    body.pin(range(len(body.mesh.vertices)))
    body.temperature = 0.0
    sim = stark.Simulation(scene, time_step=0.01, **{"contact.enabled": False})
    sim.step()
    body.temperature = 10.0
    report = sim.step()
    bulk = YOUNG / (3 * (1 - 2 * 0.3))
    assert report.energy["placed"] == pytest.approx(4.5 * bulk * (10 * ALPHA) ** 2 * np.prod(BAR), rel=0.02)


def test_energy_of_a_change_while_the_material_yields() -> None:
    """What growth brings is counted with what the material remembers at the end of the last step, not at its
    start: the ledger closes from step to step. [theory eq. 10c]"""
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.1, 0.02, cells=(5, 1))
    foil = stark.ShellMaterial(
        density=0.135, thickness=5e-4, youngs_modulus=7e9, poissons_ratio=0.3, yield_stress=2e7
    )
    ends = np.flatnonzero(np.abs(np.asarray(mesh.vertices)[:, 0]) > 0.0499)
    strip = scene.add_cloth(mesh, foil, pins=ends)
    strip.growth = 1.0
    sim = stark.Simulation(scene, **STATIC)
    elastic = 0.0
    for growth in (0.999, 0.995, 0.99):
        strip.growth = growth
        energy = sim.step().energy
        gained = energy["placed"] + energy["external"] - energy["damping"] - energy["numerical"]
        assert energy["elastic"] - elastic == pytest.approx(gained, abs=1e-12 * energy["elastic"])
        elastic = energy["elastic"]
    assert energy["damping"] > 0.0


def test_refused_rest_states() -> None:
    scene = stark.Scene()
    body = add_bar(scene, "hexahedra", name="bar")
    with pytest.raises(stark.InvalidArgument, match=r"growth\[0\] has the determinant -1"):
        body.growth = -1.0
    with pytest.raises(stark.InvalidArgument, match=r"must be \(5,\) or \(5, 3, 3\)"):
        body.growth = np.ones(4)
    with pytest.raises(stark.InvalidArgument, match="must be of finite numbers"):
        body.temperature = np.inf
    with pytest.raises(stark.InvalidArgument, match="must leave a positive stretch"):
        body.temperature = -1e4
    with pytest.raises(stark.InvalidArgument, match="needs a value of fiber_direction"):
        body.active_stress = 1.0
    with pytest.raises(stark.InvalidArgument, match="must not be zero"):
        body.fiber_direction = (0, 0, 0)
    assert body.growth.tolist() == [1.0] * 5 and not body.temperature.any() and not body.fiber_direction.any()
    with pytest.raises(ValueError, match="read-only"):
        body.growth[0] = 2.0
    body.growth = 1.0
    sim = stark.Simulation(scene, time_step=0.01)
    with pytest.raises(stark.InvalidArgument, match="must keep it while there is a simulation"):
        body.growth = np.eye(3)
    with pytest.raises(stark.InvalidArgument, match="changes the scene, not the simulation"):
        sim["bar"].temperature = 1.0
    body.growth[0] = -2.0
    with pytest.raises(stark.InvalidArgument, match=r"growth\[0\]"):
        sim.step()


def test_a_temperature_without_expansion_is_said_to_change_nothing() -> None:
    scene = stark.Scene()
    body = add_bar(scene, "hexahedra", MATERIAL.replace(thermal_expansion=0.0), name="bar")
    with pytest.warns(stark.StarkWarning, match="changes nothing, as thermal_expansion of the material is 0"):
        body.temperature = 10.0


def test_laws_with_a_parameter_of_the_same_name_keep_it() -> None:
    @stark.material
    def hot(F: stark.DeformationGradient, temperature: float = stark.parameter(1.0, unit="K")):
        return (1.0 + temperature) * stark.squared_norm(F.T @ F - stark.identity(3))

    scene = stark.Scene()
    body = scene.add_solid(stark.mesh.tet_box(0.1, 1), hot(temperature=2.0, density=1000.0), name="hot")
    with pytest.raises(stark.InvalidArgument, match="has a parameter of this name"):
        body.temperature = 1.0


LIMITED = stark.SolidMaterial(
    youngs_modulus=YOUNG,
    poissons_ratio=0.3,
    density=1000.0,
    thermal_expansion=ALPHA,
    strain_limit=0.05,
    strain_limit_stiffness=1e9,
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("limit_law", ["green_strain", "edges"])
def test_growth_of_solids_is_not_limited(kind: str, limit_law: str) -> None:
    """To three times its length, by growth in one direction and heat, without energy."""
    scene = stark.Scene()
    body = add_bar(scene, kind, LIMITED.replace(strain_limit_law=limit_law))
    X = body.mesh.vertices
    rest_on_corners(scene, body)
    body.growth, body.temperature = np.diag([1.0, 1.0, 1.0]), 0.0
    sim = stark.Simulation(scene, **{**STATIC, "newton.step_tolerance": 1e-8})  # less is rounding
    for share in np.linspace(0, 1, 11)[1:]:
        body.growth, body.temperature = np.diag([1 + 0.5 * share, 1.0, 1.0]), share / ALPHA
        report = sim.step()
        assert not report.failed, report.message
    low = X.min(axis=0)
    expected = low + (X - low) * [3.0, 2.0, 2.0]
    assert np.abs(body.positions - expected).max() < 1e-7 * BAR[0]
    assert abs(report.energy["elastic"]) < 1e-9 * LIMITED.youngs_modulus * np.prod(BAR)


def pulled_energy(kind: str, limit_law: str, grown: float) -> float:
    """Energy per rest volume, or area, of a body that has grown and is stretched by a fifth beyond."""
    scene = stark.Scene()
    if kind == "cloth":
        mesh: Any = stark.mesh.grid(0.1, 0.1, cells=2)
        sheet = stark.ShellMaterial(
            density=0.1, thickness=1e-3, youngs_modulus=1e6, strain_limit=0.05,
            strain_limit_stiffness=1e9, strain_limit_law=limit_law,
        )  # fmt: skip
        body: Any = scene.add_cloth(mesh, sheet, pins=range(len(mesh.vertices)))
    else:
        pins = range(len(bar(kind).vertices))
        body = add_bar(scene, kind, LIMITED.replace(strain_limit_law=limit_law), pins=pins)
    if grown != 1.0:
        body.growth = 1.0
    sim = stark.Simulation(scene, **STATIC)
    if grown != 1.0:
        body.growth = grown
    sim[body].pin_targets = np.asarray(body.mesh.vertices) * [1.2 * grown, 1.1 * grown, grown]
    report = sim.step()
    assert not report.failed, report.message
    return report.energy["elastic"] / grown ** (2 if kind == "cloth" else 3)


@pytest.mark.filterwarnings("ignore:.*leave a direction free")
@pytest.mark.parametrize("kind", [*KINDS, "cloth"])
@pytest.mark.parametrize("limit_law", ["green_strain", "edges"])
def test_the_limit_counts_from_the_grown_shape(kind: str, limit_law: str) -> None:
    """Stretched beyond the limit of strain, what has grown twice as large carries what the mesh does:
    much more than the law without a limit."""
    plain, grown = (pulled_energy(kind, limit_law, size) for size in (1.0, 2.0))
    assert grown == pytest.approx(plain, rel=1e-6)
    volume = 1e-5 if kind == "cloth" else np.prod(BAR)
    assert plain > 5 * YOUNG * 0.2**2 * volume


def test_growing_cloth_is_not_held_back() -> None:
    """Cotton has a limit of a tenth; grown by half where one half is warm, too, it stays without energy."""
    scene = stark.Scene()
    cotton = stark.materials.cotton.replace(thermal_expansion=ALPHA)
    mesh = stark.mesh.grid(0.1, 0.1, cells=4)
    sheet = scene.add_cloth(mesh, cotton, pins=range(len(mesh.vertices)))
    sheet.growth, sheet.temperature = 1.0, 0.0
    sim = stark.Simulation(scene, **STATIC)
    sheet.growth, sheet.temperature = 1.25, 0.2 / ALPHA
    sim[sheet].pin_targets = 1.5 * np.asarray(mesh.vertices)
    report = sim.step()
    assert not report.failed, report.message
    assert report.energy["elastic"] < 1e-9 * cotton.youngs_modulus * 0.01 * cotton.thickness
