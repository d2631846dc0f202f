"""Fixed tendons of MJCF models, and what actuators act on: one coordinate, where all joints follow it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from stark.robots.description import Mimic
from stark.robots.report import Report

# Numbers of mujoco's enumerations, which are part of its interface.
_WRAP_JOINT = 1
_ON_JOINT, _ON_JOINT_IN_PARENT, _ON_TENDON = 0, 1, 3
#: Properties of tendons that coordinates do not take over.
_OWN = {
    "tendon_stiffness": "stiffness",
    "tendon_damping": "damping",
    "tendon_frictionloss": "frictionloss",
    "tendon_armature": "armature",
    "tendon_limited": "range",
}

Naming = Callable[[str, str, int], str]
"""Of what a part is, its name in the file, and its number."""


class Transmission(NamedTuple):
    """What an actuator drives: the coordinate of a joint, by number. Its length is ``ratio`` times the
    coordinate and ``offset`` [m, rad]; so a force on it is ``ratio`` times that on the coordinate."""

    joint: int
    ratio: float
    offset: float = 0.0


class Transmissions:
    """Of joints, of which some follow others, and of the fixed tendons on them."""

    def __init__(self, model: Any, name: Naming, joint_names: list[str], mimics: Mapping[int, Mimic]) -> None:
        self._model, self._name, self._names, self._mimics = model, name, joint_names, mimics

    def of_actuator(self, k: int) -> Transmission | None:
        """None where it drives no coordinate, or several."""
        kind, part = int(self._model.actuator_trntype[k]), int(self._model.actuator_trnid[k][0])
        gear = float(self._model.actuator_gear[k][0])
        if kind in (_ON_JOINT, _ON_JOINT_IN_PARENT):
            found: Transmission | None = self._of_joint(part)
        else:
            found = self._of_tendon(part) if kind == _ON_TENDON else None
        return None if found is None else Transmission(found.joint, gear * found.ratio, gear * found.offset)

    def report(self, report: Report) -> None:
        """What becomes of each tendon."""
        for tendon in range(self._model.ntendon):
            title = f"tendon '{self._name('tendon', self._model.tendon(tendon).name, tendon)}'"
            along = self._of_tendon(tendon)
            if along is None:
                report.add("dropped", title, f"{self._lacks(tendon)}: see docs/coming_from.md")
                continue
            joint = self._names[along.joint]
            text = f"its length is {along.ratio:g} times the coordinate of '{joint}'"
            plus = f" plus {along.offset:g}" if abs(along.offset) > 1e-12 else ""
            report.add("kept", title, f"{text}{plus}")
            own = [what for key, what in _OWN.items() if np.any(getattr(self._model, key)[tendon])]
            if own:
                report.add("dropped", title, f"{', '.join(own)}: give them to joint '{joint}'")

    def _of_joint(self, joint: int) -> Transmission:
        ratio, offset, seen = 1.0, 0.0, {joint}
        while joint in self._mimics:
            offset += ratio * self._mimics[joint].offset
            ratio *= self._mimics[joint].ratio
            joint = self._names.index(self._mimics[joint].joint)
            if joint in seen:  # a circle, which the description refuses
                break
            seen.add(joint)
        return Transmission(joint, ratio, offset)

    def _of_tendon(self, tendon: int) -> Transmission | None:
        parts = self._parts(tendon)
        if parts is None or len({along.joint for along, _ in parts}) != 1:
            return None
        ratio = sum(coefficient * along.ratio for along, coefficient in parts)
        offset = sum(coefficient * along.offset for along, coefficient in parts)
        return Transmission(parts[0][0].joint, ratio, offset) if ratio != 0.0 else None

    def _parts(self, tendon: int) -> list[tuple[Transmission, float]] | None:
        """What its joints drive, with their coefficients; None of a spatial tendon."""
        first, count = int(self._model.tendon_adr[tendon]), int(self._model.tendon_num[tendon])
        wraps = range(first, first + count)
        if any(int(self._model.wrap_type[w]) != _WRAP_JOINT for w in wraps):
            return None
        return [
            (self._of_joint(int(self._model.wrap_objid[w])), float(self._model.wrap_prm[w])) for w in wraps
        ]

    def _lacks(self, tendon: int) -> str:
        parts = self._parts(tendon)
        if parts is None:
            return "goes through sites"
        joints = dict.fromkeys(self._names[along.joint] for along, _ in parts)
        if len(joints) == 1:
            return f"its length is the same for all coordinates of '{next(iter(joints))}'"
        return f"has several coordinates, of {', '.join(map(repr, joints))}"
