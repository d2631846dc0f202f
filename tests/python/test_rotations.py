"""Rotations: matrices and quaternions against closed forms, digits of small angles."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stark


def test_rotations_turn_the_right_way() -> None:
    quarter = stark.rotation(axis="z", angle=90 * stark.deg)
    np.testing.assert_allclose(quarter @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(stark.rotation(axis=(0, 0, 5), angle=math.pi / 2), quarter, atol=1e-15)
    np.testing.assert_allclose(stark.rotation(vector=(0, 0, math.pi / 2)), quarter, atol=1e-15)
    half = math.sqrt(0.5)
    np.testing.assert_allclose(stark.rotation(quaternion=(half, 0, 0, half)), quarter, atol=1e-15)


def test_quaternions_and_matrices_agree_over_all_branches() -> None:
    scipy_rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    generator = np.random.default_rng(3)
    # Half turns about and near the axes exercise every branch of the conversion.
    quaternions = [*generator.normal(size=(200, 4)), *np.eye(4), *(np.eye(4) + 1e-9)]
    for q in quaternions:
        q = q / np.linalg.norm(q)
        R = stark.rotation(quaternion=q)
        np.testing.assert_allclose(R, scipy_rotation.from_quat(q[[1, 2, 3, 0]]).as_matrix(), atol=2e-15)
        back = stark.to_quaternion(R)
        assert min(np.abs(back - q).max(), np.abs(back + q).max()) < 1e-14


def test_small_rotations_keep_their_digits() -> None:
    R = stark.rotation(axis="x", angle=1e-9)
    assert R[2, 1] == 1e-9
    assert R[1, 1] == 1.0


def test_whole_numbers_beyond_four_turns_are_taken_for_degrees() -> None:
    with pytest.warns(stark.StarkWarning, match=r"angle = 90 rad is 14.3 turns.* 90 \* stark.deg if") as told:
        turned = stark.rotation(axis="z", angle=90)
    assert told[0].filename == __file__
    assert np.array_equal(turned, stark.rotation(axis="z", angle=90.0))  # no warning of a float
    with pytest.warns(stark.StarkWarning, match="angle = -45 rad"):
        stark.rotation(axis="x", angle=np.int64(-45))  # type: ignore[arg-type]
    stark.rotation(axis="x", angle=25)


def test_messages_do_not_print_large_arrays() -> None:
    scene = stark.Scene()
    sheet = stark.mesh.grid(1.0, 1.0, cells=10)
    edge = np.flatnonzero(sheet.vertices[:, 0] < -0.49)
    cloth = scene.add_cloth(sheet, pins=edge)
    with pytest.raises(
        stark.InvalidArgument, match=r"has the shape \(121, 3\): must be three numbers"
    ) as told:
        cloth.follow(displacement=lambda t: t * sheet.vertices, vertices=edge)
        stark.Simulation(scene).step()
    assert len(str(told.value)) < 200
