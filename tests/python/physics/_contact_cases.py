"""Contact in its smallest forms (V24): bodies of 2 to 20 vertices that meet vertex on vertex, edge on edge,
and in the degenerate ways of Erleben (2018, "Methodology for assessing mesh-based contact point methods"),
rebuilt from their descriptions. All data: what the bodies are and where; the tests are in
test_contact_units.py."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import stark

Triple = tuple[float, float, float]
Turns = tuple[tuple[str, float], ...]  # axis, angle [deg]
GAP = 5e-3  # between bodies at the start [m]
SIZE = 0.1  # [m]


def prism(profile: list[tuple[float, float]], length: float) -> stark.TriangleMesh:
    """A polygon of (x, z), counterclockwise and visible from its first point, extruded along y."""
    n = len(profile)
    outline = np.array(profile)
    front, back = (np.insert(outline, 1, y, axis=1) for y in (-length / 2, length / 2))
    triangles = []
    for k in range(1, n - 1):
        triangles += [(0, k, k + 1), (n, n + k + 1, n + k)]
    for k in range(n):
        j = (k + 1) % n
        triangles += [(k, n + k, n + j), (k, n + j, j)]
    return stark.TriangleMesh(np.concatenate([front, back]), triangles)


def pyramid(tip: float) -> stark.TriangleMesh:
    """Of a square of 0.1 m at z = 0, its tip above or below."""
    h = SIZE / 2
    corners = [(-h, -h, 0.0), (h, -h, 0.0), (h, h, 0.0), (-h, h, 0.0), (0.0, 0.0, tip)]
    sides = [(k, (k + 1) % 4, 4) for k in range(4)]
    return stark.mesh.oriented(stark.TriangleMesh(corners, [*sides, (0, 1, 2), (0, 2, 3)]))


def block_with_hole() -> stark.TriangleMesh:
    """A block of 0.3 x 0.3 x 0.2 m, its top at z = 0, with a hole that a larger spike would fill."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    rings = [np.insert(0.15 * square, 2, z, axis=1) for z in (-0.2, 0.0)]
    rim = np.insert(0.06 * square, 2, 0.0, axis=1)
    vertices = np.concatenate([*rings, rim, [(0.0, 0.0, -0.12)]])
    triangles = [(0, 2, 1), (0, 3, 2)]
    for k in range(4):
        j = (k + 1) % 4
        triangles += [(k, j, 4 + j), (k, 4 + j, 4 + k)]
        triangles += [(4 + k, 4 + j, 8 + j), (4 + k, 8 + j, 8 + k), (8 + k, 8 + j, 12)]
    return stark.TriangleMesh(vertices, triangles)


# Tips and ridges that point down have their lowest point at z = 0, those that point up their highest one; so
# do cubes that are put on something or carry something.
HALF = SIZE / 2
SURFACES = {
    "cube": stark.mesh.box(SIZE).translated((0, 0, HALF)),
    "base": stark.mesh.box(SIZE).translated((0, 0, -HALF)),
    "spike": pyramid(-SIZE).translated((0, 0, SIZE)),
    "peak": pyramid(SIZE).translated((0, 0, -SIZE)),
    "wedge": prism([(0, 0), (HALF, SIZE), (-HALF, SIZE)], SIZE),
    "ridge": prism([(0, 0), (-HALF, -SIZE), (HALF, -SIZE)], SIZE),
    "hole": block_with_hole(),
    # Visible from the bottom of the crack.
    "crack": prism(
        [(0, -0.12), (-0.06, 0), (-0.15, 0), (-0.15, -0.2), (0.15, -0.2), (0.15, 0), (0.06, 0)], 0.3
    ),
    "floor": stark.mesh.grid(1.2, 1.2, 2),
    "tiles": stark.mesh.grid(1.2, 1.2, 12),
}
SHEETS = {
    "triangle": stark.TriangleMesh([(0, 0, 0), (SIZE, HALF, 0), (SIZE, -HALF, 0)], [(0, 2, 1)]),
    "sheet": stark.mesh.grid(0.2, 0.2, 2),
}
RODS = {
    "stick": stark.mesh.polyline((0, 0, 0), (SIZE, 0, 0), 1),
    "rod": stark.mesh.polyline((-SIZE, 0, 0), (SIZE, 0, 0), 4),
}


def filled(surface: stark.TriangleMesh) -> stark.TetMesh:
    """A convex body of tetrahedra that meet in its middle."""
    n = len(surface.vertices)
    middle = np.full((len(surface.triangles), 1), n)
    vertices = np.vstack([surface.vertices, surface.vertices.mean(axis=0)])
    return stark.mesh.oriented(stark.TetMesh(vertices, np.hstack([middle, surface.triangles])))


