"""The rule for velocities of bodies that turn as a whole, against the solver, and what it does not take."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from _recorded_runs import edit_states, record

import stark
from stark.verify import verify
from stark.verify.turning import turned_velocities, wrong_velocity


def spinning() -> stark.Scene:
    scene = stark.Scene()
    spin = {"velocity": (0.3, -0.2, 0.1), "angular_velocity": (13.0, 22.0, -14.0)}
    scene.add_solid(stark.mesh.tet_box((0.1, 0.05, 0.02), 2), name="block", **spin)
    scene.add_cloth(
        stark.mesh.grid(0.1, 0.1, 3), stark.materials.cotton, name="c", position=(1, 0, 0), **spin
    )
    line = stark.mesh.polyline((0, 0, 0), (0.1, 0.02, 0.0), 5)
    scene.add_rod(line, stark.materials.rubber_cord, name="cord", position=(2, 0, 0), **spin)
    return scene


@pytest.mark.parametrize("time_step", [0.01, 0.03])
def test_certificates_know_velocities_of_what_turns(tmp_path: Path, time_step: float) -> None:
    run = record(tmp_path / "run", spinning(), 8, time_step=time_step)
    certificate = verify(run)
    assert certificate.verdict == "certified", certificate.text()
    assert certificate["reported_momentum"].status == "verified"
    edit_states(run, "velocities_0000", lambda array, times: array.__imul__(1.0 + 1e-6))
    assert verify(run)["reported_energies"].status == "violated"


def test_steady_turns_stay_steady() -> None:
    masses, h, spin = np.full(8, 0.2), 0.02, np.array([3.0, -12.0, 5.0])
    x0 = np.add(stark.mesh.box(0.3).vertices, (1.0, 2.0, 3.0))  # all axes of a cube are principal ones
    centre = masses @ x0 / masses.sum()
    v0 = np.cross(spin, x0 - centre)
    R = stark.rotation(axis=spin, angle=h * float(np.linalg.norm(spin)))
    x1 = centre + (x0 - centre) @ R.T
    np.testing.assert_allclose(
        turned_velocities(masses, x0, v0, x1, h), np.cross(spin, x1 - centre), atol=1e-5
    )
    straight = (x1 - x0) / h
    assert wrong_velocity(masses, (x0, x1), (v0, straight), h) < 1.0
    assert wrong_velocity(masses, (x0, x1), (v0, 0.5 * straight), h) > 1e3
