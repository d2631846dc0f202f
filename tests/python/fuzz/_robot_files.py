"""Descriptions of robots that others made, in URDF and MJCF, with something wrong: values, names, elements
that are missing, twice or elsewhere, damaged bytes. Each gives a robot that can take a step, or an exception
of Stark's own, within seconds."""

from __future__ import annotations

import tempfile
import time
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from _damage import damaged
from _draw import Draw

import stark

_URDF = """<robot name="arm">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1" rpy="0 0 0"/><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><sphere radius="0.03"/></geometry><material name="red"/></visual>
    <collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.02" length="0.2"/></geometry></collision>
  </link>
  <link name="finger"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="thumb"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.1" rpy="0 0 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="20" velocity="3"/><dynamics damping="0.1" friction="0.05"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="upper"/><child link="finger"/><origin xyz="0 0.1 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-0.05" upper="0.05" effort="5" velocity="1"/>
  </joint>
  <joint name="other" type="prismatic">
    <parent link="upper"/><child link="thumb"/><origin xyz="0 -0.1 0.3"/><axis xyz="0 -1 0"/>
    <limit lower="-0.05" upper="0.05" effort="5" velocity="1"/>
    <mimic joint="slide" multiplier="1" offset="0"/>
  </joint>
</robot>"""

_MJCF = """<mujoco model="walker">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.002" gravity="0 0 -9.81"/>
  <default><joint damping="0.1"/><geom density="500"/>
    <default class="leg"><geom type="capsule" size="0.02 0.1"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 0.1" pos="0 0 -1"/>
    <body name="trunk" pos="0 0 0.5" quat="1 0 0 0">
      <freejoint/><geom type="box" size="0.1 0.05 0.03"/><site name="hook" pos="0.1 0 0"/>
      <body name="left" pos="0 0.1 0" childclass="leg">
        <joint name="left" type="hinge" axis="0 1 0" range="-1 1" armature="0.01" frictionloss="0.1"/>
        <geom pos="0 0 -0.15"/><site name="toe" pos="0 0 -0.2"/>
      </body>
      <body name="right" pos="0 -0.1 0" childclass="leg">
        <joint name="right" type="hinge" axis="0 1 0" range="-1 1" stiffness="2" springref="0.1"/>
        <geom pos="0 0 -0.15"/>
      </body>
      <body name="tail" pos="-0.2 0 0"><joint type="slide" axis="1 0 0"/>
        <geom type="sphere" size="0.03" mass="0.2"/></body>
    </body>
    <body name="weight" pos="1 1 0.5"><joint type="ball"/><geom type="ellipsoid" size="0.1 0.05 0.05"/></body>
  </worldbody>
  <equality><joint joint1="left" joint2="right" polycoef="0 -1 0 0 0"/></equality>
  <tendon><fixed name="pair"><joint joint="left" coef="1"/><joint joint="right" coef="0.5"/></fixed>
    <spatial name="cord"><site site="hook"/><site site="toe"/></spatial></tendon>
  <contact><exclude body1="left" body2="right"/></contact>
  <actuator><motor name="m" joint="left" gear="2" ctrlrange="-1 1"/>
    <position name="p" joint="right" kp="10" forcerange="-5 5"/>
    <general name="g" tendon="pair" gainprm="3"/></actuator>
  <keyframe><key name="home" qpos="0 0 0.5 1 0 0 0 0 0 0 1 0 0 0"/></keyframe>
</mujoco>"""

_ODD = (
    "", " ", "0", "-1", "nan", "inf", "-inf", "1e308", "1e400", "5e-324", "1 2", "0 0 0", "1 0 0 0",
    "1e9 0 0", "a b c", "0x10", "1,2,3", "true", "false", "x" * 300, "é", "shoulder", "slide", "left",
    "trunk", "upper", "base", "world", "leg", "continuous", "fixed", "floating", "planar", "box", "mesh",
    "sphere", "hinge", "slide", "free", "../../etc/passwd", "package://a/b.stl",
    "\u202e", "2147483648", "-0.5 0.5", "0.5 -0.5",
)  # fmt: skip

#: Longest time of one description, its step included [s of this process].
LONGEST = 5.0


def robot_files(draw: Draw) -> None:
    """Some changes of a good description, then it is read, built and stepped."""
    kind = draw.integer(2)
    rng = np.random.default_rng([draw.byte() for _ in range(8)])
    data, whole = (_URDF, _MJCF)[kind].encode(), True
    draw.trace.append(("urdf", "mjcf")[kind])
    changes = draw.integer(4)
    if changes:
        root = ET.fromstring(data)
        for _ in range(changes):
            draw.trace.append(_change(root, rng))
        data, whole = ET.tostring(root), False
        if rng.random() < 0.1:
            data = damaged(data, rng)
            draw.trace.append("damaged")
    with tempfile.TemporaryDirectory(dir=draw.memory) as folder:
        path = Path(folder) / ("robot.urdf" if kind == 0 else "robot.xml")
        path.write_bytes(data)
        started = time.process_time()
        _use(draw, path, whole)
        assert time.process_time() - started < LONGEST or whole  # the first one imports the readers
        assert [p.name for p in Path(folder).iterdir()] == [path.name]


def _use(draw: Draw, path: Path, whole: bool) -> None:
    draw.trace.append("use")
    scene = stark.Scene()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            robot = scene.add_robot(path)
            repr((robot, robot.joints, robot.links))
            settings = {"newton.max_iterations": 8, "time.min_step": 0.004, "execution.threads": 1}
            sim = stark.Simulation(scene, settings, time_step=0.01)
            report = sim.step()
            draw.trace[-1] += f" -> {report.status}" if report.failed else ""
        except ImportError:  # the extra 'robots' is missing
            return
        except stark.InternalError:
            raise
        except stark.Error as error:
            assert not whole, error
            assert len(str(error)) > 10
            draw.trace[-1] += f" -> {str(error)[:160]}"


def _change(root: ET.Element, rng: np.random.Generator) -> str:
    """One of a value, an attribute, or an element and where it is."""
    elements = list(root.iter())
    element = elements[rng.integers(len(elements))]
    parent = elements[rng.integers(len(elements))]
    kind = rng.integers(6)
    names = list(element.attrib)
    if kind <= 2 and names:
        name = names[rng.integers(len(names))]
        if kind == 2:
            del element.attrib[name]
            return f"{element.tag} without {name}"
        element.attrib[name] = _ODD[rng.integers(len(_ODD))]
        return f"{element.tag} {name} = {element.attrib[name]!r}"
    if kind == 3:
        for other in elements:
            if element in list(other):
                other.remove(element)
        return f"without {element.tag}"
    if kind == 4:
        others = [e for e in elements if e is not element and element not in list(e.iter())]
        if others:
            parent = others[rng.integers(len(others))]
        if parent not in list(element.iter()):
            parent.append(element)
        return f"{element.tag} also in {parent.tag}"
    ET.SubElement(parent, element.tag, dict(element.attrib))
    return f"an empty {element.tag} in {parent.tag}"
