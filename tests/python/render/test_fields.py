"""Fields against what is known of simple cases: a hanging bar, a block that rests, a wheel that turns."""

from __future__ import annotations

import numpy as np
import pytest

import stark
from stark.render import field_values
from stark.render.fields import FIELDS, field_of, von_mises

G = 9.81


def at_rest(scene: stark.Scene, steps: int = 12, time_step: float = 0.5) -> stark.Simulation:
    """After long implicit steps, which damp."""
    sim = stark.Simulation(scene, time_step=time_step)
    for _ in range(steps):
        assert not sim.step().failed
    return sim


@pytest.mark.parametrize("kind", ["tetrahedra", "quadratic", "hexahedra"])
def test_stress_of_a_hanging_bar_is_the_weight_below(kind: str) -> None:
    """rho g times the length below: without contraction across (nu = 0) the stress is uniaxial everywhere."""
    length, rho, E = 0.4, 1000.0, 1e6
    mesh = stark.mesh.tet_box((0.1, 0.1, length), (2, 2, 8))
    if kind == "quadratic":
        mesh = stark.mesh.to_quadratic(mesh)
    if kind == "hexahedra":
        mesh = stark.mesh.box_hexahedra((0.1, 0.1, length), (2, 2, 8))
    scene = stark.Scene()
    rubber = stark.SolidMaterial(youngs_modulus=E, poissons_ratio=0.0, density=rho, strain_limit=np.inf)
    z = mesh.vertices[:, 2]
    scene.add_solid(mesh, rubber, name="bar", pins=np.flatnonzero(z > z.max() - 1e-9))
    sim = at_rest(scene)
    stress, below = field_values(sim, "stress")["bar"], z - z.min()
    inner = (below > 0.05) & (below < length - 0.05)
    assert inner.sum() > 20
    # Strains are 0.4 %. Quadratic tetrahedra have lumped weights, which are off within a layer of 5 cm.
    layer = rho * G * 0.05 if kind == "quadratic" else 0.0
    assert stress[inner] == pytest.approx(rho * G * below[inner], rel=0.02, abs=0.2 * layer)
    assert np.polyfit(below[inner], stress[inner], 1)[0] == pytest.approx(rho * G, rel=0.01)
    assert stress.max() < 1.05 * rho * G * length
    strain = field_values(sim, "strain")["bar"]
    assert strain[inner] == pytest.approx(rho * G * below[inner] / E, rel=0.02, abs=0.2 * layer / E)


def test_stress_and_strain_of_a_hanging_rod() -> None:
    length, points = 2.0, 21
    scene = stark.Scene()
    cord = stark.materials.rubber_cord.replace(mass_damping=0.0)
    scene.add_rod(np.linspace((0, 0, 0), (0, 0, -length), points), cord, name="cord", pins=[0])
    sim = at_rest(scene)
    stress, below = field_values(sim, "stress")["cord"], length - np.linspace(0.0, length, points)
    assert stress[1:-1] == pytest.approx(cord.density * G * below[1:-1], rel=0.01)
    strain = field_values(sim, "strain")["cord"]
    assert strain[1:-1] == pytest.approx(cord.density * G * below[1:-1] / cord.youngs_modulus, rel=0.01)


STATIC = {"time.integrator": "quasistatic", "contact.enabled": False}


def add_held_bar(scene: stark.Scene, kind: str):
    """A bar of 1 MPa between two walls, a sheet in a frame; "free": nothing holds it."""
    shape, E, alpha = (0.1, 0.02, 0.02), 1e6, 1e-4
    rubber = stark.SolidMaterial(
        youngs_modulus=E, poissons_ratio=0.0, density=1000.0, thermal_expansion=alpha, strain_limit=np.inf
    )
    if kind == "cloth":
        sheet = stark.mesh.grid(0.1, 0.02, cells=(5, 1))
        material = stark.ShellMaterial(
            density=0.1, thickness=1e-3, youngs_modulus=E, poissons_ratio=0.0, thermal_expansion=alpha
        )
        return scene.add_cloth(sheet, material, pins=range(len(sheet.vertices)), name="bar")
    if kind == "rod":
        cord = stark.RodMaterial(density=1000.0, youngs_modulus=E, radius=5e-3, thermal_expansion=alpha)
        return scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.1, 0, 0), 5), cord, clamps=[0, 5], name="bar")
    if kind == "lattice":
        mesh = stark.mesh.lattice(stark.mesh.box(shape), cells=5)
        count = mesh.node_count
    else:
        mesh = stark.mesh.box_hexahedra(shape, (5, 1, 1))
        count = len(mesh.vertices)
    ends = np.flatnonzero(np.abs(mesh.vertices[:count, 0]) > 0.0499)
    return scene.add_solid(mesh, rubber, pins=() if kind == "free" else ends, name="bar")


