"""Curves of USD files are rods: shapes, units, masses and stiffnesses are those of the file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robots._stages import HEAD, body, joint, numbers, shape

import stark
from stark.mesh import polyline

pytest.importorskip("pxr")

LINE = polyline((0, 0, 0), (0.3, 0, 0), segments=6).vertices


def beside(y: float) -> Any:
    return LINE + np.array((0.0, y, 0.0))


def listed(rows: Iterable[Any]) -> str:
    return "[" + ", ".join(numbers(row) for row in rows) + "]"


def hair(
    name: str,
    inner: str = "",
    *,
    curves: Iterable[Any] = (LINE,),
    kind: str = "linear",
    unit: float = 1.0,
    place: Any = (0, 0, 0),
    counts: str = "",
) -> str:
    """A prim that is body and simulation geometry in one, with a rod for each of the curves."""
    curves = list(curves)
    return (
        f'def BasisCurves "{name}" (prepend apiSchemas = ["PhysicsDeformableBodyAPI", '
        '"PhysicsCurvesDeformableSimAPI", "MaterialBindingAPI", "PhysicsCollisionAPI"]) {\n'
        f'uniform token type = "{kind}"\npoint3f[] points = {listed(np.vstack(curves) / unit)}\n'
        f"int[] curveVertexCounts = {counts or [len(curve) for curve in curves]}\n"
        f"double3 xformOp:translate = {numbers(place)}\n"
        f'uniform token[] xformOpOrder = ["xformOp:translate"]\n{inner}\n}}\n'
    )


def material(name: str, inner: str) -> str:
    schemas = '"PhysicsMaterialAPI", "PhysicsCurvesDeformableMaterialAPI"'
    return f'def Material "{name}" (prepend apiSchemas = [{schemas}]) {{\n{inner}\n}}\n'


def bound(name: str) -> str:
    return f"rel material:binding:physics = </robot/{name}>"


def thick(*values: float) -> str:
    return f"float[] physics:thicknesses = {list(values)}"


def held(prim: str, link: str, points: list[int]) -> str:
    target = f"rel physics:src1 = </robot/{link}>\n" if link else ""
    return (
        f'def PhysicsAttachment "hold_{prim}_{link}" {{\nrel physics:src0 = </robot/{prim}>\n{target}'
        f'uniform token physics:type0 = "point"\nuniform token physics:type1 = "xform"\n'
        f"int[] physics:indices0 = {points}\n}}\n"
    )


def written(folder: Path, *parts: str, metre: float = 1.0, kilogram: float = 1.0, up: str = "Z") -> Path:
    file = folder / "soft.usda"
    head = HEAD.format(metre=metre, kilogram=kilogram, up=up)
    file.write_text(head + 'def Xform "robot" {\n' + "".join(parts) + "}\n")
    return file


def added(folder: Path, *parts: str, **units: Any) -> Any:
    return stark.Scene().add_robot(written(folder, *parts, **units))


def test_a_curve_in_centimetres_and_grams_with_y_up(tmp_path: Path) -> None:
    moduli = "float physics:youngsModulus = 2e7\nfloat physics:poissonsRatio = 0.25\n"
    own = "float physics:curvesStretchStiffness = 4e6\nfloat physics:curvesBendStiffness = 3e5\n"
    own += "float physics:curvesTwistStiffness = 2e5"
    color = "color3f[] primvars:displayColor = [(0.25, 0.5, 0.75)]"
    robot = added(
        tmp_path, material("wire", moduli + "float physics:density = 1.2"), material("own", moduli + own),
        hair("cord", f"{bound('wire')}\n{thick(0.4)}\n{color}", unit=0.01, place=(10, 20, 30)),
        hair("cable", f"{bound('own')}\n{thick(0.4)}", unit=0.01, place=(10, 20, 40)),
        metre=0.01, kilogram=0.001, up="Y",
    )  # fmt: skip
    cord, cable = robot.flexes["cord"], robot.flexes["cable"]
    assert isinstance(cord, stark.Rod)
    section, area = cord.material.section, np.pi * 0.002**2
    assert section["axial_stiffness"] == pytest.approx(2e6 * area)  # 2e7 g/(cm s^2)
    assert section["bending_stiffness_1"] == pytest.approx(2e6 * np.pi / 4 * 0.002**4)
    assert section["torsional_stiffness"] == pytest.approx(2e6 / 2.5 * np.pi / 2 * 0.002**4)
    assert cord.mass == pytest.approx(1200 * area * 0.3, rel=1e-6)
    assert cord.color == pytest.approx((0.25, 0.5, 0.75))
    section = cable.material.section
    assert section["axial_stiffness"] == pytest.approx(40)  # 4e6 g cm/s^2
    assert section["bending_stiffness_1"] == pytest.approx(3e-4)  # 3e5 g cm^3/s^2
    assert section["bending_stiffness_2"] == pytest.approx(3e-4)
    assert section["torsional_stiffness"] == pytest.approx(2e-4)
    sim = stark.Simulation(cord._scene, time_step=0.01)
    x, y, z = (LINE + np.array((0.1, 0.2, 0.3))).T
    np.testing.assert_allclose(cord.positions, np.column_stack([x, -z, y]), atol=1e-7)
    sim.step()
    assert sim.time == pytest.approx(0.01)


def test_curves_of_one_prim_are_rods_of_their_own(tmp_path: Path) -> None:
    curves = [LINE, beside(0.05)[:4], beside(0.1)[:2]]
    masses = "float[] physics:masses = [0.003, 0.002, 0.001]"
    robot = added(
        tmp_path, hair("hair", f"{thick(2e-3, 1e-3, 3e-3)}\n{masses}", curves=curves),
        hair("hair_1", f"{thick(1e-3)}\nfloat physics:mass = 0.007", place=(0, 0.2, 0)),
    )  # fmt: skip
    assert list(robot.flexes) == ["hair_0", "hair_1_", "hair_2", "hair_1"]
    rods = list(robot.flexes.values())
    assert [len(rod.mesh.vertices) for rod in rods] == [7, 4, 2, 7]
    assert [rod.material.radius for rod in rods] == pytest.approx([1e-3, 5e-4, 1.5e-3, 5e-4])
    assert [rod.mass for rod in rods] == pytest.approx([0.003, 0.002, 0.001, 0.007])
    stark.Simulation(rods[0]._scene, time_step=0.01).step()


@pytest.mark.parametrize(
    "inner, radii, said",
    [
        ("", (5e-4, 5e-4), "diameter 0.001 m"),
        ("float[] widths = [0.004]", (2e-3, 2e-3), "its widths as diameters"),
        (thick(2e-3, 4e-3, 6e-3, 1e-3), (2e-3, 5e-4), "the mean; the file has 0.001 to 0.006 m"),
        (thick(2e-3, 3e-3, 5e-3, 6e-3, 1e-3, 1e-3), (2e-3, 5e-4), "the mean"),
    ],
)  # fmt: skip
def test_one_diameter_a_curve(inner: str, radii: tuple[float, ...], said: str, tmp_path: Path) -> None:
    """Of all, by segment and by point; lengths decide how masses are shared that are not spread."""
    curves = [LINE[:4], beside(0.1)[:2]]
    robot = added(tmp_path, hair("hair", f"{inner}\nfloat physics:mass = 0.01", curves=curves))
    rods = [robot.flexes[f"hair_{k}"] for k in (0, 1)]
    assert [rod.material.radius for rod in rods] == pytest.approx(radii)
    volumes = np.array([3 * radii[0] ** 2, radii[1] ** 2])
    np.testing.assert_allclose([rod.mass for rod in rods], 0.01 * volumes / volumes.sum(), rtol=1e-6)
    assert said in str(robot.report)


def test_points_hang_at_an_arm_and_at_the_world(tmp_path: Path) -> None:
    """Two curves of one prim at two links; what the world holds hangs as a pinned rod does."""
    hinge = joint("h", "PhysicsRevoluteJoint", "", "arm", 'uniform token physics:axis = "Y"')
    stiff = material("cord", "float physics:youngsModulus = 1e6\nfloat physics:density = 1000")
    file = written(
        tmp_path, body("arm", shape("Cube", "double size = 0.05"), mass=0.5), hinge, stiff,
        hair("hair", f"{bound('cord')}\n{thick(4e-3)}", curves=[LINE, beside(1.0)], place=(0.2, 0, 0)),
        held("hair", "arm", [0, 1]), held("hair", "", [7]),
    )  # fmt: skip
    scene = stark.Scene()
    robot = scene.add_robot(file)
    moving, hanging = robot.flexes["hair_0"], robot.flexes["hair_1"]
    cord = stark.RodMaterial(radius=2e-3, youngs_modulus=1e6, poissons_ratio=0.3, density=1000.0)
    other = scene.add_rod(np.float32(beside(1.5)), cord, position=(0.2, 0, 0), pins=[0])
    assert list(hanging.pins) == [0] and hanging.mass == pytest.approx(other.mass, rel=1e-6)
    sim = stark.Simulation(scene, time_step=0.01)
    away = moving.positions[:2] - robot.links["arm"].position
    sim.run_until(0.1)
    assert robot.links["arm"].rotation[2, 0] < -1e-6  # the rod has turned it
    turned = robot.links["arm"].position + away @ robot.links["arm"].rotation.T
    np.testing.assert_allclose(moving.positions[:2], turned, atol=1e-4)
    np.testing.assert_allclose(hanging.positions, other.positions - np.array((0.0, 0.5, 0.0)), atol=1e-6)
    assert hanging.positions[-1, 2] < -0.03
    again = stark.load_scene(scene.save(tmp_path / "scene.json"))
    assert isinstance(again.robots[0].flexes["hair_1"], stark.Rod)


def test_shape_at_rest_and_velocity(tmp_path: Path) -> None:
    rest = LINE * (0.9, 1.0, 1.0)
    inner = f"point3f[] physics:restShapePoints = {listed(rest)}\n{thick(4e-3)}\n"
    inner += f"vector3f[] velocities = {listed(np.tile([0.0, 0.5, 0.0], (7, 1)))}"
    robot = added(tmp_path, hair("hair", inner))
    rod = robot.flexes["hair"]
    sim = stark.Simulation(rod._scene, time_step=1e-4, gravity=(0, 0, 0))
    np.testing.assert_allclose(rod.positions, LINE, atol=1e-7)
    np.testing.assert_allclose(rod.velocities, np.tile([0.0, 0.5, 0.0], (7, 1)), atol=1e-12)
    sim.run_until(0.002)
    assert np.ptp(rod.positions[:, 0]) < 0.3 - 1e-6  # it is stretched, so it contracts


def test_what_a_file_leaves_open_is_reported(tmp_path: Path) -> None:
    slack = "float physics:curvesBendStiffness = 0\nfloat physics:poissonsRatio = -0.5"
    own = '"PhysicsDeformableBodyAPI"'
    inner = hair("curve", place=(0, 0.2, 0)).replace(f"{own}, ", "").replace(', "PhysicsCollisionAPI"', "")
    robot = added(
        tmp_path, material("slack", slack), hair("rope", bound("slack")),
        hair("curl", f"{thick(1e-3)}\nfloat[] widths = [1, 2]", kind="cubic", place=(0, 0.1, 0)),
        hair("ring", 'uniform token wrap = "periodic"\nbool physics:bodyEnabled = false', place=(0, 0.3, 0)),
        f'def Xform "ghost" (prepend apiSchemas = [{own}]) {{\n{inner}}}\n',
    )  # fmt: skip
    assert list(robot.flexes) == ["rope", "curl", "ghost"]
    section = robot.flexes["rope"].material.section
    assert section["bending_stiffness_1"] == pytest.approx(1e-3 * 1e6 * np.pi / 4 * 5e-4**4)
    assert not robot._scene.contact_enabled(robot.flexes["ghost"], robot.flexes["rope"])
    text = str(robot.report)
    for line in (
        "deformable 'curl': linear curves through its points; the file has cubic ones",
        "deformable 'ring': bodyEnabled is false",
        "deformable 'rope': diameter 0.001 m",
        "deformable 'rope': youngsModulus 1e+06",
        "deformable 'rope': density 1000 kg/m^3",
        "flex 'rope': no bending_stiffness",
        "flex 'rope': Poisson's ratio 0 instead of -0.5",
    ):
        assert line in text


@pytest.mark.parametrize(
    "part, message",
    [
        (hair("a", counts="[6]"), "curveVertexCounts: 6 points: must be 7"),
        (hair("a", counts="[6, 1]"), "curveVertexCounts: must be at least 2 points"),
        (hair("a", 'uniform token wrap = "periodic"'), "wrap is periodic: must be nonperiodic, as"),
        (hair("a", counts="[]"), "curveVertexCounts: must be at least 2 points"),
        (hair("a", "float[] widths = [-1]"), "widths: -1 m: must be positive"),
        (hair("a", thick(0)), "thicknesses: 0 m: must be positive"),
        (hair("a", thick(1, 2, 3)), "thicknesses: 3 values: must be 1, 6 or 7"),
        (hair("a", "float[] physics:masses = [1, 2]"), "masses: 2 values: must be 1, 6 or 7"),
        (hair("a", "float physics:curvesStretchStiffness = 0"), "curvesStretchStiffness = 0: must be pos"),
        (hair("a", "float physics:curvesTwistStiffness = -1"), "curvesTwistStiffness = -1: must be at least"),
        (hair("a", curves=[LINE[[0, 0, 1]]]), "curve 0: points 0 and 1 coincide"),
        (hair("a", "point3f[] physics:restShapePoints = [(0, 0, 0)]"), "1 points: must be 7"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_file_is_named(part: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(stark.InvalidArgument, match=r"soft\.usda': deformable 'a'") as error:
        added(tmp_path, part)
    assert message in str(error.value)


def test_a_floating_base_takes_its_rods_along(tmp_path: Path) -> None:
    """A rod that has bent is placed with its frames: the base sees all as before, stresses too."""
    file = written(
        tmp_path, body("hub", shape("Cube", "double size = 0.05"), mass=0.5),
        material("cord", "float physics:youngsModulus = 1e6\nfloat physics:density = 1000"),
        hair("hair", f"{bound('cord')}\n{thick(4e-3)}", place=(0.03, 0, 0)), held("hair", "hub", [0, 1]),
    )  # fmt: skip
    scene = stark.Scene()
    robot = scene.add_robot(file, base="floating")
    rod = robot.flexes["hair"]
    sim = stark.Simulation(scene, time_step=0.005, gravity=(0, 0, 0))
    rod.velocities = np.outer(np.linspace(0.0, 1.0, 7) ** 2, (0.0, 0.0, 2.0))
    sim.run_until(0.05)
    assert np.ptp(rod.positions[:, 2]) > 0.02

    def seen() -> list[np.ndarray]:
        origin, axes = robot.pose
        local = (rod.positions - origin) @ axes, rod.velocities @ axes, axes.T @ rod.frames
        return [*local, axes.T @ robot.velocity, axes.T @ robot.angular_velocity]

    before = seen()
    turn = stark.rotation(axis=(1.0, 2.0, -1.0), angle=2.0)
    robot.pose = (0.3, -0.2, 2.0), turn
    for now, then in zip(seen(), before, strict=True):
        np.testing.assert_allclose(now, then, atol=1e-12)
    np.testing.assert_allclose(robot.pose[1], turn, atol=1e-12)
    assert sim.step().energy["placed"] == pytest.approx(0.0, abs=1e-12)  # [J], of 1e-4 stored