@dataclass(frozen=True)
class Part:
    """A body of a case: rigid, soft, cloth or rod as its shape and ``soft`` say."""

    shape: str
    at: Triple = (0.0, 0.0, 0.0)  # [m]
    turns: Turns = ()  # about axes of the world, one after the other
    soft: bool = False
    fixed: bool = False  # sheets at their border, rods at their ends
    velocity: Triple = (0.0, 0.0, 0.0)  # [m/s]

    def add_to(self, scene: stark.Scene, damping: float = 0.0) -> Any:
        """``damping`` [1/s] of soft bodies, cloth and rods."""
        rotation = np.eye(3)
        for axis, angle in self.turns:
            rotation = stark.rotation(axis=axis, angle=angle * stark.deg) @ rotation
        place = {"position": self.at, "velocity": self.velocity, "rotation": rotation}
        if self.shape in RODS:
            rod = RODS[self.shape]
            pins = [0, len(rod.vertices) - 1] if self.fixed else None
            return scene.add_rod(rod, CORD.replace(mass_damping=damping), pins=pins, **place)
        if self.shape in SHEETS:
            sheet = SHEETS[self.shape]
            pins = np.abs(sheet.vertices).max(axis=1) > 0.0999 if self.fixed else None
            return scene.add_cloth(sheet, FABRIC.replace(mass_damping=damping), pins=pins, **place)
        surface = SURFACES[self.shape]
        if self.soft:
            return scene.add_solid(filled(surface), RUBBER.replace(mass_damping=damping), **place)
        motion: dict[str, Any] = {"motion": "fixed"} if self.fixed else {"density": DENSITY}
        return scene.add_rigid(surface, **motion, **place)


DENSITY = 1000.0  # [kg/m^3]
RUBBER = stark.SolidMaterial(density=DENSITY, youngs_modulus=2e5, poissons_ratio=0.3)
FABRIC = stark.ShellMaterial(density=0.5, youngs_modulus=1e5, flexural_rigidity=1e-3)
CORD = stark.RodMaterial(density=DENSITY, youngs_modulus=1e8, radius=1e-3)

UP: Turns = (("y", -90.0),)  # x becomes z
DOWN: Turns = (("y", 90.0),)
QUARTER: Turns = (("z", 90.0),)