def with_rest_state(kind: str, **rest: object) -> tuple[stark.Simulation, np.ndarray]:
    """Of a bar with this rest state: stresses."""
    scene = stark.Scene()
    body = add_held_bar(scene, kind)
    for name, value in rest.items():
        setattr(body, name, value)
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    assert not sim.step().failed
    return sim, field_values(sim, "stress")["bar"]


@pytest.mark.parametrize("kind", ["solid", "lattice", "cloth", "rod"])
def test_what_is_held_while_it_shrinks_has_stress(kind: str) -> None:
    """E times what it would shrink by, of which the shape shows nothing."""
    shrunk = np.diag([1.0 - 1e-3, 1.0, 1.0])
    rest = {"growth": shrunk} if kind in ("solid", "lattice") else {"temperature": -10.0}
    sim, stress = with_rest_state(kind, **rest)
    assert stress == pytest.approx(np.full(len(stress), 1e6 * 1e-3), rel=5e-3)
    assert field_values(sim, "strain")["bar"].max() < 2e-3


@pytest.mark.parametrize(("order", "cell"), [(1, 0.033), (2, 0.1)])
def test_stress_of_a_bent_lattice_is_that_of_a_beam_also_at_nodes_beyond_its_surface(
    order: int, cell: float
) -> None:
    """Those had the polynomials of cells that are cut, up to three times the largest stress of the beam."""
    length, width, g = 1.0, 0.1, 0.02
    turned = stark.mesh.box((length, width, width)).rotated(stark.rotation(axis="x", angle=0.4))
    mesh = stark.mesh.lattice(turned, cell_size=cell, order=order)
    scene = stark.Scene()
    held = np.flatnonzero(mesh.vertices[: mesh.node_count, 0] < -0.4999 * length)
    rubber = stark.SolidMaterial(youngs_modulus=1e6, poissons_ratio=1e-6, density=1000.0)
    beam = scene.add_solid(mesh, rubber, pins=held, name="beam")
    sim = stark.Simulation(scene, gravity=(0.0, 0.0, -g), **STATIC)
    assert not sim.step().failed
    stress, x = field_values(sim, "stress")["beam"], beam.mesh.vertices
    beyond = np.clip(0.5 * length - x[:, 0], 0.0, length)
    exact = 1000.0 * g * width**2 * beyond**2 / 2 * np.abs(x[:, 2]) / (width**4 / 12)
    shown = (np.arange(len(x)) >= mesh.node_count) & (np.abs(x[:, 0]) < 0.3)
    off = (stress[shown] - exact[shown]) / exact[shown].max()
    assert np.sqrt((off**2).mean()) < 0.02 and np.abs(off).max() < 0.1  # single vertices are in slivers
    middle = np.abs(x[:, 0]) < 0.3
    assert stress[middle].max() < 1.1 * exact[shown].max()


def squashed_ball(mesh: stark.mesh.Mesh) -> tuple[np.ndarray, float]:
    """Von Mises stresses of the surface [Pa] where a ball of 0.12 m that fell on a floor is flattest, and the
    elastic energy [J]."""
    scene = stark.Scene()
    scene.add_floor(1.0)
    soft = stark.SolidMaterial(density=1000.0, youngs_modulus=1e4, poissons_ratio=0.3)
    ball = scene.add_solid(mesh, soft, position=(0.0, 0.0, 0.07), name="ball")
    sim = stark.Simulation(scene, time_step=0.01)
    for _ in range(10):
        report = sim.step()
        assert not report.failed
    surface = np.unique(ball.triangles)
    return field_values(sim, "stress")["ball"][surface], report.energy["elastic"]


