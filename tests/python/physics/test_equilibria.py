"""Quasistatic steps: they go on where iterations run out; what they find is at rest in any integrator."""

import numpy as np
import pytest

import stark

STATIC = {"time.integrator": "quasistatic", "newton.residual_tolerance": 1e-9}
SPAN, BAR, BARS, MASS, GRAVITY = 1.0, 0.25, 6, 0.02, 9.81


def hanging_chain() -> tuple[stark.Scene, list[stark.RigidBody]]:
    """Bars of 0.25 m, joined by balls and hung up at both ends, 1 m apart; they start as a V."""
    scene = stark.Scene()
    slope = np.arccos(SPAN / (BARS * BAR))
    ends, bars = [np.zeros(3)], []
    for i in range(BARS):
        down = -1.0 if i < BARS // 2 else 1.0
        along = np.array([np.cos(slope), 0.0, down * np.sin(slope)])
        ends.append(ends[-1] + BAR * along)
        turn = stark.rotation(axis="y", angle=-down * slope)
        middle = 0.5 * (ends[-1] + ends[-2])
        bars.append(scene.add_box((0.8 * BAR, 0.005, 0.005), mass=MASS, position=middle, rotation=turn))
    for i, end in enumerate(ends):
        scene.add_ball(bars[i - 1] if i else None, bars[i] if i < BARS else None, anchor=end)
    return scene, bars


def catenary_of_bars() -> np.ndarray:
    """Heights [m] of the middles. Moments about one end of a bar: tan(slope) = force across / H, where the
    force across changes by the weight of a bar from middle to middle."""
    across = MASS * GRAVITY * (np.arange(BARS) - 0.5 * (BARS - 1))
    low, high = 1e-6, 1e3
    for _ in range(200):
        pull = np.sqrt(low * high)
        low, high = (pull, high) if np.sum(BAR * np.cos(np.arctan(across / pull))) < SPAN else (low, pull)
    rise = BAR * np.sin(np.arctan(across / pull))
    return np.cumsum(rise) - 0.5 * rise


def test_iterations_go_on_where_halving_would_repeat_them() -> None:
    scene, bars = hanging_chain()
    settings = {**STATIC, "newton.max_iterations": 200, "contact.enabled": False}
    sim = stark.Simulation(scene, time_step=1 / 60, gravity=(0, 0, -GRAVITY), **settings)
    report = sim.step()
    assert not report.failed and report.rejected_steps == 0
    assert report.newton_iterations > 200, "the case must need more than one budget"
    heights = [bar.position[2] for bar in bars]
    assert heights == pytest.approx(catenary_of_bars(), abs=1e-6 * SPAN)


def test_a_budget_that_is_too_small_is_named_with_a_remedy_that_fits() -> None:
    scene, _ = hanging_chain()
    settings = {**STATIC, "newton.max_iterations": 2, "contact.enabled": False}
    report = stark.Simulation(scene, time_step=1 / 60, **settings).step()
    assert report.failed and report.diagnosis.cause == "iteration_budget"
    assert "smaller parts" in report.message and "time.step" not in report.message
    assert report.rejected_steps == 1, "a shorter step poses the same problem"


