"""The built-in potentials once more, in Python: points, operations and their order as in src/stark."""

from __future__ import annotations

import math

from friction_copies import *  # noqa: F403
from limit_copies import edge_strain_limit, membrane_strain_limit, strain_limit  # noqa: F401
from restitution_copies import *  # noqa: F403
from yielding_copies import *  # noqa: F403
from yielding_copies import fold_angle

import stark
from stark.loads.formulas import pressure  # noqa: F401  (the one of the package)


@stark.energy
def point_inertia(
    p: stark.Point,
    h: stark.TimeStep,
    mass: float,
    predicted: stark.Vec3,
    damping: float,
    inverse_scale_squared: float,
):
    inertia = inverse_scale_squared * stark.squared_norm(p.x - predicted)
    drag = damping / h * stark.squared_norm(p.x - p.x_prev)
    return 0.5 * mass * (inertia + drag)


@stark.energy
def gravity(p: stark.Point, mass: float, gravity: stark.Vec3):
    return -(mass * stark.dot(gravity, p.x))


def quadratic_energy(s: stark.Hinge, bending_stiffness: float) -> stark.Scalar:
    def cotangent(a: stark.Vec, b: stark.Vec) -> stark.Scalar:
        return stark.dot(a, b) / stark.norm(stark.cross(a, b))

    X = [p.X for p in s]
    e, a0, b0 = X[1] - X[0], X[2] - X[0], X[3] - X[0]
    a1, b1 = X[2] - X[1], X[3] - X[1]
    a_at_0, b_at_0 = cotangent(e, a0), cotangent(e, b0)
    a_at_1, b_at_1 = cotangent(-e, a1), cotangent(-e, b1)
    weights = [a_at_1 + b_at_1, a_at_0 + b_at_0, -(a_at_0 + a_at_1), -(b_at_0 + b_at_1)]
    curvature = weights[0] * s[0].x
    for i in range(1, 4):
        curvature = curvature + weights[i] * s[i].x
    return 0.5 * bending_stiffness * stark.squared_norm(curvature)


@stark.energy
def flat_bending(s: stark.Hinge, bending_stiffness: float):
    return quadratic_energy(s, bending_stiffness) * s.rest_weight


@stark.energy
def damped_flat_bending(s: stark.Hinge, h: stark.TimeStep, bending_stiffness: float, bending_damping: float):
    viscous = 0.5 * bending_damping / h * (s.angle - s.angle_prev) ** 2
    whole = quadratic_energy(s, bending_stiffness) + viscous * stark.squared_norm(s.rest_edge)
    return whole * s.rest_weight


@stark.energy
def discrete_shell_bending(
    s: stark.Hinge, h: stark.TimeStep, bending_stiffness: float, bending_damping: float
):
    angle = s.angle
    elastic = 0.5 * bending_stiffness * stark.square(angle - s.rest_angle)
    viscous = 0.5 * bending_damping / h * stark.square(angle - s.angle_prev)
    return (elastic + viscous) * s.rest_weight * stark.squared_norm(s.rest_edge)


