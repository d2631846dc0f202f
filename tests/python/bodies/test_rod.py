"""Rods in Python: meshes, handles, materials, joints, bad input, recording, laws of one's own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
from stark import InvalidArgument, InvalidMesh, StarkWarning, TraceError
from stark.recording import Recorder, Recording

GUIDE = Path(__file__).resolve().parents[3] / "docs/rods.md"
RUBBER = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=0.01)


@stark.material
def stiffening(
    stretch,
    curvature: stark.Vec2,
    twist: float,
    EA: float = stark.parameter(unit="N", above=0.0),
    EI: float = stark.parameter(unit="N m^2", above=0.0),
    GJ: float = stark.parameter(unit="N m^2", above=0.0),
    cubic: float = stark.parameter(0.0, unit="N m^4", min=0.0),
):
    """Resists strong bending more than Kirchhoff's rod does."""
    bending = stark.squared_norm(curvature)
    return 0.5 * (EA * (stretch - 1) ** 2 + EI * bending + GJ * twist**2) + 0.25 * cubic * bending**2


def section_values() -> dict[str, float]:
    section = RUBBER.section
    return {
        "EA": section["axial_stiffness"],
        "EI": section["bending_stiffness_1"],
        "GJ": section["torsional_stiffness"],
    }


def cantilever(material: stark.RodMaterial = RUBBER, **options: object) -> tuple[stark.Scene, stark.Rod]:
    scene = stark.Scene()
    mesh = stark.mesh.polyline((0, 0, 0), (1, 0, 0), 8)
    return scene, scene.add_rod(mesh, material, clamps=[0], **options)


def tip_after(material: stark.RodMaterial) -> np.ndarray:
    scene, rod = cantilever(material)
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(20):
        assert not sim.step().failed
    return rod.positions[-1]


def hanging_tip(material: stark.RodMaterial) -> float:
    """Height of the tip in equilibrium [m]."""
    scene, rod = cantilever(material)
    sim = stark.Simulation(scene, **{"time.integrator": "quasistatic"})
    assert not sim.step().failed
    return float(rod.positions[-1, 2])


def test_meshes() -> None:
    line = stark.mesh.polyline((0, 0, 0), (0, 0, 2), 4)
    assert line.length == pytest.approx(2.0)
    np.testing.assert_array_equal(line.edges, [[0, 1], [1, 2], [2, 3], [3, 4]])
    coil = stark.mesh.helix(0.1, 0.05, 3, 90)
    assert coil.vertices[-1] == pytest.approx([0.1, 0.0, 0.15])
    assert np.linalg.norm(coil.vertices[:, :2], axis=1) == pytest.approx(0.1)
    assert coil.scaled(2.0).length == pytest.approx(2.0 * coil.length)
    with pytest.raises(InvalidArgument, match="segments"):
        stark.mesh.polyline((0, 0, 0), (1, 0, 0), 0)


def test_the_handle_knows_positions_frames_and_clamps() -> None:
    scene, rod = cantilever(name="boom", normal=(0.0, 0.0, 1.0))
    assert scene["boom"] == rod and rod.kind == "rod"
    assert rod.positions.shape == (9, 3)
    assert rod.frames.shape == (9, 3, 3)
    np.testing.assert_allclose(rod.frames[3], [[0, 0, 1], [0, -1, 0], [1, 0, 0]], atol=1e-15)
    np.testing.assert_array_equal(rod.clamped, [0])
    sim = stark.Simulation(scene, time_step=0.01)
    sim.step()
    assert rod.velocities[-1, 2] < 0.0
    assert np.abs(rod.frames[-1] - rod.frames[0]).max() > 0.0
    np.testing.assert_array_equal(rod.clamp_targets, rod.frames[:1])


