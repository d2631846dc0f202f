"""Deformable bodies of USD files: shapes, units, masses and stiffnesses are those of the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robots._stages import HEAD, body, joint, numbers, shape

import stark

pytest.importorskip("pxr")

GRID = stark.mesh.grid(0.3, 0.2, (6, 4))
BLOCK = stark.mesh.tet_box(0.1, cells=3)


def rows(values: Any) -> str:
    return "[" + ", ".join(numbers(row) for row in np.asarray(values)) + "]"


def flat(values: Any) -> str:
    return "[" + ", ".join(str(int(value)) for value in np.ravel(values)) + "]"


def sheet(
    name: str, inner: str = "", *, unit: float = 1.0, place: Any = (0, 0, 0), collides: bool = True
) -> str:
    """A cloth whose prim is body and simulation geometry in one."""
    schemas = ["PhysicsDeformableBodyAPI", "PhysicsSurfaceDeformableSimAPI", "MaterialBindingAPI"]
    listed = ", ".join(f'"{name}"' for name in schemas + ["PhysicsCollisionAPI"] * collides)
    return (
        f'def Mesh "{name}" (prepend apiSchemas = [{listed}]) {{\n'
        f"point3f[] points = {rows(GRID.vertices / unit)}\n"
        f"int[] faceVertexCounts = {flat(np.full(len(GRID.triangles), 3))}\n"
        f"int[] faceVertexIndices = {flat(GRID.triangles)}\n"
        f"double3 xformOp:translate = {numbers(place)}\n"
        f'uniform token[] xformOpOrder = ["xformOp:translate"]\n{inner}\n}}\n'
    )


def block(name: str, inner: str = "", *, unit: float = 1.0, place: Any = (0, 0, 0), outer: str = "") -> str:
    """A solid whose simulation geometry is a child of the body."""
    return (
        f'def Xform "{name}" (prepend apiSchemas = ["PhysicsDeformableBodyAPI"]) {{\n{outer}\n'
        f"double3 xformOp:translate = {numbers(place)}\n"
        'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
        'def TetMesh "simulation" (prepend apiSchemas = ["PhysicsVolumeDeformableSimAPI", '
        '"PhysicsCollisionAPI", "MaterialBindingAPI"]) {\n'
        f"point3f[] points = {rows(BLOCK.vertices / unit)}\n"
        f"int4[] tetVertexIndices = {rows_of_integers(BLOCK.tets)}\n{inner}\n}}\n}}\n"
    )


def rows_of_integers(values: Any) -> str:
    return "[" + ", ".join("(" + ", ".join(map(str, map(int, row))) + ")" for row in values) + "]"


def material(name: str, inner: str) -> str:
    schemas = (
        '"PhysicsMaterialAPI", "PhysicsSurfaceDeformableMaterialAPI", "PhysicsVolumeDeformableMaterialAPI"'
    )
    return f'def Material "{name}" (prepend apiSchemas = [{schemas}]) {{\n{inner}\n}}\n'


def bound(name: str) -> str:
    return f"rel material:binding:physics = </robot/{name}>"


def written(folder: Path, *parts: str, metre: float = 1.0, kilogram: float = 1.0, up: str = "Z") -> Path:
    file = folder / "soft.usda"
    head = HEAD.format(metre=metre, kilogram=kilogram, up=up)
    file.write_text(head + 'def Xform "robot" {\n' + "".join(parts) + "}\n")
    return file


def added(file: Path) -> Any:
    scene = stark.Scene()
    return scene.add_robot(file)


def test_a_block_in_centimetres_and_grams_with_y_up(tmp_path: Path) -> None:
    rubber = material("rubber", "float physics:youngsModulus = 5e5\nfloat physics:poissonsRatio = 0.4\n"
                                "float physics:density = 1.1")  # fmt: skip
    file = written(
        tmp_path, rubber, block("jelly", bound("rubber"), unit=0.01, place=(10, 20, 30)),
        metre=0.01, kilogram=0.001, up="Y",
    )  # fmt: skip
    robot = added(file)
    jelly = robot.flexes["jelly"]
    assert isinstance(jelly, stark.Solid)
    law = jelly._shared["material"]
    assert law.youngs_modulus == pytest.approx(5e4)  # 5e5 g/(cm s^2)
    assert law.poissons_ratio == pytest.approx(0.4)
    assert jelly.mass == pytest.approx(1.1e3 * 0.1**3, rel=1e-6)
    found = stark.Simulation(jelly._scene).robots[0].flexes["jelly"].positions
    x, y, z = BLOCK.translated((0.1, 0.2, 0.3)).vertices.T
    np.testing.assert_allclose(found, np.column_stack([x, -z, y]), atol=1e-6)


def test_stiffnesses_of_a_sheet(tmp_path: Path) -> None:
    """Those of stretch and bending, or of the modulus and thickness as in a plate."""
    moduli = "float physics:youngsModulus = 2e6\nfloat physics:poissonsRatio = 0.25"
    own = "float physics:surfaceStretchStiffness = 800\nfloat physics:surfaceBendStiffness = 1e-4"
    thick = 'float[] physics:thicknesses = [4e-4]\nuniform token physics:thicknesses:elementType = "constant"'
    heavy = 'float[] physics:masses = [0.02]\nuniform token physics:masses:elementType = "constant"'
    file = written(
        tmp_path, material("foil", moduli), material("woven", moduli + "\n" + own),
        sheet("plate", f"{bound('foil')}\n{thick}\nfloat physics:density = 900"),
        sheet("cloth", f"{bound('woven')}\n{thick}\n{heavy}", place=(0, 0, 0.2), collides=False),
    )  # fmt: skip
    robot = added(file)
    plate, cloth = (robot.flexes[name]._shared["material"] for name in ("plate", "cloth"))
    assert plate.youngs_modulus == pytest.approx(2e6)
    assert plate.flexural_rigidity == pytest.approx(2e6 * 4e-4**3 / (12 * (1 - 0.25**2)), rel=1e-6)
    assert robot.flexes["plate"].mass == pytest.approx(900 * 0.3 * 0.2 * 4e-4, rel=1e-6)
    assert cloth.youngs_modulus * cloth.thickness == pytest.approx(800 * (1 - 0.25**2), rel=1e-6)
    assert cloth.flexural_rigidity == pytest.approx(1e-4, rel=1e-6)
    assert robot.flexes["cloth"].mass == pytest.approx(0.02, rel=1e-6)


def test_a_flag_hangs_at_an_arm_and_a_sheet_at_the_world(tmp_path: Path) -> None:
    corner = np.flatnonzero(GRID.vertices[:, 0] < GRID.vertices[:, 0].min() + 1e-9)
    holds = [
        f'def PhysicsAttachment "hold_{name}" {{\nrel physics:src0 = </robot/{name}>\n{target}'
        f'uniform token physics:type0 = "point"\nuniform token physics:type1 = "xform"\n'
        f"int[] physics:indices0 = {flat(corner)}\n}}\n"
        for name, target in (("flag", "rel physics:src1 = </robot/arm>\n"), ("curtain", ""))
    ]
    hinge = joint("h", "PhysicsRevoluteJoint", "", "arm", 'uniform token physics:axis = "Y"')
    file = written(
        tmp_path, body("arm", shape("Cube", "double size = 0.05"), mass=0.5), hinge,
        sheet("flag", place=(0.2, 0, 0)), sheet("curtain", place=(0.2, 1.0, 0)), *holds,
    )  # fmt: skip
    scene = stark.Scene()
    robot = scene.add_robot(file)
    flag, curtain = robot.flexes["flag"], robot.flexes["curtain"]
    sim = stark.Simulation(scene, time_step=0.01)
    start = curtain.positions[corner]
    away = flag.positions[corner] - robot.links["arm"].position
    sim.run_until(0.1)
    np.testing.assert_allclose(curtain.positions[corner], start, atol=1e-12)
    assert robot.links["arm"].rotation[2, 0] < -1e-5  # the flag has turned it
    turned = robot.links["arm"].position + away @ robot.links["arm"].rotation.T
    np.testing.assert_allclose(flag.positions[corner], turned, atol=1e-4)
    assert curtain.positions[:, 2].min() < -0.02


def test_shape_at_rest_and_velocity(tmp_path: Path) -> None:
    rest = GRID.vertices * (0.9, 0.9, 1.0)
    velocities = rows(np.tile([0.0, 0.5, 0.0], (len(rest), 1)))
    inner = f"point3f[] physics:restShapePoints = {rows(rest)}\nvector3f[] velocities = {velocities}"
    scene = stark.Scene()
    cloth = scene.add_robot(written(tmp_path, sheet("cloth", inner))).flexes["cloth"]
    sim = stark.Simulation(scene, time_step=1e-4, gravity=(0, 0, 0))
    np.testing.assert_allclose(cloth.positions, GRID.vertices, atol=1e-7)
    np.testing.assert_allclose(cloth.velocities, np.tile([0.0, 0.5, 0.0], (len(rest), 1)), atol=1e-12)
    sim.run_until(0.002)
    assert np.ptp(cloth.positions[:, 0]) < 0.3 - 1e-6  # it is stretched, so it contracts


def test_what_a_file_leaves_open_is_reported(tmp_path: Path) -> None:
    off = sheet("off", "bool physics:bodyEnabled = false")
    robot = added(written(tmp_path, sheet("cloth"), off))
    assert list(robot.flexes) == ["cloth"]
    text = str(robot.report)
    for line in (
        "deformable 'off': bodyEnabled is false",
        "deformable 'cloth': thickness 0.001 m",
        "deformable 'cloth': youngsModulus 1e+06",
        "deformable 'cloth': density 1000 kg/m^3",
        "deformable 'cloth': as of OpenUSD-proposals 111",
    ):
        assert line in text


@pytest.mark.parametrize(
    "part, message",
    [
        ('def Xform "a" (prepend apiSchemas = ["PhysicsDeformableBodyAPI"]) {\n}\n',
         "deformable 'a': has 0 simulation geometries: must have one"),
        (sheet("a").replace("faceVertexIndices = [", "faceVertexIndices = [99, "), "must be 3 numbers"),
        (sheet("a", "float[] physics:thicknesses = [-1]"), "thicknesses: -1 m: must be positive"),
        (sheet("a", "float physics:poissonsRatio = 0.7"), "poissonsRatio = 0.7: must be -1 to 0.5"),
        (block("a", "float[] physics:masses = [-2]"), "masses = -2: must be positive"),
        (sheet("a", "point3f[] physics:restShapePoints = [(0, 0, 0)]"), "1 points: must be 35"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_file_is_named(part: str, message: str, tmp_path: Path) -> None:
    file = written(tmp_path, part)
    with pytest.raises(stark.InvalidArgument, match=r"soft\.usda") as error:
        added(file)
    assert message in str(error.value)
