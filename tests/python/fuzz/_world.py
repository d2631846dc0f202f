"""The scene that random calls work on, and the calls: each draws its arguments first and returns what is to
be done, so that it can be done again to another scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from _draw import ODD_NUMBERS, Draw

import stark
from stark import materials, mesh

Call = Callable[["World"], Any]

GRID = mesh.grid(0.2, 0.2, 2)
TETS = mesh.tet_box(0.1, 1)
HEXES = mesh.box_hexahedra(0.1, 1)
CHAIN = np.array([[0.1 * k, 0.0, 0.0] for k in range(4)])


class World:
    """Bodies of all kinds that do not touch, a hinge, a motor and an energy."""

    def __init__(self) -> None:
        self.scene = scene = stark.Scene()
        self.box = scene.add_box(0.1, mass=1.0, name="box", position=(0.0, 0.0, 1.0))
        self.floor = scene.add_floor(10.0)
        self.arm = scene.add_box(0.1, density=100.0, name="arm", position=(0.5, 0.0, 1.0))
        self.lift = scene.add_sphere(
            0.1, subdivisions=1, motion="scripted", name="lift", position=(1.0, 0.0, 1.0)
        )
        self.cloth = scene.add_cloth(GRID, name="cloth", position=(0.0, 1.0, 1.0), pins=[0, 1])
        self.solid = scene.add_solid(TETS, name="solid", position=(0.0, 2.0, 1.0))
        self.rod = scene.add_rod(
            CHAIN, materials.rubber_cord, name="rod", position=(0.0, 3.0, 1.0), clamps=[0]
        )
        self.hinge = scene.add_hinge(None, self.arm, anchor=(0.5, 0.0, 1.0), axis=(0, 1, 0))
        self.motor = self.hinge.add_motor(cap=1.0, delta=0.1)
        self.load = scene.add_force(self.cloth.vertices[[3]], (0.0, 0.0, 0.1))
        self.rest: list[Any] = []  # what calls have added

    @property
    def bodies(self) -> tuple[Any, ...]:
        return (self.box, self.floor, self.arm, self.lift, self.cloth, self.solid, self.rod)

    def body(self, which: int | Any) -> Any:
        """By number; anything else is what it is."""
        return self.bodies[which] if isinstance(which, int) and 0 <= which < len(self.bodies) else which

    def fingerprint(self) -> tuple[Any, ...]:
        """All that the scene shows of itself."""
        s, core = self.scene, self.scene._core
        count = len(s.bodies)
        pairs = [(a, b) for a in range(count) for b in range(a, count)]
        return (
            repr(s),
            [(b.motion, b.color, b.contact_distance) for b in s.bodies],
            [
                (b.pins.tolist(), b.clamped.tolist() if b.kind == "rod" else [])
                for b in s.bodies
                if b.kind != "rigid"
            ],
            [core.pose(i)[0].tolist() for i, b in enumerate(s.bodies) if b.kind == "rigid"],
            [(core.friction(a, b), core.contact_enabled(a, b)) for a, b in pairs],
            [repr(x) for x in (*s.joints, *s.actuators, *s.attachments, *s.energies, *s.layers)],
            [a.parameters for a in s.actuators],
            s.default_friction,
            {body: len(followers) for body, followers in s._followers.items()},
        )


def _which(draw: Draw, *good: int) -> Any:
    """A body by number, or something that is none."""
    return draw.value(
        draw.pick(good or (0, 1, 2, 3, 4, 5, 6)), ("nobody", 99, None, 1.5, "cloth", [], ODD_NUMBERS)
    )


def _options(draw: Draw, **makers: Callable[[], Any]) -> dict[str, Any]:
    """Some of the keywords with a value: one byte says which."""
    chosen = draw.byte()
    return {name: make() for k, (name, make) in enumerate(makers.items()) if (chosen >> (k % 8)) & 1}


def _placing(draw: Draw) -> dict[str, Any]:
    return {
        "position": draw.vector(2.0 + draw.byte() / 10.0, 5.0, 2.0),
        **_options(
            draw,
            name=lambda: draw.text(None, "a", "b"),
            rotation=lambda: draw.array(np.eye(3)) if draw.byte() % 2 else draw.array([1.0, 0.0, 0.0, 0.0]),
            velocity=lambda: draw.vector(0.1, 0.0, 0.0),
            angular_velocity=lambda: draw.vector(0.0, 0.1, 0.0),
            contact_distance=lambda: draw.value(0.001),
            friction=lambda: draw.value(0.3),
            color=lambda: draw.vector(0.1, 0.2, 0.3),
        ),
    }


def _soft(draw: Draw, vertices: Any) -> dict[str, Any]:
    return _options(
        draw,
        mass=lambda: draw.value(0.1),
        pins=lambda: (
            draw.array(np.array([0, 1])) if draw.byte() % 2 else draw.array(np.zeros(len(vertices), bool))
        ),
        self_contact=lambda: draw.value(False),
        initial_positions=lambda: draw.array(vertices),
    )


def add_cloth(draw: Draw) -> Call:
    vertices, triangles = draw.array(GRID.vertices), draw.array(GRID.triangles)
    material = draw.value(materials.cotton, (materials.steel, None, "cotton", 1.0))
    more = _placing(draw) | _soft(draw, GRID.vertices)
    more |= _options(draw, rest_angles=lambda: draw.text("flat", "mesh"))
    return lambda w: w.scene.add_cloth((vertices, triangles), material, **more)


def add_solid(draw: Draw) -> Call:
    source = TETS if draw.byte() % 2 == 0 else HEXES
    elements = draw.array(source.tets if source is TETS else source.elements)
    vertices = draw.array(source.vertices)
    material = draw.value(materials.soft_rubber, (materials.cotton, None, "steel"))
    more = _placing(draw) | _soft(draw, source.vertices)
    shape = draw.value("pair", ("surface", "text", "number"))
    given = {"surface": GRID, "text": "a.obj", "number": 3}

    def call(w: World) -> Any:
        if shape != "pair":
            return w.scene.add_solid(given.get(shape, shape), material, **more)
        whole = (vertices, elements) if source is TETS else stark.SolidMesh(vertices, elements)
        return w.scene.add_solid(whole, material, **more)

    return call


def add_rod(draw: Draw) -> Call:
    points = draw.array(CHAIN)
    material = draw.value(materials.rubber_cord, (materials.cotton, None))
    more = _placing(draw) | _soft(draw, CHAIN)
    more |= _options(
        draw,
        rest_shape=lambda: draw.text("mesh", "straight"),
        normal=lambda: draw.vector(0.0, 1.0, 0.0),
        clamps=lambda: draw.array(np.array([0, 3])),
    )
    return lambda w: w.scene.add_rod(points, material, **more)


def add_rigid(draw: Draw) -> Call:
    box = mesh.box(0.1)
    vertices, triangles = draw.array(box.vertices), draw.array(box.triangles)
    more = _placing(draw) | {"mass": draw.value(1.0)}
    more |= _options(
        draw,
        density=lambda: draw.value(100.0),
        inertia=lambda: draw.value(
            (1.0, (0.0, 0.0, 0.0), np.eye(3)), ((1.0,), (1.0, 2.0, 3.0), "x", (1.0, (0, 0, 0), -np.eye(3)))
        ),
        motion=lambda: draw.text("dynamic", "fixed", "scripted"),
        linear_damping=lambda: draw.value(0.1),
        angular_damping=lambda: draw.value(0.1),
    )
    return lambda w: w.scene.add_rigid((vertices, triangles), **more)


def add_shape(draw: Draw) -> Call:
    kind = draw.pick(("box", "sphere", "cylinder", "capsule", "floor"))
    sizes = [draw.value(0.1), draw.value(0.2)][: 2 if kind in ("cylinder", "capsule") else 1]
    more = _placing(draw) | ({} if kind == "floor" else {"mass": draw.value(1.0)})
    if kind == "floor":
        more.pop("position")
        more["height"] = draw.value(-0.5)
    else:
        more |= {"segments" if "c" in kind else "subdivisions": draw.count(8 if "c" in kind else 1)}
    return lambda w: getattr(w.scene, f"add_{kind}")(*sizes, **more)


def add_joint(draw: Draw) -> Call:
    kinds = (
        "fixed",
        "ball",
        "hinge",
        "slider",
        "cylindrical",
        "planar",
        "point_on_axis",
        "universal",
        "distance",
        "span",
        "tilt",
        "spring",
    )
    kind, sides = draw.pick(kinds), [_which(draw, 0, 2), _which(draw, 3, 0, 2)]
    frames = draw.byte() % 4
    anchor, axis = draw.vector(0.3, 0.0, 1.0), draw.vector(0.0, 0.0, 1.0)
    more: dict[str, Any] = {"contact": draw.value(False)} | _options(draw, name=lambda: draw.text(None, "j"))
    if kind in ("hinge", "slider"):
        more |= _options(
            draw,
            limits=lambda: draw.value(
                (-1.0, 1.0), ((1.0, -1.0), (0.0,), (np.nan, 1.0), (0, np.inf), "ab", ("a", "b"), 3)
            ),
        )
    if kind == "spring":
        more |= {"stiffness": draw.value(10.0)} | _options(
            draw, damping=lambda: draw.value(0.1), rest_length=lambda: draw.value(0.2)
        )
    if kind == "tilt":
        more |= _options(draw, limit=lambda: draw.value(0.5))
    if kind == "distance":
        more |= _options(draw, length=lambda: draw.value(0.5))
    axes = {"universal": {"axis_a": axis, "axis_b": draw.vector(1.0, 0.0, 0.0)}, "planar": {"normal": axis}}
    corners, node = draw.array(np.array([0, 1, 4])), draw.value(2)

    def call(w: World) -> Any:
        a, b = (w.body(side) for side in sides)
        if frames == 1:
            b = w.cloth.frame(corners)
        if frames == 2:
            b = w.rod.frame(node)
        method = getattr(w.scene, f"add_{kind}")
        if kind in ("distance", "span", "spring"):
            return method(a, b, anchor, axis, **more)
        if kind in ("fixed", "ball"):
            return method(a, b, anchor, **more)
        return method(a, b, anchor, **axes.get(kind, {"axis": axis}), **more)

    return call


def add_actuator(draw: Draw) -> Call:
    x = [draw.value(v) for v in (1.0, 0.1, 0.5, 0.2)]
    kind = draw.pick(("motor", "servo", "effort", "spring", "friction", "armature", "limit", "gear", "any"))
    more = _options(
        draw,
        name=lambda: draw.text(None, "m"),
        coordinate=lambda: draw.text("angle"),
        enabled=lambda: draw.value(False),
    )
    named = draw.text("velocity_motor")
    calls: dict[str, Call] = {
        "motor": lambda w: w.hinge.add_motor(x[0], cap=x[1], delta=x[2], **more),
        "servo": lambda w: w.hinge.add_servo(x[0], stiffness=x[1], damping=x[2], cap=x[3], **more),
        "effort": lambda w: w.hinge.add_effort(x[0], **more),
        "spring": lambda w: w.hinge.add_spring(x[0], damping=x[1], rest=x[2], **more),
        "friction": lambda w: w.hinge.add_friction(x[0], stick_rate=x[1], viscous=x[2], **more),
        "armature": lambda w: w.hinge.add_armature(x[0], **more),
        "limit": lambda w: w.hinge.add_limit(x[1], x[0], **more),
        "gear": lambda w: w.hinge.add_gear(w.hinge if x[1] == 0.1 else x[1], x[0], offset=x[2], **more),
        "any": lambda w: w.scene.add_actuator(
            named, w.hinge if x[0] == 1.0 else x[0], target=x[1], cap=x[2], delta=x[3]
        ),
    }
    return calls[kind]


def attach(draw: Draw) -> Call:
    vertices, kind = draw.array(np.array([3, 4])), draw.integer(5)
    side = _which(draw, 3, 0, 5)
    more = _options(
        draw,
        distance=lambda: draw.value(3.0),
        pairs=lambda: draw.array(np.array([[3, 0], [4, 1]])),
        break_force=lambda: draw.value(10.0),
        contact=lambda: draw.value(False),
        enabled=lambda: draw.value(False),
        name=lambda: draw.text(None, "glue"),
    )

    def call(w: World) -> Any:
        a = {0: w.cloth, 1: w.solid, 2: w.body(side)}.get(kind) or w.cloth.vertices[vertices]
        return w.scene.attach(a, None if kind == 4 else w.body(side), **more)

    return call


def add_load(draw: Draw) -> Call:
    kind, value, three = draw.integer(6), draw.value(1.0), draw.vector(0.0, 0.0, 1.0)
    side, vertices = _which(draw, 0, 5), draw.array(np.array([1, 2]))
    more = _options(draw, name=lambda: draw.text(None, "load"))
    calls: tuple[Call, ...] = (
        lambda w: w.scene.add_pressure(w.body(side), value, **more),
        lambda w: w.scene.add_force(w.body(side), three, **more),
        lambda w: w.scene.add_force(w.cloth.vertices[vertices], three, **more),
        lambda w: w.scene.add_torque(w.body(side), three, **more),
        lambda w: w.scene.add_face_pressure(w.body(side), value, **more),
        lambda w: w.scene.add_traction(w.body(side), three, **more),
    )
    return calls[kind]


@stark.energy
def _pull(e: stark.Edge, stiffness: float = stark.parameter(1.0, unit="N/m", above=0.0)) -> Any:
    return 0.5 * stiffness * (e.length - 0.05) ** 2


def add_energy(draw: Draw) -> Call:
    stiffness, pairs = draw.value(2.0), draw.array(np.array([[0, 1], [1, 2]]))
    what = draw.value("energy", ("nothing", 3, None))
    more = _options(draw, name=lambda: draw.text(None, "pull"))

    def call(w: World) -> Any:
        if what != "energy":
            return w.scene.add(what)
        return w.scene.add(_pull(stark.stencils(w.cloth, pairs), stiffness=stiffness), **more)

    return call


def add_layer(draw: Draw) -> Call:
    triangles, edges = draw.array(np.array([[0, 1, 3]])), draw.array(np.array([[0, 1], [1, 2]]))
    kind, mass = draw.integer(3), draw.value(None)
    material = draw.value(materials.pet, (materials.steel, None))
    wire = draw.value(materials.rubber_cord, (materials.steel, None))
    more = _options(draw, name=lambda: draw.text(None, "layer"), color=lambda: draw.vector(0.1, 0.2, 0.3))
    rest = draw.text("mesh")
    calls: tuple[Call, ...] = (
        lambda w: w.solid.add_skin(material, triangles, mass=mass, rest_angles=rest, **more),
        lambda w: w.cloth.add_fibres(wire, edges, mass=mass, rest_shape=rest, **more),
        lambda w: w.cloth.add_fibres(wire, paths=edges, mass=mass, bending=False, **more),
    )
    return calls[kind]


def pair(draw: Draw) -> Call:
    a, b, kind, value = _which(draw), _which(draw), draw.integer(4), draw.value(0.4)
    two = draw.value((0.5, 0.4), ((0.4, 0.5), (1.0,), (1, 2, 3), (np.nan, 0), "ab", None))

    def put(w: World) -> None:
        w.scene.friction[w.body(a), w.body(b)] = value if kind == 0 else two

    def default(w: World) -> None:
        w.scene.default_friction = value

    calls: tuple[Call, ...] = (
        put,
        lambda w: w.scene.disable_contact(w.body(a), w.body(b)),
        lambda w: w.scene.enable_contact(w.body(a), w.body(b)),
        default,
    )
    return put if kind == 3 and draw.byte() % 2 else calls[kind]


def pin(draw: Draw) -> Call:
    vertices, kind = draw.array(np.array([2, 3])), draw.integer(4)
    good = 0.1
    motion, three = draw.value(good), draw.vector(0.0, 0.0, 0.1)
    targets = draw.array(np.zeros((2, 3)))
    calls: tuple[Call, ...] = (
        lambda w: w.cloth.pin(vertices),
        lambda w: w.rod.clamp(vertices),
        lambda w: w.cloth.follow(targets if motion is good else motion),
        lambda w: w.lift.follow(three),
    )
    return calls[kind]


def place(draw: Draw) -> Call:
    """Assignments to bodies and actuators before there is a simulation."""
    kind, three, value, axes = (
        draw.integer(7),
        draw.vector(1.0, 0.0, 1.0),
        draw.value(0.3),
        draw.array(np.eye(3)),
    )
    which = draw.pick((3, 0, 1, 4))
    names = ("position", "rotation", "pose", "velocity", "angular_velocity", "target", "enabled")
    values = (three, axes, (three, axes), three, three, value, draw.value(False))
    name = names[kind]

    def put(w: World) -> None:
        target = w.motor if name in ("target", "enabled") else w.bodies[which]
        if hasattr(type(target), name) or name == "target":
            setattr(target, name, values[kind])

    return put


#: Calls by name.
CALLS: dict[str, Callable[[Draw], Call]] = {
    call.__name__: call
    for call in (
        add_cloth, add_solid, add_rod, add_rigid, add_shape, add_joint, add_actuator, attach, add_load,
        add_energy, add_layer, pair, pin, place,
    )
}  # fmt: skip