def test_sections_of_round_and_rectangular_rods() -> None:
    E, nu, r = 1e7, 0.3, 0.01
    section = RUBBER.section
    assert section["axial_stiffness"] == pytest.approx(E * np.pi * r**2)
    assert section["bending_stiffness_1"] == pytest.approx(E * np.pi * r**4 / 4)
    assert section["torsional_stiffness"] == pytest.approx(E / (2 * (1 + nu)) * np.pi * r**4 / 2)
    flat = RUBBER.replace(width=0.04, height=0.01).section
    assert flat["bending_stiffness_1"] == pytest.approx(E * 0.04 * 0.01**3 / 12)
    assert flat["bending_stiffness_2"] == pytest.approx(E * 0.01 * 0.04**3 / 12)
    # Timoshenko and Goodier, table of sec. 109: b/a = 4 has J = 0.281 a^3 b.
    assert flat["torsional_stiffness"] == pytest.approx(E / 2.6 * 0.281 * 0.04 * 0.01**3, rel=5e-3)
    own = RUBBER.replace(bending_stiffness_1=2.0)
    assert own.section["bending_stiffness_1"] == 2.0
    assert own.section["bending_stiffness_2"] == section["bending_stiffness_2"]
    assert stark.materials.steel_wire.source


def test_a_law_in_python_moves_a_rod_with_the_bits_of_the_built_in() -> None:
    own = stiffening(**section_values(), base=RUBBER)
    assert isinstance(own, stark.RodMaterial) and own.law.name == "stiffening"
    plain = stiffening_free(**section_values(), base=RUBBER)
    np.testing.assert_array_equal(tip_after(plain), tip_after(RUBBER))
    assert hanging_tip(own.replace(cubic=1.0)) > hanging_tip(own) + 1e-3


@stark.material
def stiffening_free(
    stretch,
    curvature,
    twist,
    EA: float = stark.parameter(unit="N", above=0.0),
    EI: float = stark.parameter(unit="N m^2", above=0.0),
    GJ: float = stark.parameter(unit="N m^2", above=0.0),
):
    bending = EI * curvature[0] ** 2 + EI * curvature[1] ** 2
    return 0.5 * (EA * (stretch - 1) ** 2 + bending + GJ * twist**2)


def test_the_check_of_a_law_reports_derivatives_and_stability() -> None:
    report = stiffening.check(**section_values(), cubic=3.0)
    assert report.ok and {f.name for f in report.findings} == {"rest", "force", "stiffness", "stability"}


def test_laws_that_cannot_be_are_refused() -> None:
    modulus = stark.parameter(1.0, unit="N", above=0.0)

    @stark.material
    def tense(stretch, twist, k: float = modulus):
        return k * stretch + k * twist**2

    @stark.material
    def unstable(stretch, twist, k: float = modulus):
        return k * (stretch - 1) ** 2 - k * twist**2

    @stark.material
    def kinked(stretch, k: float = modulus):
        return k * stark.sqrt(stretch - 1)

    with pytest.raises(InvalidArgument, match="the force against stretch is 1 N: must be zero"):
        tense()
    with pytest.warns(StarkWarning, match="unstable at rest"):
        unstable()
    with pytest.raises(InvalidArgument, match="not finite at rest"):
        kinked()

    @stark.material
    def idle(stretch, curvature, k: float = modulus):
        return k * (stretch - 1) ** 2

    with pytest.raises(TraceError, match="does not depend on curvature"):
        idle()


def test_arguments_of_laws_are_checked_when_they_are_written() -> None:
    with pytest.raises(TraceError, match=r"must be stark\.Vec2"):

        @stark.material
        def wrong(stretch, curvature: stark.Vec3):
            return stretch

    with pytest.raises(TraceError, match="must come before"):

        @stark.material
        def late(stretch, k: float, twist: float):
            return k * stretch * twist


