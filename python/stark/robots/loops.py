"""Joints of a robot that are part of a closed loop: a four-bar linkage, two hands on one workpiece.

What carries the weight of an open tree carries it in a loop, too, where all joints of the loop are driven so.
A joint of the loop that nothing drives lacks its part, which the others would have to carry through the loop:
feedforward of the tree is wrong for them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from stark.handle import SceneLink, SimulationLink
from stark.joints.handle import Joint

_REST = -1  # the world, and what does not move by forces

Edge = tuple[str, int, int]  # name of what connects, and the bodies


def in_loops(names: Iterable[str], joints: Mapping[str, Joint], simulation: SimulationLink) -> dict[str, str]:
    """Those of the joints ``names`` of a robot that are in a loop, with what closes the loop: a joint or
    attachment that is none of the robot, or another joint."""
    edges = _edges(simulation)
    own = {joint.name for joint in joints.values()}
    found = {}
    for name in names:
        title = joints[name].name
        way = _way_round(title, edges)
        if way:
            found[name] = next((other for other in way if other not in own), way[0])
    return found


def _edges(simulation: SimulationLink) -> list[Edge]:
    """Joints that hold something, and attachments."""
    scene: Any = simulation._scene
    core, edges = simulation._core, []
    for joint in scene._joints[: core.joint_count]:
        if core.joint_enabled(joint._index) and len(core.joint_residuals(joint._index)):
            a, b = (_node(joint._given[side].get("body"), scene) for side in "ab")
            edges.append((joint.name, a, b))
    for attachment in scene._attachments[: core.attachment_count]:
        given = attachment._given
        bodies = {_node(side.get("body"), scene) for side in given["b"]}
        bodies |= {_node(given["patch_body"], scene)} if "patch_body" in given else set()
        edges += [(attachment.name, _node(given["a"].get("body"), scene), body) for body in bodies]
    return edges


def _node(body: int | None, scene: SceneLink) -> int:
    return _REST if body is None or scene._core.motion(body) != "dynamic" else int(body)


def _way_round(title: str, edges: list[Edge]) -> list[str]:
    """What leads from one side of a joint to its other one without it; empty where nothing does."""
    start, goal = next(((a, b) for name, a, b in edges if name == title), (_REST, _REST))
    ways: dict[int, list[str]] = {start: []}
    reached = [start]
    for node in reached:
        for name, a, b in edges:
            other = b if a == node else a if b == node else node
            if name != title and other not in ways:
                ways[other] = [*ways[node], name]
                reached.append(other)
    return ways.get(goal, []) if start != goal else []
