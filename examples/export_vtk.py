"""A box falls on a block of jelly; the simulation is exported to VTU files, and PyVista draws the stress of
the block.

    pip install 'stark-sim[samples]'
    python examples/export_vtk.py

Leaves out/fall.pvd and out/export_vtk.png, the picture of docs/export.md."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

import stark

OUT = Path("out")
END = 0.3  # [s]


def simulate(path: Path) -> None:
    scene = stark.Scene("fall")
    scene.add_floor(1.0)
    scene.add_solid(stark.mesh.tet_box(0.1, cells=8), name="jelly", position=(0, 0, 0.06))
    scene.add_box(0.05, name="box", mass=0.3, position=(0, 0, 0.15), angular_velocity=(1, 2, 3))
    sim = stark.Simulation(scene, time_step=0.01)
    with stark.exports.Exporter(path, sim, fields=("displacement", "stress", "contact_force")) as export:
        export.record(sim)
        for _ in sim.run(until=END):
            export.record(sim)


def draw(path: Path, picture: Path) -> None:
    """The last time of the file."""
    pyvista: Any = importlib.import_module("pyvista")
    reader = pyvista.get_reader(str(path))
    reader.set_active_time_value(reader.time_values[-1])
    (mesh,) = reader.read()
    body = mesh.cell_data["body"]  # numbers of the bodies, in the order of the scene
    floor, jelly, box = (mesh.extract_cells(np.flatnonzero(body == k)) for k in range(3))
    plotter = pyvista.Plotter(off_screen=True, window_size=(1280, 600))
    plotter.set_background("white")
    plotter.add_mesh(floor, color=(0.93, 0.94, 0.95), ambient=0.5, diffuse=0.5)
    plotter.add_mesh(box, color=(0.75, 0.76, 0.79), ambient=0.3, diffuse=0.7)
    bar = {
        "title": "von Mises stress [Pa]\n", "fmt": "%.0f", "n_labels": 5, "color": "black",
        "title_font_size": 20, "label_font_size": 18,
        "vertical": True, "position_x": 0.86, "position_y": 0.2, "height": 0.6, "width": 0.05,
    }  # fmt: skip
    plotter.add_mesh(
        jelly,
        scalars="stress",
        cmap="viridis",
        show_edges=True,
        line_width=1,
        edge_opacity=0.25,
        ambient=0.4,
        scalar_bar_args=bar,
    )
    plotter.camera_position = [(0.22, -0.34, 0.2), (0.0, 0.0, 0.055), (0.0, 0.0, 1.0)]
    plotter.enable_anti_aliasing("ssaa")
    plotter.screenshot(str(picture))
    plotter.close()


def main() -> None:
    OUT.mkdir(exist_ok=True)
    path, picture = OUT / "fall.pvd", OUT / "export_vtk.png"
    simulate(path)
    draw(path, picture)
    print(f"{path}, {picture}")


if __name__ == "__main__":
    main()
