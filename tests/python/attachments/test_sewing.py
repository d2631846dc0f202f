"""Seams that close in a run: panels that start apart are drawn together, and hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stark

TOLERANCE = 1e-6  # joints.length_tolerance [m]


def _panels(scene: stark.Scene, gap: float = 0.1) -> tuple[stark.Cloth, stark.Cloth, np.ndarray]:
    """Two upright panels, face to face, and the vertices of their sides."""
    mesh = stark.mesh.grid(0.2, 0.1, cells=(8, 4))
    upright = stark.rotation(axis="x", angle=90 * stark.deg)
    front, back = (
        scene.add_cloth(mesh, stark.materials.cotton, rotation=upright, position=(0, y, 0), name=name)
        for name, y in (("front", -gap / 2), ("back", gap / 2))
    )
    return front, back, np.flatnonzero(abs(abs(mesh.vertices[:, 0]) - 0.1) < 1e-9)


def _run(scene: stark.Scene) -> stark.Simulation:
    return stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))


def test_panels_are_sewn_around_a_body_and_stay() -> None:
    scene = stark.Scene()
    scene.add_capsule(0.03, 0.3, motion="fixed")
    front, back, sides = _panels(scene)
    seam = scene.sew(front, back, pairs=np.column_stack((sides, sides)), duration=0.3, name="side")
    sim = _run(scene)
    np.testing.assert_allclose(seam.gaps, 0.1, atol=1e-12)
    sim.run_until(0.15)
    # Threads are wound up evenly: half of the length is left, and what they are stretched by.
    assert 0.045 < seam.gaps.max() < 0.053
    sim.run_until(0.4)
    # Well below the contact distances of 2 mm, at which contact would keep the panels apart.
    assert seam.gaps.max() < 2e-4
    assert not seam.held.any()
    seam.pull_together()
    scene.energies["side threads"].force = 0.0
    sim.run_until(0.6)
    assert seam.held.all() and seam.gaps.max() < TOLERANCE
    np.testing.assert_allclose(front.positions[sides], back.positions[sides], atol=2 * TOLERANCE)


def test_a_panel_is_sewn_to_a_tube() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.2, 0.06, cells=(20, 6))
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    bent = np.column_stack((0.045 * np.sin(x / 0.045), y, -0.045 * np.cos(x / 0.045)))
    panel = scene.add_cloth(mesh, stark.materials.cotton, initial_positions=bent)
    left, right = (np.flatnonzero(abs(x - side) < 1e-9) for side in (-0.1, 0.1))
    seam = scene.sew(panel.vertices[left], panel.vertices[right], duration=0.2)
    sim = _run(scene)
    sim.run_until(0.3)
    assert seam.gaps.max() < 2e-4
    seam.pull_together()
    sim.run_until(0.4)
    assert seam.gaps.max() < TOLERANCE


def test_a_thread_pulls_with_no_more_than_its_force() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.grid(0.1, 0.1, cells=2)
    held = scene.add_cloth(mesh, pins=range(9))
    other = scene.add_cloth(mesh, pins=range(9), position=(0, 0, 0.1))
    scene.sew(held, other, pairs=[(4, 4)], duration=0.1, force=0.3, name="tie")
    sim = _run(scene)
    sim.run_until(0.2)
    pull = held.pin_forces[4]
    # 0.1 m is 100 times the reach, where a thread pulls with 1/sqrt(1 + 1e-4) of its force.
    np.testing.assert_allclose(pull, (0, 0, -0.3), atol=3e-5)


def test_points_that_break_touch_again(tmp_path: Path) -> None:
    scene = stark.Scene()
    front, back, sides = _panels(scene, 0.02)
    seam = scene.sew(front, back, pairs=np.column_stack((sides, sides)), duration=0.1, break_force=1e-9)
    sim = _run(scene)
    sim.run_until(0.2)
    seam.pull_together()
    scene.energies[f"{seam.name} threads"].force = 0.0
    sim.run_until(0.3)
    assert seam.broken.all()
    sim.run_until(0.6)
    assert seam.gaps.min() > 1e-3, "contact keeps them apart"


def test_a_document_and_a_checkpoint_keep_seams(tmp_path: Path) -> None:
    scene = stark.Scene()
    front, back, sides = _panels(scene, 0.02)
    scene.sew(front, back, pairs=np.column_stack((sides, sides)), duration=0.1, name="side")
    scene.save(tmp_path / "dress.json")
    sim, again = _run(scene), _run(stark.load_scene(tmp_path / "dress.json"))
    for one in (sim, again):
        one.run_until(0.2)
        one.attachments["side"].pull_together()
    sim.save(tmp_path / "sewn.stark")
    third = _run(scene)
    third.load(tmp_path / "sewn.stark")
    for one in (sim, again, third):
        one.run_until(0.25)
        assert one.attachments["side"].gaps.max() < TOLERANCE
        assert one.state == sim.state


def test_what_cannot_be_sewn_is_refused() -> None:
    scene = stark.Scene()
    front, back, sides = _panels(scene)
    with pytest.raises(stark.InvalidArgument, match="10 points and 4 points: must be as many"):
        scene.sew(front.vertices[sides], back.vertices[sides[:4]])
    with pytest.raises(stark.InvalidArgument, match="must be two bodies with pairs=, or points of both"):
        scene.sew(front, back)
    with pytest.raises(stark.InvalidArgument, match=r"duration = 0.* must be > 0"):
        scene.sew(front, back, pairs=[(0, 0)], duration=0.0)
    assert len(scene.attachments) == 0 and len(scene.energies) == 0
    seam = scene.sew(front, back, pairs=[(0, 0)])
    sim = _run(scene)
    with pytest.raises(stark.InvalidArgument, match="1 released pairs are away from where they meet, pair 0"):
        seam.enabled = True
    assert sim.time == 0.0
