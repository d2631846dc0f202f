"""Joints, attachments and energies tell of the state that the simulation has, whichever it had before."""

from __future__ import annotations

import numpy as np

import stark


def test_readings_follow_the_state() -> None:
    scene = stark.Scene()
    beam = scene.add_box((1.0, 0.1, 0.1), mass=1.0, position=(0.5, 0.0, 0.0), name="beam")
    hinge = scene.add_hinge("world", beam, (0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    cloth = scene.add_cloth(stark.mesh.grid(0.4, 0.4, 4), position=(1.0, 0.0, -0.5), name="cloth")
    cord = scene.attach(cloth.vertices[[20, 24]], beam)
    push = scene.add_force(beam, (0.0, 0.0, 1.0))
    sim = stark.Simulation(scene, time_step=0.01)

    def read() -> list[np.ndarray]:
        return [np.array(values) for values in (hinge.residuals, cord.forces, push.energy, push.forces)]

    kept = []
    for _ in range(5):
        sim.step()
        kept.append((sim.state, read()))
    for (other, of_other), (state, found) in zip(kept[1:] + kept[:1], kept, strict=True):
        sim.state = other
        read()
        sim.state = state
        for now, then in zip(read(), found, strict=True):
            np.testing.assert_array_equal(now, then)
        assert not np.array_equal(found[2], of_other[2])
