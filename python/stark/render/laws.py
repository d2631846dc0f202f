"""Stored energies of the built-in laws, once more as formulas of stark.symbolic, which differentiates them
for stresses. [theory, section 4] The tests compare them with the energies that the solver reports."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

import stark.symbolic as sym
from stark.formulas.law_checks import Law
from stark.formulas.material_law import MaterialLaw

from .._core import InvalidArgument


def _lame(youngs_modulus: Any, poissons_ratio: Any) -> tuple[Any, Any]:
    E, nu = youngs_modulus, poissons_ratio
    return E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))


def _in_plane(youngs_modulus: Any, poissons_ratio: Any) -> tuple[Any, Any]:
    E, nu = youngs_modulus, poissons_ratio
    return E / (2.0 * (1.0 + nu)), E * nu / (1.0 - nu * nu)


@sym.function
def stable_neo_hookean(F: sym.Mat3, youngs_modulus: float, poissons_ratio: float) -> Any:
    """[J/m^3]"""
    mu0, lambda0 = _lame(youngs_modulus, poissons_ratio)
    mu, la = 4.0 / 3.0 * mu0, lambda0 + 5.0 / 6.0 * mu0
    alpha, trace, J = 1.0 + 0.75 * mu / la, sym.trace(F.T @ F), sym.determinant(F)
    rest = 0.5 * la * (1.0 - alpha) ** 2 - 0.5 * mu * np.log(4.0)
    return 0.5 * mu * (trace - 3.0) + 0.5 * la * (J - alpha) ** 2 - 0.5 * mu * sym.log(trace + 1.0) - rest


@sym.function
def neo_hookean(F: sym.Mat3, youngs_modulus: float, poissons_ratio: float) -> Any:
    """[J/m^3]"""
    mu, la = _lame(youngs_modulus, poissons_ratio)
    log_J = sym.log(sym.determinant(F))
    return 0.5 * mu * (sym.trace(F.T @ F) - 3.0) - mu * log_J + 0.5 * la * log_J**2


@sym.function
def st_venant_kirchhoff(F: sym.Mat3, youngs_modulus: float, poissons_ratio: float) -> Any:
    """[J/m^3]"""
    mu, la = _lame(youngs_modulus, poissons_ratio)
    G = 0.5 * (F.T @ F - sym.identity(3))
    return mu * sym.trace(G @ G) + 0.5 * la * sym.trace(G) ** 2


@sym.function
def mooney_rivlin(F: sym.Mat3, c10: float, c01: float, bulk_modulus: float) -> Any:
    """[J/m^3]"""
    C = F.T @ F
    trace, J = sym.trace(C), sym.determinant(F)
    shape, II = J ** (-2.0 / 3.0), 0.5 * (trace**2 - sym.trace(C @ C))
    return c10 * (shape * trace - 3.0) + c01 * (shape**2 * II - 3.0) + 0.5 * bulk_modulus * (J - 1.0) ** 2


@sym.function
def fiber_reinforced(
    F: sym.Mat3,
    youngs_modulus: float,
    poissons_ratio: float,
    fiber_stiffness: float,
    fiber_exponent: float,
    fiber_direction: sym.Vec3,
) -> Any:
    """[J/m^3]"""
    excess = sym.maximum(sym.squared_norm(F @ sym.normalized(fiber_direction)) - 1.0, 0.0)
    fibres = 0.5 * fiber_stiffness / fiber_exponent * (sym.exp(fiber_exponent * excess**2) - 1.0)
    return stable_neo_hookean(F, youngs_modulus, poissons_ratio) + fibres


@sym.function
def membrane_neo_hookean(F: Annotated[sym.Mat, 3, 2], youngs_modulus: float, poissons_ratio: float) -> Any:
    """[J/m^3]"""
    mu, la = _in_plane(youngs_modulus, poissons_ratio)
    C = F.T @ F
    log_J = 0.5 * sym.log(sym.determinant(C))
    return 0.5 * mu * (sym.trace(C) - 2.0) - mu * log_J + 0.5 * la * log_J**2


@sym.function
def membrane_st_venant_kirchhoff(
    F: Annotated[sym.Mat, 3, 2], youngs_modulus: float, poissons_ratio: float
) -> Any:
    """[J/m^3]"""
    mu, la = _in_plane(youngs_modulus, poissons_ratio)
    G = 0.5 * (F.T @ F - sym.identity(2))
    return mu * sym.trace(G @ G) + 0.5 * la * sym.trace(G) ** 2


@sym.function
def orthotropic_cloth(
    F: Annotated[sym.Mat, 3, 2],
    warp_modulus: float,
    weft_modulus: float,
    shear_modulus: float,
    poissons_ratio: float,
) -> Any:
    """[J/m^3]; the first direction at rest is the warp."""
    G = 0.5 * (F.T @ F - sym.identity(2))
    cross = 2.0 * poissons_ratio * sym.sqrt(warp_modulus * weft_modulus) * G[0, 0] * G[1, 1]
    stretch = warp_modulus * G[0, 0] ** 2 + cross + weft_modulus * G[1, 1] ** 2
    return stretch / (2.0 * (1.0 - poissons_ratio**2)) + 2.0 * shear_modulus * G[0, 1] ** 2


_SOLIDS = (stable_neo_hookean, neo_hookean, st_venant_kirchhoff, mooney_rivlin, fiber_reinforced)
_SHELLS = (membrane_neo_hookean, membrane_st_venant_kirchhoff, orthotropic_cloth)


def stress_follows_from_strain(material: Any, is_sheet: bool) -> bool:
    """Whether ``density_and_stress`` knows the law of a material: not those that remember, those of the time
    and those that were read from a file."""
    name, built_in = _law_of(material, 2 if is_sheet else 3)
    return built_in is not None or name == "corotated" or not _unknown_stress(_recorded_law(material))


def density_and_stress(material: Any, F: np.ndarray, owner: str) -> tuple[np.ndarray, np.ndarray]:
    """Energy density (m, k) [J/m^3] and first Piola-Kirchhoff stress (m, k, 3, d) [Pa] of a material at
    deformation gradients (m, k, 3, d), d = 3 of solids, 2 of shells, of m elements; limits of strain
    included, damping not. Raises InvalidArgument that names ``owner`` for laws that are not here."""
    name, law = _law_of(material, F.shape[-1])
    if name == "corotated":
        psi, P = _corotated(material, F)
    elif law is None:
        psi, P = _recorded(material, F, owner, name)
    else:
        names = [a.name for a in law.formula.arguments if a.name != "F"]
        psi, P = law.value_and_gradient(F, **{name: _by_element(material, name) for name in names}, wrt="F")
    limit_psi, limit_P = _limit(material, F)
    return psi + limit_psi, P + limit_P


def _law_of(material: Any, d: int) -> tuple[str, Any]:
    """Name of the law of a solid, d = 3, or a shell, d = 2, and the formula above that is it, if any."""
    name = "stable_neo_hookean" if d == 3 else "membrane_neo_hookean"
    if material.law is not None:
        name = material.law.name
    elif d == 2 and np.isfinite(material.yield_stress).any():
        name = "plastic_membrane"
    return name, {f.__name__: f for f in (_SOLIDS if d == 3 else _SHELLS)}.get(name)


def _recorded_law(material: Any) -> Any:
    return None if material._recorded is None else material._recorded[0]


def _recorded(material: Any, F: np.ndarray, owner: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Of a law that a function was recorded for, at rest where it depends on what was before: without what
    is viscous."""
    law = _recorded_law(material)
    why = _unknown_stress(law)
    if why or not isinstance(law, MaterialLaw):
        raise InvalidArgument(
            f"'{owner}': stress: its law '{name}' {why}; leave the body out with bodies= or hide=, or give "
            f"an array: field={{'{owner}': values}}"
        )
    places = F.shape[1]
    values = law.values_of(material)
    for parameter in law.parameters:
        value = values[parameter.name]
        is_by_element = value.ndim > len(parameter.shape)
        values[parameter.name] = np.repeat(value, places, axis=0) if is_by_element else value
    flat = F.reshape(-1, *F.shape[2:])
    psi, P, _ = Law(law, values).at(flat, flat, order=1)
    return psi.reshape(F.shape[:2]), P.reshape(F.shape)