def test_joints_hold_nodes_at_position_and_orientation() -> None:
    scene, rod = cantilever()
    box = scene.add_box(0.05, mass=0.01, position=(1.025, 0.0, 0.0))
    fixed = scene.add_fixed(rod.frame(-1), box)
    sim = stark.Simulation(scene, time_step=0.01)
    before = rod.frames[-1].T @ np.asarray(box.rotation)
    for _ in range(30):
        assert not sim.step().failed
    after = rod.frames[-1].T @ np.asarray(box.rotation)
    assert np.abs(after - before).max() < 1e-5
    assert np.abs(fixed.residuals).max() < 1e-5
    assert box.position[2] < -0.01
    with pytest.raises(InvalidArgument, match=r"say which node, rod.frame\(0\)"):
        scene.add_ball(rod, None, anchor=(0, 0, 0))
    with pytest.raises(InvalidArgument, match="node = 9: must be the index"):
        rod.frame(9)


@pytest.mark.parametrize("lever", [0.02, 0.004])
def test_a_pinned_node_is_held_in_its_rotation(lever: float) -> None:
    """The rod is pinned at one end, whose frame is free to turn: a joint and an attachment at a lever carry
    the moment of the weight, as a clamp would."""
    scene = stark.Scene()
    rods = []
    for y in (0.0, 0.5, 1.0):
        mesh = stark.mesh.polyline((0, y, lever), (0.3, y, lever), 10)
        rods.append(scene.add_rod(mesh, RUBBER.replace(radius=0.004), pins=[0]))
    fixed = scene.add_fixed(None, rods[0].frame(0))
    hinge = scene.add_hinge(None, rods[1].frame(0, rotation=stark.rotation(axis="x", angle=0.3)))
    block = scene.add_box(0.002, motion="fixed", position=(-0.02, 1.0, 0.0))
    glue = scene.attach(block.points([(0.02, 0.0, 0.0)]), rods[2].vertices[0], contact=False)
    sim = stark.Simulation(scene, **{"time.integrator": "quasistatic"})
    assert not sim.step().failed
    for rod in rods:
        masses = np.full(11, rod.mass / 10)
        masses[[0, -1]] /= 2
        moment = 9.81 * masses @ rod.positions[:, 0]  # [N m] of the weight about the pin
        assert moment > 1e-3
        if rod is rods[0]:
            assert abs(abs(fixed.reaction.torque[1]) / moment - 1) < 1e-3
        elif rod is rods[1]:
            assert abs(np.linalg.norm(hinge.reaction.torque) / moment - 1) < 1e-3
        else:
            assert abs(abs(glue.force[0]) * lever / moment - 1) < 1e-3
        assert np.abs(rod.frames[0][:, 2] - (1, 0, 0)).max() < 1e-3


def test_frames_that_are_turned_apart_are_told_how_to_agree() -> None:
    scene, rod = cantilever()
    scene.add_hinge(None, rod.frame(-1), anchor=(1.0, 0.0, 0.0), axis="y")
    with pytest.raises(
        InvalidArgument, match=r"rad at time 0: .* turn both frames alike .* leave out anchor"
    ):
        stark.Simulation(scene)


def test_energies_act_on_frames_of_nodes() -> None:
    @stark.energy
    def torque(f: stark.Frame, moment: float):
        return -moment * (f.x @ stark.vec(0.0, 0.0, 1.0))

    scene, rod = cantilever(normal=(0.0, 1.0, 0.0))
    scene.add(torque(rod.frame(8), moment=0.01))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=0.01)
    for _ in range(20):
        assert not sim.step().failed
    assert rod.frames[-1, 2, 0] > 0.01


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"clamps": [9]}, "must be in"),
        ({"clamps": [0.5]}, "clamp|pins|indices|index"),
        ({"rest_shape": "bent"}, "rest_shape"),
        ({"normal": (1.0, 0.0, 0.0)}, "along the first edge"),
        ({"contact_distance": -1.0}, "contact_distance"),
        ({"initial_positions": np.zeros((3, 3))}, "initial_positions"),
    ],
)
def test_bad_options_are_refused(options: dict, message: str) -> None:
    with pytest.raises(InvalidArgument, match=message):
        stark.Scene().add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 8), RUBBER, **options)