# Two free bodies without gravity: the second one, above, comes down at 1 m/s.
Meeting = tuple[Part, Part]
BODIES: dict[str, Meeting] = {
    "vertex_vertex": (Part("peak"), Part("spike")),
    "vertex_edge": (Part("ridge"), Part("spike")),
    "vertex_face": (Part("base"), Part("spike", (0.02, 0.01, 0))),
    "vertex_diagonal": (Part("base"), Part("spike")),
    "vertex_border": (Part("base"), Part("spike", (HALF, 0, 0))),
    "vertex_corner": (Part("base"), Part("spike", (HALF, HALF, 0))),
    "edge_edge": (Part("ridge"), Part("wedge", turns=QUARTER)),
    "edge_edge_parallel": (Part("ridge"), Part("wedge")),
    "edge_edge_nearly_parallel": (Part("ridge"), Part("wedge", turns=(("z", 0.01),))),
    "edge_face": (Part("base"), Part("wedge")),
    "edge_border": (Part("base"), Part("wedge", (HALF, 0, 0))),
    "face_face": (Part("base"), Part("cube")),
    "face_face_turned": (Part("base"), Part("cube", turns=(("z", 45.0),))),
    "face_face_half": (Part("base"), Part("cube", (HALF, 0, 0))),
}
CLOTH: dict[str, Meeting] = {
    "tip_tip": (Part("triangle", turns=DOWN), Part("triangle", turns=UP)),
    "tip_tip_crossed": (Part("triangle", turns=DOWN), Part("triangle", turns=UP + QUARTER)),
    "tip_edge": (Part("triangle", (0, 0, -SIZE), UP), Part("triangle", turns=UP)),
    "tip_edge_crossed": (Part("triangle", (0, 0, -SIZE), UP), Part("triangle", turns=UP + QUARTER)),
    "tip_face": (Part("triangle"), Part("triangle", (0.06, 0.01, 0), UP)),
    "edge_edge": (Part("triangle", (0, 0, -SIZE), UP), Part("triangle", (0, 0, SIZE), DOWN + QUARTER)),
    "edge_edge_collinear": (Part("triangle", (0, 0, -SIZE), UP), Part("triangle", (0, 0, SIZE), DOWN)),
    "edge_face": (Part("triangle"), Part("triangle", (0.06, 0, SIZE), DOWN)),
    "edge_border": (Part("triangle"), Part("triangle", (SIZE, 0, SIZE), DOWN)),
    "face_face": (Part("triangle"), Part("triangle")),
    "face_face_turned": (Part("triangle"), Part("triangle", (SIZE, 0, 0), (("z", 180.0),))),
    "sheet_sheet": (Part("sheet"), Part("sheet")),
}
CORDS: dict[str, Meeting] = {
    "end_end": (Part("stick", turns=DOWN), Part("stick", turns=UP)),
    "end_middle": (Part("stick", (-HALF, 0, 0)), Part("stick", turns=UP)),
    "end_node": (Part("rod"), Part("stick", turns=UP)),
    "crossing": (Part("stick", (-HALF, 0, 0)), Part("stick", (0, -HALF, 0), QUARTER)),
    "crossing_at_nodes": (Part("rod"), Part("rod", turns=QUARTER)),
    "parallel": (Part("stick"), Part("stick")),
    "parallel_nodes": (Part("rod"), Part("rod")),
    "parallel_half": (Part("stick"), Part("stick", (HALF, 0, 0))),
    "parallel_shifted": (Part("stick"), Part("stick", (0, 1e-6, 0))),
    "parallel_beside": (Part("rod"), Part("rod", (0, 3e-4, 0))),
}
CORD_ON_CLOTH: dict[str, Meeting] = {
    "end_tip": (Part("triangle", turns=DOWN), Part("stick", turns=UP)),
    "end_edge": (Part("triangle", (0, 0, -SIZE), UP), Part("stick", turns=UP)),
    "end_face": (Part("triangle"), Part("stick", (0.06, 0.01, 0), UP)),
    "middle_tip": (Part("triangle", turns=DOWN), Part("stick", (-HALF, 0, 0))),
    "node_tip": (Part("triangle", turns=DOWN), Part("rod")),
    "crossing_an_edge": (Part("triangle", (0, 0, -SIZE), UP), Part("stick", (-HALF, 0, 0))),
    "along_an_edge": (Part("triangle", (0, 0, -SIZE), UP), Part("stick", (0, -HALF, 0), QUARTER)),
    "along_a_border": (Part("triangle"), Part("stick", (SIZE, -HALF, 0), QUARTER)),
    "on_a_face": (Part("triangle"), Part("stick")),
    "on_a_sheet": (Part("sheet"), Part("rod")),
    "on_a_diagonal": (Part("sheet"), Part("rod", turns=(("z", 45.0),))),
    "on_the_other_diagonal": (Part("sheet"), Part("rod", turns=(("z", -45.0),))),
}

FLOOR = Part("floor", (0, 0, -0.25), fixed=True)
ON_FLOOR = -0.25 + 2e-3


def on(shape: str, **options: Any) -> Part:
    """Fixed, its top at z = 0."""
    return Part(shape, fixed=True, **options)


def column(count: int, angle: float = 0.0, shift: float = 0.0) -> list[Part]:
    """Cubes on the ground, each turned and shifted against the one below."""
    step = SIZE + 3e-3
    return [Part("cube", (shift * k, 0, ON_FLOOR + k * step), (("z", angle * k),)) for k in range(count)]