def plate(s: object, h: object, rigidity: object, damping: object, rest: list, form: dict) -> object:
    hinges = [(0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (0, 3, 1, 6)][: len(rest)]
    angles = [fold_angle(*(s[i].x for i in hinge)) for hinge in hinges]
    bend = [angle - at_rest for angle, at_rest in zip(angles, rest, strict=True)]
    turn = [
        angle - fold_angle(*(s[i].x_prev for i in hinge)) for angle, hinge in zip(angles, hinges, strict=True)
    ]
    elastic, viscous = 0.0, 0.0
    for i in range(len(rest)):
        for j in range(i, len(rest)):
            factor = 0.5 if i == j else 1.0
            elastic = elastic + factor * form[i, j] * bend[i] * bend[j]
            viscous = viscous + factor * form[i, j] * turn[i] * turn[j]
    return rigidity * elastic + damping / h * viscous


@stark.energy
def plate_bending_1(
    s: stark.Stencil[4],
    h: stark.TimeStep,
    flexural_rigidity: float,
    bending_damping: float,
    rest_angle0: float,
    form00: float,
):
    form = {(0, 0): form00}
    return plate(s, h, flexural_rigidity, bending_damping, [rest_angle0], form)


@stark.energy
def plate_bending_2(
    s: stark.Stencil[5],
    h: stark.TimeStep,
    flexural_rigidity: float,
    bending_damping: float,
    rest_angle0: float,
    rest_angle1: float,
    form00: float,
    form01: float,
    form11: float,
):
    form = {(0, 0): form00, (0, 1): form01, (1, 1): form11}
    return plate(s, h, flexural_rigidity, bending_damping, [rest_angle0, rest_angle1], form)


@stark.energy
def plate_bending_3(
    s: stark.Stencil[6],
    h: stark.TimeStep,
    flexural_rigidity: float,
    bending_damping: float,
    rest_angle0: float,
    rest_angle1: float,
    rest_angle2: float,
    form00: float,
    form01: float,
    form02: float,
    form11: float,
    form12: float,
    form22: float,
):
    form = {(0, 0): form00, (0, 1): form01, (0, 2): form02, (1, 1): form11, (1, 2): form12, (2, 2): form22}
    return plate(s, h, flexural_rigidity, bending_damping, [rest_angle0, rest_angle1, rest_angle2], form)


@stark.energy
def plate_bending_4(
    s: stark.Stencil[7],
    h: stark.TimeStep,
    flexural_rigidity: float,
    bending_damping: float,
    rest_angle0: float,
    rest_angle1: float,
    rest_angle2: float,
    rest_angle3: float,
    form00: float,
    form01: float,
    form02: float,
    form03: float,
    form11: float,
    form12: float,
    form13: float,
    form22: float,
    form23: float,
    form33: float,
):
    form = {
        (0, 0): form00,
        (0, 1): form01,
        (0, 2): form02,
        (0, 3): form03,
        (1, 1): form11,
        (1, 2): form12,
        (1, 3): form13,
        (2, 2): form22,
        (2, 3): form23,
        (3, 3): form33,
    }
    return plate(
        s, h, flexural_rigidity, bending_damping, [rest_angle0, rest_angle1, rest_angle2, rest_angle3], form
    )


@stark.energy
def membrane_neo_hookean(t: stark.Triangle, youngs_modulus: float, poissons_ratio: float, thickness: float):
    mu = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    lam = youngs_modulus * poissons_ratio / (1.0 - poissons_ratio * poissons_ratio)
    G, g = t.rest_metric, t.metric
    det_G, det_g = stark.determinant(G), stark.determinant(g)
    I_C = (G[1, 1] * g[0, 0] - 2.0 * G[0, 1] * g[0, 1] + G[0, 0] * g[1, 1]) / det_G
    log_J = 0.5 * stark.log(det_g / det_G)
    psi = 0.5 * mu * (I_C - 2.0) - mu * log_J + 0.5 * lam * stark.square(log_J)
    return psi * thickness * t.rest_area


@stark.energy
def membrane_damping(t: stark.Triangle, h: stark.TimeStep, strain_damping: float):
    G, change = t.rest_metric, t.metric - t.metric_prev
    scale = 1.0 / stark.determinant(G)
    c11 = scale * (G[1, 1] * change[0, 0] - G[0, 1] * change[0, 1])
    c12 = scale * (G[1, 1] * change[0, 1] - G[0, 1] * change[1, 1])
    c21 = scale * (G[0, 0] * change[0, 1] - G[0, 1] * change[0, 0])
    c22 = scale * (G[0, 0] * change[1, 1] - G[0, 1] * change[0, 1])
    squared = 0.25 * (stark.square(c11) + 2.0 * c12 * c21 + stark.square(c22))
    return strain_damping * t.rest_area / (2.0 * h) * squared


# Constitutive laws: psi of F, on tetrahedra and triangles.


def lame(youngs_modulus: object, poissons_ratio: object) -> tuple:
    mu = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    lam = youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio))
    return mu, lam


