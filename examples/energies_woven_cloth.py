"""energies_woven_cloth: three strips of one fabric, cut along the warp, along the weft and on the bias.

What it shows: `@stark.material` for cloth that is not isotropic, a law of the 3x2 deformation gradient; a
warp direction for each body; dead loads as an energy with a value for each point.
The check is the closed form of the stretch of a strip that is pulled. Writes out/energies_woven_cloth.png.

    python examples/energies_woven_cloth.py            prints stretches, then "check: passed"
"""

import numpy as np
import pictures

import stark

WARP, WEFT, SHEAR, THICKNESS = 2e6, 5e5, 1e5, 5e-4  # [Pa], [m]
LENGTH, WIDTH, CELLS = 0.3, 0.06, (30, 6)  # [m]
FORCE = 6.0  # [N]
COLORS = {0: pictures.BLUE, 90: pictures.GREEN, 45: pictures.RED}  # by the angle of the warp [degrees]


@stark.material
def woven(
    F: stark.ShellDeformationGradient,
    warp: float = stark.parameter(unit="Pa", above=0.0),
    weft: float = stark.parameter(unit="Pa", above=0.0),
    shear: float = stark.parameter(unit="Pa", above=0.0),
):
    """Threads that stretch on their own, and shear between them: Green strain, first axis along the warp."""
    E = 0.5 * (F.T @ F - stark.identity(2))
    return 0.5 * warp * E[0, 0] ** 2 + 0.5 * weft * E[1, 1] ** 2 + 2 * shear * E[0, 1] ** 2


@stark.energy
def load(p: stark.Point, force: stark.Vec3):
    """Force [N] that stays what it is; its energy is minus its work."""
    return -(force @ p.x)


def add_strip(scene, angle, y):
    """A strip along x whose warp has an angle [degrees] to it, and the loads on both of its ends."""
    mesh = stark.mesh.grid(LENGTH, WIDTH, CELLS)
    direction = stark.rotation(axis="z", angle=angle * stark.deg)[:, 0]
    sheet = stark.ShellMaterial(thickness=THICKNESS, density=0.2, mass_damping=10.0)
    fabric = woven(base=sheet, warp=WARP, weft=WEFT, shear=SHEAR, warp_direction=direction)
    strip = scene.add_cloth(mesh, fabric, position=(0, y, 0), color=COLORS[angle])
    for side in (-1, 1):
        end = np.isclose(mesh.vertices[:, 0], 0.5 * side * LENGTH)
        share = np.where(np.isclose(abs(mesh.vertices[end, 1]), 0.5 * WIDTH), 0.5, 1.0) / CELLS[1]
        scene.add(load(strip.vertices[end], force=np.outer(share, (side * FORCE, 0, 0))))
    return strip


def exact_stretch(angle):
    c, s = np.cos(angle * stark.deg), np.sin(angle * stark.deg)
    stress, compliance = FORCE / (WIDTH * THICKNESS), c**4 / WARP + s**4 / WEFT + (c * s) ** 2 / SHEAR
    # Stress S = T / l gives l^2 - 1 = 2 S compliance: l^3 - l - 2 T compliance = 0, one root above 1.
    return max(np.roots([1.0, 0.0, -1.0, -2.0 * stress * compliance]).real)


def main():
    scene = stark.Scene()
    strips = {angle: add_strip(scene, angle, y=-0.1 * k) for k, angle in enumerate(COLORS)}
    shown = [pictures.snapshot(strip, shift=(-0.5, 0, 0)) for strip in strips.values()]
    # Long steps: the strips are free and need inertia, their equilibrium is reached in a few.
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 0))
    sim.run_until(6.0)
    for angle, strip in strips.items():
        row = strip.positions.reshape(CELLS[1] + 1, CELLS[0] + 1, 3)
        stretch = np.linalg.norm(row[:, -1] - row[:, 0], axis=1) / LENGTH
        print(f"warp at {angle:2} deg: stretch {stretch.mean():.9f}, exact {exact_stretch(angle):.9f}")
        # The strain is the same everywhere, which triangles represent: no error of the mesh.
        assert np.abs(stretch - exact_stretch(angle)).max() < 1e-8, "the stretch is not the closed form"
    shown += [pictures.snapshot(strip) for strip in strips.values()]
    print(pictures.save("energies_woven_cloth", shown, height=400, azimuth=-90, elevation=88, edges=True))
    print("check: passed")


if __name__ == "__main__":
    main()