def test_stress_of_a_squashed_lattice_is_that_of_its_material() -> None:
    """Cells that are cut are turned inside out beyond the surface here, where the law has stresses of 24 GPa
    in a material of 10 kPa: of these the surface had a part, up to 13 MPa."""
    surface = stark.mesh.sphere(0.06, 2)
    cube = stark.mesh.box_hexahedra(2.0, 8)
    a, b, c = np.square(cube.vertices).T
    edges = (b / 2 + c / 2 - b * c / 3, c / 2 + a / 2 - c * a / 3, a / 2 + b / 2 - a * b / 3)
    round_cube = 0.06 * cube.vertices * np.sqrt(1.0 - np.column_stack(edges))
    reference, energy = squashed_ball(stark.mesh.SolidMesh(round_cube, cube.elements))
    for order, cells in ((1, 8), (2, 4)):
        stress, stored = squashed_ball(stark.mesh.lattice(surface, cells=cells, order=order))
        assert stored == pytest.approx(energy, rel=0.02)
        assert np.median(stress) == pytest.approx(np.median(reference), rel=0.2)
        assert 0.4 * reference.max() < stress.max() < reference.max()  # which has flat corners of elements


def test_what_grows_freely_has_strain_and_no_stress() -> None:
    sim, stress = with_rest_state("free", growth=np.diag([1.2, 1.0, 0.9]))
    assert stress.max() < 1e-2
    assert field_values(sim, "strain")["bar"] == pytest.approx(np.full(len(stress), 0.2), abs=1e-6)


@pytest.mark.parametrize("kind", ["solid", "cloth", "rod"])
def test_a_muscle_that_is_held_has_its_active_stress(kind: str) -> None:
    rest: dict[str, object] = {"fiber_direction": (2.0, 0.0, 0.0), "active_stress": 1e4}
    if kind == "rod":
        rest = {"active_force": 1e4 * np.pi * 25e-6}
    _, stress = with_rest_state(kind, **rest)
    assert stress == pytest.approx(np.full(len(stress), 1e4), rel=1e-6)


@pytest.mark.parametrize("kind", ["metal", "foil", "foam"])
def test_a_muscle_of_what_remembers_has_its_active_stress_once(kind: str) -> None:
    """Such stresses come from the forces of elements, which have the active part already."""
    scene = stark.Scene()
    sheet, block = (
        stark.mesh.grid(0.1, 0.02, cells=(5, 1)),
        stark.mesh.box_hexahedra((0.1, 0.02, 0.02), (5, 1, 1)),
    )
    if kind == "foil":
        foil = stark.ShellMaterial(density=0.1, thickness=1e-3, youngs_modulus=1e6, yield_stress=1e5)
        body = scene.add_cloth(sheet, foil, pins=range(len(sheet.vertices)))
    else:
        metal = stark.j2_plasticity(shear_modulus=4e5, bulk_modulus=1e6, yield_stress=1e5, density=1000.0)
        foam = stark.generalized_maxwell(
            shear_modulus=4e5, bulk_modulus=1e6, moduli=[1e5], times=[0.1], density=1000.0
        )
        body = scene.add_solid(block, metal if kind == "metal" else foam, pins=range(len(block.vertices)))
    body.fiber_direction, body.active_stress = (1.0, 0.0, 0.0), 1e4
    sim = stark.Simulation(scene, gravity=(0, 0, 0), **STATIC)
    assert not sim.step().failed
    assert field_values(sim, "stress")[body.name] == pytest.approx(
        np.full(len(body.positions), 1e4), rel=1e-6
    )


def test_rods_that_yield_have_no_stress_of_elastic_ones() -> None:
    scene = stark.Scene()
    wire = stark.materials.steel_wire.replace(yield_stress=1e9)
    scene.add_rod(stark.mesh.polyline((0, 0, 0), (0.1, 0, 0), 5), wire, name="wire")
    with pytest.raises(stark.InvalidArgument, match="known of elastic rods"):
        field_values(stark.Simulation(scene), "stress")


def test_stress_of_a_large_stretch_is_that_of_the_deformed_area() -> None:
    """F = diag(1, 1, s) of St. Venant and Kirchhoff: the second Piola-Kirchhoff stress is linear in
    e = (s^2 - 1)/2, Cauchy's is F S F^T / s."""
    E, nu, s = 1e4, 0.3, 1.5
    mu, la, e = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu)), 0.5 * (s**2 - 1)
    along, across = s * (la + 2 * mu) * e, la * e / s
    mesh = stark.mesh.tet_box((0.1, 0.1, 0.1), (1, 1, 1))
    material = stark.materials.st_venant_kirchhoff(youngs_modulus=E, poissons_ratio=nu, density=1000.0)
    scene = stark.Scene()
    scene.add_solid(mesh, material, name="cube", initial_positions=mesh.vertices * (1, 1, s))
    values = field_values(stark.Simulation(scene), "stress")["cube"]
    assert values == pytest.approx(np.full(len(mesh.vertices), along - across))