def plane_stress(youngs_modulus: object, poissons_ratio: object) -> tuple:
    mu = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    return mu, youngs_modulus * poissons_ratio / (1.0 - poissons_ratio * poissons_ratio)


@stark.material
def stable_neo_hookean(F: stark.DeformationGradient, youngs_modulus: float, poissons_ratio: float):
    mu_small, lambda_small = lame(youngs_modulus, poissons_ratio)
    mu = 4.0 / 3.0 * mu_small
    lam = lambda_small + 5.0 / 6.0 * mu_small
    alpha = 1.0 + 0.75 * mu / lam
    I_C, J = stark.squared_norm(F), stark.determinant(F)
    rest = 0.5 * lam * stark.square(1.0 - alpha) - 0.5 * mu * math.log(4.0)
    return (
        0.5 * mu * (I_C - 3.0) + 0.5 * lam * stark.square(J - alpha) - 0.5 * mu * stark.log(I_C + 1.0) - rest
    )


@stark.material
def neo_hookean(F: stark.DeformationGradient, youngs_modulus: float, poissons_ratio: float):
    mu, lam = lame(youngs_modulus, poissons_ratio)
    log_J = stark.log(stark.determinant(F))
    return 0.5 * mu * (stark.squared_norm(F) - 3.0) - mu * log_J + 0.5 * lam * stark.square(log_J)


def green(F: stark.Mat) -> stark.Mat:
    return 0.5 * (F.T @ F - stark.identity(F.shape[1]))


@stark.material
def st_venant_kirchhoff(F: stark.DeformationGradient, youngs_modulus: float, poissons_ratio: float):
    mu, lam = lame(youngs_modulus, poissons_ratio)
    E = green(F)
    return mu * stark.squared_norm(E) + 0.5 * lam * stark.square(stark.trace(E))


@stark.material
def corotated(F: stark.DeformationGradient, youngs_modulus: float, poissons_ratio: float):
    mu, lam = lame(youngs_modulus, poissons_ratio)
    C = F.T @ F
    I1, J = stark.trace(C), stark.determinant(F)
    I2 = (
        C[0, 0] * C[1, 1]
        - stark.square(C[0, 1])
        + C[1, 1] * C[2, 2]
        - stark.square(C[1, 2])
        + C[2, 2] * C[0, 0]
        - stark.square(C[2, 0])
    )
    for invariant in (I1, I2, J):
        stark.symbolic.mark_stage(invariant)
    constant, linear = I1 * I1 - 4.0 * I2, 8.0 * J
    s = 0.5 * (I1 + 3.0)
    for _ in range(7):
        squared = s * s
        f = ((squared - 2.0 * I1) * s - linear) * s + constant
        slope = 4.0 * (squared - I1) * s - linear
        curvature = 12.0 * squared - 4.0 * I1
        s = s - 4.0 * f / (slope + stark.sqrt(9.0 * slope * slope - 12.0 * f * curvature))
    return mu * (I1 - 2.0 * s + 3.0) + 0.5 * lam * stark.square(J - 1.0)


@stark.material
def mooney_rivlin(F: stark.DeformationGradient, c10: float, c01: float, bulk_modulus: float):
    C = F.T @ F
    J, I1 = stark.determinant(F), stark.trace(C)
    I2 = 0.5 * (stark.square(I1) - stark.squared_norm(C))
    isochoric = J ** (-2.0 / 3.0)
    return (
        c10 * (isochoric * I1 - 3.0)
        + c01 * (stark.square(isochoric) * I2 - 3.0)
        + 0.5 * bulk_modulus * stark.square(J - 1.0)
    )


