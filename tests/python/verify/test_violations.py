"""Every planted fault is found, named, and told from what is merely not known; nothing good is called
wrong."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _recorded_runs import edit_rows, edit_states, record, reseal, sheet_on_box

import stark
from stark.verify import Certificate, verify
from stark.verify.joints import JointCheck
from stark.verify.reading import read

_BOX, _SHEET, _PLATE, _CUBE = range(4)
_STEPS = 20


def _move(body: int, rows: slice, shift: tuple[float, float, float]) -> list[tuple[str, Callable[..., None]]]:
    """Moves a rigid body in some states: its vertices and its pose."""

    def positions(array: np.ndarray, times: np.ndarray) -> None:
        array[rows] += shift

    def poses(array: np.ndarray, times: np.ndarray) -> None:
        array[rows, 0] += shift

    return [(f"positions_{body:04d}", positions), (f"poses_{body:04d}", poses)]


def _violated(certificate: Certificate) -> set[str]:
    return {claim.name for claim in certificate.claims if claim.status == "violated"}


# --- contact ---


def test_a_vertex_through_a_triangle_in_one_state(run: Path) -> None:
    def push(array: np.ndarray, times: np.ndarray) -> None:
        array[12, 40, 2] -= 0.02  # the middle of the sheet, into the box

    edit_states(run, f"positions_{_SHEET:04d}", push)
    certificate = verify(run)
    claim = certificate["no_intersection"]
    assert (certificate.verdict, certificate.exit_code, claim.status) == ("violated", 1, "violated")
    assert claim.where is not None
    assert claim.where["state"] == 12
    assert claim.where["time"] == pytest.approx(0.12)
    assert set(claim.where["bodies"]) == {"sheet", "box"}
    of_sheet = claim.where["vertices"][claim.where["bodies"].index("sheet")]
    assert 40 in of_sheet
    # What came in has to come out: the solver's own numbers are wrong for this state, too.
    assert "reported_distance" in _violated(certificate)


def test_tunnelling_between_states_is_never_certified(run: Path) -> None:
    """The cube is on top of the plate, then below it: both states are good. Without the path nobody can know
    that it did not go around the plate, so it is not called wrong; but it is not certified, and named."""
    for name, change in _move(_CUBE, slice(15, None), (0.0, 0.0, -0.075)):
        edit_states(run, name, change)
    certificate = verify(run)
    claim = certificate["paths"]
    assert certificate["no_intersection"].status == certificate["minimum_distance"].status == "verified"
    assert claim.status == "inconclusive"
    assert claim.where is not None
    assert claim.where["state"] == 15
    assert set(claim.where["bodies"]) == {"cube", "plate"}
    assert "no clear path" in claim.detail
    # The masses cannot have moved that fast: momentum gives it away.
    assert {"reported_energies", "reported_momentum"} <= _violated(certificate)


def test_a_vertex_inside_a_closed_surface_is_proof(tmp_path: Path) -> None:
    """A grain jumps into a hollow box: no intersection in any state, but no path leads there."""
    scene = stark.Scene()
    scene.add_box(0.2, name="hollow", motion="fixed")
    scene.add_box(0.02, name="grain", density=500.0, position=(0.3, 0.0, 0.0))
    run = record(tmp_path / "run", scene, 6, time_step=0.01)
    assert verify(run).verdict == "certified"
    for name, change in _move(1, slice(4, None), (-0.3, 0.0, 0.0)):
        edit_states(run, name, change)
    certificate = verify(run)
    claim = certificate["paths"]
    assert certificate["no_intersection"].status == "verified"
    assert claim.status == "violated"
    assert claim.where is not None
    assert (claim.where["state"], claim.where["bodies"]) == (4, ["grain", "hollow"])


def test_a_sheet_swapped_with_another_is_not_certified(tmp_path: Path) -> None:
    scene = stark.Scene()
    for k in range(2):
        grid = stark.mesh.grid(0.2, 0.2, cells=4)
        scene.add_cloth(grid, stark.materials.cotton, name=f"sheet_{k}", position=(0.0, 0.0, 0.005 * k))
    run = record(tmp_path / "run", scene, 6, time_step=0.01)
    assert verify(run).verdict == "certified"
    for body, shift in ((0, 0.005), (1, -0.005)):

        def lift(array: np.ndarray, times: np.ndarray, shift: float = shift) -> None:
            array[3:, :, 2] += shift

        edit_states(run, f"positions_{body:04d}", lift)
    claim = verify(run)["paths"]
    assert claim.status == "inconclusive"
    assert claim.where is not None
    assert claim.where["state"] == 3


def test_a_gap_below_what_the_solver_keeps(run: Path) -> None:
    """Factor 1e-3 of the sum of both contact distances: 2e-6 m."""
    heights: list[float] = []

    def lower(array: np.ndarray, times: np.ndarray) -> None:
        heights.append(float(array[10, :, 2].min()))
        array[10, :, 2] -= heights[0] - (0.01 + 1e-6)

    edit_states(run, f"positions_{_CUBE:04d}", lower)
    edit_states(run, f"poses_{_CUBE:04d}", lambda array, times: _lower_pose(array, heights[0]))
    certificate = verify(run)
    claim = certificate["minimum_distance"]
    assert certificate["no_intersection"].status == "verified"
    assert claim.status == "violated"
    assert claim.worst == pytest.approx(1e-6, abs=1e-10)  # the cube leans a little
    assert claim.tolerance == pytest.approx(2e-6, rel=1e-5)
    assert claim.where is not None
    assert (claim.where["state"], set(claim.where["bodies"])) == (10, {"cube", "plate"})


def _lower_pose(array: np.ndarray, height: float) -> None:
    array[10, 0, 2] -= height - (0.01 + 1e-6)


def test_sliding_around_a_corner_in_one_step_is_no_tunnelling(tmp_path: Path) -> None:
    """The straight path of a bead from the top of a block to its side cuts through the corner of the block:
    there is a clear way around it, and the certificate says how far it is from the straight one."""
    claim = verify(_around_a_corner(tmp_path, (0.247, 0.0, 0.253), (0.008, 0.0, -0.01)))["paths"]
    assert claim.status == "verified"
    assert "1 have detours of up to" in claim.detail
    assert 0.0005 < (claim.worst or 0.0) < 0.01


def test_a_detour_as_long_as_a_body_is_no_proof(tmp_path: Path) -> None:
    claim = verify(_around_a_corner(tmp_path, (0.24, 0.0, 0.26), (0.1, 0.0, -0.17)))["paths"]
    assert claim.status == "inconclusive"
    assert "only far from the straight lines" in claim.detail
    assert claim.where is not None
    assert claim.where["detour"] == claim.worst > 0.1 * claim.where["size"]
    assert claim.where["size"] == pytest.approx(0.1)


def _around_a_corner(
    tmp_path: Path, position: tuple[float, float, float], shift: tuple[float, float, float]
) -> Path:
    """A box of 0.1 m at a corner (0.2, y, 0.2) of a block that moves in one step."""
    scene = stark.Scene()
    scene.add_box(0.4, name="block", motion="fixed")
    scene.add_box(0.1, name="bead", density=500.0, position=position)
    run = record(tmp_path / "run", scene, 1, time_step=0.001, gravity=(0.0, 0.0, 0.0))
    for name, change in _move(1, slice(1, None), shift):
        edit_states(run, name, change)
    return run


@pytest.mark.parametrize("speed", [6.0, 10.0])
def test_bodies_that_change_places_in_a_step_are_not_certified(tmp_path: Path, speed: float) -> None:
    """Boxes of 50 mm that are thrown at each other, 100 mm a step and more."""
    scene = stark.Scene()
    for k in range(2):
        place = (0.1 * k, 0.01 * k, 0.0)
        velocity = (speed * (1 - 2 * k), 0.0, 0.0)
        scene.add_box(0.05, name=f"box_{k}", density=800.0, position=place, velocity=velocity)
    run = record(
        tmp_path / "run", scene, 1, time_step=1 / 60, contact_distance=0.001, gravity=(0.0, 0.0, 0.0)
    )
    ends = np.array([x.mean(axis=0) for x in read(run).state(1).positions])
    claim = verify(run)["paths"]
    assert claim.status == ("inconclusive" if ends[0, 0] > ends[1, 0] else "verified")


def test_rigid_bodies_turn_on_arcs(tmp_path: Path) -> None:
    """A bar turns by 90 degrees around a post that stands in the way of its straight lines: its end is 50 mm
    from the axis on the arc, 35 mm on the chord."""
    scene = stark.Scene()
    scene.add_box((0.1, 0.004, 0.004), name="bar", motion="scripted")
    scene.add_box(0.006, name="post", motion="fixed", position=(0.029, 0.029, 0.0))
    scene.add_box((0.004, 0.004, 0.02), name="free", density=500.0, position=(0.02, 0.02, 0.0))
    scene.disable_contact("bar", "free")
    turn = stark.rotation(axis="z", angle=-np.pi / 2)
    run = record(tmp_path / "run", scene, 1, time_step=0.001, gravity=(0.0, 0.0, 0.0))

    def positions(array: np.ndarray, times: np.ndarray) -> None:
        array[1] = array[0] @ turn.T

    def poses(array: np.ndarray, times: np.ndarray) -> None:
        array[1, 1:] = turn @ array[0, 1:]

    edit_states(run, "positions_0000", positions)
    edit_states(run, "poses_0000", poses)
    claim = verify(run)["paths"]
    assert claim.status == "verified"


# --- bodies, joints ---


def test_a_bent_rigid_body(run: Path) -> None:
    def bend(array: np.ndarray, times: np.ndarray) -> None:
        array[7, 0, 2] += 1e-9

    edit_states(run, f"positions_{_CUBE:04d}", bend)
    claim = verify(run)["rigid_shapes"]
    assert claim.status == "violated"
    assert claim.where == {"time": pytest.approx(0.07), "bodies": ["cube"]}


def test_a_fixed_body_that_moves(run: Path) -> None:
    for name, change in _move(_BOX, slice(5, 6), (0.0, 0.0, -1e-6)):
        edit_states(run, name, change)
    claim = verify(run)["rigid_shapes"]
    assert (claim.status, claim.where and claim.where["bodies"]) == ("violated", ["box"])


def test_a_joint_that_comes_apart(joined: Path, tmp_path: Path) -> None:
    run = Path(shutil.copytree(joined, tmp_path / "run"))
    for name, change in _move(2, slice(6, 7), (2e-6, 0.0, 0.0)):  # the hinge
        edit_states(run, name, change)
    claim = verify(run)["joints"]
    assert claim.status == "violated"
    assert claim.where == {"time": pytest.approx(0.06), "joint": "hinge"}
    assert claim.worst == pytest.approx(2e-6, rel=0.5)
    assert claim.tolerance == 1e-6


def test_a_joint_that_is_released_may_come_apart(joined: Path, tmp_path: Path) -> None:
    run = Path(shutil.copytree(joined, tmp_path / "run"))
    for name, change in _move(2, slice(6, 7), (2e-6, 0.0, 0.0)):
        edit_states(run, name, change)

    def release(array: np.ndarray, times: np.ndarray) -> None:
        array[:, 2] = 0

    edit_states(run, "joints", release)
    assert verify(run)["joints"].status == "verified"


def test_an_attached_point_that_comes_off(joined: Path, tmp_path: Path) -> None:
    run = Path(shutil.copytree(joined, tmp_path / "run"))
    scene = json.loads((run / "states/scene.json").read_text())
    patch = [body["name"] for body in scene["bodies"]].index("patch")

    def pull(array: np.ndarray, times: np.ndarray) -> None:
        array[4, 12, 2] += 1e-4

    edit_states(run, f"positions_{patch:04d}", pull)
    claim = verify(run)["attachments"]
    assert claim.status == "violated"
    assert claim.where is not None
    assert (claim.where["time"], claim.where["pair"]) == (pytest.approx(0.04), 1)
    assert claim.worst == pytest.approx(1e-4, rel=0.01)


@stark.joint
def screw(a: stark.Frame, b: stark.Frame, pitch: float = stark.parameter(0.01, unit="m/rad")) -> Any:
    """Turns in proportion to its displacement."""
    d = b.origin - a.origin
    turn = stark.atan2(b.x @ a.y, b.x @ a.x)
    return stark.hold(
        length=[a.x @ d, a.y @ d, a.z @ d - pitch * turn],
        direction=a.z - b.z,
        displacement={"displacement": a.z @ d},
    )


def stops() -> stark.Scene:
    """A pendulum that falls onto a stop, a slider that is pulled by a gear, a screw of one's own with a lower
    stop, a wheel that turns more than once up to a stop."""
    scene = stark.Scene("stops")
    boxes = [
        scene.add_box(0.1, name=f"box_{k}", density=500.0, position=(0.5 * k, 0.0, 0.0)) for k in range(4)
    ]
    hinge = scene.add_hinge(None, boxes[0], (-0.2, 0.0, 0.0), (0, 1, 0), limits=(-1.0, 0.02), name="pendulum")
    slider = scene.add_slider(None, boxes[1], (0.5, 0.0, 0.0), (1, 0, 0), name="slider")
    slider.add_gear(hinge, 0.3)
    bolt = scene.add_joint(
        screw, None, boxes[2], anchor=(1.0, 0.0, 0.0), axis=(0, 0, 1), pitch=0.05, name="screw"
    )
    bolt.add_limit(lower=-0.01)
    wheel = scene.add_hinge(None, boxes[3], (1.5, 0.0, 0.0), (1, 0, 0), name="wheel")
    wheel.add_effort(-1.0)
    wheel.add_limit(lower=-7.0)
    return scene


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stops") / "run"
    record(folder, stops(), 50, time_step=0.01)
    return folder


def test_stops_gears_and_formulas_of_ones_own_are_certified(stopped: Path) -> None:
    certificate = verify(stopped)
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["joints"].status == certificate["stops"].status == "verified"
    check = JointCheck(read(stopped))
    for state in check.run.states():
        check.add(state)
    turned = {name: q for (joint, name), q in check.stops._turned.items() if joint == 3}
    assert turned == {"angle": pytest.approx(-7.0, abs=1e-4)}  # it arrived, after more than a turn
    assert check.stops._turned[2, "displacement"] == pytest.approx(-0.01, abs=1e-5)


@pytest.mark.parametrize(
    ("value", "change", "where"),
    [
        (1, -0.01, "limit"),  # the upper stop lies lower
        (2, 0.001, "gear"),  # another ratio
        (4, 0.005, "lower_limit"),
    ],
)
def test_a_stop_that_does_not_hold(
    stopped: Path, tmp_path: Path, value: int, change: float, where: str
) -> None:
    run = Path(shutil.copytree(stopped, tmp_path / "run"))
    for chunk in (0, 1):
        edit_states(run, "actuator_values", lambda array, times: _add(array, value, change), chunk)
    certificate = verify(run)
    claim = certificate["stops"]
    assert claim.status == "violated", certificate.text()
    assert certificate["joints"].status == "verified"
    assert claim.where is not None
    assert claim.where["actuator"].startswith(where)


def _add(array: np.ndarray, column: int, change: float) -> None:
    array[:, column] += change


def test_a_joint_of_ones_own_that_is_off(stopped: Path, tmp_path: Path) -> None:
    run = Path(shutil.copytree(stopped, tmp_path / "run"))
    for name, change in _move(2, slice(5, 6), (0.0, 0.0, 1e-4)):
        edit_states(run, name, change)
    claim = verify(run)["joints"]
    assert claim.status == "violated"
    assert claim.where is not None
    assert (claim.where["joint"], claim.where["time"]) == ("screw", pytest.approx(0.05))
    assert claim.worst == pytest.approx(1e-4, rel=0.01)


def test_formulas_that_need_more_than_states_are_not_certified(tmp_path: Path) -> None:
    """With bdf2, the start of the step that a formula sees is no state; with implicit Euler it is."""

    @stark.joint
    def led(a: stark.Frame, b: stark.Frame) -> Any:
        return stark.hold(length=b.origin - a.origin + 0.5 * (b.origin_prev - a.origin_prev))

    for integrator, status in (("bdf2", "not recorded"), ("implicit_euler", "verified")):
        scene = stark.Scene()
        box = scene.add_box(0.1, density=100.0)
        scene.add_joint(led, None, box, anchor=(0.0, 0.0, 0.1))
        settings = {"time_step": 0.01, "time.integrator": integrator}
        certificate = verify(record(tmp_path / integrator, scene, 3, **settings))
        assert certificate["joints"].status == status, certificate.text()
        assert certificate.exit_code == (3 if status == "not recorded" else 0)


def test_recordings_of_older_versions_say_less(stopped: Path, tmp_path: Path) -> None:
    """They have the names of actuators and no formulas."""
    run = Path(shutil.copytree(stopped, tmp_path / "run"))
    path = run / "states/scene.json"
    scene = json.loads(path.read_text())
    scene["actuators"] = [actuator["name"] for actuator in scene["actuators"]]
    for joint in scene["joints"]:
        del joint["formula"], joint["coordinates"]
    path.write_text(json.dumps(scene))
    reseal(run)
    certificate = verify(run)
    assert {certificate["stops"].status, certificate["joints"].status} == {"not recorded"}
    assert certificate.exit_code == 3


# --- what the solver reported ---


def _set(
    row: int, *keys: str, value: Any = None, factor: float = 1.0
) -> Callable[[list[dict[str, Any]]], None]:
    def change(rows: list[dict[str, Any]]) -> None:
        place = rows[row]
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = place[keys[-1]] * factor if value is None else value

    return change


@pytest.mark.parametrize(
    ("change", "claim"),
    [
        (_set(4, "energy", "kinetic", factor=1.0 + 1e-6), "reported_energies"),
        (_set(4, "energy", "gravity", factor=1.0 + 1e-6), "reported_energies"),
        (_set(1, "energy", "elastic", value=1e-6), "energy_ledger"),
        (_set(1, "energy", "numerical", factor=1.01), "energy_ledger"),
        (_set(_STEPS - 1, "energy", "numerical", value=1.0), "energy_ledger"),
        (_set(_STEPS - 1, "energy", "contact", factor=1.0 + 1e-6), "energy_ledger"),
        (_set(_STEPS - 1, "contact_energy_at_start", factor=1.0 + 1e-6), "energy_ledger"),
        (_set(_STEPS - 1, "contact_energy_at_start", value=-1e-9), "energy_ledger"),
        (_set(_STEPS - 1, "contact_energy_at_start", value=None, factor=float("nan")), "energy_ledger"),
        (_set(_STEPS - 1, "energy", "friction", value=-1e-4), "friction_dissipates"),
        (_set(_STEPS - 1, "bristle_energy_at_start", value=-1e-12), "friction_dissipates"),
        (_set(9, "momentum", "z", factor=1.0 + 1e-6), "reported_momentum"),
        (_set(9, "angular_momentum", "x", value=1e-6), "reported_momentum"),
        (_set(9, "acceleration", value=0.02), "residual"),
        (_set(9, "acceleration", value=None, factor=float("nan")), "residual"),
        (_set(9, "last_motion", value=1.0), "residual"),
        (_set(9, "time", factor=1.0 + 1e-6), "steps"),
        (_set(9, "time_step", factor=1.01), "steps"),
        (_set(-1, "min_distance", factor=0.9), "reported_distance"),
        (lambda rows: rows.pop(3), "steps"),
        (lambda rows: rows.pop(), "steps"),
    ],
)
def test_tampered_telemetry(run: Path, change: Callable[[list[dict[str, Any]]], None], claim: str) -> None:
    edit_rows(run, change)
    certificate = verify(run)
    assert claim in _violated(certificate), certificate.text()
    assert certificate.exit_code == 1


@pytest.mark.parametrize(
    ("part", "rejected", "is_possible"),
    [(0.09, 2, True), (0.11, 2, False), (0.009, 0, True), (0.011, 0, False)],
)
def test_stiffened_contact_may_store_a_part_of_the_kinetic_energy(
    tmp_path: Path, part: float, rejected: int, is_possible: bool
) -> None:
    """Honest runs in which contact stored next to nothing before were called violated."""
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, velocity=(1.0, 0, 0))
    run = record(tmp_path / "run", scene, 4, time_step=0.01)

    def stiffen(rows: list[dict[str, Any]]) -> None:
        before, row = rows[2], rows[3]
        assert before["energy"]["contact"] == row["contact_energy_at_start"] == 0.0
        gained = part * before["energy"]["kinetic"]
        row["contact_energy_at_start"] += gained
        row["energy"]["numerical"] += gained
        row["rejected_steps"] = rejected

    edit_rows(run, stiffen)
    assert (verify(run)["energy_ledger"].status == "verified") == is_possible


def test_a_state_that_is_not_finite(run: Path) -> None:
    def spoil(array: np.ndarray, times: np.ndarray) -> None:
        array[3, 0, 0] = np.nan

    edit_states(run, f"positions_{_SHEET:04d}", spoil)
    certificate = verify(run)
    assert certificate["steps"].status == "violated"
    assert "state 3 has positions that are not finite" in certificate["steps"].detail


def test_steps_that_ended_at_rounding_are_inconclusive(run: Path) -> None:
    def change(rows: list[dict[str, Any]]) -> None:
        rows[5].update(acceleration=0.02, solve_status="round_off")

    edit_rows(run, change)
    certificate = verify(run)
    assert (certificate["residual"].status, certificate.exit_code) == ("inconclusive", 3)


def test_values_of_energies_of_the_scene_may_change_the_balance(tmp_path: Path) -> None:
    """A live parameter adds energy that no ledger has: that is not called wrong."""

    @stark.energy
    def spring(p: stark.Point, stiffness: float = 1.0) -> Any:
        return 0.5 * stiffness * stark.squared_norm(p.x)

    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=2), stark.materials.cotton)
    scene.add(spring(cloth.vertices))
    run = record(tmp_path / "run", scene, 5, time_step=0.01)
    assert verify(run)["energy_ledger"].status == "verified"
    edit_rows(run, _set(2, "energy", "elastic", factor=2.0))
    assert verify(run)["energy_ledger"].status == "inconclusive"


def test_spins_that_no_torque_explains(run: Path) -> None:
    """Angular velocities are recorded; they must change as the rotations of the steps say."""

    def faster(array: np.ndarray, times: np.ndarray) -> None:
        array[5:] += (0.0, 0.0, 1e-3)

    edit_states(run, f"angular_velocities_{_CUBE:04d}", faster)
    claim = verify(run)["reported_momentum"]
    assert claim.status == "violated"


@pytest.fixture(scope="module")
def run_of_bdf2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sheet and a cube that fall; a box that tumbles, with nothing around it."""
    scene = sheet_on_box()
    scene.add_box(
        (0.1, 0.2, 0.3), name="top", density=100.0, position=(3.0, 0.0, 0.0), angular_velocity=(1.0, 7.0, 2.0)
    )
    settings = {"time_step": 0.01, "contact_distance": 0.001, "time.integrator": "bdf2"}
    return record(tmp_path_factory.mktemp("bdf2") / "run", scene, 12, **settings)