def test_wrong_meshes_and_materials_are_refused() -> None:
    scene = stark.Scene()
    with pytest.raises(InvalidMesh, match="polyline"):
        scene.add_rod(stark.mesh.box((1, 1, 1)), RUBBER)
    with pytest.raises(InvalidMesh, match="at least 2"):
        scene.add_rod([(0, 0, 0)], RUBBER)
    with pytest.raises(InvalidArgument, match="RodMaterial"):
        scene.add_rod([(0, 0, 0), (1, 0, 0)], stark.materials.cotton)
    with pytest.raises(InvalidArgument, match="RodMaterial"):
        stiffening(**section_values(), base=stark.materials.cotton)


def test_values_may_differ_by_segment() -> None:
    stiff = np.where(np.arange(8) < 4, 100.0, 1.0) * RUBBER.section["bending_stiffness_1"]
    both = {"bending_stiffness_1": stiff, "bending_stiffness_2": stiff}
    assert hanging_tip(RUBBER.replace(**both)) > hanging_tip(RUBBER) + 1e-2
    with pytest.raises(InvalidArgument, match="bending_stiffness_1"):
        cantilever(RUBBER.replace(bending_stiffness_1=stiff[:5]))


def test_pictures_and_recordings_show_a_tube(tmp_path: Path) -> None:
    scene, rod = cantilever()
    assert rod.triangles.shape == (0, 3)
    tube = stark.TriangleMesh(rod.surface_positions, rod.surface_triangles)
    assert tube.is_closed
    sides = len(stark.tubes.outline(RUBBER))
    area = 0.5 * sides * np.sin(2.0 * np.pi / sides) * 0.01**2
    assert tube.volume == pytest.approx(area * 1.0, rel=1e-9)
    sim = stark.Simulation(scene, time_step=0.01)
    with Recorder(tmp_path / "run", sim) as recorder:
        for _ in range(3):
            sim.step()
            recorder.record(sim)
    run = Recording(tmp_path / "run")
    assert run.frame(-1).bodies[0].kind == "rod"
    assert run.still(0.0, width=80, height=60).std() > 1.0  # not an empty picture
    np.testing.assert_allclose(run.positions("rod", -1), rod.surface_positions, atol=1e-6)


def test_the_code_of_the_guide_runs(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 6
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block.replace("until=0.5", "until=0.05"), str(GUIDE), "exec"), names)
    assert len(capsys.readouterr().out.splitlines()) == 5
    assert isinstance(names["soft"], stark.RodMaterial)


@stark.energy
def tendon(e: stark.Edge, rest: float = 0.3, stiffness: float = 5e3):
    return 0.5 * stiffness * stark.maximum(stark.total(e.length, "length") - rest, 0.0) ** 2


def bent_by_a_tendon(lever: float, pull: float) -> tuple[stark.Rod, Any]:
    scene = stark.Scene()
    material = stark.RodMaterial(density=1000.0, youngs_modulus=1e7, radius=0.003)
    line = stark.mesh.polyline((0, 0, 0), (0.3, 0, 0), 30)
    rod = scene.add_rod(line, material, clamps=[0], normal=(0, 0, 1), name="arm")
    eyelets = rod.points(range(31), (lever, 0.0, 0.0))
    cable = scene.add(tendon((eyelets[:-1], eyelets[1:]), rest=0.3 - pull))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    for _ in range(2):
        assert not sim.step().failed
    assert np.allclose(sim[rod].frames[0], [[0, 0, 1], [0, -1, 0], [1, 0, 0]])
    return sim[rod], cable