def test_cloth_that_is_stretched_by_a_tenth() -> None:
    """Uniaxial strain of a membrane without lateral strain: sigma_x = E/(1 - nu^2) eps, sigma_y = nu sigma_x
    for small ones."""
    mesh, eps = stark.mesh.grid(0.2, 0.2, cells=4), 1e-3
    sheet = stark.ShellMaterial(youngs_modulus=1e5, poissons_ratio=0.3, thickness=1e-3, density=0.2)
    scene = stark.Scene()
    x = mesh.vertices @ np.diag([1.0 + eps, 1.0, 1.0]) @ stark.rotation(axis=(1, 1, 0), angle=0.5).T
    scene.add_cloth(mesh, sheet, name="sheet", initial_positions=x, pins=np.arange(len(x)))
    sim = stark.Simulation(scene)
    sigma = 1e5 / (1.0 - 0.09) * eps
    expected = sigma * np.sqrt(1.0 - 0.3 + 0.09)
    assert field_values(sim, "stress")["sheet"] == pytest.approx(np.full(len(x), expected), rel=5e-3)
    assert field_values(sim, "strain")["sheet"] == pytest.approx(np.full(len(x), eps), rel=1e-6)


def test_pressure_sums_to_the_weight() -> None:
    scene = stark.Scene()
    mesh = stark.mesh.tet_box((0.2, 0.2, 0.1), (6, 6, 3))
    scene.add_box((1.0, 1.0, 0.1), name="table", motion="fixed", position=(0, 0, -0.05))
    rubber = stark.SolidMaterial(youngs_modulus=2e5, poissons_ratio=0.3, density=1000.0)
    lift = 0.0015 - mesh.vertices[:, 2].min()
    scene.add_solid(mesh, rubber, name="block", position=(0, 0, lift))
    sim = at_rest(scene, 20, 0.1)
    weight = 1000.0 * 0.2 * 0.2 * 0.1 * G
    block = sim["block"]
    pressure = field_values(sim, "pressure")["block"]
    x = block.positions[block.triangles]
    bottom = (mesh.vertices[block.triangles][..., 2] < mesh.vertices[:, 2].min() + 1e-9).all(axis=1)
    areas = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    total = (pressure[block.triangles].mean(axis=1) * areas)[bottom].sum()
    assert total == pytest.approx(weight, rel=0.01)
    assert pressure[mesh.vertices[:, 2] > mesh.vertices[:, 2].min() + 1e-3].max() == 0.0
    forces = field_values(sim, "contact_force")["block"]
    assert forces.sum() == pytest.approx(weight, rel=0.02)  # all upwards, friction is small
    assert set(field_of(sim, "pressure").values) == {"block"}  # the table is fixed
    assert set(field_values(sim, "pressure")) == {"block", "table"}


def test_speeds_of_a_wheel_and_of_a_scripted_one() -> None:
    scene = stark.Scene()
    for name, motion in (("free", "dynamic"), ("driven", "scripted")):
        extra = {"mass": 1.0} if motion == "dynamic" else {}
        mesh = stark.mesh.box((0.2, 0.2, 0.02)).translated(
            (0.3, 0, 0)
        )  # the origin is not the centre of mass
        scene.add_rigid(mesh, name=name, motion=motion, position=(0, 2.0 * (name == "free"), 0), **extra)
    sim = stark.Simulation(scene, time_step=1e-4)
    sim["free"].velocity, sim["free"].angular_velocity = (1, 0, 0), (0, 0, 5)
    sim["driven"].velocity, sim["driven"].angular_velocity = (0, 0, 2), (0, 0, 5)
    sim.step()
    speed = field_values(sim, "speed")
    corners = sim["free"].mesh.vertices - (0.3, 0, 0)
    expected = np.linalg.norm(np.cross((0, 0, 5), corners) + np.eye(3)[0], axis=1)
    assert speed["free"] == pytest.approx(expected, rel=2e-3)  # falls for 0.1 ms
    expected = np.hypot(2.0, 5.0 * np.linalg.norm(sim["driven"].mesh.vertices[:, :2], axis=1))
    assert speed["driven"] == pytest.approx(expected, rel=1e-3)


