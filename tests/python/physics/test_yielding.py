"""Rods and shells that yield, against closed forms: loading, unloading and reversal, what stays after
bending, stored and dissipated energy, the same bits after a rewind and on any number of threads."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark

STATIC: dict[str, Any] = {
    "time.integrator": "quasistatic",
    "contact.enabled": False,
    "newton.step_tolerance": 1e-10,
    "newton.acceleration_tolerance": 1e-8,
}


class Slider:
    """A spring in a row with a slider of linear isotropic hardening, for one strain."""

    def __init__(self, stiffness: float, force: float, hardening: float) -> None:
        self.stiffness, self.force, self.hardening = stiffness, force, hardening
        self.flow = self.slip = 0.0

    def step(self, strain: float) -> tuple[float, float]:
        """Stored energy and dissipation of a step."""
        trial = self.stiffness * (strain - self.flow)
        excess = max(abs(trial) - self.force - self.hardening * self.slip, 0.0)
        slip = excess / (self.stiffness + self.hardening)
        self.flow += np.copysign(slip, trial)
        self.slip += slip
        stored = 0.5 * self.stiffness * (strain - self.flow) ** 2 + 0.5 * self.hardening * self.slip**2
        return stored, self.force * slip


WIRE = stark.RodMaterial(
    density=7850.0, youngs_modulus=2e11, radius=1e-3, yield_stress=4e8, hardening_modulus=5e9
)


def there_and_back(top: float) -> np.ndarray:
    return top * np.concatenate([np.linspace(0.0, 1.0, 6)[1:], np.linspace(1.0, -1.0, 11)[1:]])


def test_a_wire_in_tension_unloading_and_reversal() -> None:
    length, section = 0.2, WIRE.section
    scene = stark.Scene()
    points = np.linspace([0, 0, 0], [length, 0, 0], 5)
    rod = scene.add_rod(points, WIRE, clamps=[0], pins=range(1, 5))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    # The yield stress grows by the hardening modulus times the plastic stretch.
    closed = Slider(section["axial_stiffness"], section["yield_force"], 5e9 * np.pi * 1e-6)
    scale = section["yield_force"] * 5e-3 * length
    for strain in there_and_back(5e-3):
        sim[rod].pin_targets = points[sim[rod].pins] * (1.0 + strain)
        report = sim.step()
        assert not report.failed
        stored, lost = closed.step(strain)
        assert report.energy["elastic"] == pytest.approx(stored * length, rel=1e-6, abs=1e-6 * scale)
        assert report.energy["damping"] == pytest.approx(lost * length, rel=1e-6, abs=1e-6 * scale)
        assert report.energy["damping"] >= -1e-12 * scale
    assert closed.slip > 5e-3


@stark.energy
def couple(node: stark.Frame, moment: float, first: stark.Vec3, second: stark.Vec3):
    """A moment about the normal of two directions, on the axis of a node that is along the first at rest."""
    return -moment * stark.atan2(stark.dot(node.z, second), stark.dot(node.z, first))


@pytest.mark.parametrize("section", ["round", "flat"])
def test_a_bent_wire_springs_back_by_the_elastic_part(section: str) -> None:
    """A moment at the end bends the wire to an arc, 1.3 of what it yields at; after it what is left is the
    plastic curvature (M - M_y)/H: exactly that of the segments, and within 1 % that of a continuous wire."""
    wire = WIRE if section == "round" else WIRE.replace(width=4e-3, height=1e-3)
    segments, given = 20, wire.section
    yields, stiffness = given["yield_moment_1"], given["bending_stiffness_1"]
    hardening = given["yield_hardening"] * yields**2
    top = 1.3 * yields
    length = 2.5 / ((top - yields) / hardening + top / stiffness)
    scene = stark.Scene()
    points = np.linspace([0, 0, 0], [length, 0, 0], segments + 1)
    rod = scene.add_rod(points, wire, clamps=[0], normal=(0, 1, 0))
    axis = rod.frames[0][:, 0]  # d1, about which it bends
    second = np.cross(axis, [1.0, 0.0, 0.0])
    load = scene.add(couple(rod.frame(segments), moment=0.0, first=(1, 0, 0), second=tuple(second)))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)

    def curvature(moment: float) -> tuple[float, float]:
        """Curvature (tan(phi/2) + sin(phi/2))/L of the segments, theory eq. 29, and what the moment does
        work on per turn: L times its derivative."""
        load.moment = moment
        report = sim.step()
        assert not report.failed, report.message
        assert report.energy["damping"] >= -1e-15
        z = sim[rod].frames[:, :, 2]
        turns = np.arctan2(np.cross(z[:-1], z[1:]) @ axis, np.einsum("ij,ij->i", z[:-1], z[1:]))
        np.testing.assert_allclose(turns, turns[0], rtol=1e-6, atol=1e-9)
        half = 0.5 * turns[0]
        rate = 0.5 / np.cos(half) ** 2 + 0.5 * np.cos(half)
        return float((np.tan(half) + np.sin(half)) * segments / length), float(rate)

    for moment in np.linspace(0.0, top, 14)[1:]:
        bent, rate = curvature(moment)
    plastic = (top / rate - yields) / hardening
    assert bent == pytest.approx(plastic + top / rate / stiffness, rel=1e-6)
    assert curvature(0.0)[0] == pytest.approx(plastic, rel=1e-6)
    assert plastic == pytest.approx((top - yields) / hardening, rel=1e-2)


def test_a_wire_that_is_bent_and_twisted_yields_on_the_ellipsoid() -> None:
    """Energies of a path in three strains of one segment against a search for the root of theory eq. 10i."""
    section = WIRE.section
    scene = stark.Scene()
    rod = scene.add_rod([(0, 0, 0), (0, 0, 0.01)], WIRE, clamps=[0, 1])
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    K = np.array([section[f"bending_stiffness_{k}"] for k in (1, 2)] + [section["torsional_stiffness"]])
    Y = np.array([section[f"yield_moment_{k}"] for k in (1, 2)] + [section["yield_torque"]])
    H, a = section["yield_hardening"], K / Y**2
    flow, p = np.zeros(3), 0.0
    frames = np.array(sim[rod].frames)
    for way in ((1.0, 0.0, 0.0), (1.0, 1.0, 0.5), (-0.5, 1.0, 2.0), (0.0, 0.0, 0.0)):
        turn = 0.09 * np.array(way)
        sim[rod].clamp_targets = frames @ np.stack([turned(-0.5 * turn), turned(0.5 * turn)])
        report = sim.step()
        assert not report.failed
        angle = max(float(np.linalg.norm(turn)), 1e-12)
        strain = (np.tan(0.5 * angle) + np.sin(0.5 * angle)) * turn / angle / 0.01 - flow
        R = 1.0 + H * p
        low, high = 0.0, 1.0 / H

        def excess(n: float, strain: np.ndarray = strain, R: float = R) -> float:
            return float(np.linalg.norm(K * strain / (1 + a * n) / Y) * (1 - H * n) - R)

        for _ in range(200):
            n = 0.5 * (low + high)
            low, high = (n, high) if excess(n) > 0.0 else (low, n)
        n = 0.5 * (low + high)
        work = R * n / (1 - H * n)
        flow, p = flow + strain * (1 - 1 / (1 + a * n)), p + work
        stored = 0.5 * (K * (strain / (1 + a * n)) ** 2).sum() + 0.5 * H * p**2
        assert work > 0.0
        assert report.energy["elastic"] == pytest.approx(0.01 * stored, rel=1e-6)
        assert report.energy["damping"] == pytest.approx(0.01 * work, rel=1e-6)


def turned(turn: np.ndarray) -> np.ndarray:
    """The rotation about a vector by its length [rad]."""
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


@pytest.mark.parametrize(("integrator", "order"), [("implicit_euler", 1), ("bdf2", 2)])
def test_steps_are_of_the_order_of_the_integrator_while_it_yields(integrator: str, order: int) -> None:
    """A bar whose end flies away and stretches it beyond the yield force."""

    def end(step: float) -> float:
        scene = stark.Scene()
        bar = stark.RodMaterial(
            density=1000.0, youngs_modulus=1e6, radius=1e-2, yield_stress=2e3, hardening_modulus=1e5
        )
        rod = scene.add_rod([(0, 0, 0), (1, 0, 0)], bar, clamps=[0], velocity=(0.5, 0, 0))
        settings = {**STATIC, "time.integrator": integrator, "newton.acceleration_tolerance": 1e-10}
        sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), **settings)
        sim.run_until(0.02)
        assert sim.state.arrays()["internal_variable"][0] > 5e-3
        return float(rod.positions[1, 0])

    coarse, middle, fine = (end(step) for step in (1e-3, 5e-4, 2.5e-4))
    assert np.log2((coarse - middle) / (middle - fine)) == pytest.approx(order, abs=0.1)


# --- shells ---

SIDE = 0.02  # [m]
PAPER: dict[str, Any] = {"density": 0.08, "thickness": 1e-4, "youngs_modulus": 1e6, "bending_stiffness": 2e-4}


def folded(material: stark.ShellMaterial, angles: list[float], cells: int = 4) -> list[tuple[float, Any]]:
    """A sheet whose right half a plate turns about the middle to each angle, and then lets go: fold angle of
    the middle line and report of each step."""
    scene = stark.Scene()
    mesh = stark.mesh.grid(2 * SIDE, SIDE, cells=(2 * cells, cells))
    x = np.asarray(mesh.vertices)[:, 0]
    left, right = np.flatnonzero(x < 1e-6), np.flatnonzero(x > 1e-6)
    sheet = scene.add_cloth(mesh, material, pins=left)
    hand = scene.add_box(0.01, motion="scripted", position=(0, 0, 0))
    hold = scene.attach(sheet.vertices[right], hand)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **{**STATIC, "joints.length_tolerance": 1e-9})
    found = []
    for angle in [*angles, None]:
        if angle is None:
            hold.enabled = False
        else:
            sim[hand].rotation = stark.rotation(axis="y", angle=-angle)
        report = sim.step()
        assert not report.failed, report.message
        far = sim[sheet].positions[right]
        far = far[far[:, 0] ** 2 + far[:, 2] ** 2 > (0.9 * SIDE) ** 2]
        found.append((float(np.arctan2(far[:, 2], far[:, 0]).mean()), report))
    return found


def test_a_folded_sheet_keeps_its_crease() -> None:
    """A spring and a slider for each hinge of the line: the sheet opens by the elastic part."""
    yields, hardening = 0.01, 2e-5
    sheet = stark.ShellMaterial(**PAPER, bending_yield_moment=yields, bending_hardening=hardening)
    edge = SIDE / 4
    weight = 3.0 * edge**2 / edge**2  # of the hinges on the line, whose triangles have half of edge^2
    closed = Slider(PAPER["bending_stiffness"] * weight, yields * edge, hardening * weight)
    angles = [0.05, 0.3, 0.6, 0.9, 1.2, 1.5, 1.2, 0.9, 1.2, 1.5]  # at most a sixteenth of a turn on
    found = folded(sheet, angles)
    for angle, (_, report) in zip(angles, found, strict=False):
        stored, lost = closed.step(angle)
        assert report.energy["elastic"] == pytest.approx(4 * stored, rel=1e-5)
        assert report.energy["damping"] == pytest.approx(4 * lost, rel=1e-5, abs=1e-12)
    assert found[-1][0] == pytest.approx(closed.flow, rel=1e-5)
    assert closed.flow > 1.2


@pytest.mark.parametrize("poissons_ratio", [0.0, 0.3])
def test_a_plate_rolled_up_yields_by_von_mises(poissons_ratio: float) -> None:
    """A cylinder: moments (1, nu) D k, plastic flow across, too; energies per area against the return to the
    ellipse, found by a search. Fold angles of a cylinder differ from curvature times length by their
    square."""
    D, yields, hardening, nu = 0.01, 0.02, 1e-4, poissons_ratio
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.1, 0.05, cells=(20, 10))
    X = np.asarray(mesh.vertices)
    plate = stark.ShellMaterial(
        density=0.1, thickness=1e-4, youngs_modulus=1e-3, poissons_ratio=nu, bending_stiffness=0.0,
        flexural_rigidity=D, bending_yield_moment=yields, bending_hardening=hardening,
    )  # fmt: skip
    sheet = scene.add_cloth(mesh, plate, pins=range(len(X)))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    K = D * np.array([1 + nu, 1 - nu])
    Y = yields * np.sqrt([2.0, 2.0 / 3.0])
    H, a, flow, p = hardening / yields**2, K / Y**2, np.zeros(2), 0.0
    for curvature in (1.0, 4.0, 6.0, 2.0, -3.0):
        angle = X[:, 0] * curvature
        sim[sheet].pin_targets = np.stack(
            [np.sin(angle) / curvature, X[:, 1], (1 - np.cos(angle)) / curvature], axis=1
        )
        report = sim.step()
        strain = curvature * np.sqrt([0.5, 0.5]) - flow
        R = 1 + H * p
        low, high = 0.0, 1.0 / H
        for _ in range(200):
            n = 0.5 * (low + high)
            yet = np.linalg.norm(K * strain / (1 + a * n) / Y) * (1 - H * n) > R
            low, high = (n, high) if yet else (low, n)
        work = R * low / (1 - H * low)
        kept = 1 / (1 + a * low)
        flow, p = flow + strain * (1 - kept), p + work
        stored = 0.5 * (K * (strain * kept) ** 2).sum() + 0.5 * H * p**2
        assert report.energy["elastic"] == pytest.approx(0.005 * stored, rel=2e-3, abs=1e-9)
        assert report.energy["damping"] == pytest.approx(0.005 * work, rel=2e-3, abs=1e-9)
    assert p > 0.1


def test_a_bent_strip_springs_back_by_the_elastic_part() -> None:
    """A strip that a hand bends to an arc and lets go keeps the plastic curvature (m - m_y)/H_b, within 2
    %."""
    D, yields, hardening, bent = 0.01, 0.02, 2e-3, 8.0
    length, width = 0.1, 0.02
    scene = stark.Scene()
    mesh = stark.mesh.grid(length, width, cells=(20, 4))
    X = np.asarray(mesh.vertices) + np.array([0.5 * length, 0.0, 0.0])
    plate = stark.ShellMaterial(
        density=0.1, thickness=1e-4, youngs_modulus=1e7, poissons_ratio=0.0, bending_stiffness=0.0,
        flexural_rigidity=D, bending_yield_moment=yields, bending_hardening=hardening,
    )  # fmt: skip
    cell = length / 20
    sheet = scene.add_cloth(
        mesh, plate, position=(0.5 * length, 0, 0), pins=np.flatnonzero(X[:, 0] < 1.5 * cell)
    )
    end = np.flatnonzero(X[:, 0] > length - 1.5 * cell)
    hand = scene.add_box(0.01, motion="scripted", position=(length, 0, 0))
    hold = scene.attach(sheet.vertices[end], hand)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    free = length - 2 * cell  # bends between the middles of the cells that are held flat

    def turn() -> float:
        x = sim[sheet].positions
        tip = x[X[:, 0] > length - 0.5 * cell].mean(axis=0) - x[
            np.abs(X[:, 0] - length + cell) < 0.1 * cell
        ].mean(axis=0)
        return float(np.arctan2(tip[2], tip[0]))

    for part in np.linspace(0.0, 1.0, 9)[1:]:
        k = bent * part
        angle = k * (free + cell)
        # The held cells at the ends are tangents of the arc between.
        where = np.array([np.sin(angle) / k, 0, (1 - np.cos(angle)) / k])
        where += cell / 2 * np.array([1 + np.cos(angle), 0, np.sin(angle)])
        sim[hand].position, sim[hand].rotation = where, stark.rotation(axis="y", angle=-angle)
        assert not sim.step().failed
    held = turn()
    hold.enabled = False
    assert not sim.step().failed
    # m = m_y + H_b k_p and m = D (k - k_p)
    plastic = (D * bent - yields) / (D + hardening)
    assert turn() / held == pytest.approx(plastic / bent, rel=0.02)


def test_a_membrane_in_tension_unloading_and_reversal() -> None:
    """Tension along one side, with the other one as it is without a force: the uniaxial law at finite
    strain."""
    E, nu, yields, hardening, t = 1e7, 0.3, 1e5, 5e5, 1e-3
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.1, 0.1, cells=2)
    X = np.asarray(mesh.vertices)
    foil = stark.ShellMaterial(
        density=0.1, thickness=t, youngs_modulus=E, poissons_ratio=nu, bending_stiffness=0.0,
        yield_stress=yields, hardening_modulus=hardening,
    )  # fmt: skip
    sheet = scene.add_cloth(mesh, foil, pins=range(len(X)))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    closed = Slider(E, yields, hardening)
    for strain in there_and_back(0.05):
        stored, lost = closed.step(strain)
        # Elastic strains shrink the width by nu, plastic ones by a half.
        across = -nu * (strain - closed.flow) - 0.5 * closed.flow
        sim[sheet].pin_targets = X * np.exp([strain, across, 0.0])
        report = sim.step()
        assert not report.failed
        volume = 0.01 * t
        assert report.energy["elastic"] == pytest.approx(volume * stored, rel=1e-6)
        assert report.energy["damping"] == pytest.approx(
            volume * lost, rel=1e-6, abs=1e-6 * volume * yields * 0.05
        )
    assert closed.slip > 0.1


def test_a_membrane_in_simple_shear_keeps_what_it_remembers_when_it_turns() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.1, 0.1, cells=2)
    X = np.asarray(mesh.vertices)
    foil = stark.ShellMaterial(
        density=0.1, thickness=1e-3, youngs_modulus=1e7, poissons_ratio=0.3, yield_stress=1e5
    )
    sheet = scene.add_cloth(mesh, foil, pins=range(len(X)))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    sheared = X @ np.array([[1.0, 0.6, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).T
    for part in (0.25, 0.5, 0.75, 1.0):
        sim[sheet].pin_targets = X + part * (sheared - X)
        report = sim.step()
    # Kirchhoff stress stays on the ellipse: in the plane, sqrt 3 |shear| = yield stress, e = shear/(2 mu).
    shear = 1e5 / np.sqrt(3.0)
    assert report.energy["elastic"] == pytest.approx(0.01 * 1e-3 * 0.5 * shear**2 / (1e7 / 2.6), rel=1e-2)
    before = sim.state.arrays()["internal_variable"].copy()
    end = sheared @ turned(np.array([0.3, 0.4, 1.2])).T
    for part in (0.25, 0.5, 0.75, 1.0):
        sim[sheet].pin_targets = sheared @ turned(part * np.array([0.3, 0.4, 1.2])).T
        sim.step()
    np.testing.assert_allclose(sim[sheet].positions, end, atol=1e-12)
    np.testing.assert_allclose(sim.state.arrays()["internal_variable"], before, rtol=1e-9)


def test_nothing_changes_where_nothing_yields() -> None:
    """A yield stress that is never reached: the elastic rod and plate, to rounding."""
    ends = []
    for yields in (np.inf, 1e15):
        scene = stark.Scene()
        plate = stark.materials.plate(youngs_modulus=1e7, poissons_ratio=0.3, thickness=1e-3, density=1000.0)
        sheet = scene.add_cloth(
            stark.mesh.grid(0.1, 0.05, cells=(8, 4)),
            plate.replace(bending_yield_moment=0.25 * yields * 1e-6 if np.isfinite(yields) else 0.0),
            pins=[0, 1, 9, 10],
        )
        wire = stark.RodMaterial(youngs_modulus=1e8, radius=1e-3, yield_stress=yields)
        rod = scene.add_rod(stark.mesh.polyline((0, 0.2, 0), (0.1, 0.2, 0), 6), wire, clamps=[0])
        sim = stark.Simulation(
            scene, time_step=0.005, **{"contact.enabled": False, "newton.step_tolerance": 1e-12}
        )
        sim.run_until(0.05)
        ends.append(np.concatenate([sim[sheet].positions, sim[rod].positions]))
    assert np.abs(ends[0] - ends[1]).max() < 1e-9


def swinging(**settings: Any) -> stark.Simulation:
    """A sheet, a foil and a wire that fall over their clamped ends and yield there."""
    scene = stark.Scene()
    grid = stark.mesh.grid(0.1, 0.05, cells=(8, 4))
    clamp = np.flatnonzero(np.asarray(grid.vertices)[:, 0] < -0.03)
    soft = stark.ShellMaterial(
        density=0.5,
        youngs_modulus=1e6,
        bending_stiffness=1e-4,
        bending_damping=1e-6,
        bending_yield_moment=4e-3,
    )
    scene.add_cloth(grid, soft, pins=clamp)
    foil = stark.materials.plate(youngs_modulus=1e8, poissons_ratio=0.3, thickness=2e-4, density=2000.0)
    foil = foil.replace(yield_stress=2e5, hardening_modulus=1e6)
    scene.add_cloth(grid, foil, pins=clamp, position=(0, 0.2, 0))
    wire = stark.RodMaterial(youngs_modulus=1e8, radius=1e-3, yield_stress=5e5, density=2000.0)
    scene.add_rod(stark.mesh.polyline((0, 0.4, 0), (0.15, 0.4, 0), 8), wire, clamps=[0])
    return stark.Simulation(scene, time_step=0.004, **{"contact.enabled": False, **settings})


@pytest.mark.parametrize(
    "settings",
    [{"execution.threads": 3, "execution.oversubscribe": True}, {"execution.backend": "interpreter"}],
)
def test_the_same_bits_with_threads_the_interpreter_and_after_a_rewind(settings: dict[str, Any]) -> None:
    one, other = swinging(), swinging(**settings)
    one.run_until(0.04)
    kept = one.state
    reports = [one.step() for _ in range(5)]
    end = one.state
    assert all(r.energy["damping"] >= -1e-12 for r in reports)
    assert sum(r.energy["damping"] for r in reports) > 1e-6
    one.state = kept
    for _ in range(5):
        one.step()
    other.run_until(0.04)
    for _ in range(5):
        other.step()
    assert one.state == end
    assert other.state.hash == end.hash


def test_the_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    examples = Path(__file__).parents[3] / "examples"
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(examples))
    runpy.run_path(str(examples / "creases.py"))["main"]()
    assert (tmp_path / "out/creases.png").stat().st_size > 10_000


def test_wrong_values_are_named() -> None:
    with pytest.raises(stark.InvalidArgument, match="yield_stress"):
        stark.Scene().add_rod([(0, 0, 0), (0, 0, 1)], stark.RodMaterial(yield_stress=-1.0))
    with pytest.raises(stark.InvalidArgument, match="without a yield_stress"):
        stark.Scene().add_rod([(0, 0, 0), (0, 0, 1)], stark.RodMaterial(hardening_modulus=1.0))
    with pytest.raises(stark.InvalidArgument, match="bending_yield_moment"):
        stark.Scene().add_cloth(
            stark.mesh.grid(1, 1, cells=1), stark.ShellMaterial(bending_yield_moment=-1.0)
        )
