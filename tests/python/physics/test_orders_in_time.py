"""Order of convergence in time of every law, one by one: each drives or damps a body of a few nodes, with
implicit Euler and BDF2. Orders are those of the differences of runs with steps h, h/2 and h/4; what damps is
compared with its exact solution where there is one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _mechanisms import observed_order, simulate
from _validation import validate
from test_orders_in_space import MEMBRANES, SOLIDS, stretched_and_bent, stretched_in_plane

import stark

EXACT = {"newton.acceleration_tolerance": 1e-7, "newton.step_tolerance": 1e-10}
UNTIL = 0.24  # [s]
STEPS = (0.008, 0.004, 0.002)  # [s]
Observed = Callable[[], np.ndarray]
Motion = Callable[[stark.Scene], Observed]


def positions(body: Any) -> Observed:
    return lambda: body.positions


# --- solids: a cube of 1 m, one element, that is let go from a bent shape ---


def cube(material: Any) -> Motion:
    def add(scene: stark.Scene) -> Observed:
        mesh = stark.mesh.box_hexahedra(1.0, 1)
        start = stretched_and_bent(mesh.vertices)
        return positions(scene.add_solid(mesh, material, initial_positions=start, self_contact=False))

    return add


def heavy(material: Any, **changes: float) -> Any:
    return material.replace(density=200.0, **changes)  # periods of a second and more


RUBBER = SOLIDS["stable_neo_hookean"][1]
MOTIONS: dict[str, Motion] = {name: cube(heavy(material)) for name, (_, material) in SOLIDS.items()}
MOTIONS["solid_strain_damping"] = cube(heavy(RUBBER, strain_damping=500.0))
MOTIONS["solid_mass_damping"] = cube(heavy(RUBBER, mass_damping=2.0))
LIMIT = {"strain_limit": 0.05, "strain_limit_stiffness": 1e4, "strain_limit_hardening": 0.0}
MOTIONS["solid_strain_limit"] = cube(heavy(RUBBER, **LIMIT))


# --- cloth: eight triangles of 1 m2, one edge held ---


def sheet(material: Any, shape: Callable[[np.ndarray], np.ndarray], **options: Any) -> Motion:
    def add(scene: stark.Scene) -> Observed:
        mesh = stark.mesh.grid(1.0, 1.0, 2)
        pins = mesh.vertices[:, 0] < -0.4999
        start = shape(mesh.vertices)
        start[pins] = mesh.vertices[pins]
        cloth = scene.add_cloth(
            mesh, material, initial_positions=start, pins=pins, self_contact=False, **options
        )
        return positions(cloth)

    return add


def rolled(X: np.ndarray) -> np.ndarray:
    """On a cylinder about y, its generator at the held edge."""
    angle = 1.2 * (X[:, 0] + 0.5)
    return np.column_stack([np.sin(angle) / 1.2 - 0.5, X[:, 1], (1 - np.cos(angle)) / 1.2])


MOTIONS |= {name: sheet(heavy(m), stretched_in_plane) for name, (_, m) in MEMBRANES.items()}
FABRIC = heavy(MEMBRANES["membrane"][1])
MOTIONS["membrane_strain_damping"] = sheet(FABRIC.replace(strain_damping=200.0), stretched_in_plane)
MOTIONS["membrane_strain_limit"] = sheet(FABRIC.replace(**LIMIT), stretched_in_plane)
# 1 kg/m2, so soft in its plane that steps resolve its motion there too.
PLATE: dict[str, float] = {"density": 1.0, "thickness": 1.0, "youngs_modulus": 10.0}
HINGE = stark.ShellMaterial(**PLATE, bending_stiffness=0.1)
MOTIONS["hinge_flat"] = sheet(HINGE, rolled)
MOTIONS["hinge_mesh"] = sheet(HINGE, rolled, rest_angles="mesh")
MOTIONS["plate"] = sheet(stark.ShellMaterial(**PLATE, flexural_rigidity=0.03), rolled)
MOTIONS["bending_damping"] = sheet(HINGE.replace(bending_damping=0.03), rolled)


# --- rods: three segments, clamped at one end, with a velocity ---


def rod(velocity: Any = (0, 0, 0), turning: Any = (0, 0, 0), **changes: float) -> Motion:
    def add(scene: stark.Scene) -> Observed:
        material = stark.RodMaterial(density=200.0, youngs_modulus=1e3, radius=0.2, **changes)
        line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), 3)
        body = scene.add_rod(
            line, material, velocity=velocity, angular_velocity=turning, clamps=[0], self_contact=False
        )
        return lambda: np.concatenate([body.positions.ravel(), body.frames.ravel()])

    return add


SIDEWAYS = {"velocity": (0.0, 0.6, 0.4)}
MOTIONS["rod_stretch"] = rod(velocity=(0.3, 0.0, 0.0))
MOTIONS["rod_bending"] = rod(velocity=(0.0, 0.3, 0.2))
MOTIONS["rod_twist"] = rod(turning=(1.0, 0.0, 0.0))
MOTIONS["rod_strain_damping"] = rod(**SIDEWAYS, strain_damping=0.3)
MOTIONS["rod_mass_damping"] = rod(**SIDEWAYS, mass_damping=2.0)


# --- rigid bodies and springs ---


def block(scene: stark.Scene, **options: Any) -> Any:
    return scene.add_box((0.3, 0.2, 0.1), mass=1.0, **options)


def joint_spring(kind: str, damping: float) -> Motion:
    """A block on a joint to the world, with a spring and damper along its coordinate."""

    def add(scene: stark.Scene) -> Observed:
        if kind == "hinge":
            body = block(scene, velocity=(0.0, 0.6, 0.0), angular_velocity=(0.0, 0.0, 3.0))
            joint = scene.add_hinge(None, body, anchor=(-0.2, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
            joint.add_spring(2.0, damping=damping)
        elif kind == "slider":
            body = block(scene, velocity=(0.5, 0.0, 0.0))
            joint = scene.add_slider(None, body, anchor=(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0))
            joint.add_spring(40.0, damping=damping)
        else:  # between a corner of the block and a point: it swings and turns
            body = block(scene, velocity=(0.0, 0.5, 0.3))
            scene.add_spring(None, body, (0.6, 0.2, 0.1), (0.1, 0.1, 0.05), stiffness=15.0, damping=damping)
        return lambda: np.concatenate([body.position, body.rotation.ravel()])

    return add


for _kind, _damping in (("hinge", 0.1), ("slider", 4.0), ("span", 4.0)):
    MOTIONS[f"{_kind}_spring"] = joint_spring(_kind, 0.0)
    MOTIONS[f"{_kind}_damper"] = joint_spring(_kind, _damping)


def damped(**damping: float) -> Motion:
    def add(scene: stark.Scene) -> Observed:
        body = block(scene, velocity=(1.0, 0.0, 0.5), angular_velocity=(1.0, 2.5, 1.5), **damping)
        return lambda: np.concatenate([body.position, body.rotation.ravel()])

    return add


MOTIONS["linear_damping"] = damped(linear_damping=2.0)
MOTIONS["angular_damping"] = damped(angular_damping=2.0)


def run(motion: Motion, integrator: str, step: float) -> np.ndarray:
    scene = stark.Scene()
    observe = motion(scene)
    sim = simulate(scene, step, gravity=(0, 0, 0), **{"time.integrator": integrator}, **EXACT)
    for report in sim.run(UNTIL):
        assert report.status == "accepted", report.message
    return observe().ravel()


def order_of(law: str, integrator: str) -> float:
    return observed_order(*(run(MOTIONS[law], integrator, h) for h in STEPS))


@pytest.mark.parametrize("law", MOTIONS)
def test_laws_converge_in_time(law: str) -> None:
    validate(f"time.{law}", [order_of(law, "implicit_euler"), order_of(law, "bdf2")])
