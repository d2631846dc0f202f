"""energies_magnet: a flying magnet catches a cloth.

What it shows: `@stark.energy` on pairs of points, a vertex of the cloth and the moving centre of a ball; a
live parameter that switches the magnet on; the forces on both points of each pair.
The check is physics: forces of the closed form, opposite in each pair; no momentum of cloth and ball together
comes or goes; at the end the ball flies as after an inelastic impact. Writes out/energies_magnet.png.

    python examples/energies_magnet.py            prints "check: passed" after some seconds
"""

import numpy as np
import pictures

import stark

STRENGTH, CORE = 4e-6, 0.05  # [J m], [m]
ON, UNTIL = 0.2, 1.2  # time at which the magnet is switched on, end [s]


@stark.energy
def magnet(
    p: stark.Point,
    center: stark.Point,
    strength: float = stark.parameter(unit="J m", min=0.0),
    core: float = stark.parameter(unit="m", above=0.0),
):
    """Attraction of two points, which the core keeps finite where they meet: -s / sqrt(r^2 + core^2)."""
    d = p.x - center.x
    return -strength / stark.sqrt(d @ d + core**2)


def build():
    scene = stark.Scene()
    fabric = stark.materials.cotton.replace(mass_damping=0.0)  # drag of the air would take momentum
    mesh, upright = stark.mesh.grid(0.4, 0.4, cells=20), stark.rotation(axis="x", angle=70 * stark.deg)
    cloth = scene.add_cloth(mesh, fabric, position=(0, 0.25, 0), rotation=upright, color=pictures.RED)
    ball = scene.add_sphere(0.05, mass=0.2, position=(0, -0.2, 0), velocity=(0, 0.5, 0), color=pictures.BLUE)
    pull = scene.add(magnet(cloth.vertices, ball.points((0, 0, 0)), strength=0.0, core=CORE))
    return stark.Simulation(scene, time_step=1 / 60, gravity=(0, 0, 0)), cloth, ball, pull


def vertex_masses(cloth):
    """A third of the mass of the triangles around each vertex [kg]."""
    a, b, c = np.moveaxis(cloth.mesh.vertices[cloth.triangles], 1, 0)
    masses = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1) * stark.materials.cotton.density
    return np.bincount(cloth.triangles.ravel(), np.repeat(masses / 3, 3))


def check(momenta, mass, cloth, ball, pull):
    d = cloth.positions - ball.position
    exact = -STRENGTH * d / ((d * d).sum(axis=1, keepdims=True) + CORE**2) ** 1.5
    # Both are differentiated exactly: what is left is rounding.
    assert np.allclose(pull.forces[:, 0], exact, rtol=1e-10, atol=1e-15), "forces are not the closed form"
    assert np.allclose(pull.forces[:, 1], -exact, rtol=1e-10, atol=1e-15), "no reaction on the centre"
    # The sum over some hundred vertices, whose forces cancel to rounding.
    assert np.abs(momenta - (0.0, 0.1, 0.0)).max() < 1e-12, "momentum is lost"
    # What is left of the cloth's swinging moves the ball, which is six times heavier, by less than 5 %.
    together = 0.1 / (ball.mass + mass.sum())
    assert np.linalg.norm(ball.velocity - (0, together, 0)) < 0.05 * together, "the cloth was not caught"


def main():
    sim, cloth, ball, pull = build()
    mass, momenta, shown, moments = vertex_masses(cloth), [], [], 0
    for step in sim.run(until=UNTIL):
        momenta.append(mass @ cloth.velocities + ball.mass * ball.velocity)
        if step.time > ON and pull.strength == 0.0:
            pull.strength = STRENGTH  # live: the next step takes it, nothing is compiled again
        if step.time > ON + 0.3 * moments:
            shown += [pictures.snapshot(body, shift=(0.5 * moments, 0, 0)) for body in (cloth, ball)]
            moments += 1
    check(np.array(momenta), mass, cloth, ball, pull)
    print(pictures.save("energies_magnet", shown, azimuth=-84, elevation=13))
    print("check: passed")


if __name__ == "__main__":
    main()