def _unknown_stress(law: Any) -> str:
    """Why the stress does not follow from the deformation alone; empty if it does."""
    if not isinstance(law, MaterialLaw):
        return "is not one of those whose stress is known"
    if law.internals:
        return "has internal variables"
    return "depends on the time" if any(source[0] == "time" for source in law.sources.values()) else ""


def _by_element(material: Any, name: str) -> Any:
    """A number, or values (m, 1, ...) for the places of each element."""
    value = np.asarray(getattr(material, name), dtype=np.float64)
    vector = name.endswith("direction")
    return value if value.ndim == int(vector) else value[:, None]


def _corotated(material: Any, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """mu |F - R|^2 + lambda/2 (J - 1)^2: P = 2 mu (F - R) + lambda (J - 1) cof F."""
    mu, la = _lame(_by_element(material, "youngs_modulus"), _by_element(material, "poissons_ratio"))
    U, s, V = np.linalg.svd(F)
    sign = np.ones_like(s)
    sign[..., 2] = np.sign(np.linalg.det(U) * np.linalg.det(V))
    s = s * sign
    R = (U * sign[..., None, :]) @ V
    J = s.prod(axis=-1)
    psi = mu * ((s - 1.0) ** 2).sum(axis=-1) + 0.5 * la * (J - 1.0) ** 2
    cofactors = np.stack([s[..., 1] * s[..., 2], s[..., 2] * s[..., 0], s[..., 0] * s[..., 1]], axis=-1)
    cofactor = (U * (sign * cofactors)[..., None, :]) @ V
    both = np.asarray(2.0 * mu)[..., None, None] * (F - R)
    return psi, both + np.asarray(la * (J - 1.0))[..., None, None] * cofactor


def _limit(material: Any, F: np.ndarray) -> tuple[Any, Any]:
    """Of the limit of strain, by the eigenvalues of the Green strain (theory eq. 14)."""
    limit = _by_element(material, "strain_limit")
    if not np.isfinite(limit).any() or material.strain_limit_law != "green_strain":
        return 0.0, 0.0
    k, eta = (_by_element(material, f"strain_limit_{name}") for name in ("stiffness", "hardening"))
    strain = 0.5 * (np.swapaxes(F, -1, -2) @ F - np.eye(F.shape[-1]))
    if ((strain**2).sum(axis=(-1, -2)) < np.maximum(limit, 0.0) ** 2).all():  # no eigenvalue is beyond it
        return 0.0, 0.0
    values, vectors = np.linalg.eigh(strain)
    excess = np.maximum(values - np.asarray(limit)[..., None], 0.0)
    S, cube = (excess**3).sum(axis=-1), np.minimum(limit, 1e30) ** 3
    psi = k / 3.0 * S * (1.0 + eta * S / (S + cube))
    slope = k * (1.0 + eta * S * (S + 2.0 * cube) / (S + cube) ** 2)
    second = (vectors * (slope[..., None] * excess**2)[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    return psi, F @ second