@stark.material(isotropic=False)
def fiber_reinforced(
    F: stark.DeformationGradient,
    youngs_modulus: float,
    poissons_ratio: float,
    fiber_stiffness: float,
    fiber_exponent: float,
    fiber_direction: stark.Vec3,
):
    matrix = stable_neo_hookean(F, youngs_modulus, poissons_ratio)
    stretched = F @ stark.normalized(fiber_direction)
    excess = stark.maximum(stark.squared_norm(stretched) - 1.0, 0.0)
    k1, k2 = fiber_stiffness, fiber_exponent
    return matrix + k1 / (2.0 * k2) * (stark.exp(k2 * stark.square(excess)) - 1.0)


@stark.material
def solid_damping(
    F: stark.DeformationGradient,
    F_prev: stark.DeformationGradient,
    h: stark.TimeStep,
    strain_damping: float,
):
    increment = 0.5 * (F.T @ F - F_prev.T @ F_prev)
    return strain_damping / (2.0 * h) * stark.squared_norm(increment)


@stark.material
def membrane_st_venant_kirchhoff(
    F: stark.ShellDeformationGradient, youngs_modulus: float, poissons_ratio: float
):
    mu, lam = plane_stress(youngs_modulus, poissons_ratio)
    E = green(F)
    return mu * stark.squared_norm(E) + 0.5 * lam * stark.square(stark.trace(E))


@stark.material(isotropic=False)
def orthotropic_cloth(
    F: stark.ShellDeformationGradient,
    warp_modulus: float,
    weft_modulus: float,
    shear_modulus: float,
    poissons_ratio: float,
):
    E1, E2, nu = warp_modulus, weft_modulus, poissons_ratio
    E = green(F)
    stretch = (
        E1 * stark.square(E[0, 0])
        + 2.0 * nu * stark.sqrt(E1 * E2) * E[0, 0] * E[1, 1]
        + E2 * stark.square(E[1, 1])
    )
    return stretch / (2.0 * (1.0 - nu * nu)) + 2.0 * shear_modulus * stark.square(E[0, 1])


# Contact.


def barrier(d: object, kappa: object, d_hat: object, least: object) -> object:
    u = (d - least) / least
    wall = stark.where(u < 1.0, stark.square(d_hat) * stark.square(u - 1.0) * stark.log(u), 0.0)
    return -(kappa * (stark.square(d - d_hat) * stark.log(d / d_hat) + wall))


def mollifier(x: list, threshold: object) -> object:
    c = stark.squared_norm(stark.cross(x[1] - x[0], x[3] - x[2]))
    ratio = c / threshold
    return ratio * (2.0 - ratio)


def point_edge(p: object, a: object, b: object) -> object:
    return stark.norm(stark.cross(a - p, b - p)) / stark.norm(b - a)


def plane_distance(offset: object, normal: object) -> object:
    return stark.abs(stark.dot(offset, normal)) / stark.norm(normal)


def edge_edge(a0: object, a1: object, b0: object, b1: object) -> object:
    return plane_distance(b0 - a0, stark.cross(a1 - a0, b1 - b0))


@stark.energy
def barrier_point_point(
    s: stark.Stencil[2], stiffness: float, contact_distance: float, least_distance: float
):
    return barrier(stark.norm(s[0].x - s[1].x), stiffness, contact_distance, least_distance)


@stark.energy
def barrier_point_edge(s: stark.Stencil[3], stiffness: float, contact_distance: float, least_distance: float):
    return barrier(point_edge(*(p.x for p in s)), stiffness, contact_distance, least_distance)


@stark.energy
def barrier_point_triangle(
    s: stark.Stencil[4], stiffness: float, contact_distance: float, least_distance: float
):
    p, a, b, c = (point.x for point in s)
    return barrier(
        plane_distance(p - a, stark.cross(b - a, c - a)), stiffness, contact_distance, least_distance
    )


