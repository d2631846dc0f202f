"""Deformable parts of robots in a scene: cloth, solids and rods that links hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stark import materials
from stark.bodies import Cloth, RigidBody, Rod, Solid
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.mesh import TetMesh, TriangleMesh, oriented
from stark.robots.description import Flex
from stark.robots.kinematics import Placement
from stark.robots.report import Report

#: Poisson's ratios beyond make linear tetrahedra lock.
_LARGEST_RATIO = 0.49
#: Of rods, where nothing is said.
_DIAMETER, _MODULUS = 1e-3, 1e6  # [m], [Pa]
_SLACK = 1e-3


@dataclass(frozen=True, eq=False)
class Carrier:
    """Where a link is: as a part of a body, and in the world."""

    body: RigidBody | None
    in_body: Placement
    in_world: Placement


def add_flex(
    scene: Any,
    flex: Flex,
    carrier: Carrier,
    name: str,
    given: Mapping[str, Any],
    contact: bool,
    report: Report,
) -> Cloth | Rod | Solid:
    """Adds a deformable part as a body of that name and fixes its held vertices to their link. ``given``:
    options of all bodies of the robot; without ``contact`` it touches nothing."""
    title = f"flex '{flex.name}'"
    held = list(flex.held)
    options: dict[str, Any] = {
        "mass": flex.mass,
        "name": name,
        "position": carrier.in_world.position,
        "rotation": carrier.in_world.rotation,
        "self_contact": flex.touches_itself and contact,
        "color": flex.color,
        "velocity": carrier.in_world.rotation @ np.array(flex.velocity),
        "initial_positions": flex.start,
        **given,
    }
    if flex.radius > 0.0:
        options.setdefault("contact_distance", flex.radius)
        report.add("kept", title, f"radius {options['contact_distance']:g} m as its contact distance")
    if carrier.body is None and held:
        options["pins"] = held
    body: Cloth | Rod | Solid
    if flex.is_solid:
        mesh = oriented(TetMesh(flex.vertices, flex.cells))
        solid: Solid = scene.add_solid(mesh, _solid(flex, report, title), **options)
        body = solid
        if locking := solid._locking():
            report.add("suspicious", title, locking)
    elif flex.is_rod:
        body = scene.add_rod(flex.vertices, _rod(flex, report, title), **options)
    else:
        sheet, angles = TriangleMesh(flex.vertices, flex.cells), "mesh" if flex.folds_at_rest else "flat"
        body = scene.add_cloth(sheet, _shell(flex, report, title), rest_angles=angles, **options)
    report.add("kept", title, f"a {body.kind} of {len(flex.vertices)} vertices and {flex.mass:g} kg")
    if carrier.body is not None and held:
        shape = flex.vertices if flex.start is None else flex.start
        at = shape[held] @ carrier.in_body.rotation.T + carrier.in_body.position
        scene.attach(body.vertices[held], carrier.body.points(at), name=f"{name}.held")
    if held:
        report.add("kept", title, f"{len(held)} vertices are fixed to '{flex.link}'")
    if not (flex.touches and contact):
        scene._touches_nothing(body)
    return body


def _solid(flex: Flex, report: Report, title: str) -> SolidMaterial:
    material = materials.soft_rubber.replace(strain_limit=np.inf)
    if not flex.youngs_modulus > 0.0:
        report.add("assumed", title, "no elasticity: soft rubber")
        return material
    return material.replace(
        youngs_modulus=flex.youngs_modulus,
        poissons_ratio=_ratio(flex, report, title),
        mass_damping=0.0,
        strain_damping=flex.damping * flex.youngs_modulus,
    )


def _shell(flex: Flex, report: Report, title: str) -> ShellMaterial:
    if not (flex.youngs_modulus > 0.0 and flex.thickness > 0.0):
        report.add("assumed", title, "no elasticity or thickness: cotton of the mass of the file")
        return materials.cotton
    material = materials.plate(
        youngs_modulus=flex.youngs_modulus,
        poissons_ratio=_ratio(flex, report, title),
        thickness=flex.thickness,
        density=1.0,  # the mass is given
        mass_damping=0.0,
        strain_damping=flex.damping * flex.youngs_modulus * flex.thickness,
    )
    rigidity = flex.flexural_rigidity if flex.bends else 0.0
    return material if rigidity is None else material.replace(flexural_rigidity=rigidity)


def _rod(flex: Flex, report: Report, title: str) -> RodMaterial:
    if not flex.thickness > 0.0:
        report.add("assumed", title, f"no diameter: {_DIAMETER:g} m")
    if not flex.youngs_modulus > 0.0:
        report.add("assumed", title, f"no elasticity: a modulus of {_MODULUS:g} Pa")
    ratio = min(max(flex.poissons_ratio, 0.0), 0.5)
    if ratio != flex.poissons_ratio:
        report.add("assumed", title, f"Poisson's ratio {ratio:g} instead of {flex.poissons_ratio:g}")
    material = RodMaterial(
        youngs_modulus=flex.youngs_modulus if flex.youngs_modulus > 0.0 else _MODULUS,
        poissons_ratio=ratio,
        radius=0.5 * (flex.thickness if flex.thickness > 0.0 else _DIAMETER),
        density=1.0,  # the mass is given
        strain_damping=flex.damping,
    )
    given: dict[str, Any] = {}
    for name, value in flex.rod_stiffnesses.items():
        own = ["bending_stiffness_1", "bending_stiffness_2"] if name == "bending_stiffness" else [name]
        if not value > 0.0:  # a rod must have some; 0 in RodMaterial is that of the section
            value = _SLACK * material.section[own[0]]
            report.add("assumed", title, f"no {name}: {value:g}, {_SLACK:g} times that of its section")
        given |= dict.fromkeys(own, value)
    return material.replace(**given)


def _ratio(flex: Flex, report: Report, title: str) -> float:
    if flex.poissons_ratio <= _LARGEST_RATIO:
        return flex.poissons_ratio
    report.add("assumed", title, f"Poisson's ratio {_LARGEST_RATIO:g} instead of {flex.poissons_ratio:g}")
    return _LARGEST_RATIO
