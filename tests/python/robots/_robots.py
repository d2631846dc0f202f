"""Robots for tests: random trees as URDF and MJCF, and small files with one fault each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
ARM = Path(__file__).parents[3] / "examples/robot_arm.urdf"
GRAVITY = np.array([0.3, -0.2, -9.81])  # in no direction that hides anything


def text(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))


def random_inertia(random: np.random.Generator) -> tuple[float, Floats, Floats]:
    """Mass, centre, full tensor about it: that of a cloud of points."""
    points = random.normal(scale=0.1, size=(8, 3))
    mass = float(random.uniform(0.2, 3.0))
    away = points - points.mean(axis=0)
    tensor = mass * (np.trace(away.T @ away) * np.eye(3) - away.T @ away) / len(points)
    return mass, random.normal(scale=0.05, size=3), tensor


def random_urdf(seed: int, count: int = 9) -> str:
    """A tree with joints of all kinds, fixed links with mass, one joint that mimics another one."""
    random = np.random.default_rng(seed)
    kinds = ["revolute", "continuous", "prismatic", "fixed"]
    rows = [_link(random, 0)]
    for k in range(1, count):
        kind = kinds[(k - 1) % 4]
        mimic = '<mimic joint="joint_1" multiplier="-0.7" offset="0.2"/>' if k == 5 else ""
        limit = "" if kind == "fixed" else '<limit lower="-3" upper="3" effort="50" velocity="2"/>'
        rows += [
            _link(random, k),
            f'<joint name="joint_{k}" type="{kind}"><parent link="link_{random.integers(max(0, k - 3), k)}"/>'
            f'<child link="link_{k}"/><origin xyz="{text(random.normal(scale=0.3, size=3))}" '
            f'rpy="{text(random.uniform(-3, 3, 3))}"/><axis xyz="{text(random.normal(size=3))}"/>'
            f"{limit}{mimic}</joint>",
        ]
    return f'<robot name="tree_{seed}">{"".join(rows)}</robot>'


def _link(random: np.random.Generator, k: int) -> str:
    mass, center, tensor = random_inertia(random)
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    values = tensor[np.triu_indices(3)]
    moments = " ".join(f'{name}="{float(value)!r}"' for name, value in zip(names, values, strict=True))
    return (
        f'<link name="link_{k}"><inertial>'
        f'<origin xyz="{text(center)}" rpy="{text(random.uniform(-3, 3, 3))}"/>'
        f'<mass value="{mass!r}"/><inertia {moments}/></inertial></link>'
    )


def written_mjcf(folder: Path, body: str, more: str = "") -> Path:
    """A file with this world, and what stands beside it."""
    file = folder / "robot.xml"
    file.write_text(f'<mujoco model="m"><worldbody>{body}</worldbody>{more}</mujoco>')
    return file


def random_mjcf(seed: int, count: int = 7) -> str:
    """A tree of bodies with hinges and slides whose axes miss the origins, with classes and an equality."""
    random = np.random.default_rng(seed)
    parents = [0] + [int(random.integers(max(0, k - 2), k)) for k in range(1, count)]
    inner = [""] * count
    for k in reversed(range(count)):
        inner[k] = _body(random, k, "".join(inner[c] for c in range(k + 1, count) if parents[c] == k))
    return f"""<mujoco model="tree"><compiler angle="degree"/>
      <option gravity="{text(GRAVITY)}"/>
      <default><joint damping="0.1" armature="0.01"/>
        <default class="arm"><joint range="-170 170"/></default></default>
      <worldbody>{inner[0]}</worldbody>
      <equality><joint joint1="j5" joint2="j1" polycoef="0.1 -0.5 0 0 0"/></equality>
      <actuator><motor name="m1" joint="j1" gear="20" ctrlrange="-1 1"/></actuator></mujoco>"""


def _body(random: np.random.Generator, k: int, inner: str) -> str:
    mass, center, tensor = random_inertia(random)
    values = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
    quat = random.normal(size=4)
    joint = ""
    if k % 3 == 1 or k == 5:
        joint = f'<joint class="arm" name="j{k}" ref="{10 * k}" axis="{text(random.normal(size=3))}" '
        joint += f'pos="{text(random.normal(scale=0.1, size=3))}"/>'
    elif k % 3 == 2:
        joint = f'<joint name="j{k}" type="slide" axis="{text(random.normal(size=3))}" range="-1 1"/>'
    return (
        f'<body name="b{k}" pos="{text(random.normal(scale=0.3, size=3))}" quat="{text(quat)}">{joint}'
        f'<inertial pos="{text(center)}" mass="{mass!r}" fullinertia="{text(np.array(values))}"/>'
        f'<geom type="capsule" size="0.02 0.05"/>{inner}</body>'
    )


def pair(joint: str = "", link: str = "", more: str = "", kind: str = "revolute") -> str:
    """Two links and a joint, with other contents of the joint or the second link."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'
        "</inertial>"
    )
    joint = joint or '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="2"/>'
    return (
        f'<robot name="pair"><link name="base"/><link name="arm">{link or inertial}</link>'
        f'<joint name="hinge" type="{kind}"><parent link="base"/><child link="arm"/>'
        f"{joint}</joint>{more}</robot>"
    )