@stark.energy
def barrier_edge_edge(s: stark.Stencil[4], stiffness: float, contact_distance: float, least_distance: float):
    return barrier(edge_edge(*(p.x for p in s)), stiffness, contact_distance, least_distance)


@stark.material
def linear_rod(
    stretch: float,
    curvature: stark.Vec2,
    twist: float,
    axial_stiffness: float,
    bending_stiffness_1: float,
    bending_stiffness_2: float,
    torsional_stiffness: float,
):
    return 0.5 * (
        axial_stiffness * stark.square(stretch - 1.0)
        + bending_stiffness_1 * stark.square(curvature[0])
        + bending_stiffness_2 * stark.square(curvature[1])
        + torsional_stiffness * stark.square(twist)
    )


@stark.material
def rod_damping(
    stretch: float,
    curvature: stark.Vec2,
    twist: float,
    stretch_prev: float,
    curvature_prev: stark.Vec2,
    twist_prev: float,
    h: stark.TimeStep,
    axial_stiffness: float,
    bending_stiffness_1: float,
    bending_stiffness_2: float,
    torsional_stiffness: float,
    strain_damping: float,
):
    rates = (
        axial_stiffness * stark.square(stretch - stretch_prev)
        + bending_stiffness_1 * stark.square(curvature[0] - curvature_prev[0])
        + bending_stiffness_2 * stark.square(curvature[1] - curvature_prev[1])
        + torsional_stiffness * stark.square(twist - twist_prev)
    )
    return 0.5 * strain_damping / h * rates


@stark.energy
def barrier_mollified_point_point(
    s: stark.Stencil[4],
    stiffness: float,
    contact_distance: float,
    least_distance: float,
    parallel_threshold: float,
):
    x = [p.x for p in s]
    return mollifier(x, parallel_threshold) * barrier(
        stark.norm(x[0] - x[2]), stiffness, contact_distance, least_distance
    )


@stark.energy
def barrier_mollified_point_edge(
    s: stark.Stencil[4],
    stiffness: float,
    contact_distance: float,
    least_distance: float,
    parallel_threshold: float,
):
    x = [p.x for p in s]
    return mollifier(x, parallel_threshold) * barrier(
        point_edge(x[0], x[2], x[3]), stiffness, contact_distance, least_distance
    )


@stark.energy
def barrier_mollified_edge_edge(
    s: stark.Stencil[4],
    stiffness: float,
    contact_distance: float,
    least_distance: float,
    parallel_threshold: float,
):
    x = [p.x for p in s]
    return mollifier(x, parallel_threshold) * barrier(
        edge_edge(*x), stiffness, contact_distance, least_distance
    )


@stark.energy
def fibre_seam(node: stark.Point, neighbour: stark.Point, d1: stark.Point, d2: stark.Point, stiffness: float):
    def across(way: stark.Vec, first: stark.Vec, second: stark.Vec) -> list[stark.Scalar]:
        return [stark.dot(way, first), stark.dot(way, second)]

    now = across(neighbour.x - node.x, d1.x, d2.x)
    rest = across(neighbour.X - node.X, d1.X, d2.X)
    length_squared, rest_squared = (stark.square(w[0]) + stark.square(w[1]) for w in (now, rest))
    limit = 0.04 * rest_squared
    t = length_squared / limit
    fading = (15.0 - 10.0 * t + 3.0 * stark.square(t)) / (8.0 * stark.sqrt(limit))
    inverse = stark.where(t < 1.0, fading, 1.0 / stark.sqrt(stark.maximum(length_squared, limit)))
    rest_inverse = 1.0 / stark.sqrt(rest_squared)
    first, second = (w * inverse - r * rest_inverse for w, r in zip(now, rest, strict=True))
    return 0.5 * stiffness * (stark.square(first) + stark.square(second))
