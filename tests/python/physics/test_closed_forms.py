"""Time integrators and material laws against closed forms that hold to rounding: V02, V03, V04."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _validation import validate
from scipy.optimize import brentq

import stark
from stark import materials

G = 9.81  # [m/s^2]
EXACT = {"contact.enabled": False, "newton.acceleration_tolerance": 1e-10, "newton.step_tolerance": 1e-12}
STATIC = {"time.integrator": "quasistatic", "newton.max_iterations": 500, **EXACT}


# --- V02: time integrators ---


@stark.energy
def spring(p: stark.Point, stiffness: float):
    return 0.5 * stiffness * (p.x @ p.x)


def motion(integrator: str, stiffness: float, gravity: float, start: float) -> np.ndarray:
    """Height of 1 kg on a spring from the origin after each of 100 steps of 10 ms [m]."""
    scene = stark.Scene()
    body = scene.add_box(0.1, mass=1.0, position=(0, 0, start))
    if stiffness > 0.0:
        scene.add(spring(body.points((0, 0, 0)), stiffness=stiffness))
    settings = {**EXACT, "time.integrator": integrator}
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, -gravity), **settings)
    heights = []
    for _ in range(100):
        sim.step(max_time_step=0.01)
        heights.append(body.position[2])
    return np.array(heights)


def recursion(integrator: str, acceleration: Callable[[float], float], start: float) -> np.ndarray:
    """The same of the formulas of the integrators, for a_new = acceleration(x) that is affine in x."""
    h, x, v, gain, lag = 0.01, start, 0.0, 0.0, 0.0
    result = []
    slope, constant = acceleration(1.0) - acceleration(0.0), acceleration(0.0)
    for n in range(100):
        second = integrator == "bdf2" and n > 0  # its first step is one of implicit Euler
        s = 2 * h / 3 if second else h
        x_bar, v_bar = (x + h / 3 * (v - lag), v + gain / 3) if second else (x, v)
        x = (x_bar + s * v_bar + s * s * constant) / (1 - s * s * slope)
        v_before, v = v, (x - x_bar) / s
        gain = v - v_before
        lag = (lag + gain) / 3 if second else gain / 2
        result.append(x)
    return np.array(result)


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_integrators_are_their_formulas(integrator: str) -> None:
    fall = motion(integrator, 0.0, G, 0.0)
    swing = motion(integrator, 100.0, 0.0, 1.0)
    validate(f"V02.fall_{integrator}", fall[-1])
    validate(f"V02.oscillator_{integrator}", swing[-1])
    assert fall == pytest.approx(recursion(integrator, lambda _: -G, 0.0), abs=1e-9)
    assert swing == pytest.approx(recursion(integrator, lambda x: -100.0 * x, 1.0), abs=1e-9)


# --- V03: patch test ---


@pytest.mark.parametrize("kind", ["tet4", "tet10", "hex8", "hex27"])
def test_distorted_elements_pass_the_patch_test(kind: str) -> None:
    """A cube of distorted elements whose boundary is moved by an affine map of 10 to 30 % strain; the inner
    nodes start elsewhere and must arrive at the map."""
    coarse = stark.mesh.tet_box(1.0, 4) if "tet" in kind else stark.mesh.box_hexahedra(1.0, 4)
    inside = (np.abs(coarse.vertices) < 0.4999).all(axis=1)
    random = np.random.default_rng(7)
    moved = coarse.vertices + 0.04 * random.uniform(-1, 1, coarse.vertices.shape) * inside[:, None]
    mesh = type(coarse)(moved, coarse.tets if kind.startswith("tet") else coarse.elements)
    if kind in ("tet10", "hex27"):
        mesh = stark.mesh.to_quadratic(mesh)
    F = np.array([[1.2, 0.1, 0.0], [-0.05, 0.9, 0.2], [0.1, 0.0, 1.1]])
    target = mesh.vertices @ F.T
    inside = (np.abs(mesh.vertices) < 0.4999).all(axis=1)
    start = target + 0.01 * random.uniform(-1, 1, target.shape) * inside[:, None]
    scene = stark.Scene()
    material = stark.SolidMaterial(youngs_modulus=1e5, poissons_ratio=0.3)
    body = scene.add_solid(mesh, material, initial_positions=start, pins=~inside, self_contact=False)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    report = sim.step()
    assert report.status == "accepted", report.message
    assert inside.sum() >= 27
    validate(f"V03.{kind}", np.abs(body.positions - target).max())


# --- V04: laws ---

E, NU = 1.0, 0.3
STRETCHES = (0.7, 0.9, 1.1, 1.5)
SHEARS = (0.1, 0.3, 0.6)
C10, C01, BULK = 0.15, 0.05, 2.0
K1, K2 = 0.1, 0.5
Pair = tuple[float, float]


def lame(nu: float) -> Pair:
    return E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))


# Nominal stress along the stretch a and across it, for the stretch b across; then that of simple shear g.


def neo_hookean(a: float, b: float, nu: float = NU) -> Pair:
    mu, lam = lame(nu)
    pressure = lam * np.log(a * b * b)
    return mu * (a - 1 / a) + pressure / a, mu * (b - 1 / b) + pressure / b


def stable(a: float, b: float, nu: float = NU) -> Pair:
    mu, lam = lame(nu)
    mu, lam = 4 / 3 * mu, lam + 5 / 6 * mu
    shear = mu * (1 - 1 / (a * a + 2 * b * b + 1))
    volume = lam * (a * b * b - 1 - 0.75 * mu / lam)
    return shear * a + volume * b * b, shear * b + volume * a * b


def stable_shear(g: float) -> float:
    return 4 / 3 * lame(NU)[0] * g * (1 - 1 / (4 + g * g))


def st_venant(a: float, b: float) -> Pair:
    mu, lam = lame(NU)
    along, across = (a * a - 1) / 2, (b * b - 1) / 2
    trace = lam * (along + 2 * across)
    return a * (2 * mu * along + trace), b * (2 * mu * across + trace)


def corotated(a: float, b: float) -> Pair:
    mu, lam = lame(NU)
    volume = lam * (a * b * b - 1)
    return 2 * mu * (a - 1) + volume * b * b, 2 * mu * (b - 1) + volume * a * b


def corotated_shear(g: float) -> float:
    s = g / 2 + np.sqrt(g * g / 4 + 1)  # the larger principal stretch; the other is 1/s
    return 2 * lame(NU)[0] * (s - 1 + (1 - 1 / s) / s**2) / (1 + 1 / s**2)


def mooney_rivlin(a: float, b: float) -> Pair:
    J = a * b * b
    first, second = a * a + 2 * b * b, 2 * a * a * b * b + b**4
    bulk = BULK * (J - 1) * J
    one, two = C10 * J ** (-2 / 3), C01 * J ** (-4 / 3)
    along = one * (2 * a - 2 / 3 * first / a) + two * (4 * a * b * b - 4 / 3 * second / a) + bulk / a
    across = one * (2 * b - 2 / 3 * first / b) + two * (2 * (a * a * b + b**3) - 4 / 3 * second / b)
    return along, across + bulk / b


def fiber_reinforced(a: float, b: float) -> Pair:
    excess = max(a * a - 1, 0.0)
    along, across = stable(a, b)
    return along + 2 * K1 * a * excess * np.exp(K2 * excess**2), across


mu, lam = lame(NU)
LAWS: dict[str, tuple[Any, Callable[[float, float], Pair], Callable[[float], float]]] = {
    "stable_neo_hookean": (stark.SolidMaterial, stable, stable_shear),
    "neo_hookean": (materials.neo_hookean, neo_hookean, lambda g: mu * g),
    "st_venant_kirchhoff": (
        materials.st_venant_kirchhoff,
        st_venant,
        lambda g: mu * (g + g**3) + lam * g**3 / 2,
    ),
    "corotated": (materials.corotated, corotated, corotated_shear),
    "mooney_rivlin": (materials.mooney_rivlin, mooney_rivlin, lambda g: 2 * (C10 + C01) * g),
    "fiber_reinforced": (
        materials.fiber_reinforced,
        fiber_reinforced,
        lambda g: stable_shear(g) + 2 * K1 * g**3 * np.exp(K2 * g**4),
    ),
}


def material(law: str, nu: float) -> stark.SolidMaterial:
    if law == "mooney_rivlin":
        return materials.mooney_rivlin(c10=C10, c01=C01, bulk_modulus=BULK, density=1.0)
    fibers = {"fiber_stiffness": K1, "fiber_exponent": K2, "fiber_direction": (0, 0, 1)}
    options = fibers if law == "fiber_reinforced" else {}
    return LAWS[law][0](youngs_modulus=E, poissons_ratio=nu, density=1.0, **options)


@stark.energy
def support(p: stark.Point, target: stark.Vec3, stiffness: stark.Vec3):
    """Springs along the three axes."""
    d = p.x - target
    return 0.5 * (stiffness[0] * d[0] ** 2 + stiffness[1] * d[1] ** 2 + stiffness[2] * d[2] ** 2)


def deform(law: str, F: np.ndarray, held: np.ndarray, nu: float = NU) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the corners of a unit cube, and the forces that hold them (8, 3). `held` says which
    coordinates of which corner follow F; springs of 1e8 E hold them to 1e-8."""
    mesh = stark.mesh.box_hexahedra(1.0, 1).translated((0.5, 0.5, 0.5))
    scene = stark.Scene()
    # Starts deformed: with springs as stiff as these, Newton's way there would be long.
    target = mesh.vertices @ F.T
    body = scene.add_solid(mesh, material(law, nu), initial_positions=target, self_contact=False)
    supports = scene.add(support(body.vertices, target=target, stiffness=1e8 * held))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    report = sim.step()
    assert report.status == "accepted", report.message
    return body.positions, supports.forces.reshape(8, 3)


