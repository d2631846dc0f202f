"""energies_thermal_shell: heated strips of plastic sheet, one free, the others between supports.

What it shows: `@stark.energy` on triangles as the membrane of a shell; a live temperature for each triangle.
The check: the free strip grows by alpha dT and stays flat; hot ones between supports become arches as long as
if they were free, and as high as Euler's elastica of that length. Writes out/energies_thermal_shell.png.

    python examples/energies_thermal_shell.py            prints sizes, then "check: passed"
"""

import numpy as np
import pictures

import stark

LENGTH, WIDTH, THICKNESS, CELLS, YOUNG, ALPHA = 0.3, 0.05, 5e-4, (30, 5), 1e9, 2e-4  # [m], [Pa], [1/K]
HEATING = (160.0, 0.0, 10.0, 40.0, 160.0)  # [K] above rest; the first strip is free
COLORS = (pictures.RED, pictures.BLUE, pictures.GREEN, pictures.YELLOW, pictures.RED)


@stark.energy
def hot_membrane(t: stark.Triangle, temperature: float = stark.parameter(unit="K")):
    """St. Venant-Kirchhoff membrane (Poisson's ratio 0) of F without the free expansion 1 + alpha dT."""
    F = t.F / (1 + ALPHA * temperature)
    E = 0.5 * (F.T @ F - stark.identity(2))
    return 0.5 * YOUNG * stark.trace(E @ E) * THICKNESS * t.rest_area


@stark.energy
def support(p: stark.Point, stiffness: float = stark.parameter(1e6, unit="N/m", min=0.0)):
    """Edge across the strip, along which its end is free to slide and about which it turns."""
    return 0.5 * stiffness * stark.squared_norm((p.x - p.x0)[::2])


def add_strip(scene, y, color, supported):
    # The cloth brings inertia and bending, D = E t^3 / 12 = 3 k; its own membrane is too soft to matter.
    sheet = stark.ShellMaterial(youngs_modulus=1, bending_stiffness=YOUNG * THICKNESS**3 / 36, mass_damping=2)
    strip = scene.add_cloth(stark.mesh.grid(LENGTH, WIDTH, CELLS), sheet, position=(0, y, 0), color=color)
    if supported:
        scene.add(support(strip.vertices[np.abs(strip.mesh.vertices[:, 0]) == 0.5 * LENGTH]))
    return strip, scene.add(hot_membrane(strip.faces, temperature=np.zeros(len(strip.triangles))))


def elastica(stretch):
    """Height [m] of a sheet that is bent between supports at 1 / stretch of its length."""
    k, phi = np.linspace(0.0, 0.5, 1001)[:, None], (np.arange(200) + 0.5) * np.pi / 400
    root = np.sqrt(1 - (k * np.sin(phi)) ** 2)
    K, E = 0.5 * np.pi * (1 / root).mean(axis=1), 0.5 * np.pi * root.mean(axis=1)
    return stretch * LENGTH * np.interp(1 - 1 / stretch, 2 - 2 * E / K, k[:, 0] / K)


def check(strip, stretch, supported):
    rows = strip.positions.reshape(CELLS[1] + 1, CELLS[0] + 1, 3)
    longer = np.linalg.norm(np.diff(rows, axis=1), axis=2).sum(axis=1).mean() / LENGTH
    height, exact = np.ptp(rows[..., 2].mean(axis=0)), elastica(stretch) * supported
    print(f"stretch {longer:.7f} of {stretch:.3f}, height {1e3 * height:6.3f} mm of {1e3 * exact:6.3f} mm")
    # The thrust between supports is Euler's, the strain pi^2 t^2 / (12 L^2) = 2.3e-6.
    assert abs(longer - stretch) < (4e-6 if supported else 1e-9), "the strip does not grow by alpha dT"
    # Triangles do not bend quite as a plate does, 0.6 %; the little gravity lifts the cold strip by 1e-6 m.
    assert abs(height - exact) < 0.01 * exact + 2e-6, "the strip is not as high as the elastica"


def main():
    scene = stark.Scene()
    strips = [add_strip(scene, y=0.08 * k, color=COLORS[k], supported=k > 0) for k in range(5)]
    # Long steps, each near equilibrium. A hundred-thousandth of gravity, upwards, decides the side.
    sim = stark.Simulation(scene, time_step=1.0, gravity=(0, 0, 1e-4))
    for level in (*np.linspace(0.05, 1.0, 20), *np.ones(10)):
        for (_, membrane), kelvin in zip(strips, HEATING, strict=True):
            membrane.temperature[:] = level * kelvin  # live, in place
        sim.step()
    for k, (strip, _) in enumerate(strips):
        check(strip, 1 + ALPHA * HEATING[k], supported=k > 0)
    shown = [pictures.snapshot(strip) for strip, _ in strips]
    print(pictures.save("energies_thermal_shell", shown, height=420, azimuth=-68, elevation=30, edges=True))
    print("check: passed")


if __name__ == "__main__":
    main()
