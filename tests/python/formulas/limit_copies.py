"""The built-in strain limits once more, in Python: see builtin_copies."""

from __future__ import annotations

import stark


@stark.energy
def edge_strain_limit(e: stark.Edge, volume: float, strain_limit: float, strain_limit_stiffness: float):
    strain = e.length / e.rest_length - 1.0
    excess = stark.maximum(strain - strain_limit, 0.0)
    return volume * strain_limit_stiffness / 3.0 * excess * excess * excess


def positive_cubes_2(trace: object, determinant: object) -> object:
    both = trace * (stark.square(trace) - 3.0 * determinant)
    larger = 0.5 * (trace + stark.sqrt(stark.square(trace) - 4.0 * determinant))
    some = stark.where(trace > 0.0, both, 0.0)
    return stark.where(determinant < -1e-40, larger * stark.square(larger), some)


def strain_limit_density(
    S: object, strain_limit: object, strain_limit_stiffness: object, strain_limit_hardening: object
) -> object:
    cube = strain_limit * stark.square(strain_limit)
    return strain_limit_stiffness / 3.0 * S * (1.0 + strain_limit_hardening * S / (S + cube))


@stark.energy
def membrane_strain_limit(
    t: stark.Triangle,
    strain_limit: float,
    thickness: float,
    strain_limit_stiffness: float,
    strain_limit_hardening: float,
):
    G, g = t.rest_metric, t.metric
    scale = 1.0 / stark.determinant(G)
    c11 = scale * (G[1, 1] * g[0, 0] - G[0, 1] * g[0, 1])
    c12 = scale * (G[1, 1] * g[0, 1] - G[0, 1] * g[1, 1])
    c21 = scale * (G[0, 0] * g[0, 1] - G[0, 1] * g[0, 0])
    c22 = scale * (G[0, 0] * g[1, 1] - G[0, 1] * g[0, 1])
    shift = 0.5 + strain_limit
    a11, a22 = 0.5 * c11 - shift, 0.5 * c22 - shift
    S = positive_cubes_2(a11 + a22, a11 * a22 - 0.25 * c12 * c21)
    density = strain_limit_density(S, strain_limit, strain_limit_stiffness, strain_limit_hardening)
    return density * thickness * t.rest_area


def positive_root(J1: object, J2: object, J3: object) -> object:
    spread = (J1 + 2.0 * stark.sqrt(stark.square(J1) - 3.0 * J2)) / 3.0
    radical = stark.sqrt(stark.square(J2) - 4.0 * J1 * J3)
    quadratic = stark.where(J2 > 0.0, 2.0 * J3 / (J2 + radical), (J2 - radical) / (2.0 * J1))
    x = stark.where(J1 < 0.0, stark.minimum(spread, quadratic), spread)
    for _ in range(3):
        f = ((x - J1) * x + J2) * x - J3
        slope = (3.0 * x - 2.0 * J1) * x + J2
        curvature = 6.0 * x - 2.0 * J1
        x = x - 3.0 * f / (slope + stark.sqrt(4.0 * stark.square(slope) - 6.0 * f * curvature))
    return x


def positive_cubes_3(I1: object, I2: object, I3: object) -> object:
    all_above = I1 * (stark.square(I1) - 3.0 * I2) + 3.0 * I3
    two = I3 < 0.0
    root = positive_root(stark.where(two, -I1, I1), I2, stark.abs(I3))
    total = I1 + root
    product = I2 + root * total
    some = stark.where(two, total * (stark.square(total) - 3.0 * product), root * stark.square(root))
    none = ((I1 <= 0.0) & (I2 >= -1e-40) & (I3 <= 1e-40)) | (stark.square(I1) - 2.0 * I2 <= 1e-40)
    return stark.where(none, 0.0, stark.where((I1 > 0.0) & (I2 >= 0.0) & (I3 >= 0.0), all_above, some))


@stark.material
def strain_limit(
    F: stark.DeformationGradient,
    strain_limit: float,
    strain_limit_stiffness: float,
    strain_limit_hardening: float,
):
    A = 0.5 * (F.T @ F) - (0.5 + strain_limit) * stark.identity(3)
    xx, yy, zz = stark.square(A[0, 1]), stark.square(A[1, 2]), stark.square(A[0, 2])
    I1 = stark.trace(A)
    I2 = A[0, 0] * A[1, 1] - xx + A[1, 1] * A[2, 2] - yy + A[2, 2] * A[0, 0] - zz
    I3 = (
        A[0, 0] * A[1, 1] * A[2, 2]
        + 2.0 * A[0, 1] * A[1, 2] * A[0, 2]
        - A[0, 0] * yy
        - A[1, 1] * zz
        - A[2, 2] * xx
    )
    S = positive_cubes_3(I1, I2, I3)
    return strain_limit_density(S, strain_limit, strain_limit_stiffness, strain_limit_hardening)
