"""Copies of the built-in friction potentials as users write them."""

from __future__ import annotations

import stark


def deflected(points: list, weights: list, u: object, facing: object = None, slopes: tuple = ()) -> object:
    for i, (p, weight) in enumerate(zip(points, weights, strict=True)):
        motion = p.x - p.x_prev
        u = u + weight * motion
        if slopes:
            u = u + slopes[i] * stark.dot(facing, motion)
    return u


def coulomb_smoothed(s: object, u: object, limit: object, eps: object, model: tuple) -> object:
    slope, pull, way, pull_at_iterate, way_at_iterate, is_model = model
    p, q = stark.dot(pull, u) - pull_at_iterate, stark.dot(way, u) - way_at_iterate
    y = stark.sqrt(stark.maximum(s, stark.square(1e-8 * eps)))
    stick = s / eps - s * y / (3.0 * stark.square(eps)) + eps / 3.0
    smooth = stark.where(s < stark.square(eps), stick, y)
    return limit * stark.where(is_model > 0.5, 0.5 * slope * (s - p * q), smooth)


def coulomb(
    points: list,
    weights: list,
    limit: object,
    normal: object,
    eps: object,
    u: object,
    model: tuple,
    facing: object = None,
    slopes: tuple = (),
) -> object:
    u = deflected(points, weights, u, facing, slopes)
    tangential = u - normal * stark.dot(normal, u)
    return coulomb_smoothed(stark.squared_norm(tangential), u, limit, eps, model)


def in_ellipse(
    points: list,
    weights: list,
    along: object,
    across: object,
    u: object,
    facing: object = None,
    slopes: tuple = (),
) -> object:
    u = deflected(points, weights, u, facing, slopes)
    return stark.square(stark.dot(along, u)) + stark.square(stark.dot(across, u)), u


@stark.energy
def friction_2(
    s: stark.Stencil[2],
    limit: float,
    normal: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
    weight0: float,
    weight1: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights = [weight0, weight1]
    return coulomb(list(s), weights, limit, normal, stick_displacement, deflection, model)


@stark.energy
def friction_3(
    s: stark.Stencil[3],
    limit: float,
    normal: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = [weight0, weight1, weight2], (slope0, slope1, slope2)
    kept = (limit, normal, stick_displacement, deflection, model)
    return coulomb(list(s), weights, *kept, facing, slopes)


@stark.energy
def friction_4(
    s: stark.Stencil[4],
    limit: float,
    normal: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    weight3: float,
    slope3: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = [weight0, weight1, weight2, weight3], (slope0, slope1, slope2, slope3)
    kept = (limit, normal, stick_displacement, deflection, model)
    return coulomb(list(s), weights, *kept, facing, slopes)


@stark.energy
def friction_5(
    s: stark.Stencil[5],
    limit: float,
    normal: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    weight3: float,
    slope3: stark.Vec3,
    weight4: float,
    slope4: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = [weight0, weight1, weight2, weight3, weight4], (slope0, slope1, slope2, slope3, slope4)
    kept = (limit, normal, stick_displacement, deflection, model)
    return coulomb(list(s), weights, *kept, facing, slopes)


@stark.energy
def friction_6(
    s: stark.Stencil[6],
    limit: float,
    normal: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    weight3: float,
    slope3: stark.Vec3,
    weight4: float,
    slope4: stark.Vec3,
    weight5: float,
    slope5: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = (
        [weight0, weight1, weight2, weight3, weight4, weight5],
        (slope0, slope1, slope2, slope3, slope4, slope5),
    )
    kept = (limit, normal, stick_displacement, deflection, model)
    return coulomb(list(s), weights, *kept, facing, slopes)


@stark.energy
def anisotropic_friction_2(
    s: stark.Stencil[2],
    limit: float,
    along: stark.Vec3,
    across: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
    weight0: float,
    weight1: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    square, u = in_ellipse(list(s), [weight0, weight1], along, across, deflection)
    return coulomb_smoothed(square, u, limit, stick_displacement, model)


@stark.energy
def anisotropic_friction_3(
    s: stark.Stencil[3],
    limit: float,
    along: stark.Vec3,
    across: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = [weight0, weight1, weight2], (slope0, slope1, slope2)
    square, u = in_ellipse(list(s), weights, along, across, deflection, facing, slopes)
    return coulomb_smoothed(square, u, limit, stick_displacement, model)


@stark.energy
def anisotropic_friction_4(
    s: stark.Stencil[4],
    limit: float,
    along: stark.Vec3,
    across: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    weight3: float,
    slope3: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = [weight0, weight1, weight2, weight3], (slope0, slope1, slope2, slope3)
    square, u = in_ellipse(list(s), weights, along, across, deflection, facing, slopes)
    return coulomb_smoothed(square, u, limit, stick_displacement, model)


@stark.energy
def anisotropic_friction_5(
    s: stark.Stencil[5],
    limit: float,
    along: stark.Vec3,
    across: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    weight3: float,
    slope3: stark.Vec3,
    weight4: float,
    slope4: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = [weight0, weight1, weight2, weight3, weight4], (slope0, slope1, slope2, slope3, slope4)
    square, u = in_ellipse(list(s), weights, along, across, deflection, facing, slopes)
    return coulomb_smoothed(square, u, limit, stick_displacement, model)


@stark.energy
def anisotropic_friction_6(
    s: stark.Stencil[6],
    limit: float,
    along: stark.Vec3,
    across: stark.Vec3,
    stick_displacement: float,
    deflection: stark.Vec3,
    facing: stark.Vec3,
    weight0: float,
    slope0: stark.Vec3,
    weight1: float,
    slope1: stark.Vec3,
    weight2: float,
    slope2: stark.Vec3,
    weight3: float,
    slope3: stark.Vec3,
    weight4: float,
    slope4: stark.Vec3,
    weight5: float,
    slope5: stark.Vec3,
    slope: float,
    pull: stark.Vec3,
    way: stark.Vec3,
    pull_at_iterate: float,
    way_at_iterate: float,
    is_model: float,
):
    model = (slope, pull, way, pull_at_iterate, way_at_iterate, is_model)
    weights, slopes = (
        [weight0, weight1, weight2, weight3, weight4, weight5],
        (slope0, slope1, slope2, slope3, slope4, slope5),
    )
    square, u = in_ellipse(list(s), weights, along, across, deflection, facing, slopes)
    return coulomb_smoothed(square, u, limit, stick_displacement, model)