def test_rounding_of_a_load_is_no_jump_of_its_energy() -> None:
    """A bowl under two forces that pull and two that press, free to turn about the line of the former: what
    it stands in is no equilibrium that holds, and the load is not to blame. It was said to jump by
    10^-17 J."""
    around, rings = 32, 9
    turn, rise = np.meshgrid(
        np.arange(around) * 2.0 * np.pi / around, np.linspace(0.0, 0.4 * np.pi, rings), indexing="ij"
    )
    points = 10.0 * np.stack(
        (np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)), axis=-1
    )
    index = np.arange(around * rings).reshape(around, rings)
    a, b = index, np.roll(index, -1, axis=0)
    cells = [(a[:, :-1], b[:, :-1], b[:, 1:]), (a[:, :-1], b[:, 1:], a[:, 1:])]
    faces = np.concatenate([np.stack([k.ravel() for k in cell], axis=1) for cell in cells])
    skin = stark.ShellMaterial(
        density=1.0, thickness=0.04, youngs_modulus=6.825e7, poissons_ratio=0.3, flexural_rigidity=400.0
    )
    scene = stark.Scene()
    bowl = scene.add_cloth(stark.mesh.TriangleMesh(points.reshape(-1, 3), faces), skin, rest_angles="mesh")
    front, left, back, right = rim = index[:: around // 4, 0]
    scene.add_force(
        bowl.vertices[rim], [(0.002, 0, 0), (0, -0.002, 0), (-0.002, 0, 0), (0, 0.002, 0)], name="load"
    )
    for held, normal in (([front, back], "y"), ([left, right], "x"), ([front], "z")):
        scene.add_rollers(bowl.vertices[held], normal)
    settings = {"newton.step_tolerance": 1e-8, "time.min_step": 0.6, "contact.enabled": False}
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), settings={**STATIC, **settings})
    report = sim.step()
    assert report.failed and report.diagnosis is not None
    assert report.diagnosis.cause != "rough_energy", report.message


@pytest.mark.parametrize("integrator", ["implicit_euler", "bdf2"])
def test_an_equilibrium_stays_where_it_is(integrator: str) -> None:
    scene = stark.Scene()
    rubber = stark.RodMaterial(density=1000, youngs_modulus=1e7, poissons_ratio=0.3, width=0.01, height=0.01)
    line = stark.mesh.polyline((0, 0, 0), (1, 0, 0), 20)
    rod = scene.add_rod(line, rubber, clamps=[0], normal=(0, 1, 0), self_contact=False)
    arm = scene.add_box((0.2, 0.02, 0.02), mass=0.1, position=(0.1, 1.0, 0.0))
    hinge = scene.add_hinge(None, arm, anchor=(0, 1, 0), axis=(0, 1, 0))
    static = stark.Simulation(scene, {"contact.enabled": False, **STATIC})
    assert not static.step().failed
    sag = rod.positions[-1, 2]
    assert sag < -0.5 and hinge.angle == pytest.approx(np.pi / 2, abs=1e-6)
    assert not rod.velocities.any() and not arm.angular_velocity.any()

    dynamic = stark.Simulation(
        scene, {"contact.enabled": False, "time.integrator": integrator, "newton.residual_tolerance": 1e-9}
    )
    dynamic.state = static.state
    reports = [dynamic.step() for _ in range(30)]
    assert reports[-1].integrator == integrator and not reports[-1].failed
    # Tolerances of 1e-9 N move a rod of 0.1 kg by next to nothing.
    assert rod.positions[-1, 2] == pytest.approx(sag, abs=1e-7)


def test_states_go_to_simulations_without_history_and_back() -> None:
    scene = stark.Scene()
    ball = scene.add_sphere(0.05, mass=0.1, velocity=(1.0, 0.0, 0.0))
    bdf2 = stark.Simulation(scene, time_step=0.01, **{"time.integrator": "bdf2"})
    bdf2.run_until(0.1)
    there = ball.position.copy()
    euler = stark.Simulation(scene, time_step=0.01)
    euler.state = bdf2.state
    assert ball.position.tolist() == there.tolist()
    euler.run_until(0.2)
    bdf2.state = euler.state
    assert [bdf2.step().integrator for _ in range(2)] == ["implicit_euler", "bdf2"]


