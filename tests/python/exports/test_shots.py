"""What exports hold: motions of rigid bodies from their points, fields of all bodies in a row."""

from __future__ import annotations

import numpy as np
import pytest
from _falls import falling

import stark
from stark.exports.shots import Camera, check_fields, pose_between
from stark.recording.format import drawn, surface


@pytest.mark.parametrize("angle", [0.0, 0.3, 3.1])
def test_the_motion_between_two_sets_of_points_is_found(angle: float) -> None:
    points = np.random.default_rng(1).normal(size=(20, 3))
    rotation, move = stark.rotation(axis=(1, 2, 3), angle=angle), np.array([0.1, -2.0, 3.0])
    found = pose_between(points, points @ rotation.T + move)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-14)
    np.testing.assert_allclose(found.position, move, atol=1e-14)


def test_points_of_a_plane_are_turned_and_not_mirrored() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    rotation = stark.rotation(axis="x", angle=np.pi)
    found = pose_between(points, points @ rotation.T)
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-14)


def test_velocities_are_means_since_the_shot_before() -> None:
    sim, camera = falling(), Camera(("velocity", "stress"))
    first = camera.take(sim, sim.time, 0)
    sim.run_until(0.03)
    second = camera.take(sim, sim.time, 1)
    assert not first.fields["velocity"]["box"].any()
    moved = second.bodies[-1].positions - first.bodies[-1].positions
    np.testing.assert_allclose(second.fields["velocity"]["box"], moved / 0.03, rtol=1e-6)
    data = second.point_data
    count = sum(len(body.positions) for body in second.bodies)
    assert data["velocity"].shape == (count, 3) and data["stress"].shape == (count,)
    rigid = np.concatenate([np.full(len(b.positions), b.kind == "rigid") for b in second.bodies])
    assert np.array_equal(np.isnan(data["stress"]), rigid)


def test_one_word_is_no_list_of_fields() -> None:
    with pytest.raises(stark.InvalidArgument, match=r"must be several names: \('stress',\)"):
        check_fields("stress", live=True)


def test_colours_are_found_once_and_surfaces_computed_once_a_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    from stark.exports import shots

    sim = falling()
    calls: list[int] = []
    find = shots.body_colors
    monkeypatch.setattr(shots, "body_colors", lambda parts: calls.append(len(parts)) or find(parts))
    camera = Camera(())
    first, second = (camera.take(sim, time, k) for k, time in enumerate((0.0, 0.1)))
    assert len(calls) == 1 and first.colors == second.colors == tuple(find(drawn(sim)))

    class Skin:
        asked = 0
        triangles = surface_triangles = np.zeros((0, 3), dtype=np.int32)

        @property
        def surface_positions(self) -> np.ndarray:
            self.asked += 1
            return np.zeros((3, 3))

    skin = Skin()
    assert len(surface(skin)[0]) == 3 and skin.asked == 1