def test_speeds_are_those_of_differences() -> None:
    scene = stark.Scene()
    scene.add_solid(stark.mesh.tet_box((0.1, 0.1, 0.1), (1, 1, 1)), name="soft", angular_velocity=(0, 3, 1))
    scene.add_rigid(stark.mesh.sphere(0.1), name="ball", mass=1.0, position=(1, 0, 0), velocity=(0, 1, 0))
    scene.add_rod([(0, 1, 0), (0.1, 1, 0), (0.2, 1, 0)], name="rod")
    sim = stark.Simulation(scene, time_step=1e-5)
    sim.step()
    before = {body.name: body.positions for body in sim.bodies}
    sim.step()
    for name, speed in field_values(sim, "speed").items():
        moved = np.linalg.norm(sim[name].positions - before[name], axis=1) / 1e-5
        assert speed == pytest.approx(moved, rel=1e-3, abs=1e-6), name


def test_von_mises() -> None:
    assert von_mises(np.diag([7.0, 0.0, 0.0])) == pytest.approx(7.0)
    assert von_mises(np.diag([7.0, 7.0, 7.0])) == pytest.approx(0.0)
    shear = np.zeros((2, 3, 3))
    shear[:, 0, 1] = shear[:, 1, 0] = 2.0
    assert von_mises(shear) == pytest.approx(2.0 * np.sqrt([3.0, 3.0]))


@pytest.fixture(scope="module")
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), name="cloth")
    scene.add_rigid(stark.mesh.box(0.1), name="box", mass=1.0, position=(0, 0, 1))
    scene.add_rod([(1, 0, 0), (1, 0.1, 0)], name="rod")
    return stark.Simulation(scene)


def test_which_bodies_have_which_fields(sim) -> None:
    assert {name: set(field_of(sim, name).values) for name in ("stress", "strain", "pressure", "speed")} == {
        "stress": {"cloth", "rod"},
        "strain": {"cloth", "rod"},
        "pressure": {"cloth", "box"},
        "speed": {"cloth", "box", "rod"},
    }
    shown = field_of(sim, {"cloth": "stress"})
    assert set(shown.values) == {"cloth"} and (shown.label, shown.unit) == ("von Mises stress", "Pa")
    own = field_of(sim, {"*o*": "speed", sim["box"]: np.arange(8.0)})
    assert set(own.values) == {"cloth", "box", "rod"} and own.values["box"][7] == 7.0
    assert set(FIELDS) >= {"stress", "strain", "pressure", "contact_force", "speed"}


def test_bodies_that_are_not_shown_are_not_asked() -> None:
    """Nor is the stress of their laws, which may not be known."""
    scene, mesh = stark.Scene(), stark.mesh.tet_box((0.1, 0.1, 0.1), (1, 1, 1))
    wire = stark.materials.steel_wire.replace(yield_stress=1e9)
    scene.add_rod(np.linspace((0, 0, 0), (0.1, 0, 0), 3), wire, name="own")
    scene.add_solid(mesh, name="known", position=(1, 0, 0))
    sim = stark.Simulation(scene)
    with pytest.raises(stark.InvalidArgument, match=r"'own': stress: is known of elastic rods"):
        sim.picture(field="stress", size=(16, 16), quality="draft")
    sim.picture(field="stress", hide="own", size=(16, 16), quality="draft")
    assert set(field_of(sim, {"known": "stress"}).values) == {"known"}


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (
            "stres",
            "field 'stres' is unknown; choose one of stress, strain, plastic_strain, pressure, contact_force",
        ),
        (3, "field = 3: must be one of stress"),
        ({"cup": [1.0]}, "field: body = 'cup': no body has such a name"),
        ({"cloth": [1.0]}, r"field of 'cloth' has the shape \(1,\): must be \(9,\), a value for each vertex"),
        ({"cloth": np.full(9, np.nan)}, "field of 'cloth': value 0 is nan: must be finite"),
        ({"cloth": "warm"}, "field 'warm' is unknown"),
        ({"cloth": "speed", "box": "pressure"}, "must name one field"),
        ({"cloth": ["a"] * 9}, "field of 'cloth' = .*must be of real numbers"),
    ],
)
def test_fields_that_are_none(sim, field, message: str) -> None:
    with pytest.raises(stark.InvalidArgument, match=message):
        field_of(sim, field)
