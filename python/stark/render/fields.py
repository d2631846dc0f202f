"""Fields on the surfaces of bodies: numbers at vertices, computed from what handles of bodies tell."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from stark.bodies.contact_pressures import pressures_of
from stark.body_kinds import has_pose, names_of, row_of

from .._core import InvalidArgument
from ..arguments import real_array, shown_value
from .choosing import matching
from .deformation import Deformation, at_body, in_material, of_body


class Field(NamedTuple):
    """Values by name of body, at each vertex (n,), and what they are."""

    values: dict[str, np.ndarray]
    label: str
    unit: str


class _Kind(NamedTuple):
    label: str
    unit: str
    kinds: tuple[str, ...]  #: of the bodies that have it
    compute: Callable[[Any], np.ndarray]
    #: Of several bodies of a simulation, where that is faster than one by one.
    together: Callable[[Any, Sequence[Any]], Sequence[np.ndarray]] | None = None


def field_values(sim: Any, name: str, bodies: Any = None) -> dict[str, np.ndarray]:
    """A field of the bodies of a simulation as they are now: values at each vertex (n,), in the order of
    ``positions``, by name of body. Bodies that do not have it are left out; ``bodies`` are the only ones to
    look at, by handle, name or pattern.

    - "speed" [m/s]: length of the velocity; all bodies.
    - "contact_force" [N]: length of the sum of contact forces on the vertex, friction included; all bodies.
    - "pressure" [Pa]: normal contact force over area, ``body.contact_pressure()``; all but rods.
    - "strain" [1]: largest change of a principal stretch, max abs(s_i - 1); cloth, solids, rods.
    - "stress" [Pa]: von Mises stress (Cauchy), of rods axial force over area; cloth, solids, rods.
    - "plastic_strain" [1]: equivalent plastic strain, of cloth in its plane; cloth and solids, 0 of what
      does not yield.

    Strains and stresses are means over the elements at a vertex. Stresses are those of the constitutive law
    and of limits of Green strain, without damping; cloth has them in its middle surface (its bending is left
    out), with the thickness at rest. Skins and fibres are not counted. Growth and thermal expansion are
    strains, counted from the mesh, but free of stress; muscles have their active stress. Materials that yield
    or relax have the stress that their internal variables leave, the mean over each element.

    Raises InvalidArgument for fields that are unknown, and for the stress of rods that yield or have a law of
    their own."""
    kind = _known(name)
    if not hasattr(sim, "bodies"):
        raise InvalidArgument(f"field_values: sim = {shown_value(sim)}: must be a stark.Simulation")
    every = list(sim.bodies)
    indices = range(len(every)) if bodies is None else matching(bodies, [b.name for b in every], "bodies")
    chosen = [every[i] for i in indices if every[i].kind in kind.kinds]
    if kind.together is not None and len(chosen) > 1 and hasattr(type(sim), "contacts"):
        return dict(zip([body.name for body in chosen], kind.together(sim, chosen), strict=True))
    return {body.name: kind.compute(body) for body in chosen}


def field_of(source: Any, field: Any, shown: Collection[str] | None = None) -> Field:
    """What ``picture(field=...)`` shows: the name of a field, or a dictionary of bodies (handle, name or
    pattern) with arrays of a value for each vertex (n,), or with the name of a field. Bodies whose kind does
    not have the field are left out, and of those that are not named fixed ones and all but the ``shown``."""
    if isinstance(field, str):
        if _is_recorded(source, field):
            return _recorded(source, field, shown)
        kind = _known(field)
        bodies = [b for b in _with_handles(source, field).bodies if shown is None or b.name in shown]
        moving = [b for b in bodies if b.motion != "fixed"]
        return Field(field_values(source, field, moving), kind.label, kind.unit)
    if not isinstance(field, Mapping):
        raise InvalidArgument(
            f"field = {field!r}: must be one of {', '.join(FIELDS)}, or a dictionary of bodies with arrays "
            f"of a value for each vertex"
        )
    bodies = list(source.bodies)
    names = [body.name for body in bodies]
    values: dict[str, np.ndarray] = {}
    words = [value for value in field.values() if isinstance(value, str)]
    if any(word != words[0] for word in words):
        raise InvalidArgument(f"field = {field!r}: must name one field: a picture has one scale of colours")
    for key, given in field.items():
        for i in matching(key, names, "field: body"):
            if isinstance(given, str) and _is_recorded(source, given):
                values |= _recorded(source, given, {names[i]}).values
            elif isinstance(given, str):
                values |= field_values(_with_handles(source, given), given, names[i])
            else:
                values[names[i]] = _given(bodies[i], given)
    if words and _is_recorded(source, words[0]):
        return _recorded(source, words[0], ())._replace(values=values)
    label, unit = (_known(words[0]).label, _known(words[0]).unit) if words else ("", "")
    return Field(values, label, unit)


def _is_recorded(source: Any, name: str) -> bool:
    """Whether ``source`` is a frame of a recording with this field."""
    recording = getattr(source, "recorded", None)
    return recording is not None and any(entry.name == name for entry in recording.fields)


def _recorded(frame: Any, name: str, shown: Collection[str] | None) -> Field:
    """What was recorded at the drawn vertices."""
    entry = next(entry for entry in frame.recorded.fields if entry.name == name)
    every = frame.recorded.field(name, frame.index)
    values = {body: v for body, v in every.items() if shown is None or body in shown}
    return Field(values, entry.label, entry.unit)


def _known(name: Any) -> _Kind:
    if not isinstance(name, str) or name not in FIELDS:
        raise InvalidArgument(
            f"field '{name}' is unknown; choose one of {', '.join(FIELDS)}, or give arrays: "
            f"field={{'body': values}}"
        )
    return FIELDS[name]


def _with_handles(source: Any, name: str) -> Any:
    if not all(hasattr(body, "contact_forces") for body in source.bodies):
        raise InvalidArgument(
            f"field '{name}': needs a simulation, or a recording that has it (stark run --fields {name}); "
            f"else give arrays, field={{'body': values}}"
        )
    return source


def _given(body: Any, given: Any) -> np.ndarray:
    values, count = real_array(given, f"field of '{body.name}'"), len(body.positions)
    if values.shape != (count,):
        raise InvalidArgument(
            f"field of '{body.name}' has the shape {values.shape}: must be ({count},), a value for each "
            f"vertex"
        )
    if not np.isfinite(values).all():
        bad = int(np.flatnonzero(~np.isfinite(values))[0])
        raise InvalidArgument(f"field of '{body.name}': value {bad} is {values[bad]}: must be finite")
    return values


# --- the fields ---


def _speed(body: Any) -> np.ndarray:
    if body.motion == "fixed":
        return np.zeros(len(body.positions))
    if not has_pose(body):
        return np.asarray(np.linalg.norm(body.velocities, axis=1))
    position, rotation = body.pose
    center = position if body.motion == "scripted" else position + rotation @ body.center_of_mass
    turning = np.cross(body.angular_velocity, body.positions - center)
    return np.asarray(np.linalg.norm(body.velocity + turning, axis=1))


def _contact_force(body: Any) -> np.ndarray:
    return np.asarray(np.linalg.norm(body.contact_forces, axis=1))


def _pressure(body: Any) -> np.ndarray:
    return np.asarray(body.contact_pressure())


def _pressures(sim: Any, bodies: Sequence[Any]) -> Sequence[np.ndarray]:
    return pressures_of(bodies, sim.contacts)


def _strain(body: Any) -> np.ndarray:
    if not row_of(body).has_triangles:
        strains: np.ndarray = np.abs(_at_nodes(body, _stretches(body) - 1.0))
        return strains
    deformation = of_body(body)
    F = deformation.gradients
    # eigenvalues are squares of the principal stretches
    left = in_material(body, F, lambda F: F @ np.swapaxes(F, -1, -2))
    if row_of(body).is_sheet:
        normals = np.cross(F[..., 0], F[..., 1])
        normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
        left = left + normals[..., :, None] * normals[..., None, :]  # no stretch across the sheet
    squares = np.linalg.eigvalsh(at_body(body, deformation, left))
    return np.asarray(np.abs(np.sqrt(np.maximum(squares, 0.0)) - 1.0).max(axis=1))


def _stress(body: Any) -> np.ndarray:
    if not row_of(body).has_triangles:
        return _rod_stress(body, body._shared["material"])
    return von_mises(at_body(body, *body_stress(body, of_material=True)))


def _plastic_strain(body: Any) -> np.ndarray:
    known, deformation = body.internal_variables, of_body(body)
    if "plastic_work" in known:  # of sheets, as without hardening
        limit = np.asarray(body._shared["material"].yield_stress, dtype=np.float64).reshape(-1, 1)
        values = known["plastic_work"] / limit
    else:
        values = known.get("plastic_strain", np.zeros((len(deformation.elements), 1)))
    return at_body(body, deformation, values.mean(axis=1, keepdims=True))


def body_stress(body: Any, *, of_material: bool = False) -> tuple[Deformation, np.ndarray]:
    """Of a cloth or a solid: its deformation, and the Cauchy stress in its elements (m, k, 3, 3) [Pa]; k = 1
    where the material remembers. ``of_material``: as ``in_material``, for means at vertices."""
    from .laws import stress_follows_from_strain

    material = body._shared["material"]
    deformation = of_body(body, material._fields.get("warp_direction"))
    if not stress_follows_from_strain(material, row_of(body).is_sheet):
        return deformation, _mean_stress(body, material)

    def stress(F: np.ndarray) -> np.ndarray:
        F = _seen(F)
        elastic = deformation._replace(gradients=beyond_rest(body, F))
        cauchy = cauchy_stress(material, elastic, body.name)
        return cauchy + _active_stress(body, F) if body.active_stress.any() else cauchy

    F = _with_ratios(body, deformation.gradients)
    return deformation, in_material(body, F, stress) if of_material else stress(F)


def _with_ratios(body: Any, F: np.ndarray) -> np.ndarray:
    """Deformation gradients (m, k, 3, 3) of a solid of mean dilatation, and as a fourth column the volume
    ratio that its law sees at each node; of other bodies as they are. [theory eq. 15c]"""
    forms = np.reshape(body._require_simulation("stress")._core.volume_ratios(body._index), (-1, 4))
    if not len(forms):
        return F
    ratios = forms[:, :1] + np.einsum("mni,mi->mn", body.mesh.vertices[body.mesh.elements], forms[:, 1:])
    column = np.stack([ratios, 0.0 * ratios, 0.0 * ratios], axis=-1)[..., None]
    return np.concatenate([F, column], axis=-1)


def _seen(F: np.ndarray) -> np.ndarray:
    """What the law of a point sees. [theory eq. 15b]"""
    if F.shape[-1] < 4:
        return F
    F, ratios = F[..., :3], F[..., 0, 3]
    return np.asarray(np.cbrt(ratios / np.linalg.det(F))[..., None, None] * F)


def _mean_stress(body: Any, material: Any) -> np.ndarray:
    """Of elements (m, 1, 3, 3), from their forces, which know what it remembers, and have the active stress.
    [theory eq. 10r]"""
    stress = np.array(body._require_simulation("stress")._core.mean_stresses(body._index)).reshape(-1, 3, 3)
    if row_of(body).is_sheet:
        stress = stress / np.asarray(material.thickness, dtype=np.float64).reshape(-1, 1, 1)
    return stress[:, None]


def _rest_stretch(body: Any) -> np.ndarray:
    """G* (m,) or (m, 3, 3): growth times thermal stretch of each element. [theory eq. 15d]"""
    growth = body.growth
    thermal = 1.0 + np.asarray(body._shared["material"].thermal_expansion) * body.temperature
    return np.asarray(growth * thermal.reshape(-1, *[1] * (growth.ndim - 1)))


def beyond_rest(body: Any, gradients: np.ndarray) -> np.ndarray:
    """Deformation gradients (m, k, 3, d) beyond growth and thermal expansion, which are free of stress."""
    stretch = _rest_stretch(body)
    if stretch.ndim == 3:
        return np.asarray(gradients @ np.linalg.inv(stretch)[:, None])
    return np.asarray(gradients / stretch[:, None, None, None])


def _active_stress(body: Any, F: np.ndarray) -> np.ndarray:
    """Cauchy stress (m, k, 3, 3) of a muscle: S |F a| f f^T / J along its fibres f. [theory eq. 15e]"""
    if row_of(body).is_sheet:
        fibres = of_body(body, body.fiber_direction).gradients[..., 0]
    else:
        directions = body.fiber_direction / np.linalg.norm(body.fiber_direction, axis=1, keepdims=True)
        fibres = np.einsum("mkij,mj->mki", F, directions)
    ratio = np.sqrt(np.linalg.det(np.swapaxes(F, -1, -2) @ F))
    along = body.active_stress[:, None] / (np.linalg.norm(fibres, axis=-1) * ratio)
    return np.asarray(along[..., None, None] * fibres[..., :, None] * fibres[..., None, :])


def cauchy_stress(material: Any, deformation: Deformation, owner: str) -> np.ndarray:
    """Of elements (m, k, 3, 3) [Pa]: P F^T / J with the first Piola-Kirchhoff stress P of the law of a
    material, J the ratio of volumes, of cloth that of areas."""
    from .laws import density_and_stress

    F = deformation.gradients
    P = density_and_stress(material, F, owner)[1]
    J = np.sqrt(np.linalg.det(np.swapaxes(F, -1, -2) @ F))
    return np.asarray(P @ np.swapaxes(F, -1, -2) / J[..., None, None])


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Of symmetric tensors (..., 3, 3): (3/2 s : s)^1/2 with the deviator s."""
    pressure = np.trace(stress, axis1=-2, axis2=-1) / 3.0
    deviator = stress - pressure[..., None, None] * np.eye(3)
    return np.asarray(np.sqrt(1.5 * (deviator**2).sum(axis=(-1, -2))))