@pytest.mark.parametrize(
    ("name", "body", "claims"),
    [
        ("velocities", _SHEET, {"reported_energies", "reported_momentum"}),
        ("velocities", _CUBE, {"reported_energies", "reported_momentum"}),
        ("lags", _CUBE, {"reported_energies", "reported_momentum"}),
        ("spins", -1, {"reported_momentum"}),
        ("angular_velocities", -1, {"reported_momentum"}),
    ],
)
def test_what_bdf2_remembers_must_follow_from_the_states(
    run_of_bdf2: Path, tmp_path: Path, name: str, body: int, claims: set[str]
) -> None:
    run = Path(shutil.copytree(run_of_bdf2, tmp_path / "run"))
    assert verify(run).verdict == "certified"
    bodies = len(json.loads((run / "states/scene.json").read_text())["bodies"])

    def change(array: np.ndarray, times: np.ndarray) -> None:
        array[5] += 1e-6 if name == "lags" else 1e-4

    edit_states(run, f"{name}_{body % bodies:04d}", change)
    assert claims <= _violated(verify(run))


@pytest.mark.parametrize(
    ("keys", "claim"),
    [(("energy", "kinetic"), "reported_energies"), (("momentum", "z"), "reported_momentum")],
)
def test_energy_and_momentum_of_bdf2_are_those_of_the_states(
    run_of_bdf2: Path, tmp_path: Path, keys: tuple[str, ...], claim: str
) -> None:
    run = Path(shutil.copytree(run_of_bdf2, tmp_path / "run"))
    edit_rows(run, _set(7, *keys, factor=1.0 + 1e-6))
    assert claim in _violated(verify(run))


def test_what_joints_give_in_an_impact_is_no_lag(tmp_path: Path) -> None:
    """A door in space hits its stop, which no contact tells of; a free box beside it is looked at as ever."""
    scene = stark.Scene("door")
    frame = scene.add_box((0.2, 0.02, 0.2), name="frame", density=500.0, position=(-0.2, 0.0, 0.0))
    door = scene.add_box(
        (0.2, 0.02, 0.2),
        name="door",
        density=900.0,
        position=(0.2, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 5.0),
    )
    scene.add_hinge(frame, door, (0.0, 0.0, 0.0), (0, 0, 1), limits=(-0.3, 0.3))
    scene.add_box(0.05, name="free", density=500.0, position=(0.0, 0.0, 2.0), velocity=(1.0, 0.0, 0.0))
    settings = {"time_step": 0.01, "time.integrator": "bdf2", "gravity": (0.0, 0.0, 0.0)}
    run = record(tmp_path / "run", scene, 15, **settings)
    certificate = verify(run)
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["stops"].status == "verified"

    def change(array: np.ndarray, times: np.ndarray) -> None:
        array[5] += 1e-6

    edit_states(run, "lags_0002", change)
    assert {"reported_energies", "reported_momentum"} <= _violated(verify(run))
