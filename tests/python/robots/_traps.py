"""Small robots of our own, each with what made files of packages fail or differ."""

# ruff: noqa: E501 (rows of XML)
INERTIAL = (
    '<inertial><origin xyz="0.01 0 -0.02" rpy="0.1 0.2 0.3"/><mass value="1.5"/>'
    '<inertia ixx="0.02" ixy="0.001" ixz="-0.002" iyy="0.03" iyz="0.0005" izz="0.025"/></inertial>'
)


def urdf(joint: str, link: str = INERTIAL, tip: str = INERTIAL, more: str = "") -> str:
    """A base, a link on a joint, and a tip that is fixed to the link."""
    return (
        f'<robot name="trap"><link name="base">{INERTIAL}</link><link name="link">{link}</link>'
        f'<link name="tip">{tip}</link>{joint}<joint name="weld" type="fixed"><parent link="link"/>'
        f'<child link="tip"/><origin xyz="0 0.1 0.2" rpy="0.3 0 -0.4"/>{more}</joint></robot>'
    )


def revolute(rest: str, kind: str = "revolute") -> str:
    return (
        f'<joint name="hinge" type="{kind}"><parent link="base"/><child link="link"/>'
        f'<origin xyz="0.1 0.2 0.3" rpy="-0.2 0.4 0.6"/><axis xyz="0 2 0.5"/>{rest}</joint>'
    )


LIMIT = '<limit lower="-1" upper="2" effort="5" velocity="3"/>'
#: By name: what the file has, and the coordinates that it must give.
URDF: dict[str, tuple[str, tuple[str, ...]]] = {
    "limit without lower and upper": (urdf(revolute('<limit effort="9" velocity="3"/>')), ("hinge",)),
    "limits that are 0": (urdf(revolute('<limit lower="0" upper="0" effort="0" velocity="0"/>')), ("hinge",)),
    "mimic of a fixed joint": (urdf(revolute(LIMIT), more='<mimic joint="hinge"/>'), ("hinge",)),
    "moments without mass": (
        urdf(
            revolute(LIMIT),
            tip='<inertial><mass value="0"/><inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial>',
        ),
        ("hinge",),
    ),
    "material inside of a geometry": (
        urdf(
            revolute(LIMIT),
            link=f'{INERTIAL}<visual><geometry><sphere radius="0.1"/><material name="red"/></geometry></visual>',
        ),
        ("hinge",),
    ),
    "continuous with the limits of another kind": (urdf(revolute(LIMIT, "continuous")), ("hinge",)),
}

BODY = '<inertial pos="0.01 0.02 0.03" mass="1.2" fullinertia="0.02 0.03 0.025 0.001 0.002 -0.001"/>'
_TWO = f'<body name="b" pos="0 0 .4">{BODY}<joint name="y" axis="0 1 0"/></body>'
MJCF: dict[str, tuple[str, tuple[str, ...]]] = {
    "several joints of a body": (
        f'<worldbody><body name="a" pos="0 0 1" euler="20 0 10">{BODY}<joint name="x" axis="1 0 0" pos="0 0 .1"/>'
        f'<joint name="s" type="slide" axis="0 1 1"/><joint name="z" axis="0 0 1" pos=".1 0 0"/>'
        f"{_TWO}</body></worldbody>",
        ("x", "s", "z", "y"),
    ),
    "classes and angles in radians": (
        '<compiler angle="radian" eulerseq="zyx" autolimits="true"/><default><default class="arm">'
        '<joint axis="0 1 0" damping="2" range="-1 2" ref="0.3"/><default class="tip"><joint armature="0.1"/></default>'
        f'</default></default><worldbody><body name="a" childclass="arm" euler=".3 .2 .1">{BODY}<joint name="x"/>'
        f'<body name="b" pos="0 0 .4">{BODY}<joint name="y" class="tip"/></body></body></worldbody>',
        ("x", "y"),
    ),
    "gravity that is off, a medium, compensation": (
        '<option density="1000"><flag gravity="disable"/></option>'
        f'<worldbody><body name="a" gravcomp="1">{BODY}<joint name="x"/></body></worldbody>',
        ("x",),
    ),
    "a free base with arms": (
        f'<worldbody><body name="a" pos="0 0 1"><freejoint/>{BODY}{_TWO}</body></worldbody>',
        ("y",),
    ),
    "several bodies in the world": (
        f'<worldbody><body name="a" pos="0 0 1"><freejoint/>{BODY}</body>{_TWO}</worldbody>',
        ("y",),
    ),
    "meshes with scale and a place of reference": (
        '<asset><mesh name="m" scale="2 1 -1" refpos=".1 0 .2" refquat="1 1 0 0" '
        'vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset><worldbody><body name="a">'
        '<joint name="x" axis="0 1 0"/><geom type="mesh" mesh="m" pos=".1 .2 .3" euler="10 20 30"/></body></worldbody>',
        ("x",),
    ),
    "actuators of all kinds, tendons, loops": (
        f'<worldbody><body name="a">{BODY}<joint name="x" axis="0 1 0"/><site name="p"/>{_TWO}</body></worldbody>'
        '<tendon><fixed name="t"><joint joint="x" coef="1"/><joint joint="y" coef="1"/></fixed></tendon>'
        '<equality><connect name="c" body1="b" body2="world" anchor="0 0 0"/><weld name="w" body1="b" body2="a"/>'
        '<joint name="lock" joint1="y"/></equality><actuator><motor name="m" joint="x" gear="3" ctrlrange="-2 2"/>'
        '<position name="p" joint="y" kp="5"/><velocity name="v" tendon="t"/><general name="g" site="p"/>'
        '<intvelocity name="i" joint="x" kp="1" actrange="-1 1"/><damper name="d" joint="x" ctrlrange="0 1"/>'
        '<cylinder name="cy" joint="x"/><muscle name="mu" tendon="t" lengthrange="0 1"/></actuator>',
        ("x", "y"),
    ),
}
