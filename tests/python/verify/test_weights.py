"""Rigid bodies are looked at together: sums against those of one body after the other, and one wrong body
among many."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import edit_states, record

import stark
from stark.verify import verify
from stark.verify.reading import read
from stark.verify.rotation import axes_and_angles, free_rotation, turned
from stark.verify.weights import groups_of


def tumbling() -> stark.Scene:
    """Boxes and a tetrahedron that tumble, two boxes at a hinge, a cord, a sheet and a fixed box."""
    scene, rng = stark.Scene(), np.random.default_rng(4)
    for k in range(12):
        spin = {"velocity": rng.normal(size=3), "angular_velocity": 8.0 * rng.normal(size=3)}
        size = tuple(rng.uniform(0.02, 0.1, 3))
        scene.add_box(size, density=500.0, position=(0.3 * k, 0.0, 0.0), name=f"box_{k}", **spin)
    corners = 0.1 * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
    mesh = stark.mesh.TriangleMesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    scene.add_rigid(mesh, density=500.0, position=(0, 1, 0), angular_velocity=(1, 2, 3), name="tetrahedron")
    arm = scene.add_box((0.2, 0.02, 0.02), density=500.0, position=(0, 2, 0), name="arm")
    scene.add_hinge(None, arm, anchor=(-0.1, 2, 0), axis=(0, 1, 0), name="hinge")
    line = stark.mesh.polyline((0, 3, 0), (0.1, 3, 0), 5)
    scene.add_rod(line, stark.materials.rubber_cord, name="cord", clamps=[0])
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 3), stark.materials.cotton, name="sheet", position=(0, 4, 0))
    scene.add_box(0.1, motion="fixed", position=(0, 5, 0), name="post")
    return scene


@pytest.fixture(scope="module", params=["implicit_euler", "bdf2"])
def run_folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp(request.param) / "run"
    return record(folder, tumbling(), 6, time_step=0.01, **{"time.integrator": request.param})


def test_rigid_bodies_are_together_and_others_alone(run_folder: Path) -> None:
    run = read(run_folder)
    hinged = next(i for i, body in enumerate(run.bodies) if body.name == "arm")
    groups = groups_of(run.bodies, {hinged})
    assert [len(group.masses) for group in groups] == [13, 1, 6, 16]
    assert [group.is_held for group in groups] == [False, True, False, False]
    assert [len(group.moments) for group in groups] == [13, 1, 5, 0]  # a node of the cord is clamped
    state = run.state(3)
    moving = groups[0].moving(state)
    for row, body in enumerate(run.bodies[:13]):
        assert body.inertia is not None and state.poses[row] is not None
        pose = np.asarray(state.poses[row])
        centre = pose[0] + pose[1:] @ np.array(body.inertia["center_of_mass"])
        assert groups[0].masses[row] == body.inertia["mass"]
        assert moving.places[row] == pytest.approx(centre, rel=1e-15, abs=1e-15)
        assert moving.reach is not None and moving.rotations is not None
        assert moving.reach[row] == pytest.approx(
            np.linalg.norm(state.positions[row] - centre, axis=1).max(), rel=1e-14
        )
        R = moving.rotations[row]
        turned_tensor = R @ np.diag(groups[0].moments[row]) @ R.T
        tensor = pose[1:] @ np.array(body.inertia["tensor"]) @ pose[1:].T
        assert turned_tensor == pytest.approx(tensor, abs=1e-14 * np.abs(tensor).max())


def test_many_bodies_are_certified(run_folder: Path) -> None:
    certificate = verify(run_folder)
    assert certificate.verdict == "certified"
    found = {claim.name: claim.status for claim in certificate.claims}
    assert found["reported_energies"] == found["reported_momentum"] == found["rigid_shapes"] == "verified"


def test_one_wrong_body_among_many_is_found(run_folder: Path, tmp_path: Path) -> None:
    def violated(name: str, change: float) -> set[str]:
        folder = shutil.copytree(run_folder, tmp_path / f"{name}_{change}")
        edit_states(folder, name, lambda rows, _: rows[4].__imul__(1.0 + change))
        return {claim.name for claim in verify(folder).claims if claim.status == "violated"}

    assert "reported_momentum" in violated("angular_velocities_0007", 1e-4)
    assert "rigid_shapes" in violated("poses_0007", 1e-7)
    folder = shutil.copytree(run_folder, tmp_path / "moved")
    edit_states(folder, "positions_0009", lambda rows, _: rows[4, 2].__iadd__(1e-7))
    claims = {claim.name: claim for claim in verify(folder).claims}
    assert claims["rigid_shapes"].where == {"time": pytest.approx(0.04), "bodies": ["box_9"]}
    assert claims["display"].status == "verified"  # that state has no frame


def test_free_rotations_do_not_depend_on_other_bodies() -> None:
    """Some turn so fast that they need hundreds of substeps, others rest."""
    rng = np.random.default_rng(0)
    rotations = np.linalg.qr(rng.normal(size=(9, 3, 3)))[0]
    moments = rng.uniform(1.0, 2.0, (9, 3))
    momenta = rng.normal(size=(9, 3)) * np.array([0.0, 0.1, 1, 1, 10, 100, 1000, 3, 1])[:, None]
    together = free_rotation(rotations, moments, momenta, 0.01)
    alone = [free_rotation(*(a[k : k + 1] for a in (rotations, moments, momenta)), 0.01) for k in range(9)]
    assert together == pytest.approx(np.concatenate(alone), rel=1e-13, abs=1e-13)
    assert together[0] == pytest.approx(rotations[0], abs=0.0)
    assert together @ together.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), (9, 3, 3)))


def test_axes_and_angles_are_those_of_the_turns() -> None:
    rng = np.random.default_rng(1)
    w = rng.normal(size=(6, 3))
    w[0] = 0.0
    turns = turned(w, np.broadcast_to(np.eye(3), (6, 3, 3)))
    axes, angles = axes_and_angles(turns)
    assert np.linalg.norm(axes, axis=1) == pytest.approx(np.ones(6))
    assert turned(axes * angles[:, None], np.broadcast_to(np.eye(3), (6, 3, 3))) == pytest.approx(turns)
    assert angles[0] == 0.0 and (angles <= np.pi).all()
