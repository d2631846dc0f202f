"""bouncing_balls: four balls that give back 0, 30, 60 and 90 % of the speed of an impact.

python examples/bouncing_balls.py      simulates 1.2 s, checks itself, prints the heights
"""

from __future__ import annotations

import numpy as np

import stark

DROP, RADIUS = 0.5, 0.05  # [m]
COEFFICIENTS = (0.0, 0.3, 0.6, 0.9)


def main() -> None:
    scene = stark.Scene("bouncing balls")
    floor = scene.add_floor(2.0)
    balls = []
    for k, e in enumerate(COEFFICIENTS):
        ball = scene.add_sphere(RADIUS, mass=0.1, position=(0.2 * k - 0.3, 0.0, RADIUS + DROP))
        scene.restitution[ball, floor] = e
        balls.append(ball)
    sim = stark.Simulation(scene, time_step=1 / 240)
    heights = np.array([[ball.position[2] - RADIUS for ball in balls] for _report in sim.run(until=1.2)])
    hit = np.argmin(heights[: heights.shape[0] // 2], axis=0)
    for k, e in enumerate(COEFFICIENTS):
        rebound = heights[hit[k] :, k].max() / DROP
        print(f"restitution {e}: back to {100 * rebound:.1f} % of the height")
        assert abs(np.sqrt(rebound) - e) < (0.03 if e > 0.0 else 0.1), rebound  # 0: the contact layer remains
    print("check: passed")


if __name__ == "__main__":
    main()