# Under gravity, until they lie still. What is named first falls or slides.
RESTS: dict[str, list[Part]] = {
    "one_cube": column(1),
    "two_cubes": column(2),
    "three_cubes": column(3),
    "four_cubes": column(4),
    "five_cubes": column(5),
    "five_cubes_turned": column(5, angle=45.0),
    "five_cubes_leaning": column(5, shift=0.015),
    "bridge": [
        Part("cube", (0.06, 0, ON_FLOOR)),
        Part("cube", (-0.06, 0, ON_FLOOR)),
        Part("cube", (0, 0, ON_FLOOR + SIZE + 3e-3)),
    ],
    # Erleben
    "spike_on_spike": [Part("spike", (1e-3, 0, GAP)), on("peak")],
    "spike_on_wedge": [Part("spike", (1e-3, 0, GAP)), on("ridge")],
    "wedge_on_spike": [Part("wedge", (1e-3, 0, GAP)), on("peak")],
    "wedge_on_wedge": [Part("wedge", (1e-3, 0, GAP)), on("ridge")],
    "wedge_across_wedge": [Part("wedge", (0.01, 0, GAP), QUARTER), on("ridge")],
    "spike_in_hole": [Part("spike", (0.01, 0.005, 0)), on("hole")],
    "spike_in_crack": [Part("spike", (0.01, 0.005, 0)), on("crack")],
    "wedge_in_hole": [Part("wedge", (0.01, 0.005, GAP)), on("hole")],
    "wedge_in_crack": [Part("wedge", (0.01, 0.005, 0)), on("crack")],
    "wedge_across_crack": [Part("wedge", (0.01, 0.005, GAP), QUARTER), on("crack")],
    "cube_on_hole": [Part("cube", (0, 0, GAP)), on("hole")],
    "cube_on_crack": [Part("cube", (0.03, 0, GAP)), on("crack")],
    "cube_on_base": [Part("cube", (0, 0, GAP)), on("base")],
    "cube_past_edge": [Part("cube", (SIZE + 3e-3, 0, 0)), on("base")],
    "cliff_holds": [Part("cube", (0.04, 0, GAP)), on("base")],
    "cliff_falls": [Part("cube", (0.06, 0, GAP)), on("base")],
}
# Where the first body ends on the floor, below what it was put on.
FALLS = {
    "spike_on_spike",
    "spike_on_wedge",
    "wedge_on_spike",
    "wedge_on_wedge",
    "wedge_across_wedge",
    "cube_past_edge",
    "cliff_falls",
}
# Cubes that slide over edges within a plane; no floor besides.
SLIDES = [Part("cube", (-0.25, 0.03, 2e-3), velocity=(1.0, 0.2, 0.0)), on("tiles")]
CLOTH_RESTS: dict[str, list[Part]] = {
    "on_base": [Part("sheet", (0, 0, GAP)), on("base")],
    "on_base_turned": [Part("sheet", (0, 0, GAP), (("z", 45.0),)), on("base")],
    "on_peak": [Part("sheet", (0, 0, GAP)), on("peak")],
    "on_ridge": [Part("sheet", (0, 0, GAP)), on("ridge")],
    "on_hole": [Part("sheet", (0, 0, GAP)), on("hole")],
    "on_crack": [Part("sheet", (0, 0, GAP)), on("crack")],
    "on_sheet": [Part("sheet", (0, 0, GAP)), on("sheet")],
    "on_sheet_half": [Part("sheet", (0.05, 0.05, GAP)), on("sheet")],
    "on_sheet_turned": [Part("sheet", (0, 0, GAP), (("z", 45.0),)), on("sheet")],
    "three_sheets": [Part("sheet", (0, 0, 2 * GAP)), Part("sheet", (0, 0, GAP)), on("sheet")],
    "edge_on_sheet": [Part("sheet", (1e-3, 0, 0.1 + GAP), UP), on("sheet")],
    "corner_on_sheet": [Part("sheet", (1e-3, 0, 0.15), (("z", 45.0), ("y", -90.0))), on("sheet")],
    "cube_on_sheet": [Part("cube", (0, 0, GAP)), on("sheet")],
    "spike_on_sheet": [Part("spike", (1e-3, 0, GAP)), on("sheet")],
    "wedge_on_sheet": [Part("wedge", (1e-3, 0, GAP)), on("sheet")],
}
CORD_RESTS: dict[str, list[Part]] = {
    "on_base": [Part("rod", (0, 0, GAP)), on("base")],
    "on_border": [Part("rod", (HALF, 0, GAP), QUARTER), on("base")],
    "on_peak": [Part("rod", (0, 1e-3, GAP)), on("peak")],
    "along_ridge": [Part("rod", (0, 0, GAP), QUARTER), on("ridge")],
    "across_ridge": [Part("rod", (0, 0, GAP)), on("ridge")],
    "in_hole": [Part("rod", (0.01, 0, 0.1 + GAP), UP), on("hole")],
    "in_crack": [Part("rod", (0.01, 0, -0.05), QUARTER), on("crack")],
    "across_crack": [Part("rod", (0.01, 0, GAP)), on("crack")],
    "across_rod": [Part("rod", (0, 0, GAP), QUARTER), on("rod")],
    "across_rod_askew": [Part("rod", (0.03, 0, GAP), (("z", 60.0),)), on("rod")],
    "three_rods": [Part("rod", (0, 0, 2 * GAP)), Part("rod", (0, 0, GAP), QUARTER), on("rod")],
    "on_sheet": [Part("rod", (0, 0, GAP)), on("sheet")],
    "on_sheet_diagonal": [Part("rod", (0, 0, GAP), (("z", 45.0),)), on("sheet")],
    "on_sheet_border": [Part("rod", (0.1, 0, GAP), QUARTER), on("sheet")],
    "upright_on_sheet": [Part("rod", (1e-3, 0, 0.1 + GAP), UP), on("sheet")],
    "sheet_on_rod": [Part("sheet", (0, 0, GAP)), on("rod")],
    "sheet_on_rod_diagonal": [Part("sheet", (0, 0, GAP), (("z", 45.0),)), on("rod")],
}
