"""Order of convergence in space of every law, against exact solutions: manufactured ones of solids and
membranes, with loads that the laws written by hand ask for, waves of plates, closed forms of rods."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _validation import validate
from test_shells import irregular

import stark
from stark import materials

STATIC = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-11,
    "newton.acceleration_tolerance": 1e-9,
}
E, NU = 1e3, 0.3  # [Pa]
MU = E / (2 * (1 + NU))
LAMBDA = E * NU / ((1 + NU) * (1 - 2 * NU))
PLANE = E * NU / (1 - NU**2)  # lambda of plane stress
C10, C01, BULK = 0.15 * E, 0.05 * E, 2.0 * E
K1, K2, FIBER = 0.3 * E, 0.5, np.array([0.0, 0.6, 0.8])
WARP, WEFT, SHEAR = E, 0.4 * E, 0.2 * E

Stress = Callable[[np.ndarray], np.ndarray]  # first Piola-Kirchhoff of a deformation gradient


@stark.energy
def dead_load(p: stark.Point, force: stark.Vec3):
    """A force that keeps its direction [N]."""
    return -stark.dot(force, p.x)


def settled(scene: stark.Scene, **settings: Any) -> stark.Simulation:
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), **{**STATIC, **settings})
    report = sim.step()
    assert report.status == "accepted", report.message
    return sim


def order(errors: list[float]) -> float:
    """Of the errors on a mesh and on one that is twice as fine."""
    return float(np.log2(errors[0] / errors[1]))


# --- solids ---


def scalar(values: np.ndarray) -> np.ndarray:
    """To be multiplied with matrices."""
    return values[..., None, None]


def transposed(F: np.ndarray) -> np.ndarray:
    return np.swapaxes(F, -1, -2)


def det(F: np.ndarray) -> np.ndarray:
    return scalar(np.linalg.det(F))


def trace(C: np.ndarray) -> np.ndarray:
    return scalar(np.trace(C, axis1=-2, axis2=-1))


def cofactor_over_det(F: np.ndarray) -> np.ndarray:
    return transposed(np.linalg.inv(F))


def stable_neo_hookean(F: np.ndarray) -> np.ndarray:
    mu, lam, J = 4 / 3 * MU, LAMBDA + 5 / 6 * MU, det(F)
    alpha = 1 + 0.75 * mu / lam
    return mu * (1 - 1 / (1 + trace(transposed(F) @ F))) * F + lam * (J - alpha) * J * cofactor_over_det(F)


def neo_hookean(F: np.ndarray) -> np.ndarray:
    return MU * (F - cofactor_over_det(F)) + LAMBDA * np.log(det(F)) * cofactor_over_det(F)


def st_venant_kirchhoff(F: np.ndarray) -> np.ndarray:
    G = (transposed(F) @ F - np.eye(3)) / 2
    return F @ (2 * MU * G + LAMBDA * trace(G) * np.eye(3))


def corotated(F: np.ndarray) -> np.ndarray:
    left, _, right = np.linalg.svd(F)
    return 2 * MU * (F - left @ right) + LAMBDA * (det(F) - 1) * det(F) * cofactor_over_det(F)


def mooney_rivlin(F: np.ndarray) -> np.ndarray:
    C, J, inverse = transposed(F) @ F, det(F), cofactor_over_det(F)
    first, second = trace(C), (trace(C) ** 2 - trace(C @ C)) / 2
    one = C10 * J ** (-2 / 3) * (2 * F - 2 / 3 * first * inverse)
    two = C01 * J ** (-4 / 3) * (2 * first * F - 2 * F @ C - 4 / 3 * second * inverse)
    return one + two + BULK * (J - 1) * J * inverse


def fiber_reinforced(F: np.ndarray) -> np.ndarray:
    f = F @ FIBER
    excess = scalar(np.sum(f * f, axis=-1) - 1)
    assert np.all(excess > 0.0)
    fibers = f[..., :, None] * FIBER
    return stable_neo_hookean(F) + 2 * K1 * excess * np.exp(K2 * excess**2) * fibers


def isotropic(law: Callable[..., Any]) -> Any:
    return law(youngs_modulus=E, poissons_ratio=NU, density=1.0)


SOLIDS: dict[str, tuple[Stress, Any]] = {
    "stable_neo_hookean": (stable_neo_hookean, isotropic(stark.SolidMaterial)),
    "neo_hookean": (neo_hookean, isotropic(materials.neo_hookean)),
    "st_venant_kirchhoff": (st_venant_kirchhoff, isotropic(materials.st_venant_kirchhoff)),
    "corotated": (corotated, isotropic(materials.corotated)),
    "mooney_rivlin": (mooney_rivlin, materials.mooney_rivlin(c10=C10, c01=C01, bulk_modulus=BULK)),
    "fiber_reinforced": (
        fiber_reinforced,
        materials.fiber_reinforced(
            youngs_modulus=E,
            poissons_ratio=NU,
            fiber_stiffness=K1,
            fiber_exponent=K2,
            fiber_direction=FIBER,
        ),
    ),
}


def stretched_and_bent(X: np.ndarray) -> np.ndarray:
    """A map of the unit cube with strains of a quarter, and longer along the fibres everywhere."""
    x, y, z = np.moveaxis(np.asarray(X), -1, 0)
    u = (
        0.1 * np.sin(2 * y) * z,
        0.15 * y + 0.08 * np.sin(2 * x + 1) * np.cos(z),
        0.25 * z + 0.1 * np.cos(2 * x) * np.sin(y + 0.5),
    )
    return X + np.stack(u, axis=-1)


def gradient(of: Callable[[np.ndarray], np.ndarray], X: np.ndarray, dim: int = 3) -> np.ndarray:
    """Last index: the derivative, by differences of fourth order."""
    h = 1e-3
    columns = []
    for step in h * np.eye(3)[:dim]:
        near, far = of(X + step) - of(X - step), of(X + 2 * step) - of(X - 2 * step)
        columns.append((8 * near - far) / (12 * h))
    return np.stack(columns, axis=-1)


def body_force(stress: Stress, shape: Callable[[np.ndarray], np.ndarray], X: np.ndarray) -> np.ndarray:
    """- Div P [N/m^3]."""
    return -np.trace(gradient(lambda Y: stress(gradient(shape, Y)), X), axis1=-2, axis2=-1)


def error_of_solid(law: str, cells: int) -> float:
    """Largest distance from the exact solution [m] of a cube that is held at its boundary."""
    stress, material = SOLIDS[law]
    mesh = stark.mesh.box_hexahedra(1.0, cells)
    X = mesh.vertices
    exact = stretched_and_bent(X)
    inside = np.flatnonzero((np.abs(X) < 0.4999).all(axis=1))
    pins = np.setdiff1d(np.arange(len(X)), inside)
    scene = stark.Scene()
    body = scene.add_solid(mesh, material, initial_positions=exact, pins=pins, self_contact=False)
    force = body_force(stress, stretched_and_bent, X[inside]) / cells**3
    scene.add(dead_load(body.vertices[inside], force=force))
    sim = settled(scene)
    return float(np.linalg.norm(sim[body].positions - exact, axis=1).max())


@pytest.mark.parametrize("law", SOLIDS)
def test_solid_laws_converge_in_space(law: str) -> None:
    validate(f"space.{law}", order([error_of_solid(law, n) for n in (4, 8)]))


# --- membranes ---


def in_plane(F: np.ndarray) -> np.ndarray:
    return F[..., :2, :2]


def membrane(F: np.ndarray) -> np.ndarray:
    return MU * (F - cofactor_over_det(F)) + PLANE * np.log(det(F)) * cofactor_over_det(F)


def membrane_st_venant_kirchhoff(F: np.ndarray) -> np.ndarray:
    G = (transposed(F) @ F - np.eye(2)) / 2
    return F @ (2 * MU * G + PLANE * trace(G) * np.eye(2))


def orthotropic_cloth(F: np.ndarray) -> np.ndarray:
    G = (transposed(F) @ F - np.eye(2)) / 2
    coupling = NU * np.sqrt(WARP * WEFT)
    S = np.empty_like(G)
    S[..., 0, 0] = (WARP * G[..., 0, 0] + coupling * G[..., 1, 1]) / (1 - NU**2)
    S[..., 1, 1] = (WEFT * G[..., 1, 1] + coupling * G[..., 0, 0]) / (1 - NU**2)
    S[..., 0, 1] = S[..., 1, 0] = 2 * SHEAR * G[..., 0, 1]
    return F @ S


def thin(law: Callable[..., Any], **options: Any) -> Any:
    return law(thickness=1.0, bending_stiffness=0.0, density=1.0, **options)


MEMBRANES: dict[str, tuple[Stress, Any]] = {
    "membrane": (membrane, thin(stark.ShellMaterial, youngs_modulus=E, poissons_ratio=NU)),
    "membrane_st_venant_kirchhoff": (
        membrane_st_venant_kirchhoff,
        thin(materials.membrane_st_venant_kirchhoff, youngs_modulus=E, poissons_ratio=NU),
    ),
    "orthotropic_cloth": (
        orthotropic_cloth,
        thin(
            materials.orthotropic_cloth,
            warp_direction=(1, 0, 0),
            warp_modulus=WARP,
            weft_modulus=WEFT,
            shear_modulus=SHEAR,
            poissons_ratio=NU,
        ),
    ),
}


def stretched_in_plane(X: np.ndarray) -> np.ndarray:
    """Longer in all directions, so that the sheet stays flat."""
    x, y = X[..., 0], X[..., 1]
    u = 0.3 * x + 0.1 * np.sin(2 * y + 0.5) * np.cos(x), 0.25 * y + 0.08 * np.sin(2 * x + 1) * np.cos(y)
    return X + np.stack([*u, np.zeros_like(x)], axis=-1)


def error_of_membrane(law: str, cells: int) -> float:
    """Largest distance from the exact solution [m] of a square that is held at its boundary."""
    stress, material = MEMBRANES[law]
    mesh = stark.mesh.grid(1.0, 1.0, cells)
    X = mesh.vertices
    exact = stretched_in_plane(X)
    inside = np.flatnonzero((np.abs(X[:, :2]) < 0.4999).all(axis=1))
    pins = np.setdiff1d(np.arange(len(X)), inside)
    scene = stark.Scene()
    sheet = scene.add_cloth(mesh, material, initial_positions=exact, pins=pins, self_contact=False)
    divergence = gradient(lambda Y: stress(in_plane(gradient(stretched_in_plane, Y))), X[inside], 2)
    force = np.zeros((len(inside), 3))
    force[:, :2] = -np.trace(divergence, axis1=-2, axis2=-1) / cells**2
    scene.add(dead_load(sheet.vertices[inside], force=force))
    sim = settled(scene)
    return float(np.linalg.norm(sim[sheet].positions - exact, axis=1).max())


@pytest.mark.parametrize("law", MEMBRANES)
def test_membrane_laws_converge_in_space(law: str) -> None:
    validate(f"space.{law}", order([error_of_membrane(law, n) for n in (8, 16)]))


# --- bending of shells ---

K = 3.0  # [1/m]
# Hinges on a structured grid bend as an orthotropic plate, k/2 (3 (xx + xy)^2 + 3 (yy + xy)^2 + 12 xy^2) for
# diagonals along (1, 1): a wave exp(K (x + r y)) needs no load if (1 + r^2) (1 + r)^2 + 4 r^2 = 0.
ACROSS = np.roots([1.0, 2.0, 6.0, 2.0, 1.0])[0]


def hinge_wave(X: np.ndarray, diagonal: float) -> np.ndarray:
    return np.real(np.exp(K * (X[:, 0] + diagonal * ACROSS * X[:, 1])))


def plate_wave(X: np.ndarray, _: float) -> np.ndarray:
    """Harmonic, and so without load in every isotropic plate."""
    return np.exp(K * X[:, 0]) * np.cos(K * X[:, 1])


def bending(**stiffness: float) -> stark.ShellMaterial:
    # Stiff enough in its plane that bending does not move it there, thin enough that it does not stretch.
    return stark.ShellMaterial(density=1.0, thickness=1e-3, youngs_modulus=1e3, **stiffness)


HINGE, PLATE = bending(bending_stiffness=1.0), bending(flexural_rigidity=1.0)
Wave = Callable[[np.ndarray, float], np.ndarray]
BENDING: dict[str, tuple[stark.ShellMaterial, str, Wave, Callable[[int], stark.TriangleMesh]]] = {
    "hinge_flat": (HINGE, "flat", hinge_wave, lambda n: stark.mesh.grid(1.0, 1.0, n)),
    "hinge_mesh": (HINGE, "mesh", hinge_wave, lambda n: stark.mesh.grid(1.0, 1.0, n)),
    "plate": (PLATE, "flat", plate_wave, lambda n: stark.mesh.grid(1.0, 1.0, n)),
    "plate_irregular": (PLATE, "flat", plate_wave, irregular),
}


def error_of_bending(law: str, cells: int, free: float = 0.299) -> float:
    """Of a wave of 10 micrometres, held outside of a square of 2 ``free`` [m]."""
    material, rest_angles, wave, make = BENDING[law]
    mesh = make(cells)
    X = mesh.vertices
    corners = X[mesh.triangles[0]]
    longest = max(np.roll(corners, 1, axis=0) - corners, key=np.linalg.norm)
    height = 1e-5 * wave(X, np.sign(longest[0] * longest[1]))
    held = np.abs(X[:, :2]).max(axis=1) > free
    start = np.column_stack([X[:, :2], height * held])
    scene = stark.Scene()
    sheet = scene.add_cloth(
        mesh, material, initial_positions=start, rest_angles=rest_angles, pins=held, self_contact=False
    )
    # The smallest mass is that of 0.1 g.
    sim = settled(scene, **{"newton.acceleration_tolerance": 1e-4, "newton.step_tolerance": 1e-9})
    return float(np.abs(sim[sheet].positions[:, 2] - height).max())


@pytest.mark.parametrize("law", BENDING)
def test_bending_laws_converge_in_space(law: str) -> None:
    validate(f"space.{law}", order([error_of_bending(law, n) for n in (20, 40)]))


def test_a_plate_that_is_clamped_by_two_rows_of_vertices_is_of_first_order() -> None:
    """Triangles at the border have no angles of their own: the clamp is felt over part of a cell."""
    errors = [error_of_bending("plate", n, free=0.5 - 1.02 / n) for n in (32, 64)]
    validate("space.plate_clamp", order(errors))


# --- rods ---

THICK = stark.RodMaterial(density=1000.0, youngs_modulus=1e6, radius=0.05)


def error_of_stretch(segments: int) -> float:
    """A bar of 1 m under a pull of sin(pi x) N/m: EA u'' = -sin(pi x)."""
    scene = stark.Scene()
    line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), segments)
    rod = scene.add_rod(line, THICK, clamps=[0], self_contact=False)
    x = line.vertices[:, 0]
    force = np.column_stack([np.sin(np.pi * x) / segments, 0 * x, 0 * x])
    scene.add(dead_load(rod.vertices[np.arange(1, segments + 1)], force=force[1:]))
    sim = settled(scene)
    stiffness = THICK.section["axial_stiffness"] * np.pi
    exact = (np.sin(np.pi * x) / np.pi + x) / stiffness
    return float(np.abs(sim[rod].positions[:, 0] - x - exact).max())


def error_of_deflection(segments: int) -> float:
    """A short cantilever of Timoshenko under a small load at its end, a third of whose deflection is shear;
    relative."""
    length, force = 0.1, 1e-4
    scene = stark.Scene()
    line = stark.mesh.polyline((0, 0, 0), (length, 0, 0), segments)
    rod = scene.add_rod(line, THICK, clamps=[0], self_contact=False)
    scene.add(dead_load(rod.vertices[segments], force=(0.0, 0.0, force)))
    sim = settled(scene)
    section = THICK.section
    exact = (
        force * length**3 / (3 * section["bending_stiffness_1"]) + force * length / section["shear_stiffness"]
    )
    return abs(float(sim[rod].positions[-1, 2] / exact) - 1.0)


def error_of_twist(segments: int) -> float:
    """Energy of a twist of 1.2 rad, relative."""
    scene = stark.Scene()
    line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), segments)
    rod = scene.add_rod(line, THICK, clamps=[0, segments], self_contact=False)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    start = sim[rod].clamp_targets
    targets = start.copy()
    targets[1] = stark.rotation(axis="x", angle=1.2) @ start[1]
    rod.clamp_targets = targets
    report = sim.step()
    assert report.status == "accepted", report.message
    return abs(report.energy["elastic"] / (0.5 * THICK.section["torsional_stiffness"] * 1.2**2) - 1.0)


RODS = {"rod_stretch": error_of_stretch, "rod_deflection": error_of_deflection, "rod_twist": error_of_twist}


@pytest.mark.parametrize("law", RODS)
def test_rods_converge_in_space(law: str) -> None:
    validate(f"space.{law}", order([RODS[law](n) for n in (5, 10)]))
