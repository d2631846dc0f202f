"""Membranes against closed forms: strain limit of a strip (V11), a balloon and its limit point (V12), a disc
that pressure bulges (Hencky)."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from _mechanisms import simulate
from _validation import validate
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial import Delaunay

import stark

STATIC = {
    "time.integrator": "quasistatic",
    "newton.acceleration_tolerance": 1e-6,
    "newton.step_tolerance": 1e-9,
    "newton.max_iterations": 500,
}


# --- V11: strain limit ---

MODULUS, THICKNESS, WIDTH, LENGTH = 5e3, 1e-3, 0.1, 0.5  # [Pa], [m], [m], [m]
LIMIT, STIFFNESS = 0.1, 1e6  # [1], [Pa]
LOADS = (0.04, 0.1, 0.5, 2.0)  # [N]


@stark.energy
def load(p: stark.Point, force: stark.Vec3):
    """A force on each point [N]."""
    return -(force @ p.x)


LAWS: dict[str, dict[str, Any]] = {
    "green": {"strain_limit_hardening": 0.0},
    "hardening": {"strain_limit_hardening": 500.0},
    "edges": {"strain_limit_law": "edges"},
}


def limit_stress(name: str, a: float) -> float:
    """Nominal stress of the limit at the stretch a [Pa]."""
    if name == "edges":  # of the area of a cell its two edges along the load stand for a third
        return STIFFNESS / 3 * max(a - 1 - LIMIT, 0.0) ** 2
    excess = max((a**2 - 1) / 2 - LIMIT, 0.0)
    v = (excess / LIMIT) ** 3
    return STIFFNESS * a * excess**2 * (1 + LAWS[name]["strain_limit_hardening"] * v * (2 + v) / (1 + v) ** 2)


def stretch_of_strip(name: str, force: float) -> float:
    """Without lateral contraction the strip only gets longer. Its cells are ten times wider than long, so
    that diagonals stay below the limit."""

    def resultant(a: float) -> float:
        return THICKNESS * WIDTH * (MODULUS / 2 * (a - 1 / a) + limit_stress(name, a))

    return brentq(lambda a: resultant(a) - force, 1.0, 3.0, xtol=1e-14)


@pytest.mark.filterwarnings("ignore:.*leave a direction free:stark.StarkWarning")
@pytest.mark.parametrize("name", LAWS)
def test_strip_beyond_its_strain_limit(name: str) -> None:
    grid = stark.mesh.grid(WIDTH, LENGTH, (1, 50))
    y = grid.vertices[:, 1]
    material = stark.ShellMaterial(
        youngs_modulus=MODULUS,
        thickness=THICKNESS,
        poissons_ratio=0.0,
        strain_limit=LIMIT,
        strain_limit_stiffness=STIFFNESS,
        bending_stiffness=1e-9,
        **LAWS[name],
    )
    measured = []
    for force in LOADS:
        scene = stark.Scene()
        start = grid.vertices * (1.0, 1.01, 1.0)  # under tension, so that the flat strip is stable
        strip = scene.add_cloth(grid, material, initial_positions=start, pins=y > 0.499 * LENGTH)
        end = np.flatnonzero(y < -0.499 * LENGTH)
        scene.add(load(strip.vertices[end], force=(0, -force / 2, 0)))
        sim = simulate(scene, 1.0, gravity=(0, 0, 0), **STATIC)
        report = sim.step()
        assert report.status == "accepted", report.message
        # The cells next to the clamp too: without lateral contraction the field is uniform.
        measured.append(np.ptp(strip.positions[:, 1]) / np.ptp(start[:, 1] / 1.01))
    expected = [stretch_of_strip(name, force) for force in LOADS]
    assert measured == pytest.approx(expected, abs=1e-6)
    validate(f"V11.stretch_{name}", measured)


# --- V11: strains of sheets at rest ---


def largest_green_strain(mesh: stark.TriangleMesh, positions: np.ndarray) -> float:
    """Largest eigenvalue of the Green strain in any triangle."""
    at_rest, now = mesh.vertices[mesh.triangles], positions[mesh.triangles]
    D = np.stack([at_rest[:, 1] - at_rest[:, 0], at_rest[:, 2] - at_rest[:, 0]], -1)[:, :2]
    d = np.stack([now[:, 1] - now[:, 0], now[:, 2] - now[:, 0]], -1)
    F = d @ np.linalg.inv(D)
    return float(np.linalg.eigvalsh(0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(2))).max())


def hung_by_corners(cells: int, **changes: Any) -> float:
    """Largest Green strain of a cotton sheet of 1 m that hangs at rest by two corners."""
    scene = stark.Scene()
    mesh = stark.mesh.grid(1.0, 1.0, cells=cells)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    cotton = stark.materials.cotton.replace(mass_damping=2.0, **changes)
    cloth = scene.add_cloth(mesh, cotton, pins=(np.abs(np.abs(x) - 0.5) < 1e-9) & (np.abs(y - 0.5) < 1e-9))
    sim = stark.Simulation(scene, time_step=1 / 30, **{"contact.enabled": False})
    assert not sim.run_until(4.0).failed
    return largest_green_strain(mesh, cloth.positions)


def test_sheets_that_hang_by_corners_keep_their_limit() -> None:
    """The stress at a corner grows as the mesh is refined; a cubic alone lets strains grow with it."""
    strains = [hung_by_corners(25), hung_by_corners(50)]
    assert max(strains) < 1.5 * LIMIT
    published = hung_by_corners(50, strain_limit_hardening=0.0)
    assert published > 1.5 * LIMIT
    validate("V11.corner", strains)
    validate("V11.corner_as_published", published)


def test_a_limit_on_edges_warns_of_free_directions() -> None:
    scene = stark.Scene()
    edges = stark.materials.cotton.replace(strain_limit_law="edges")
    with pytest.warns(stark.StarkWarning, match=r"leave a direction free on 100 % .* stretch by 41 %"):
        scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells=4), edges)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.add_cloth(stark.mesh.grid(1.0, 1.0, cells=4), stark.materials.cotton, position=(0, 0, 1))
        scene.add_cloth(stark.mesh.sphere(1.0, 2), edges, position=(0, 0, 4))


# --- V12: balloon ---

MU, LAMBDA = 1 / 2.6, 0.3 / (1 - 0.09)  # over E, plane stress, Poisson's ratio 0.3
STRETCHES = (1.05, 1.1, 1.2, 1.4, 1.7, 2.0)


@stark.energy
def pressure(t: stark.Triangle, p: float = stark.parameter(unit="Pa")):
    """-p V, the volume of a closed surface as a sum of tetrahedra over the origin."""
    return -p * (t.center @ t.area_vector) / 3


@stark.energy
def radius(p: stark.Point, target: float, stiffness: float):
    """Springs towards a sphere about the origin."""
    return 0.5 * stiffness * (stark.norm(p.x) - target) ** 2


def closed_form(stretch: float) -> float:
    """p R / (E h) of a balloon of the logarithmic law (theory eq. 11)."""
    return (2 * MU * (stretch - 1 / stretch) + 4 * LAMBDA * np.log(stretch) / stretch) / stretch**2


def balloon(stretch: float, poissons_ratio: float = 0.3) -> tuple[stark.Scene, Any]:
    """R = E h = 1, stretched to begin with."""
    sphere = stark.mesh.sphere(1.0, 3)
    material = stark.ShellMaterial(
        youngs_modulus=1e3,
        thickness=1e-3,
        poissons_ratio=poissons_ratio,
        density=1.0,
        bending_stiffness=1e-9,
    )
    scene = stark.Scene()
    skin = scene.add_cloth(sphere, material, initial_positions=stretch * sphere.vertices, self_contact=False)
    return scene, skin


def held_pressure(stretch: float, poissons_ratio: float = 0.3) -> float:
    """Pressure of a balloon that stiff springs hold at a stretch: their force over its area."""
    scene, skin = balloon(stretch, poissons_ratio)
    springs = scene.add(radius(skin.vertices, target=stretch, stiffness=1e4))
    sim = simulate(scene, 1.0, gravity=(0, 0, 0), **STATIC)
    report = sim.step()
    assert report.status == "accepted", report.message
    forces = np.linalg.norm(springs.forces.reshape(-1, 3), axis=1)
    return float(forces.sum() / stark.TriangleMesh(skin.positions, skin.triangles).area)


def test_balloon_held_at_a_stretch_presses_as_the_law_says() -> None:
    validate("V12.pressure", [held_pressure(a) for a in STRETCHES])
    best = minimize_scalar(
        lambda a: -held_pressure(a), bounds=(1.4, 1.7), method="bounded", options={"xatol": 1e-3}
    )
    validate("V12.limit_stretch", best.x)
    validate("V12.limit_pressure", -best.fun)


@pytest.mark.parametrize(
    ("poissons_ratio", "limit", "at"), [(0.0, 0.385, 1.73), (0.3, 0.445, 1.56), (0.49, 0.558, 1.49)]
)
def test_the_limit_of_a_balloon_depends_on_poissons_ratio(
    poissons_ratio: float, limit: float, at: float
) -> None:
    """The numbers of the guide to energies."""
    below, pressed, above = (held_pressure(at * s, poissons_ratio) for s in (0.96, 1.0, 1.04))
    assert pressed == pytest.approx(limit, abs=1e-3) and pressed > max(below, above)


def blown(start: float, p: float, **settings: Any) -> tuple[stark.Simulation, Any]:
    """A balloon under constant pressure. Springs of 1e-6 of its stiffness keep it from drifting."""
    scene, skin = balloon(start)
    scene.add(pressure(skin.faces, p=p))
    scene.add(radius(skin.vertices, target=start, stiffness=1e-8))
    return simulate(scene, 0.5, gravity=(0, 0, 0), **settings), skin


def mean_radius(skin: Any) -> float:
    return float(np.linalg.norm(skin.positions, axis=1).mean())


def test_balloon_under_pressure_stretches_as_the_law_says() -> None:
    measured = []
    for stretch in STRETCHES[:4]:  # below the limit point
        sim, skin = blown(stretch - 0.01, closed_form(stretch), **STATIC)
        report = sim.step()
        assert report.status == "accepted", report.message
        measured.append(mean_radius(skin))
    validate("V12.stretch", measured)


def test_balloon_grows_without_bound_beyond_its_limit_point() -> None:
    """Implicit Euler damps: at 98 % of the limit pressure it comes to rest, at 102 % it does not."""
    limit = closed_form(minimize_scalar(lambda a: -closed_form(a), bounds=(1.3, 2.0), method="bounded").x)
    below = brentq(lambda a: closed_form(a) - 0.98 * limit, 1.2, 1.55)
    for share in (0.98, 1.02):
        sim, skin = blown(1.38, share * limit)
        for report in sim.run(30.0):
            assert not report.failed, report.message
            if mean_radius(skin) > 2.2:
                break
        if share < 1.0:
            assert mean_radius(skin) == pytest.approx(below, rel=0.01)
        else:
            assert mean_radius(skin) > 2.2


# --- Hencky: a disc whose rim is held bulges under pressure ---


def hencky(ratio: float) -> tuple[float, float]:
    """Height of the middle over a (p a/(E t))^(1/3), its stress over (E p^2 a^2/t^2)^(1/3) [Hencky 1915]."""
    stresses = [1.0, -1.0, -2 / 3, -13 / 18, -17 / 18, -37 / 27, -1205 / 567]
    heights = [1.0, 1 / 2, 5 / 9, 55 / 72, 7 / 6, 205 / 108, 17051 / 5292]

    def stretch_at_rim(b: float) -> float:
        return sum((2 * n + 1 - ratio) * c * b ** (1 - 3 * n) for n, c in enumerate(stresses))

    b = brentq(stretch_at_rim, 1.5, 3.0)
    return sum(c * b ** (-1 - 3 * n) for n, c in enumerate(heights)), b / 4.0


def disc(rings: int) -> tuple[stark.TriangleMesh, int]:
    """A disc of 1 m of rings of vertices about the first one, and the vertices of its rim."""
    turns = [np.arange(6 * k) * 2 * np.pi / (6 * k) for k in range(1, rings + 1)]
    flat = np.vstack(
        [(0.0, 0.0)] + [k / rings * np.column_stack((np.cos(t), np.sin(t))) for k, t in enumerate(turns, 1)]
    )
    triangles = Delaunay(flat).simplices
    (ax, ay), (bx, by) = (np.moveaxis(flat[triangles[:, k]] - flat[triangles[:, 0]], 1, 0) for k in (1, 2))
    areas = ax * by - ay * bx
    triangles = np.where((areas < 0.0)[:, None], triangles[:, ::-1], triangles)[abs(areas) > 1e-9]
    return stark.TriangleMesh(np.column_stack((flat, 0.0 * flat[:, 0])), triangles), 6 * rings


def test_a_disc_bulges_as_henckys() -> None:
    modulus, thickness, ratio, pressure = 1e7, 1e-3, 0.3, 0.1
    mesh, rim = disc(24)
    film = stark.materials.membrane_st_venant_kirchhoff(
        youngs_modulus=modulus, poissons_ratio=ratio, thickness=thickness, density=0.2, bending_stiffness=0.0
    )
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    start = mesh.vertices + np.outer(0.02 * (x**2 + y**2 - 1.0), [0, 0, 1])
    scene = stark.Scene()
    pins = np.arange(len(x) - rim, len(x))
    sheet = scene.add_cloth(mesh, film, pins=pins, initial_positions=start, name="sheet")
    scene.add_face_pressure(sheet, pressure)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), settings=STATIC)
    sim.run_until(3 * sim.time_step)
    height, stress = hencky(ratio)
    validate("hencky.height", -sheet.positions[0, 2] / np.cbrt(pressure / modulus / thickness) / height)
    found = stark.render.tensor_values(sim, "stress")["sheet"][0]
    scale = np.cbrt(modulus * (pressure / thickness) ** 2)
    validate("hencky.stress", np.linalg.eigvalsh(np.reshape(found, (3, 3)))[1:] / scale / stress)
    assert sheet.pin_forces.sum(axis=0) == pytest.approx([0, 0, np.pi * pressure], rel=5e-3, abs=1e-6)


@pytest.mark.parametrize(
    ("side", "modulus", "cells"), [(0.01, 1e6, 16), (0.1, 1e5, 24), (0.1, 1e7, 32), (0.01, 1e7, 32)]
)
def test_a_flat_sheet_without_bending_finds_its_sag(side: float, modulus: float, cells: int) -> None:
    """Nothing holds it across its plane at first, so that Newton directions are as long as rounding has them.
    The sag of a membrane, w = 0.72 a (ρ g a/E)^(1/3) for ν = 0.3, does not know its thickness."""
    scene, mesh = stark.Scene(), stark.mesh.grid(side, side, cells)
    sheet = stark.ShellMaterial(
        density=side, thickness=1e-3 * side, youngs_modulus=modulus, poissons_ratio=0.3, bending_stiffness=0.0
    )
    rim = (np.abs(mesh.vertices[:, :2]) > 0.499 * side).any(axis=1)
    body = scene.add_cloth(mesh, sheet, pins=np.flatnonzero(rim))
    sim = stark.Simulation(scene, settings={"time.integrator": "quasistatic"})
    report = sim.step()
    assert not report.failed, report.message
    assert report.newton_iterations < 20 and report.rejected_steps == 0
    half = 0.5 * side
    share = -body.positions[:, 2].min() / (half * (1e3 * 9.81 * half / modulus) ** (1.0 / 3.0))
    assert share == pytest.approx(0.724, rel=0.005)