@pytest.mark.parametrize("lever", [0.01, -0.004])
def test_a_tendon_beside_a_rod_bends_it_into_an_arc(lever: float) -> None:
    """Moment T d everywhere. The angle of the arc: by what the cable is shorter than the rod, over d."""
    rod, cable = bent_by_a_tendon(lever, pull=0.003)
    tension = cable.total_slopes["length"]
    moments = np.linalg.norm(rod.section_moments, axis=1)
    # A straight piece of cable has the lever d cos(half the angle of a segment): 1e-4 less at most.
    assert moments == pytest.approx(tension * abs(lever), rel=3e-4)
    axis = np.linalg.norm(np.diff(rod.positions, axis=0), axis=1).sum()
    angle = 2.0 * np.arcsin(np.linalg.norm(rod.frames[-1][:, 2] - rod.frames[0][:, 2]) / 2.0)
    assert angle == pytest.approx((axis - cable.length) / abs(lever), rel=1e-3)
    assert np.sign(rod.positions[-1, 2]) == np.sign(lever)


def test_points_of_nodes() -> None:
    scene = stark.Scene()
    rod = scene.add_rod(
        stark.mesh.polyline((0, 0, 0), (1, 0, 0), 4), clamps=[0], normal=(0, 0, 1), name="rod"
    )
    assert rod.points([-1, 0], (0.1, 0, 0)).positions == pytest.approx(np.array([[1, 0, 0.1], [0, 0, 0.1]]))
    each = rod.points(slice(1, 3), [(0.1, 0, 0), (0, 0, 0.2)])
    assert each.positions == pytest.approx(np.array([[0.25, 0, 0.1], [0.7, 0, 0]]))
    assert rod.points(2).positions == pytest.approx(np.array([[0.5, 0, 0]]))
    assert len(rod.points([])) == 0
    with pytest.raises(stark.InvalidArgument, match="index 5 is out of bounds"):
        rod.points(5)
    with pytest.raises(
        stark.InvalidArgument, match=r"shape \(3, 3\) for 2 nodes: must be \(3,\) or \(2, 3\)"
    ):
        rod.points([0, 1], np.zeros((3, 3)))


def test_a_ring_that_meets_its_own_end_is_told_how_to_close() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 41)
    scene = stark.Scene()
    scene.add_rod(0.1 * np.column_stack((np.cos(turn), np.sin(turn), 0 * turn)), name="ring")
    with pytest.raises(stark.InitialIntersection) as refused:
        stark.Simulation(scene)
    assert "'ring' touches itself at time 0 near (0.1, " in str(refused.value)
    assert "of a ring leave out the last segment and weld the ends" in str(refused.value)
    assert "self_contact = false" in str(refused.value)


def test_what_is_one_for_a_whole_rod_is_told_with_what_is_not() -> None:
    """Of a rod that tapers."""
    tapered = stark.RodMaterial(radius=np.linspace(2e-3, 1e-3, 10))
    with pytest.raises(
        stark.InvalidArgument, match="give one value for the whole body, or values of axial_st"
    ):
        stark.Scene().add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 10), tapered)


def test_a_rod_that_tapers_bends_by_its_stiffness_of_each_segment() -> None:
    """A cantilever of half the radius at its end under a small force there: f (L - s)^2 / B(s), summed."""
    count, length, young, force = 40, 0.5, 1e8, 1e-3
    radius = 4e-3 * (1.0 - 0.5 * (np.arange(count) + 0.5) / count)
    bending = young * np.pi * radius**4 / 4.0
    tapered = stark.RodMaterial(density=1000.0, youngs_modulus=young, radius=4e-3).replace(
        bending_stiffness_1=bending, bending_stiffness_2=bending
    )
    scene = stark.Scene()
    rod = scene.add_rod(stark.mesh.polyline((0, 0, 0), (length, 0, 0), count), tapered, clamps=[0])
    scene.add_force(rod.vertices[[count]], (0, 0, force))
    sim = stark.Simulation(scene, time={"integrator": "quasistatic"}, time_step=1.0, gravity=(0, 0, 0))
    assert not sim.step().failed
    s = length * (np.arange(20000) + 0.5) / 20000
    stiffness = young * np.pi / 4.0 * (4e-3 * (1.0 - 0.5 * s / length)) ** 4
    exact = length * np.mean(force * (length - s) ** 2 / stiffness)
    assert rod.positions[-1, 2] == pytest.approx(exact, rel=2e-3)