def _rod_stress(rod: Any, material: Any) -> np.ndarray:
    limits = ("yield_stress", "yield_force", "yield_moment_1", "yield_moment_2", "yield_torque")
    yields = any(0.0 < np.min(getattr(material, name)) < np.inf for name in limits)
    if material.law is not None or material._fields or yields:
        raise InvalidArgument(
            f"'{rod.name}': stress: is known of elastic rods of the built-in law with one value for all "
            f"edges; compute it and give an array: field={{'{rod.name}': values}}"
        )
    section = material.section
    area = section["mass"] / material.density
    stretches = _stretches(rod) / _rest_stretch(rod)
    forces = section["axial_stiffness"] * (stretches - 1.0) + getattr(rod, "active_force", 0.0)
    stresses: np.ndarray = np.abs(_at_nodes(rod, forces / area))
    return stresses


def _stretches(body: Any) -> np.ndarray:
    """Lengths of the edges over those at rest (m,)."""
    a, b = body.mesh.edges.T
    now, rest = (np.linalg.norm(x[b] - x[a], axis=1) for x in (body.positions, body.mesh.vertices))
    return np.asarray(now / rest)


def _at_nodes(body: Any, values: np.ndarray) -> np.ndarray:
    """Means at each node of what its edges have (m,)."""
    ends, count = body.mesh.edges.ravel(), len(body.mesh.vertices)
    sums = np.bincount(ends, weights=np.repeat(values, 2), minlength=count)
    return np.asarray(sums / np.maximum(np.bincount(ends, minlength=count), 1))


_ELASTIC, _ALL = names_of(strains=True), names_of()
FIELDS: dict[str, _Kind] = {
    "stress": _Kind("von Mises stress", "Pa", _ELASTIC, _stress),
    "strain": _Kind("strain", "", _ELASTIC, _strain),
    "plastic_strain": _Kind(
        "plastic strain", "", names_of(strains=True, has_triangles=True), _plastic_strain
    ),
    "pressure": _Kind("contact pressure", "Pa", names_of(has_triangles=True), _pressure, _pressures),
    "contact_force": _Kind("contact force", "N", _ALL, _contact_force),
    "speed": _Kind("speed", "m/s", _ALL, _speed),
}