@pytest.mark.parametrize("motion", [-0.2, -0.01, -1e-6, 1e-6, 0.01])
def test_a_slack_sheet_follows_its_pins_from_a_flat_start(motion: float) -> None:
    """Nothing resists where an unstressed sheet goes, and energies along a step do not tell while pins move.
    The sheet hangs the same whether its pins move in the first step or in the second."""

    def sag(settles: bool) -> float:
        scene = stark.Scene()
        mesh = stark.mesh.grid(1.0, 0.1, cells=(20, 2))
        left, right = (np.flatnonzero(side * mesh.vertices[:, 0] > 0.499) for side in (-1, 1))
        cloth = scene.add_cloth(mesh, stark.materials.cotton, pins=np.concatenate([left, right]))
        sim = stark.Simulation(
            scene, time_step=0.01, **{"contact.enabled": False, "time.integrator": "quasistatic"}
        )
        if settles:
            assert not sim.step().failed
        targets = cloth.pin_targets.copy()
        targets[np.isin(cloth.pins, right), 0] += motion
        cloth.pin_targets = targets
        report = sim.step()
        assert not report.failed, report.message
        return float(cloth.positions[:, 2].min())

    assert sag(False) == pytest.approx(sag(True), abs=1e-6)
    assert sag(False) < -0.1


def bent_strip(load: float, step: float, density: float) -> tuple[float, float]:
    """Drop [m] of the end of a strip of steel of 1 m under a load [N], and the pull of its clamp [N]."""
    steel = stark.RodMaterial(
        density=density, youngs_modulus=2e11, poissons_ratio=0.3, width=0.02, height=0.01
    )
    scene = stark.Scene()
    strip = scene.add_rod(stark.mesh.polyline((0, 0, 0), (1, 0, 0), 20), steel, clamps=[0], normal=(0, 1, 0))
    scene.add_force(strip.vertices[-1], (0, 0, -load))
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    assert not sim.step().failed
    return -float(strip.positions[-1, 2]), float(strip.pin_forces[:, 2].sum())


@pytest.mark.parametrize(("step", "density"), [(1.0, 7850.0), (100.0, 1e9)])
def test_deflections_do_not_depend_on_masses_and_the_step(step: float, density: float) -> None:
    """P L^3 / (3 E I), of loads and deflections that dynamic steps would call nothing."""
    stiffness = 2e11 * 0.02 * 0.01**3 / 12.0
    for load in (1e-6, 1e-3, 1.0, 30.0):
        drop, pull = bent_strip(load, step, density)
        assert drop == pytest.approx(load / (3.0 * stiffness), rel=3e-3)
        assert pull == pytest.approx(load, rel=1e-3)


def test_a_small_load_on_a_thin_shell_is_not_stretched_by_the_line_search() -> None:
    """An eighth of the pinched cylinder [MacNeal and Harder 1985], 600 long, radius 300, thickness 3: its
    deflection is proportional to loads of 1 and 0.001."""
    grid = stark.mesh.grid(1.0, 1.0, cells=32)
    u, v = grid.vertices[:, :2].T + 0.5
    shape = 300.0 * np.column_stack((np.sin(u * np.pi / 2), v, np.cos(u * np.pi / 2)))
    bending = 3e6 * 27.0 / 12.0 / 0.91
    metal = stark.ShellMaterial(
        density=3000.0, thickness=3.0, youngs_modulus=3e6, poissons_ratio=0.3, flexural_rigidity=bending
    )
    drops = []
    for load in (1.0, 1e-3):
        scene = stark.Scene()
        shell = scene.add_cloth(
            stark.mesh.TriangleMesh(shape, grid.triangles), metal, rest_angles="mesh", contact_distance=1.0
        )
        for normal, edge in (("x", u < 1e-9), ("z", u > 1 - 1e-9), ("y", v < 1e-9)):
            scene.add_symmetry(shell.vertices[edge], normal)
        for normal in "xz":
            scene.add_rollers(shell.vertices[v > 1 - 1e-9], normal)
        pinched = np.flatnonzero((u < 1e-9) & (v < 1e-9))
        scene.add_force(shell.vertices[pinched], (0, 0, -0.25 * load))
        sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
        assert not sim.step().failed
        drops.append(float(shape[pinched[0], 2] - shell.positions[pinched[0], 2]) / load)
    assert drops[1] == pytest.approx(drops[0], rel=2e-3)
    assert 1.0 < drops[0] / 1.8248e-5 < 1.3, (
        "it converges from above: 1.38, 1.25 and 1.15 at 16, 32, 48 cells"
    )


