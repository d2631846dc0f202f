"""A pole on a cart is balanced from random starts: reset, place, read, act, thousands of times a second.

    python examples/random_starts.py

The cart slides on a rail, the pole turns on the cart, a controller pushes the cart. Each trial starts at
another angle, placed through the joints, and the pole must be upright after three seconds."""

from __future__ import annotations

import time

import numpy as np

import stark

TRIALS, STEPS, STEP = 20, 300, 0.01  # [s]


def build() -> stark.Scene:
    scene = stark.Scene("pole")
    cart = scene.add_box((0.2, 0.1, 0.06), mass=1.0, position=(0, 0, 0.5), name="cart")
    pole = scene.add_box((0.03, 0.03, 0.6), mass=0.2, position=(0, 0.1, 0.8), name="pole")
    rail = scene.add_slider(None, cart, anchor=(0, 0, 0.5), axis=(1, 0, 0), name="rail")
    scene.add_hinge(cart, pole, anchor=(0, 0.1, 0.5), axis=(0, 1, 0), name="hinge")
    rail.add_effort(0.0, name="push")
    return scene


def control(state: np.ndarray) -> float:
    """Force on the cart [N], from displacement [m], angle [rad] and their rates."""
    return float(np.clip(state @ np.array([6.0, 60.0, 8.0, 10.0]), -20.0, 20.0))


def main() -> None:
    sim = stark.Simulation(build(), time_step=STEP, threads=1)
    rail, hinge = sim.joints
    (push,) = sim.actuators
    random = np.random.default_rng(1)
    begin = time.perf_counter()
    for trial in range(TRIALS):
        sim.reset()
        with sim.placing():
            hinge.angle = start = random.uniform(-0.3, 0.3)
            rail.displacement = random.uniform(-0.2, 0.2)
            hinge.rates = {"angle": random.uniform(-0.5, 0.5)}
        for _ in range(STEPS):
            displacement, angle = rail.displacement, hinge.angle
            rates = rail.rates["displacement"], hinge.rates["angle"]
            push.target = control(np.array([displacement, angle, *rates]))
            assert not sim.step().failed
        print(
            f"trial {trial:2d}: from {start:+.3f} rad to {hinge.angle:+.4f} rad, {rail.displacement:+.4f} m"
        )
        assert abs(hinge.angle) < 0.02
    rate = TRIALS * STEPS / (time.perf_counter() - begin)
    print(f"{TRIALS * STEPS} steps, {rate:.0f} a second")


if __name__ == "__main__":
    main()
