"""Overlapping bodies are found as a simulation would refuse them."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from verify._recorded_runs import record

import stark
from stark.verify import verify


def names(pairs: Any) -> list[tuple[str, str]]:
    return [(a.name, b.name) for a, b in pairs]


def chain(count: int = 4) -> stark.Scene:
    """Boxes of 0.3 m in a row, 10 mm into each other."""
    scene = stark.Scene()
    for k in range(count):
        size = (0.3, 0.05 - 0.002 * k, 0.05 - 0.002 * k)
        scene.add_box(size, mass=1.0, position=(0.29 * k, 0.0, 0.0), name=f"link {k}")
    return scene


def test_all_pairs_at_once() -> None:
    scene = chain()
    with pytest.raises(
        stark.InitialIntersection, match=r"2 more pairs of bodies intersect: scene\.disable_overlapping\(\)"
    ):
        stark.Simulation(scene)
    assert names(scene.disable_overlapping()) == [(f"link {k}", f"link {k + 1}") for k in range(3)]
    assert not scene.contact_enabled("link 0", "link 1") and scene.contact_enabled("link 0", "link 2")
    assert scene.disable_overlapping() == []
    assert not stark.Simulation(scene, gravity=(0, 0, 0)).step().failed


def test_one_pair_is_named_alone() -> None:
    with pytest.raises(stark.InitialIntersection, match=r"disable contact between them$"):
        stark.Simulation(chain(2))


def test_of_some_bodies() -> None:
    scene = chain()
    assert names(scene.disable_overlapping(["link 0", "link 1", "link 3"])) == [("link 0", "link 1")]
    with pytest.raises(stark.InvalidArgument, match="no such"):
        scene.disable_overlapping(["no such"])


def test_inside_of_what_is_filled() -> None:
    """A small box inside of a large one, of a solid, and of a hollow one, in which it may be."""
    scene = stark.Scene()
    scene.add_box(0.2, mass=1.0, name="full")
    scene.add_solid(stark.mesh.tet_box(0.2, 2), stark.materials.soft_rubber, position=(1, 0, 0), name="soft")
    scene.add_rigid(stark.mesh.box(0.2), mass=1.0, hollow=True, position=(2, 0, 0), name="shell")
    for k in range(3):
        scene.add_box(0.02, mass=0.1, position=(k, 0.0, 0.0), name=f"small {k}")
    assert names(scene.disable_overlapping()) == [("full", "small 0"), ("soft", "small 1")]
    stark.Simulation(scene, gravity=(0, 0, 0))


def test_pairs_without_contact_are_left_as_they_are() -> None:
    """Held by a joint, disabled before, fixed both: none of them is reported, so what a joint holds
    comes into contact again when it is released."""
    scene = chain(3)
    scene.add_hinge("link 0", "link 1", anchor=(0.145, 0, 0), axis=(0, 0, 1))
    scene.disable_contact("link 1", "link 2")
    for k in range(2):
        scene.add_box(0.1, motion="fixed", position=(3 + 0.05 * k, 0.01 * k, 0.02 * k), name=f"wall {k}")
    assert scene.disable_overlapping() == []
    stark.Simulation(scene, gravity=(0, 0, 0))


def test_bodies_far_from_each_other_are_not_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    """All pairs of 1,000 boxes took half a minute. Here 60 boxes have 1,770 pairs, of which two are in each
    other."""
    scene = stark.Scene()
    places = [(0.1 * k, 0.0, 0.0) for k in range(59)] + [(0.03, 0.0, 0.01)]
    for k, place in enumerate(places):
        scene.add_box(0.05, mass=0.1, position=place, name=f"box {k}")
    asked: list[tuple[str, str]] = []
    enabled = stark.Scene.contact_enabled

    def counted(self: stark.Scene, a: Any, b: Any) -> bool:
        asked.append((a.name, b.name))
        return enabled(self, a, b)

    monkeypatch.setattr(stark.Scene, "contact_enabled", counted)
    assert names(scene.disable_overlapping()) == [("box 0", "box 59")]
    assert asked == [("box 0", "box 59")]


def test_after_a_simulation_it_is_too_late() -> None:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0)
    scene.add_box(0.1, mass=1.0, position=(1, 0, 0))
    sim = stark.Simulation(scene)
    with pytest.raises(stark.InvalidArgument, match="before"):
        scene.disable_overlapping()
    assert sim.time == 0.0


def test_certificates_name_them(tmp_path: Any) -> None:
    scene = chain(2)
    scene.disable_overlapping()
    run = record(tmp_path / "run", scene, 2, time_step=0.01, gravity=(0, 0, 0))
    pair = {"bodies": ["link 0", "link 1"], "reason": "excluded by the scene"}
    assert verify(run).recording["excluded_pairs"] == [pair]


@pytest.mark.parametrize(
    ("obstacle", "place", "radius"),
    [
        ({"size": (1.6, 0.02, 0.02)}, (-0.3, 0.0, 0.012), 0.005),  # long edges
        ({"size": (2.0, 2.0, 0.1)}, (0.7, -0.6, 0.05), 0.02),  # large triangles
    ],
)
def test_where_bodies_intersect_is_said_to_a_radius(
    obstacle: dict[str, object], place: tuple[float, float, float], radius: float
) -> None:
    scene = stark.Scene()
    scene.add_box(motion="fixed", name="obstacle", **obstacle)  # type: ignore[arg-type]
    scene.add_sphere(radius, mass=0.01, position=place, name="bead")
    with pytest.raises(stark.InitialIntersection, match="the first near") as error:
        stark.Simulation(scene)
    numbers = re.search(r"the first near \((.*?)\) m", str(error.value)).group(1).split(", ")  # type: ignore[union-attr]
    assert np.linalg.norm(np.array(numbers, dtype=float) - place) < 1.05 * radius


def test_where_crossing_edges_touch_is_where_they_are_near() -> None:
    """Two triangles whose long edges cross, 1e-13 m apart: not at the ends of the edges."""
    scene = stark.Scene()
    lower = stark.TriangleMesh([(-1.0, 0.0, 0.0), (3.0, 0.0, 0.0), (1.0, 0.0, -1.0)], [(0, 1, 2)])
    upper = stark.TriangleMesh([(0.0, -1.0, 1e-13), (0.0, 5.0, 1e-13), (0.0, 2.0, 1.0)], [(0, 1, 2)])
    scene.add_cloth(lower, rest_angles="mesh", name="lower")
    scene.add_cloth(upper, rest_angles="mesh", name="upper")
    with pytest.raises(stark.InitialIntersection, match=r"touch at time 0 near \(0, 0, "):
        stark.Simulation(scene, contact_distance=1e-3)
