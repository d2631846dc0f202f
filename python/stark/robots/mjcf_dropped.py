"""What of MJCF models no scene has, named once each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from stark.robots.report import Report

# Numbers of mujoco's enumerations, which are part of its interface.
_FREE, _MESH = 0, 7
_NO_GRAVITY, _GRAVITY = 1 << 7, (0.0, 0.0, -9.81)  # a flag; what MJCF has if left out [m/s^2]
#: Parts that are not read: counts in the model.
_COUNTED = {
    "nsensor": "sensors",
    "nkey": "keyframes",
    "npair": "contact pairs: what they name touches, with the friction of the scene",
    "ncam": "cameras",
    "nplugin": "plugins, with the stiffness that those of elasticity give",
}
#: Of geoms and joints: values that are not 0.
_VALUES = {
    "geom_surfacevel": "surfacevel of geoms: see belts in docs/friction.md",
    "geom_adhesion": "adhesion of geoms",
    "jnt_springyield": "springs of joints that yield: they are elastic",
    "actuator_delay": "delays of actuators",
}
#: What a <flag> switches off, by the number of its bit.
_FLAGS = {
    0: "constraint",
    1: "equality",
    2: "frictionloss",
    3: "limit",
    4: "contact",
    5: "spring",
    6: "damper",
}
_OF_FREE = {
    "damping": "dof_damping",
    "dry friction": "dof_frictionloss",
    "armature": "dof_armature",
}


def report_dropped(model: Any, bodies: Sequence[str], joints: Sequence[str], report: Report) -> None:
    """``bodies``, ``joints``: names by number, "" for those of flexes."""
    for attribute, what in _COUNTED.items():
        if count := int(getattr(model, attribute, 0)):
            report.add("dropped", "file", f"{count} {what}")
    for attribute, what in _VALUES.items():
        if np.any(getattr(model, attribute, 0)):
            report.add("dropped", "file", what)
    _report_options(model, report)
    _report_free_joints(model, joints, report)
    for body in np.flatnonzero(np.asarray(model.body_mocapid) >= 0).tolist():
        report.add(
            "dropped",
            f"body '{bodies[body]}'",
            "mocap: it is fixed where the file has it; add it to the scene with motion='scripted'",
        )
    report.add("dropped", "file", "friction, softness and margins of contact: those of the scene hold")
    if (model.geom_type == _MESH).any():
        report.add("kept", "file", "meshes touch as they are, not by their convex hulls")


def _report_options(model: Any, report: Report) -> None:
    option = model.opt
    gravity = [0.0, 0.0, 0.0] if option.disableflags & _NO_GRAVITY else option.gravity.tolist()
    if not np.allclose(gravity, _GRAVITY, atol=1e-2):
        report.add("dropped", "file", f"gravity {gravity} m/s^2: that of the simulation holds")
    if option.density or option.viscosity or option.wind.any():
        report.add("dropped", "file", "a medium: density, viscosity, wind")
    for bit, what in _FLAGS.items():
        if option.disableflags & (1 << bit):
            remedy = (
                "give contact=False" if what == "contact" else "remove what it switches off from the file"
            )
            report.add("dropped", "file", f"<flag {what}='disable'>: it acts; {remedy}", warn=True)


def _report_free_joints(model: Any, joints: Sequence[str], report: Report) -> None:
    for joint in np.flatnonzero(np.asarray(model.jnt_type) == _FREE).tolist():
        first = int(model.jnt_dofadr[joint])
        given = [what for what, key in _OF_FREE.items() if np.any(getattr(model, key)[first : first + 6])]
        given += ["spring"] if model.jnt_stiffness[joint] else []
        if given:
            report.add(
                "dropped", f"joint '{joints[joint]}'", f"{', '.join(given)}: of free joints they are not kept"
            )
