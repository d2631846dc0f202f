"""energies_mooney_rivlin: a rubber bar of your own law in a tensile test.

What it shows: `@stark.material`, a law as the stored energy of a deformation gradient; an energy with a live
value as the testing machine, whose forces are read off.
The check is the closed form of the incompressible bar: at the stretch l the nominal stress is
2 (l - l^-2) (c10 + c01 / l). Writes out/energies_mooney_rivlin.png and, with the curve, .svg.

    python examples/energies_mooney_rivlin.py            prints stresses, then "check: passed"
"""

import numpy as np
import pictures

import stark

C10, C01, BULK, LENGTH, WIDTH = 3e4, 1e4, 1e9, 0.2, 0.05  # [Pa], [m]
STRETCHES = (0.6, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0)
DRAWN = (0.6, 1.0, 1.5, 2.0, 3.0)


@stark.material
def rubber(
    F: stark.DeformationGradient,
    c10: float = stark.parameter(unit="Pa", above=0.0),
    c01: float = stark.parameter(unit="Pa", above=0.0),
    bulk: float = stark.parameter(unit="Pa", above=0.0),
):
    """Mooney-Rivlin: invariants of the part of C that keeps the volume, and the change of the volume."""
    I1, I2, _ = stark.invariants(F.T @ F)
    J = stark.determinant(F)
    return c10 * (I1 * J ** (-2 / 3) - 3) + c01 * (I2 * J ** (-4 / 3) - 3) + 0.5 * bulk * (J - 1) ** 2


@stark.energy
def roller(p: stark.Point, normal: stark.Vec3, offset: float, stiffness: float = 1e8):
    """Holds points in the plane normal . x = offset [m], in which they slide; stiffness [N/m]."""
    return 0.5 * stiffness * (stark.dot(normal, p.x) - offset) ** 2


def build():
    """A bar along x: rollers hold one end and two sides, planes of symmetry, and pull the other end."""
    scene = stark.Scene()
    mesh = stark.mesh.tet_box((LENGTH, WIDTH, WIDTH), (12, 3, 3))
    bar = scene.add_solid(mesh, rubber(c10=C10, c01=C01, bulk=BULK, density=1100.0), color=pictures.GREEN)
    low, high = mesh.bounds
    for k, normal in enumerate(np.eye(3)):
        scene.add(roller(bar.vertices[mesh.vertices[:, k] == low[k]], normal=normal, offset=low[k]))
    pull = scene.add(roller(bar.vertices[mesh.vertices[:, 0] == high[0]], normal=(1, 0, 0), offset=high[0]))
    time, newton = {"integrator": "quasistatic"}, {"acceleration_tolerance": 1e-4}
    return stark.Simulation(scene, gravity=(0, 0, 0), time=time, newton=newton), bar, pull


def exact_stress(stretch):
    return 2 * (stretch - stretch**-2) * (C10 + C01 / stretch)


def main():
    sim, bar, pull = build()
    measured, shown = [], []
    for stretch in STRETCHES:
        pull.offset = (stretch - 0.5) * LENGTH  # live: the fixed end is at -LENGTH / 2
        assert not sim.step().failed
        stress = pull.forces[:, 0, 0].sum() / WIDTH**2
        measured.append((stretch, stress / 1e3))
        exact = exact_stress(stretch)
        print(f"stretch {stretch:.2f}: {stress:7.0f} Pa, incompressible {exact:7.0f} Pa")
        # The bar gives by 1e-4 in volume, stress over bulk modulus; the stress by as much.
        assert abs(stress - exact) < 3e-4 * abs(stress) + 1e-3, "not the closed form"
        if stretch in DRAWN:
            shown.append(pictures.snapshot(bar, shift=(0, -0.1 * DRAWN.index(stretch), 0)))
    curve = [(stretch, exact_stress(stretch) / 1e3) for stretch in np.linspace(0.6, 3.0, 100)]
    print(pictures.plot("energies_mooney_rivlin", curve, measured, "stretch", "nominal stress [kPa]"))
    print(pictures.save("energies_mooney_rivlin", shown, azimuth=-80, elevation=45, edges=True))
    print("check: passed")


if __name__ == "__main__":
    main()
