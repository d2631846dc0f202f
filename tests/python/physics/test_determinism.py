"""The same bits for any number of threads and both ways of evaluation; rewinding repeats a run bit by bit."""

from __future__ import annotations

import pytest

import stark


def cluttered() -> stark.Scene:
    """All kinds of bodies in frictional contact at once: a cloth between a ball and a soft box, on a
    floor."""
    scene = stark.Scene()
    scene.default_friction = 0.4
    scene.add_floor(1.0)
    scene.add_solid(
        stark.mesh.tet_box(0.08, 3),
        stark.materials.soft_rubber.replace(youngs_modulus=5e4),
        position=(0, 0, 0.0415),
    )
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, 14), position=(0.01, 0, 0.084), velocity=(0.2, 0, -0.5))
    scene.add_sphere(0.03, subdivisions=2, mass=0.05, position=(0.01, 0.005, 0.117), velocity=(0.2, 0, -0.5))
    return scene


def run(steps: int = 8, **settings: object) -> tuple[list[str], int]:
    sim = stark.Simulation(cluttered(), time_step=1 / 60, contact_distance=1e-3, **settings)
    hashes, contacts = [], 0
    for _ in range(steps):
        report = sim.step()
        assert not report.failed, report.message
        contacts = max(contacts, report.contact_count)
        hashes.append(sim.state.hash)
    return hashes, contacts


@pytest.fixture(scope="module")
def reference() -> list[str]:
    hashes, contacts = run(threads=1)
    assert contacts > 50 and len(set(hashes)) == len(hashes)
    return hashes


@pytest.mark.parametrize("threads", [2, 5])
def test_bits_do_not_depend_on_the_number_of_threads(threads: int, reference: list[str]) -> None:
    assert run(threads=threads, **{"execution.oversubscribe": True})[0] == reference


def test_bits_do_not_depend_on_the_back_end(reference: list[str]) -> None:
    assert run(threads=1, **{"execution.backend": "interpreter"})[0] == reference


def test_hash_sees_the_smallest_change(reference: list[str]) -> None:
    assert run(steps=1, gravity=(0, 0, -9.81 * (1 + 1e-15)))[0] != reference[:1]


@pytest.mark.parametrize("solver", ["cholesky", "pcg", "cholesky_float"])
def test_rewinding_repeats_the_run(solver: str) -> None:
    sim = stark.Simulation(cluttered(), time_step=1 / 60, contact_distance=1e-3, **{"linear.solver": solver})
    for _ in range(3):
        assert not sim.step().failed
    middle, time = sim.state, sim.time

    def go_on() -> list[str]:
        hashes = []
        for _ in range(4):
            assert not sim.step().failed
            hashes.append(sim.state.hash)
        return hashes

    first = go_on()
    sim.state = middle
    assert sim.time == time and sim.state.hash == middle.hash
    assert go_on() == first
