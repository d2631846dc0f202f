"""Random scenes of all kinds: what is drawn, and that the bench sees what is wrong in them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import stark

pytest.importorskip("ipctk")

from benchmarks.torture.campaign import description_of, kind_at, run_campaign, run_one, summary
from benchmarks.torture.case import Setup, run, simulate
from benchmarks.torture.judge import Judge
from benchmarks.torture.random_containers import SHELLS, build_containers, staying, winding
from benchmarks.torture.random_impacts import no_passing
from benchmarks.torture.random_joints import build_joints
from benchmarks.torture.random_kinds import KINDS
from benchmarks.torture.random_materials import KINDS as MATERIALS
from benchmarks.torture.random_materials import add_body
from benchmarks.torture.random_squeezes import build_squeezes

pytestmark = pytest.mark.filterwarnings("ignore::stark.StarkWarning")

NEW = [kind for kind in KINDS if kind != "mixed"]


@pytest.mark.parametrize("kind", NEW)
def test_descriptions_are_json_and_come_again(kind: str) -> None:
    first = description_of(3, 7, kind)
    assert json.loads(json.dumps(first)) == first == description_of(3, 7, kind)
    assert first != description_of(3, 8, kind)


@pytest.mark.parametrize("kind", NEW)
def test_scenes_of_a_seed(kind: str) -> None:
    """None intersects at time 0, and each ends complete or in a failed step."""
    for index in range(8):
        outcome = run_one(22, index, kind, most_steps=12)
        wrong = [p for p in outcome.problems if " failed: " not in p]
        assert outcome.status in ("complete", "failed") and not wrong, (index, wrong, outcome.message)


def test_what_is_drawn() -> None:
    """Everything that the kinds promise turns up."""
    drawn = {kind: [description_of(4, k, kind) for k in range(150)] for kind in NEW}
    worlds = [d for descriptions in drawn.values() for d in descriptions]
    assert {d["bdf2"] for d in worlds} == {True, False}
    assert {d["threads"] for d in worlds} == {1, 2, 3, 5}
    assert {d["again"] for d in worlds} == {"", "threads", "resume", "certify"}
    assert any(d["restitution"] is not None for d in worlds)
    speeds = [body["speed"] for d in drawn["impacts"] for body in d["bodies"]]
    assert 2.9 < max(speeds) <= 3.0
    assert {d["shell"] for d in drawn["containers"]} == set(SHELLS)
    assert {d["kind"] for d in drawn["joints"]} == {"chain", "gripper", "arm", "glued"}
    assert any(link["switches"] for d in drawn["joints"] for link in d["links"])
    assert any(link["cap"] > 8.0 for d in drawn["joints"] for link in d["links"])
    assert min(d["closing"] for d in drawn["squeezes"]) < 0.0
    assert {body["kind"] for d in drawn["materials"] for body in d["bodies"]} == set(MATERIALS)
    assert not any(d["bdf2"] and "prony" in str(d["bodies"]) for d in drawn["materials"])


@pytest.mark.parametrize("kind", MATERIALS)
def test_materials_are_what_their_names_say(kind: str) -> None:
    """What yields and what creeps remembers, what grows grows, and pairs hang on a joint that can break."""
    drawn = [description_of(4, k, "materials") for k in range(150)]
    world, body = next((d, b) for d in drawn for b in d["bodies"] if b["kind"] == kind)
    scene = stark.Scene()
    add_body(scene, body, world, position=np.zeros(3), rotation=np.eye(3), velocity=np.zeros(3))
    sim = stark.Simulation(scene, time_step=10.0 ** world["time_step"], gravity=(0, 0, 0))
    before = sim.bodies[0].positions
    sim.run_until(10.0 ** world["time_step"] * world["steps"])
    remembers = kind.startswith("prony") or kind in ("metal", "creased", "dented", "bent")
    assert (len(sim.state.arrays()["internal_variable"]) > 0) == remembers
    ratio = np.ptp(sim.bodies[0].positions, axis=0).max() / np.ptp(before, axis=0).max()
    if kind.startswith("growing"):
        assert (ratio > 1.0) == (body["growth"] > 1.0) and abs(ratio - 1.0) > 1e-3
    else:
        assert ratio == pytest.approx(1.0, abs=1e-9)
    assert [joint.break_force > 0.0 for joint in sim.joints] == [True] * (kind == "breaking")


def test_kinds_follow_the_number_of_the_scene(tmp_path: Any) -> None:
    kinds = ("joints", "squeezes")
    rows = run_campaign(5, 3, 3, tmp_path / "rows.jsonl", kinds)
    assert [row["kind"] for row in rows] == [kind_at(k, kinds) for k in (3, 4, 5)]
    found = summary(rows)
    assert found["kinds"]["joints"]["scenes"] == 1 and found["kinds"]["squeezes"]["scenes"] == 2


def test_a_scene_without_an_end_is_no_exception(monkeypatch: pytest.MonkeyPatch) -> None:
    def endless(*_: object) -> None:
        raise TimeoutError("no end after 1 CPU seconds")

    monkeypatch.setitem(KINDS, "mixed", (KINDS["mixed"][0], endless))  # type: ignore[arg-type]
    outcome = run_one(2, 0)
    assert (outcome.status, outcome.problems) == ("no end", ["no end after 1 CPU seconds"])


# --- watches ---


class Pose:
    """A body at a place, by name."""

    def __init__(self, name: str, points: Any, turn: float = 0.0) -> None:
        self.name, self.kind = name, "rigid"
        self.surface_positions = self.positions = np.array(points, dtype=float)
        self.position = np.zeros(3)
        self.rotation = stark.rotation(axis="x", angle=turn)


class Poses(dict[Any, Any]):
    """As little of a simulation as watches need."""

    def __init__(self, *bodies: Pose) -> None:
        super().__init__({body.name: body for body in bodies})
        self.bodies = bodies

    def __getitem__(self, body: Any) -> Any:
        return super().__getitem__(getattr(body, "name", body))


@pytest.mark.parametrize(
    ("end", "turn", "found"),
    [
        ((0.0, 0.0, -0.1), 0.0, True),
        ((0.0, 0.0, 0.05), 0.0, False),
        ((2.0, 0.0, -0.1), 0.0, False),  # beside it
        ((0.0, 0.0, -0.1), 1.0, False),  # a plate that turns fast may have moved out of the way
    ],
)
def test_who_passes_through_a_plate_is_seen(end: Any, turn: float, found: bool) -> None:
    plate = Pose("plate", [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)])
    watch = no_passing([(plate, 1.0)])
    assert watch is not None and no_passing([]) is None
    assert watch(Poses(plate, Pose("shot", [(0.0, 0.0, 0.1), (0.01, 0.0, 0.12)]))) is None  # type: ignore[arg-type]
    after = Poses(Pose("plate", plate.positions, turn), Pose("shot", [end, end]))
    assert (watch(after) is not None) == found  # type: ignore[arg-type]


def test_who_leaves_a_container_is_seen() -> None:
    box = stark.mesh.box(1.0)
    shell = Pose("shell", box.vertices)
    watch = staying([(Pose("thing", []), shell, np.asarray(box.triangles))])
    assert watch(Poses(shell, Pose("thing", [(0, 0, 0), (0.4, 0, 0)]))) is None  # type: ignore[arg-type]
    assert "not inside" in str(watch(Poses(shell, Pose("thing", [(0, 0, 0), (0.6, 0, 0)]))))  # type: ignore[arg-type]
    numbers = winding(np.array([(0.0, 0, 0), (3.0, 0, 0)]), box.vertices[np.asarray(box.triangles)])
    assert numbers == pytest.approx([1.0, 0.0], abs=1e-12)


def overlapping(joint: bool) -> stark.Simulation:
    """Two boxes on a hinge that turn into each other."""
    scene = stark.Scene()
    a = scene.add_box(0.1, motion="fixed")
    b = scene.add_box(0.1, mass=1.0, position=(0.105, 0.0, 0.0), angular_velocity=(0.0, -8.0, 0.0))
    if joint:
        scene.add_hinge(a, b, anchor=(0.0525, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    else:
        scene.disable_contact(a, b)
    return stark.Simulation(scene, time_step=0.01, gravity=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("joint", [True, False])
def test_what_a_joint_or_the_scene_keeps_from_contact_may_meet(joint: bool) -> None:
    sim = overlapping(joint)
    judge = Judge(sim)
    for _ in range(6):
        assert not sim.step().failed
        assert not judge.intersects()


def test_prescribed_bodies_that_meet_have_to_be_named() -> None:
    scene = stark.Scene()
    for side in (-1.0, 1.0):
        scene.add_box(0.1, motion="scripted", position=(0.203 * side, 0, 0), velocity=(-side, 0, 0))
    outcome = run("meeting", Setup(scene, 0.2, {"time_step": 0.01}))
    assert outcome.problems == [] and outcome.caveats["prescribed_overlap"] > 3
    sim = simulate(Setup(scene, 0.2, {"time_step": 0.01}))
    judge = Judge(sim)
    for _ in range(17):
        sim.step()
    assert not judge.intersects() and judge.prescribed == {(0, 1)}


def test_causes_that_a_scene_may_fail_for_are_no_problems() -> None:
    """A jaw that closes on a box further than it is thick."""
    description = description_of(1, 0, "squeezes")
    thing = {**description["thing"], "shape": "box", "size": 1.0, "flatness": 0.0, "turn": [0.0] * 3}
    description |= {"jaws": "plates", "count": 2, "opening": 1.1, "closing": 0.1, "thing": thing, "more": []}
    description |= {"pins": None, "again": "", "follow": True, "back": False, "one_sided": False, "steps": 6}
    outcome = run("squeezed", build_squeezes(description))
    assert (outcome.status, outcome.cause, outcome.problems) == ("failed", "blocked_motion", [])


def test_a_certificate_and_other_threads_are_looked_at() -> None:
    from benchmarks.torture.campaign import _once_more

    description = description_of(1, 1, "joints") | {"bdf2": False, "steps": 3}
    for how in ("threads", "resume", "certify"):
        made = description | {"again": how}
        outcome = run("again", build_joints(made))
        assert _once_more(lambda made=made: build_joints(made), made, outcome) == []  # type: ignore[misc]
        outcome.hash = "another"
        assert _once_more(lambda made=made: build_joints(made), made, outcome)  # type: ignore[misc]


def test_things_start_in_their_container() -> None:
    for index in range(20):
        setup = build_containers(description_of(6, index, "containers"))
        sim = simulate(setup)
        assert setup.watch is not None and setup.watch(sim) is None
