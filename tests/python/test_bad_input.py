# ruff: noqa: E501
"""Bad input: every case raises the right exception, whose message names the object, the value and a remedy.

The cases run in one interpreter, which therefore survived all the ones before; the last test runs a handful
in a process of its own and looks at the exit code and at the files."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import InitialIntersection, InvalidArgument, InvalidMesh, InvalidSetting, mesh

NAN, INF = float("nan"), float("inf")


def cloth(**options: Any) -> Any:
    return stark.Scene().add_cloth(mesh.grid(1.0, 1.0, 2), name="sheet", **options)


def solid(**options: Any) -> Any:
    return stark.Scene().add_solid(mesh.tet_box(1.0, 1), name="block", **options)


def rigid(**options: Any) -> Any:
    return stark.Scene().add_rigid(mesh.box(1.0), name="crate", **options)


def cloth_of(vertices: Any, triangles: Any) -> Any:
    return stark.Scene().add_cloth((vertices, triangles), name="sheet")


def solid_of(vertices: Any, tets: Any) -> Any:
    return stark.Scene().add_solid((vertices, tets), name="block")


def rigid_of(vertices: Any, triangles: Any, **options: Any) -> Any:
    return stark.Scene().add_rigid((vertices, triangles), name="crate", **{"mass": 1.0, **options})


SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
CORNER = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
ONE_TET = np.array([[0, 1, 2, 3]])
BOX = mesh.box(1.0)


def changed(array: np.ndarray, index: Any, value: float) -> np.ndarray:
    copy = np.array(array, dtype=np.float64)
    copy[index] = value
    return copy


def two_bodies() -> stark.Scene:
    scene = stark.Scene()
    scene.add_box(1.0, mass=1.0)
    scene.add_floor()
    return scene


def named(name: str) -> stark.Scene:
    scene = stark.Scene()
    scene.add_floor(name=name)
    return scene


def assign(target: Any, name: str, value: Any) -> None:
    setattr(target, name, value)


def duplicate_name() -> None:
    scene = two_bodies()
    scene.add_box(0.1, mass=1.0, name="floor")


def friction(a: Any, b: Any, value: Any) -> None:
    two_bodies().friction[a, b] = value


def foreign_body() -> None:
    two_bodies().disable_contact(cloth(), "floor")


def crossing() -> stark.Scene:
    scene = lone_box()
    scene.add_cloth(mesh.grid(2.0, 2.0, 4), name="sheet", position=(0, 0, 0.1))
    return scene


def torn_sheet() -> stark.Scene:
    """Each triangle with vertices of its own, as in files that write them for each face."""
    scene, grid = stark.Scene(), mesh.grid(1.0, 1.0, 2)
    rows = np.arange(3 * len(grid.triangles)).reshape(-1, 3)
    scene.add_cloth(mesh.TriangleMesh(grid.vertices[grid.triangles].reshape(-1, 3), rows), name="sheet")
    return scene


def pea_in_a_box() -> stark.Scene:
    scene = stark.Scene()
    scene.add_box(1.0, mass=1.0)
    scene.add_sphere(0.1, mass=1.0, name="pea")
    return scene


def lone_box() -> stark.Scene:
    scene = stark.Scene()
    scene.add_box(1.0, mass=1.0)
    return scene


def pea_apart() -> stark.Scene:
    scene = lone_box()
    scene.add_sphere(0.1, mass=1.0, position=(2, 0, 0))
    return scene


def simulate(scene: Any = None, *args: Any, **settings: Any) -> Any:
    return stark.Simulation(two_bodies() if scene is None else scene, *args, **settings)


def late_step(length: float) -> None:
    sim = simulate(lone_box(), time_step=0.01)
    sim.step()
    taken = sim._taken
    try:
        sim.step(max_time_step=length)
    finally:
        assert sim._taken is taken


@dataclass
class Case:
    name: str
    action: Callable[[], Any]
    error: type[Exception]
    parts: tuple[str, ...]  # object, value, rule or remedy


CASES = [
    # Vertices and indices.
    Case("nan vertex", lambda: cloth_of(changed(SQUARE, (2, 1), NAN), TWO), InvalidMesh,
         ("cloth 'sheet'", "vertex 2 is at (1, nan, 0) m", "finite", "repair or remove")),
    Case("infinite vertex", lambda: solid_of(changed(CORNER, (3, 2), INF), ONE_TET), InvalidMesh,
         ("solid 'block'", "vertex 3 is at (0, 0, inf) m", "finite")),
    Case("nan vertex of a rigid body", lambda: rigid_of(changed(BOX.vertices, (0, 0), NAN), BOX.triangles), InvalidMesh,
         ("rigid body 'crate'", "vertex 0", "nan", "finite")),
    Case("index too large", lambda: cloth_of(SQUARE, [[0, 1, 2], [0, 2, 4]]), InvalidMesh,
         ("cloth 'sheet'", "triangle 1 refers to vertex 4", "[0, 4)", "start at 0")),
    Case("index far too large", lambda: cloth_of(SQUARE, [[0, 1, 10**6]]), InvalidMesh,
         ("triangle 0 refers to vertex 1000000", "[0, 4)")),
    Case("negative index", lambda: cloth_of(SQUARE, [[0, -1, 2]]), InvalidMesh,
         ("triangle 0 refers to vertex -1", "[0, 4)")),
    Case("tet index too large", lambda: solid_of(CORNER, [[0, 1, 2, 4]]), InvalidMesh,
         ("solid 'block'", "tetrahedron 0 refers to vertex 4", "[0, 4)")),
    Case("rigid index too large", lambda: rigid_of(SQUARE, [[0, 1, 7]]), InvalidMesh,
         ("rigid body 'crate'", "refers to vertex 7")),
    Case("index beyond 32 bits", lambda: cloth_of(SQUARE, [[0, 1, 2**40]]), InvalidMesh,
         ("sheet", "1099511627776", "32 bits")),
    Case("repeated vertex in a triangle", lambda: cloth_of(SQUARE, [[0, 1, 1]]), InvalidMesh,
         ("cloth 'sheet'", "triangle 0 uses vertex 1 twice", "remove the element")),
    Case("repeated vertex in a tet", lambda: solid_of(CORNER, [[0, 1, 2, 2]]), InvalidMesh,
         ("solid 'block'", "tetrahedron 0 uses vertex 2 twice")),
    # Shapes and types.
    Case("vertices in the plane", lambda: cloth_of(SQUARE[:, :2], TWO), InvalidMesh,
         ("sheet", "(4, 2)", "must be (n, 3)")),
    Case("vertices in a row", lambda: cloth_of(SQUARE.ravel(), TWO), InvalidMesh, ("sheet", "(12,)", "must be (n, 3)")),
    Case("ragged tets", lambda: solid_of(CORNER, [[0, 1, 2, 3], [0]]), InvalidMesh, ("block", "tets", "(m, 4)")),
    Case("ragged vertices", lambda: cloth_of([[0, 0, 0], [1, 0]], TWO), InvalidMesh, ("sheet", "vertices", "(n, 3)")),
    Case("vertices of text", lambda: cloth_of([["a", "b", "c"]], TWO), InvalidMesh, ("vertices", "real numbers")),
    Case("quads as triangles", lambda: cloth_of(SQUARE, [[0, 1, 2, 3]]), InvalidMesh, ("sheet", "(1, 4)", "must be (m, 3)")),
    Case("triangles as tets", lambda: solid_of(CORNER, [[0, 1, 2]]), InvalidMesh, ("block", "(1, 3)", "must be (m, 4)")),
    Case("fractional indices", lambda: cloth_of(SQUARE, [[0.0, 1.0, 2.5]]), InvalidMesh,
         ("sheet", "float64", "must be integers", "astype")),
    Case("no triangles", lambda: cloth_of(SQUARE, np.empty((0, 3), int)), InvalidMesh,
         ("cloth 'sheet'", "0 triangles", "at least one")),
    Case("no tets", lambda: solid_of(CORNER, []), InvalidMesh, ("solid 'block'", "0 tetrahedra", "tetrahedralise")),
    Case("a number as mesh", lambda: stark.Scene().add_cloth(3), InvalidMesh, ("cloth", "int", "stark.TriangleMesh")),
    Case("a path as mesh", lambda: stark.Scene().add_rigid("box.obj", mass=1), InvalidMesh,
         ("rigid body", "str", "stark.mesh.load")),
    Case("surface as solid", lambda: stark.Scene().add_solid(BOX, name="block"), InvalidMesh,
         ("solid 'block'", "TriangleMesh", "tetrahedralise")),
    Case("volume as cloth", lambda: stark.Scene().add_cloth(mesh.tet_box(1.0, 1), name="sheet"), InvalidMesh,
         ("cloth 'sheet'", "TetMesh", "add_solid")),
    # Elements.
    Case("degenerate triangle", lambda: cloth_of(changed(SQUARE, (2, slice(None)), [2, 0, 0]), TWO), InvalidMesh, ("cloth 'sheet'", "triangle 0 (vertices 0, 1, 2)", "0 m^2", "remove it")),
    Case("sliver triangle", lambda: cloth_of(changed(SQUARE, (2, slice(None)), [0.5, 1e-8, 0.0]), [[0, 1, 2], [0, 2, 3]]),
         InvalidMesh, ("triangle 0", "5e-09 m^2", "degenerate")),
    Case("degenerate rigid triangle", lambda: rigid_of(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), [[0, 1, 2]]),
         InvalidMesh, ("rigid body 'crate'", "triangle 0", "0 m^2")),
    Case("flat tet", lambda: solid_of(changed(CORNER, (3, 2), 0.0), ONE_TET), InvalidMesh,
         ("solid 'block'", "tetrahedron 0", "0 m^3", "remesh")),
    Case("inverted tet", lambda: solid_of(CORNER, [[1, 0, 2, 3]]), InvalidMesh,
         ("solid 'block'", "tetrahedron 0", "-0.167 m^3", "1 of 1 are inverted", "stark.mesh.oriented")),
    Case("unused vertex of a cloth", lambda: cloth_of(np.vstack([SQUARE, [[9, 9, 9]]]), TWO), InvalidMesh,
         ("cloth 'sheet'", "1 vertex (first: 4)", "no triangle", "stark.mesh.compact")),
    Case("unused vertices of a solid", lambda: solid_of(np.vstack([CORNER, CORNER + 5]), ONE_TET), InvalidMesh,
         ("solid 'block'", "4 vertices (first: 4)", "stark.mesh.compact")),
    Case("density of an open mesh", lambda: rigid_of(SQUARE, TWO, mass=None, density=1.0), InvalidMesh,
         ("rigid body 'crate'", "not watertight", "4 edges", "stark.mesh.cleaned(mesh)")),
    Case("rigid body inside out", lambda: rigid_of(BOX.vertices, BOX.triangles[:, ::-1]), InvalidMesh,
         ("rigid body 'crate'", "-1 m^3", "counter-clockwise", "stark.mesh.oriented")),
    Case("mixed orientation", lambda: rigid_of(BOX.vertices, np.vstack([BOX.triangles[:1, ::-1], BOX.triangles[1:]])),
         InvalidMesh, ("rigid body 'crate'", "oriented differently", "stark.mesh.oriented")),
    Case("initial positions of another mesh", lambda: cloth(initial_positions=SQUARE), InvalidMesh,
         ("cloth 'sheet'", "initial_positions has 4 rows", "9 vertices")),
    Case("nan initial position", lambda: solid(initial_positions=np.full((9, 3), NAN)), InvalidMesh,
         ("solid 'block'", "initial position 0", "nan", "finite")),
    # Numbers of bodies.
    Case("negative mass", lambda: rigid(mass=-1.0), InvalidArgument,
         ("rigid body 'crate'", "mass = -1 kg", "must be > 0", "fixed")),
    Case("zero mass", lambda: rigid(mass=0.0), InvalidArgument, ("crate", "mass = 0 kg", "must be > 0", "fixed")),
    Case("nan mass", lambda: rigid(mass=NAN), InvalidArgument, ("crate", "mass = nan kg", "must be > 0")),
    Case("infinite mass", lambda: rigid(mass=INF), InvalidArgument, ("crate", "mass = inf kg", "finite", "fixed")),
    Case("mass as text", lambda: rigid(mass="heavy"), InvalidArgument, ("crate", "mass = 'heavy'", "must be a number")),
    Case("negative mass of a cloth", lambda: cloth(mass=-1.0), InvalidArgument, ("cloth 'sheet'", "-1.0 kg", "> 0")),
    Case("mass of a solid as text", lambda: solid(mass="1 kg"), InvalidArgument, ("solid 'block'", "'1 kg'", "> 0")),
    Case("mass and densities of a cloth", lambda: cloth(mass=1.0, material=stark.materials.cotton.replace(
        density=np.full(8, 0.1))), InvalidArgument, ("cloth 'sheet'", "density of each element", "leave out")),
    Case("negative density", lambda: rigid(density=-5.0), InvalidArgument, ("crate", "density = -5 kg/m^3", "must be > 0")),
    Case("no mass at all", lambda: rigid(), InvalidArgument, ("rigid body 'crate'", "none of mass", "add mass= [kg]")),
    Case("mass and density", lambda: rigid(mass=1.0, density=1.0), InvalidArgument, ("crate", "more than one", "exactly one")),
    Case("unphysical inertia", lambda: rigid(inertia=(1.0, (0, 0, 0), np.diag([1.0, 1.0, 3.0]))), InvalidArgument,
         ("crate", "(1, 1, 3) kg m^2", "sum of the other two")),
    Case("asymmetric inertia", lambda: rigid(inertia=(1.0, (0, 0, 0), np.eye(3) + np.eye(3, k=1))), InvalidArgument,
         ("crate", "inertia tensor", "1 kg m^2", "symmetric")),
    Case("inertia of another form", lambda: rigid(inertia=(1.0, 2.0)), InvalidArgument, ("crate", "(1.0, 2.0)", "3x3 tensor")),
    Case("unknown motion", lambda: rigid(motion="scriptd"), InvalidArgument,
         ("crate", "motion = 'scriptd'", "'fixed'", "did you mean 'scripted'?")),
    Case("moving fixed body", lambda: rigid(motion="fixed", velocity=(1, 0, 0)), InvalidArgument,
         ("crate", "(1, 0, 0) m/s", "at rest", "scripted")),
    Case("negative damping", lambda: rigid(mass=1.0, linear_damping=-0.1), InvalidArgument,
         ("crate", "linear_damping = -0.1 1/s", ">= 0")),
    Case("a date for a position", lambda: cloth(position=np.datetime64("2020-01-01")), InvalidArgument,
         ("sheet", "position", "2020-01-01", "three numbers")),
    Case("a step below the rounding of the time", lambda: late_step(1e-20), InvalidArgument,
         ("step", "1e-20 s", "0.01", "must be longer", "max_time_step")),
    Case("nan position", lambda: cloth(position=(0, NAN, 0)), InvalidArgument,
         ("cloth 'sheet'", "position = (0, nan, 0) m", "finite")),
    Case("position in the plane", lambda: cloth(position=(0, 1)), InvalidArgument, ("sheet", "position", "three numbers")),
    Case("infinite velocity", lambda: solid(velocity=(INF, 0, 0)), InvalidArgument,
         ("solid 'block'", "velocity = (inf, 0, 0) m/s", "finite")),
    Case("scaled rotation", lambda: rigid(mass=1.0, rotation=2 * np.eye(3)), InvalidArgument,
         ("crate", "rotation", "determinant 8", "stark.rotation(axis=, angle=)")),
    Case("mirroring rotation", lambda: cloth(rotation=np.diag([1.0, 1.0, -1.0])), InvalidArgument,
         ("sheet", "determinant -1", "determinant 1")),
    Case("zero quaternion", lambda: cloth(rotation=(0, 0, 0, 0)), InvalidArgument, ("sheet", "(w, x, y, z)", "not all zero")),
    Case("rotation of another form", lambda: cloth(rotation=(1, 2, 3)), InvalidArgument, ("sheet", "(1, 2, 3)", "quaternion")),
    Case("zero contact distance", lambda: cloth(contact_distance=0.0), InvalidArgument,
         ("cloth 'sheet'", "contact_distance = 0 m", "must be > 0", "contact.distance")),
    Case("negative friction of a body", lambda: cloth(friction=-0.5), InvalidArgument,
         ("cloth 'sheet'", "friction = -0.5", ">= 0", "default")),
    Case("color out of range", lambda: cloth(color=(0, 0, 255)), InvalidArgument, ("sheet", "color channel = 255", "[0, 1]")),
    Case("unknown rest angles", lambda: cloth(rest_angles="curved"), InvalidArgument, ("sheet", "'curved'", "'flat', 'mesh'")),
    # Names and pairs.
    Case("duplicate name", duplicate_name, InvalidArgument, ("rigid body 'floor'", "taken", "unique", "choose another")),
    Case("empty name", lambda: stark.Scene().add_floor(name=""), InvalidArgument, ("name = ''", "non-empty")),
    Case("name of another type", lambda: stark.Scene().add_floor(name=7), InvalidArgument, ("name = 7", "text")),
    Case("unknown body", lambda: two_bodies()["flor"], InvalidArgument, ("unknown body 'flor'", "did you mean 'floor'?")),
    Case("unlike any body", lambda: named("c")["x"], InvalidArgument, ("unknown body 'x': must be",)),
    Case("body of another scene", foreign_body, InvalidArgument, ("'sheet'", "another scene", "add it here")),
    Case("number as body", lambda: two_bodies().disable_contact(1, 2), InvalidArgument, ("body = 1", "its name")),
    Case("negative friction", lambda: friction("box", "floor", -1.0), InvalidArgument,
         ("friction of 'box' and 'floor'", "-1", ">= 0", "use 0")),
    Case("nan friction", lambda: friction("box", "floor", NAN), InvalidArgument, ("'box' and 'floor'", "nan", ">= 0")),
    Case("friction as text", lambda: friction("box", "floor", "high"), InvalidArgument, ("floor", "'high'", "must be a number")),
    Case("friction of an unknown pair", lambda: friction("box", "wall", 1.0), InvalidArgument, ("unknown body 'wall'",)),
    Case("friction of one body", lambda: two_bodies().friction["box"], InvalidArgument, ("'box'", "two bodies")),
    Case("negative default friction", lambda: assign(two_bodies(), "default_friction", -1), InvalidArgument,
         ("scene: default_friction = -1", ">= 0", "use 0")),
    # Pins.
    Case("pin out of range", lambda: cloth(pins=[0, 9]), InvalidArgument, ("cloth 'sheet'", "pinned vertex 9", "[0, 9)")),
    Case("negative pin", lambda: cloth().pin([-1]), InvalidArgument,
         ("cloth 'sheet'", "pinned vertex -1", "[0, 9)", "give indices of vertices")),
    Case("negative pin of a new body", lambda: cloth(pins=[-1]), InvalidArgument,
         ("cloth 'sheet'", "pinned vertex -1", "[0, 9)", "give indices of vertices")),
    Case("fractional pin", lambda: cloth().pin([0.5]), InvalidArgument, ("sheet", "float64", "vertex indices")),
    Case("pin mask of another mesh", lambda: cloth().pin(np.ones(4, bool)), InvalidArgument, ("sheet", "(4,)", "(9,)")),
    # Materials.
    Case("negative stiffness", lambda: stark.materials.cotton.replace(youngs_modulus=-1.0), InvalidArgument,
         ("material 'cotton'", "youngs_modulus = -1 Pa", "must be > 0", "default is 5000 Pa")),
    Case("incompressible", lambda: stark.SolidMaterial(poissons_ratio=0.5), InvalidArgument,
         ("SolidMaterial", "poissons_ratio = 0.5", "in [0, 0.5)")),
    Case("nan density", lambda: stark.ShellMaterial(density=NAN), InvalidArgument,
         ("ShellMaterial", "density = nan kg/m^2", "must be > 0")),
    Case("negative damping of a material", lambda: stark.materials.soft_rubber.replace(strain_damping=-1), InvalidArgument,
         ("material 'soft_rubber'", "strain_damping = -1 Pa s", ">= 0")),
    Case("unknown parameter", lambda: stark.materials.cotton.replace(young_modulus=1.0), InvalidArgument,
         ("ShellMaterial", "young_modulus", "did you mean 'youngs_modulus'?")),
    Case("material as text", lambda: cloth(material="cotton"), InvalidArgument, ("cloth", "'cotton'", "stark.materials.cotton")),
    Case("material of a solid on cloth", lambda: cloth(material=stark.materials.soft_rubber), InvalidArgument,
         ("cloth", "SolidMaterial", "stark.ShellMaterial")),
    # Settings.
    Case("unknown setting", lambda: simulate(tme_step=0.1), InvalidSetting, ("'tme_step'", "did you mean 'time_step'?")),
    Case("unknown dotted setting", lambda: simulate(**{"newton.residual_tolerence": 1.0}), InvalidSetting,
         ("'newton.residual_tolerence'", "did you mean 'newton.residual_tolerance'?")),
    Case("unknown attribute", lambda: assign(stark.Settings().newton, "iterations", 3), InvalidSetting,
         ("'newton.iterations'", "newton.max_iterations")),
    Case("setting without its group", lambda: stark.Settings(step_tolerance=1.0), InvalidSetting,
         ("'step_tolerance'", "did you mean 'newton.step_tolerance'?")),
    Case("negative time step", lambda: simulate(time_step=-0.1), InvalidSetting,
         ("time.step = -0.1 s", "must be > 0", "default is")),
    Case("zero time step", lambda: simulate(time_step=0), InvalidSetting, ("time.step = 0 s", "must be > 0")),
    Case("nan gravity", lambda: simulate(gravity=(0, 0, NAN)), InvalidSetting, ("gravity = (0, 0, nan) m/s^2", "finite")),
    Case("gravity as a number", lambda: simulate(gravity=-9.81), InvalidSetting, ("gravity = -9.81", "three numbers")),
    Case("negative tolerance", lambda: assign(stark.Settings().newton, "residual_tolerance", -1.0), InvalidSetting,
         ("newton.residual_tolerance = -1 N", ">= 0", "default is 0 N")),
    Case("infinite tolerance", lambda: simulate(**{"newton.step_tolerance": INF}), InvalidSetting,
         ("newton.step_tolerance = inf m/s", "finite")),
    Case("no tolerance", lambda: simulate(newton={"acceleration_tolerance": 0, "step_tolerance": 0}), InvalidSetting,
         ("newton.step_tolerance", "all 0", "set at least one")),
    Case("fractional count", lambda: simulate(**{"newton.max_iterations": 2.5}), InvalidSetting,
         ("newton.max_iterations = 2.5", "whole number")),
    Case("negative threads", lambda: simulate(threads=-2), InvalidSetting, ("execution.threads = -2", "[0, 1024]")),
    Case("unknown choice", lambda: simulate(**{"linear.solver": "cholesk"}), InvalidSetting,
         ("linear.solver = 'cholesk'", "'pcg'", "did you mean 'cholesky'?")),
    Case("flag as number", lambda: simulate(**{"contact.enabled": 2}), InvalidSetting,
         ("contact.enabled = 2", "true or false")),
    Case("setting as list", lambda: simulate(time_step=[0.1]), InvalidSetting, ("time.step = '[0.1]'", "must be > 0")),
    Case("setting as none", lambda: simulate(time_step=None), InvalidSetting, ("time.step = 'None'", "must be > 0")),
    Case("quarter turn an iteration", lambda: simulate(**{"newton.max_rotation": 1.6}), InvalidSetting,
         ("newton.max_rotation = 1.6 rad", "quarter turn")),
    Case("shortest step above the step", lambda: simulate(**{"time.min_step": 1.0}), InvalidSetting,
         ("time.min_step = 1 s", "time.step", "lower time.min_step")),
    Case("group as setting", lambda: assign(stark.Settings(), "newton", 3), InvalidSetting, ("'newton'", "group")),
    Case("text without value", lambda: stark.Settings().set_text("time.step"), InvalidSetting, ("'time.step'", "name=value")),
    Case("text of another type", lambda: stark.Settings().set_text("time.step=fast"), InvalidSetting,
         ("time.step = 'fast'", "must be > 0")),
    Case("name of a setting elsewhere", lambda: stark.Simulation(lone_box(), dt=0.01), InvalidSetting,
         ("'dt'", "did you mean 'time_step'?")),
    Case("part of the name of a setting", lambda: stark.Settings(iterations=3), InvalidSetting,
         ("'iterations'", "'newton.max_iterations'")),
    Case("other words of other programs", lambda: stark.Settings().update({"newton.maxiter": 9}), InvalidSetting,
         ("unknown setting 'newton.maxiter' (did you mean 'newton.max_iterations'?)",)),
    Case("start of the name of a setting", lambda: stark.Settings().update({"newton.residual": 1e-3}), InvalidSetting,
         ("unknown setting 'newton.residual' (did you mean 'newton.residual_tolerance'?)",)),
    Case("part of the name of a parameter", lambda: stark.materials.cotton.replace(damping=1), InvalidArgument,
         ("unknown parameter 'damping'", "did you mean")),
    # Simulations.
    Case("empty scene", lambda: simulate(stark.Scene("nothing")), InvalidArgument, ("'nothing'", "0 bodies", "add_cloth")),
    Case("crossing surfaces", lambda: simulate(crossing()), InitialIntersection,
         ("'box' and 'sheet'", "intersect", "near (", "move them apart")),
    Case("triangles that share no vertices", lambda: simulate(torn_sheet()), InitialIntersection,
         ("'sheet' intersects itself", "lie at the same places", "stark.mesh.merged(mesh)")),
    Case("contained body", lambda: simulate(pea_in_a_box()), InitialIntersection,
         ("'pea' is inside 'box'", "near (", "fills its closed surface", "move it out", "hollow = true")),
    Case("density of a shell", lambda: stark.Scene().add_box(1.0, density=1.0, hollow=True), InvalidArgument,
         ("density = 1 kg/m^3", "no volume", "mass=")),
    Case("hollow as a number", lambda: stark.Scene().add_box(1.0, mass=1.0, hollow=2), InvalidArgument,
         ("hollow = 2", "True or False")),
    Case("body that is no part of the simulation", lambda: simulate(lone_box())["wall"], InvalidArgument, ("unknown body 'wall'",)),
    Case("run to nan", lambda: simulate(lone_box()).run(NAN), InvalidArgument, ("until = nan s", ">= 0")),
    Case("negative step", lambda: simulate(lone_box()).step(max_time_step=-1), InvalidArgument,
         ("max_time_step = -1 s", "> 0")),
    Case("nowhere for a dynamic body", lambda: assign(simulate(lone_box())["box"], "position", (0, 0, NAN)),
         InvalidArgument, ("'box': position", "must be finite")),
    Case("state of another simulation", lambda: assign(simulate(lone_box()), "state", simulate(pea_apart()).state),
         InvalidArgument, ("state", "rigid bodies", "same scene")),
    Case("mesh as scene", lambda: simulate(BOX), InvalidArgument, ("TriangleMesh", "stark.Scene")),
    Case("number as settings", lambda: simulate(None, 0.1), InvalidArgument, ("settings = 0.1", "stark.Settings")),
    Case("pose without a simulation", lambda: assign(rigid(motion="scripted"), "position", (0, 0, 1)), InvalidArgument,
         ("'crate'", "needs a simulation", "stark.Simulation(scene)")),
    Case("velocities without a simulation", lambda: cloth().velocities, InvalidArgument, ("'sheet'", "velocities need a simulation")),
    Case("pins in words", lambda: stark.Scene().add_cloth(mesh.grid(1.0, 1.0, 2), pins="corners"), InvalidArgument,
         ("pins = 'corners'", "indices of vertices, like [0, 8]")),
    # Shapes, rotations, files.
    Case("negative size", lambda: mesh.box(-1.0), InvalidArgument, ("box: size = -1.0 m", "positive")),
    Case("size of two numbers", lambda: stark.Scene().add_box((1, 2), mass=1), InvalidArgument, ("box: size", "(1, 2)", "three")),
    Case("no turns", lambda: mesh.helix(0.1, 0.1, 0, 4), InvalidArgument, ("helix: turns = 0: must be a number > 0",)),
    Case("no cells", lambda: mesh.grid(1.0, 1.0, 0), InvalidArgument, ("grid: cells = 0", "[1, 100000]")),
    Case("fractional cells", lambda: mesh.tet_box(1.0, (1, 2, 2.5)), InvalidArgument, ("tet_box: cells = 2.5", "whole number")),
    Case("nan radius", lambda: mesh.sphere(NAN), InvalidArgument, ("sphere: radius = nan m", "> 0")),
    Case("sphere of a billion triangles", lambda: mesh.sphere(1.0, 13), InvalidArgument, ("subdivisions = 13", "at most 8")),
    Case("torus through itself", lambda: mesh.torus(0.1, 0.2), InvalidArgument, ("minor_radius = 0.2 m", "major_radius")),
    Case("zero axis", lambda: stark.rotation(axis=(0, 0, 0), angle=1.0), InvalidArgument, ("axis = (0, 0, 0)", "direction")),
    Case("unknown axis", lambda: stark.rotation(axis="w", angle=1.0), InvalidArgument, ("axis = 'w'", "'x', 'y', 'z'")),
    Case("nan angle", lambda: stark.rotation(axis="x", angle=NAN), InvalidArgument, ("angle = nan rad", "finite")),
    Case("angle without axis", lambda: stark.rotation(angle=1.0), InvalidArgument, ("axis= and angle=", "stark.deg")),
    Case("no such file", lambda: mesh.load("/nowhere/cup.obj"), InvalidMesh, ("/nowhere/cup.obj", "readable mesh file")),
]  # fmt: skip


def test_there_are_at_least_sixty_cases_with_names_of_their_own() -> None:
    assert len(CASES) >= 60
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_bad_input_is_refused(case: Case) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(case.error) as caught:
            case.action()
    message = str(caught.value)
    assert isinstance(caught.value, stark.Error)
    for part in case.parts:
        assert part in message, f"'{part}' is not in: {message}"
    assert "\n" not in message


def test_a_refused_body_leaves_the_scene_as_it_was() -> None:
    scene = two_bodies()
    with pytest.raises(InvalidArgument):
        scene.add_cloth(mesh.grid(1, 1, 2), pins=[100])
    with pytest.raises(InvalidMesh):
        scene.add_solid((CORNER, [[1, 0, 2, 3]]))
    assert [body.name for body in scene] == ["box", "floor"]
    assert scene._core.body_count == 2


def test_refused_settings_leave_all_settings_as_they_were() -> None:
    settings = stark.Settings(time_step=0.01)
    with pytest.raises(InvalidSetting):
        settings.update({"contact_distance": 1e-4, "newton.max_iterations": -1})
    assert settings.changed() == {"time.step": 0.01}


def test_the_process_survives_and_writes_nothing(tmp_path: Any) -> None:
    script = """
import numpy, stark
failures = 0
for action in (
    lambda: stark.Scene().add_cloth((numpy.full((3, 3), numpy.nan), [[0, 1, 2]])),
    lambda: stark.Scene().add_cloth((numpy.zeros((3, 3)), [[0, 1, 2147483647]])),
    lambda: stark.Scene().add_solid((numpy.zeros((4, 3)), [[0, 1, 2, -2147483648]])),
    lambda: stark.Scene().add_rigid(stark.mesh.box(1.0), mass=-1.0),
    lambda: stark.Settings(time_step=float("nan")),
    lambda: stark._core.Scene().name(5),
    lambda: stark._core.Scene().pin(-1, [0]),
):
    try:
        action()
    except stark.InvalidArgument:
        failures += 1
print(failures, "refused")
"""
    environment = {**os.environ, "PYTHONPATH": str(Path(stark.__file__).parents[1])}
    run = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == "7 refused"
    assert run.stderr == ""
    assert list(tmp_path.iterdir()) == []