def pull(law: str, stretch: float, nu: float = NU) -> Pair:
    """Nominal stress over E, and the stretch across."""
    corner = stark.mesh.box_hexahedra(1.0, 1).vertices + 0.5
    held = np.column_stack([corner[:, 0] < 0.5, corner[:, 1] < 0.5, np.ones(8)]).astype(float)
    guess = stretch**-nu  # across, what linear elasticity says of logarithms
    x, forces = deform(law, np.diag([guess, guess, stretch]), held, nu)
    top = corner[:, 2] > 0.5
    assert np.ptp(x[top, 2]) < 2e-8
    assert x[top, 2].mean() == pytest.approx(stretch, abs=2e-8)
    return float(forces[top, 2].sum()), float(np.ptp(x[:, 0]))


@pytest.mark.parametrize("law", LAWS)
def test_uniaxial_stress_of_every_law(law: str) -> None:
    measured = np.array([pull(law, a) for a in STRETCHES])
    closed_form = LAWS[law][1]
    across = [brentq(lambda b, a=a: closed_form(a, b)[1], 0.5, 1.6, xtol=1e-14) for a in STRETCHES]
    stress = [closed_form(a, b)[0] for a, b in zip(STRETCHES, across, strict=True)]
    assert measured[:, 0] == pytest.approx(stress, abs=1e-7)
    assert measured[:, 1] == pytest.approx(across, abs=1e-7)
    validate(f"V04.pull_{law}", measured[:, 0])


@pytest.mark.parametrize("law", ["stable_neo_hookean", "neo_hookean"])
def test_uniaxial_stress_of_a_nearly_incompressible_law(law: str) -> None:
    closed_form = {"stable_neo_hookean": stable, "neo_hookean": neo_hookean}[law]
    measured = np.array([pull(law, a, 0.45) for a in STRETCHES])
    across = [brentq(lambda b, a=a: closed_form(a, b, 0.45)[1], 0.5, 1.6, xtol=1e-14) for a in STRETCHES]
    assert measured[:, 1] == pytest.approx(across, abs=1e-7)
    validate(f"V04.pull_045_{law}", measured[:, 0])


@pytest.mark.parametrize("law", LAWS)
def test_simple_shear_of_every_law(law: str) -> None:
    top = stark.mesh.box_hexahedra(1.0, 1).vertices[:, 2] > 0.0
    measured = []
    for g in SHEARS:
        _, forces = deform(law, np.array([[1, 0, g], [0, 1, 0], [0, 0, 1.0]]), np.ones((8, 3)))
        measured.append(forces[top, 0].sum())
    assert measured == pytest.approx([LAWS[law][2](g) for g in SHEARS], abs=1e-7)
    validate(f"V04.shear_{law}", measured)
