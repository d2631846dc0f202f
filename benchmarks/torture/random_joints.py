"""Bodies on joints and attachments that are released, held again and break, with motors and servos beyond any
cap, that press arms and fingers against what is in their way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stark

from .case import Setup
from .random_scenes import Description, Source
from .random_world import (
    add_thing,
    distance_of,
    draw_thing,
    draw_world,
    rotation_of,
    setup_of,
    shape_of,
    unit,
)

Floats = NDArray[np.float64]

KINDS = ("chain", "gripper", "arm", "glued", "glued")
JOINTS = ("hinge", "ball", "slider", "fixed", "cylindrical", "universal", "distance")
_TURNS = ("hinge", "cylindrical")
#: For which a step may fail: forces and torques without bound against what cannot give way.
_CAUSES = ("crushing_load", "overload", "blocked_motion")


def draw_joints(source: Source) -> Description:
    kind = KINDS[source.whole(0, len(KINDS) - 1)]
    return {
        **draw_world(source),
        "kind": kind,
        "links": [
            {
                **draw_thing(source, ("box", "box", "sphere") if kind == "chain" else ("box",)),
                "joint": JOINTS[source.whole(0, len(JOINTS) - 1)],
                "axis": [source.number(-1.0, 1.0) for _ in range(3)],
                "gap": source.number(-1.0, 1.0),  # over the range of contact
                "contact": bool(source.whole(0, 1)),
                "drive": ("nothing", "motor", "motor", "servo", "effort")[source.whole(0, 4)],
                "cap": source.number(-3.0, 9.0),  # [N, N m]
                "target": source.number(-2.0, 2.0),  # [m/s, rad/s] up to a third of a turn in a step
                "velocity": [source.number(-3.0, 3.0) for _ in range(3)],  # scales a second
                "switches": _draw_switches(source),
            }
            for _ in range(source.whole(1, 4))
        ],
        "base": ("world", "free", "scripted", "fixed")[source.whole(0, 3)],
        "break_force": source.number(-4.0, 4.0) if source.whole(0, 2) else None,  # [N]
        "glue_contact": bool(source.whole(0, 3)),
        "thing": draw_thing(source),
        "sheet": bool(source.whole(0, 1)),
        "floor": source.whole(0, 1) == 0,
    }


def _draw_switches(source: Source) -> list[list[Any]]:
    """Parts of the run after which a joint is released, held again, ..."""
    if source.whole(0, 2) == 0:
        return []
    first = source.number(0.05, 0.7)
    return [[first, False]] + ([[first + source.number(0.05, 0.25), True]] if source.whole(0, 3) == 0 else [])


def build_joints(d: Description) -> Setup:
    scene = stark.Scene()
    build = {"chain": _chain, "gripper": _gripper, "arm": _arm, "glued": _glued}[d["kind"]]
    switched = build(scene, d)
    if d["floor"]:
        scene.add_floor(20.0 * 10.0 ** d["scale"], height=-1.5 * 10.0 ** d["scale"])
    free = d["kind"] == "chain" and d["base"] == "free"
    # Coordinates that are half a turn off, and what is held again far from where it was, cannot be held.
    return setup_of(
        scene,
        d,
        balanced=free or (d["kind"] == "glued" and d["base"] == "free"),
        passive=False,
        causes=_CAUSES + (("contradicting_joints",) if _held_again(d) else ()),
        drive=_switching(switched, d),
    )


def _held_again(d: Description) -> bool:
    return any(on for link in d["links"] for _, on in link["switches"])


def _switching(
    switched: list[tuple[Any, list[list[Any]]]], d: Description
) -> Callable[[stark.Simulation], None]:
    """Switches joints and attachments of whatever simulation it is called with."""
    until = 10.0 ** d["time_step"] * d["steps"]

    def drive(sim: stark.Simulation) -> None:
        for handle, switches in switched:
            passed = [on for part, on in switches if sim.time >= part * until * (1.0 - 1e-9)]
            if not passed:
                continue
            is_glue = isinstance(handle, stark.attachments.Attachment)
            mine: Any = (sim.attachments if is_glue else sim.joints)[handle._index]
            if mine.enabled != passed[-1] and not (passed[-1] and np.any(getattr(mine, "broken", False))):
                if passed[-1]:
                    mine.pull_together()
                else:
                    mine.enabled = passed[-1]

    return drive


# --- kinds ---


def _chain(scene: stark.Scene, d: Description) -> list[tuple[Any, Any]]:
    """Boxes and balls in a row, each on a joint with the one before."""
    size, distance = 10.0 ** d["scale"], distance_of(d)
    switched = []
    before, end = _base(scene, d, size), 0.0
    for link in d["links"]:
        mesh, half = _link_mesh(link, size)
        gap = 2.0 * distance * 10.0 ** link["gap"]
        at = end + gap + half
        body = scene.add_rigid(
            mesh,
            density=10.0 ** link["density"],
            position=(at, 0.0, 0.0),
            velocity=size * np.array(link["velocity"])
            if before is None and d["base"] == "free"
            else (0, 0, 0),
        )
        if before is not None or d["base"] == "world":
            joint = _add_joint(scene, link, before, body, (end + 0.5 * gap, 0.0, 0.0), d)
            switched.append((joint, link["switches"]))
        before, end = body, at + half
    if d["sheet"]:
        add_thing(scene, d["thing"], 0.3 * size, position=(0.5 * end, 0.0, 0.75 * size))
    return switched


def _link_mesh(link: Description, size: float) -> tuple[Any, float]:
    """And half of its length."""
    if link["shape"] == "sphere":
        return stark.mesh.sphere(0.3 * size * link["size"], subdivisions=1), 0.3 * size * link["size"]
    wide = 0.4 * size * 10.0 ** (0.7 * link["flatness"])
    return stark.mesh.box((size * link["size"], wide, 0.4 * size)), 0.5 * size * link["size"]


def _base(scene: stark.Scene, d: Description, size: float) -> Any:
    if d["base"] in ("world", "free"):
        return None
    velocity = size * np.array(d["links"][0]["velocity"]) if d["base"] == "scripted" else (0, 0, 0)
    box = (0.4 * size, 0.5 * size, 0.5 * size)
    return scene.add_box(box, motion=d["base"], position=(-0.2 * size, 0, 0), velocity=velocity)


def _add_joint(scene: stark.Scene, link: Description, a: Any, b: Any, anchor: Any, d: Description) -> Any:
    axis, kind = unit(link["axis"]), link["joint"]
    contact = link["contact"] and a is not None
    if kind == "distance":
        other = np.zeros(3) if a is None else a.position
        return scene.add_distance(a, b, other, b.position, contact=contact)
    if kind == "universal":
        across = unit(np.cross(axis, unit(np.cross(axis, (0.3, 0.5, 0.8)))))
        return scene.add_universal(a, b, anchor, axis, across, contact=contact)
    add = getattr(scene, f"add_{kind}")
    options = {} if kind in ("ball", "fixed") else {"axis": axis}
    joint = add(a, b, anchor=anchor, contact=contact, **options)
    _add_drive(joint, link, d)
    return joint


def _add_drive(joint: Any, link: Description, d: Description) -> None:
    if link["joint"] not in ("hinge", "slider", "cylindrical") or link["drive"] == "nothing":
        return
    step, cap = 10.0 ** d["time_step"], 10.0 ** link["cap"]
    on = (
        {"coordinate": "angle" if link["target"] > 0 else "displacement"}
        if link["joint"] == "cylindrical"
        else {}
    )
    angle = link["joint"] == "hinge" or on.get("coordinate") == "angle"
    rate = (1.0 if angle else 0.3 * 10.0 ** d["scale"]) * link["target"] / (2.0 * step)
    if link["drive"] == "motor":
        joint.add_motor(target=rate, cap=cap, delta=0.1 * abs(rate) + 1e-9, **on)
    elif link["drive"] == "servo":
        joint.add_servo(target=rate * step, stiffness=cap, damping=cap * step, cap=cap, **on)
    else:
        joint.add_effort(target=float(np.clip(cap, 0.0, 1e3)) * np.sign(link["target"]), **on)


def _gripper(scene: stark.Scene, d: Description) -> list[tuple[Any, Any]]:
    """Two fingers on sliders close on something, with what force the cap allows."""
    size, switched = 10.0 ** d["scale"], []
    link = d["links"][0]
    palm = scene.add_box((2.0 * size, 0.3 * size, 0.1 * size), motion="fixed", position=(0, 0, 0.8 * size))
    for side in (-1.0, 1.0):
        at = (side * 0.6 * size, 0.0, 0.0)
        finger = scene.add_box(
            (0.1 * size, 0.4 * size, 0.8 * size), density=10.0 ** link["density"], position=at
        )
        joint = scene.add_slider(palm, finger, anchor=at, axis=(1.0, 0.0, 0.0), contact=link["contact"])
        speed = 10.0 ** link["target"] * size
        joint.add_motor(target=-side * speed, cap=10.0 ** link["cap"], delta=0.1 * speed)
        switched.append((joint, link["switches"]))
    add_thing(scene, d["thing"], 0.45 * size, position=(0.0, 0.0, 0.0))
    return switched


def _arm(scene: stark.Scene, d: Description) -> list[tuple[Any, Any]]:
    """An arm on a hinge or slider is driven into a fixed block and what lies between."""
    size, link = 10.0 ** d["scale"], d["links"][0]
    arm = scene.add_box(
        (size, 0.2 * size, 0.2 * size), density=10.0 ** link["density"], position=(0.6 * size, 0, 0)
    )
    kind = "hinge" if link["size"] > 0.6 else "slider"
    axis = (0.0, 1.0, 0.0) if kind == "hinge" else (0.0, 0.0, 1.0)
    joint = getattr(scene, f"add_{kind}")(None, arm, anchor=(0.0, 0.0, 0.0), axis=axis)
    down = 1.0 if kind == "hinge" else -1.0
    speed = 10.0 ** link["target"] * (1.0 if kind == "hinge" else size)
    step = 10.0 ** d["time_step"]
    speed = min(speed, 2.0 / step) if kind == "hinge" else speed
    joint.add_motor(target=down * speed, cap=10.0 ** link["cap"], delta=0.1 * speed)
    scene.add_box((0.5 * size,) * 3, motion="fixed", position=(0.8 * size, 0.0, -0.85 * size))
    add_thing(scene, d["thing"], 0.2 * size, position=(0.8 * size, 0.0, -0.36 * size))
    return [(joint, link["switches"])]


def _glued(scene: stark.Scene, d: Description) -> list[tuple[Any, Any]]:
    """Things that hang on a plate by their vertices, with or without a gap, and fall on it when let go."""
    size, distance = 10.0 ** d["scale"], distance_of(d)
    link = d["links"][0]
    motion: dict[str, Any] = {"motion": d["base"]} if d["base"] in ("scripted", "fixed") else {"density": 1e3}
    if d["base"] == "scripted":
        motion |= {"velocity": size * np.array(link["velocity"])}
    plate = scene.add_box((2.0 * size, 2.0 * size, 0.2 * size), position=(0, 0, -0.1 * size), **motion)
    gap = 2.0 * distance * 10.0 ** link["gap"]
    switched = []
    for k, x in enumerate((-0.5, 0.5)[: len(d["links"])]):
        thing = {
            **d["thing"],
            "turn": [0.0] * 3 if k == 0 or d["thing"]["shape"] == "box" else d["thing"]["turn"],
        }
        corners = shape_of(thing).vertices @ rotation_of(thing["turn"]).T
        low = 0.4 * size * thing["size"] * float(corners[:, 2].min())
        body = add_thing(scene, thing, 0.4 * size, position=(x * size, 0.0, gap - low))
        points = np.flatnonzero(body.positions[:, 2] < gap + 0.02 * size)
        force = None if d["break_force"] is None else 10.0 ** d["break_force"]
        glue = scene.attach(body.vertices[points], plate, break_force=force, contact=d["glue_contact"])
        switched.append((glue, d["links"][k]["switches"]))
    return switched