def quarter_ring(load: float, step: float, mass: float) -> tuple[float, float, int]:
    """How far a ring of radius 0.5 m closes along and opens across two opposite forces, over P R^3 / (E I),
    and the iterations of the step. Its ends are welded to boxes 1 m away, which slide."""
    turn = np.linspace(0.0, np.pi / 2, 61)
    places = 0.5 * np.column_stack((np.cos(turn), np.sin(turn), 0.0 * turn))
    steel = stark.RodMaterial(density=7850.0, youngs_modulus=2e11, poissons_ratio=0.3, radius=0.005)
    scene = stark.Scene()
    ring = scene.add_rod(places, steel, self_contact=False)
    for node, out in ((0, (1.0, 0.0, 0.0)), (-1, (0.0, 1.0, 0.0))):
        box = scene.add_box(0.01, mass=mass, position=places[node] + out)
        scene.add_slider(None, box, anchor=box.position, axis=out)
        scene.add_fixed(box, ring.frame(node))
    scene.add_force(ring.vertices[-1], (0.0, -load / 2, 0.0))
    sim = stark.Simulation(scene, time_step=step, gravity=(0, 0, 0), time={"integrator": "quasistatic"})
    report = sim.step()
    assert not report.failed
    unit = 0.5 * load * 0.5**3 / steel.section["bending_stiffness_1"]
    moved = ring.positions - places
    return -moved[-1, 1] / unit, moved[0, 0] / unit, report.newton_iterations


@pytest.mark.parametrize(("load", "step", "mass"), [(1.0, 1.0, 0.1), (0.01, 0.01, 0.1), (0.01, 1.0, 100.0)])
def test_joints_of_bodies_that_nothing_else_holds(load: float, step: float, mass: float) -> None:
    """A ring between two forces [Timoshenko, Strength of materials]: of deflections of a micrometre, too, at
    the default tolerances of joints, whatever the bodies between weigh."""
    closing, opening, iterations = quarter_ring(load, step, mass)
    assert closing == pytest.approx(np.pi / 4 - 2 / np.pi, rel=2e-3)
    assert opening == pytest.approx(2 / np.pi - 0.5, rel=2e-3)
    assert iterations < 20


def shortened_column(scene: stark.Scene) -> stark.Solid:
    """By 30 %, with an imperfection of 0.1 mm: it bows out."""
    mesh = stark.mesh.box_hexahedra((0.05, 0.05, 0.4), (2, 2, 12))
    height = mesh.vertices[:, 2]
    rubber = stark.SolidMaterial(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.3)
    column = scene.add_solid(mesh, rubber, pins=np.abs(height) > 0.1999, self_contact=False)
    column.follow(displacement=lambda t: (1e-4, 0.0, -0.12), vertices=np.flatnonzero(height > 0.1999))
    return column


def curling_plate(scene: stark.Scene) -> stark.Cloth:
    mesh = stark.mesh.grid(0.5, 0.2, cells=(10, 4))
    sheet = stark.ShellMaterial(
        density=1.0, thickness=2e-3, youngs_modulus=1e7, poissons_ratio=0.3, flexural_rigidity=6.67e-3
    )
    plate = scene.add_cloth(mesh, sheet, pins=np.flatnonzero(mesh.vertices[:, 0] < -0.19), self_contact=False)
    plate.natural_curvature = 3.0
    return plate


@pytest.mark.parametrize("build", [shortened_column, curling_plate])
def test_a_second_step_under_the_same_load_moves_nothing(build) -> None:
    """Projected Hessians are too stiff: the column ended at a saddle, and moved on by 122 mm."""
    scene = stark.Scene()
    body = build(scene)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), settings={"time.integrator": "quasistatic"})
    start = body.positions.copy()
    assert not sim.step().failed
    first = body.positions.copy()
    assert not sim.step().failed
    way = np.abs(first - start).max()
    assert np.abs(body.positions - first).max() < 1e-3 * way  # what docs/integrators.md promises
