"""Bodies so slow that stopping them is within the tolerances keep their momentum when they meet."""

import pytest

import stark


@pytest.mark.parametrize("speed", [1e-3, 3e-4])
@pytest.mark.parametrize("distance", [2e-5, 1e-4])
@pytest.mark.parametrize("part", [0.2, 1.25, 2.3])
def test_momentum_of_slow_impacts(speed, distance, part):
    # In a step of 0.1 s a ball goes through the whole layer of contact, and to stop it takes 0.01 m/s^2 at
    # most, the default of newton.acceleration_tolerance.
    step, gap = 0.1, part * 0.1 * speed
    scene = stark.Scene()
    scene.add_sphere(radius=0.05, mass=1.0, name="first", velocity=(speed, 0, 0))
    scene.add_sphere(radius=0.05, mass=1.0, name="second", position=(0.102 + gap, 0, 0))
    sim = stark.Simulation(scene, gravity=(0, 0, 0), time_step=step, contact_distance=distance)
    for _ in range(int((gap + 0.01) / speed / step)):
        sim.step()
    first, second = (sim[name].velocity[0] / speed for name in ("first", "second"))
    assert second > 0.45
    assert first + second == pytest.approx(1.0, abs=1e-6)
