"""Actuators of MJCF models: limits of effort and gains of servos, by joint."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stark.robots.description import Gains
from stark.robots.mjcf_tendons import Naming, Transmission, Transmissions
from stark.robots.report import Report

# Numbers of mujoco's enumerations, which are part of its interface.
_FIXED_GAIN, _NO_DYNAMICS = 0, 0
_NO_BIAS, _AFFINE = 0, 1
_ONE_AXIS = (2, 3)  # joints that slide or turn


@dataclass
class JointDrives:
    """What the joints of a model are driven by, by number."""

    efforts: dict[int, float] = field(default_factory=dict)
    """Limits [N m, N], the smallest of several."""
    gains: dict[int, Gains] = field(default_factory=dict)
    armature: dict[int, float] = field(default_factory=dict)
    """What the rotors of actuators add to that of joints [kg m^2, kg]."""
    damping: dict[int, float] = field(default_factory=dict)
    """What acts without a drive, too [N m s, N s/m]."""


def read_actuators(
    model: Any, name: Naming, joint_names: list[str], along: Transmissions, report: Report
) -> JointDrives:
    """Of joints themselves and of the actuators on them, on what follows them and on tendons."""
    found = JointDrives()
    for joint in range(model.njnt):
        if model.jnt_actfrclimited[joint]:
            found.efforts[joint] = float(np.abs(model.jnt_actfrcrange[joint]).max())
    for k in range(model.nu):
        title = f"actuator '{name('actuator', model.actuator(k).name, k)}'"
        driven = along.of_actuator(k)
        if driven is None or int(model.jnt_type[driven.joint]) not in _ONE_AXIS:
            report.add(
                "dropped", title, "acts on no single joint: use robot.add_servos, add_motors, add_efforts"
            )
            continue
        joint, ratio = driven.joint, driven.ratio
        _add_rotor(model, k, driven, joint_names[joint], found, report, title)
        gains, known = _gains(model, k, ratio), found.gains.get(joint, Gains(0.0))
        if gains is None or (gains.stiffness > 0.0 and known.stiffness > 0.0):
            report.add("dropped", title, "is not built: use robot.add_servos, add_motors, add_efforts")
        else:
            # Beside one that follows a position, one that follows a rate is its damping.
            found.gains[joint] = Gains(gains.stiffness + known.stiffness, gains.damping + known.damping)
            what = f"stiffness {gains.stiffness:g} and damping {gains.damping:g} of a servo"
            if gains.stiffness == 0.0:
                what = f"damping {gains.damping:g} of a servo that follows target_rate"
            of = f"'{joint_names[joint]}'"
            report.add("kept", title, f"{what} on {of}: robot.add_servos() takes them where none are given")
            _report_control(model, k, driven, report, title)
        limit = _limit(model, k, abs(ratio))
        if limit is None:
            continue
        found.efforts[joint] = min(limit, found.efforts.get(joint, np.inf))
        report.add("kept", title, f"limit of effort {limit:g} of joint '{joint_names[joint]}'")
    return found


def _limit(model: Any, k: int, ratio: float) -> float | None:
    """Of the effort on the joint [N m, N]."""
    if model.actuator_forcelimited[k]:
        return float(np.abs(model.actuator_forcerange[k]).max()) * ratio
    is_effort = model.actuator_gaintype[k] == _FIXED_GAIN and model.actuator_biastype[k] == _NO_BIAS
    if model.actuator_ctrllimited[k] and is_effort:
        return float(np.abs(model.actuator_ctrlrange[k]).max() * abs(model.actuator_gainprm[k][0])) * ratio
    return None


def _gains(model: Any, k: int, ratio: float) -> Gains | None:
    """Of a servo: its force is gain * control + b_1 * length + b_2 * velocity, of a length that is ratio
    times the coordinate. One that follows a rate has no b_1, and the gain -b_2."""
    is_affine = model.actuator_gaintype[k] == _FIXED_GAIN and model.actuator_biastype[k] == _AFFINE
    if not is_affine or model.actuator_dyntype[k] != _NO_DYNAMICS:
        return None
    stiffness, damping = (-float(value) * ratio**2 for value in model.actuator_biasprm[k][1:3])
    follows_rate = stiffness == 0.0 and model.actuator_gainprm[k][0] == -model.actuator_biasprm[k][2] > 0.0
    return Gains(stiffness, max(0.0, damping)) if stiffness > 0.0 or follows_rate else None


def _add_rotor(
    model: Any, k: int, driven: Transmission, joint: str, found: JointDrives, report: Report, title: str
) -> None:
    """Inertia and damping of an actuator, which its joint has whether something drives it or not."""
    for what, known in (("armature", found.armature), ("damping", found.damping)):
        value = float(getattr(model, f"actuator_{what}", np.zeros(model.nu))[k]) * driven.ratio**2
        if value:
            known[driven.joint] = known.get(driven.joint, 0.0) + value
            report.add("kept", title, f"{what} {value:g} of joint '{joint}'")
    if np.any(getattr(model, "actuator_dampingpoly", np.zeros(model.nu))[k]):
        report.add("dropped", title, "dampingpoly: only linear damping is kept")


def _report_control(model: Any, k: int, driven: Transmission, report: Report, title: str) -> None:
    """How the control of a servo of the file follows from targets, and what it has beside its gains: a
    constant force, targets that end before the joint."""
    gain, (force, per_length) = float(model.actuator_gainprm[k][0]), model.actuator_biasprm[k][:2]
    if force:
        text = f"constant effort {float(force) * driven.ratio:g}: use feedforward of robot.add_servos()"
        report.add("dropped", title, text)
    if per_length == 0.0 or gain == 0.0:
        return
    per = -float(per_length) / gain
    ratio, offset = per * driven.ratio, per * driven.offset
    if abs(ratio - 1.0) > 1e-9 or abs(offset) > 1e-12:
        plus = f" plus {offset:g}" if abs(offset) > 1e-12 else ""
        report.add("kept", title, f"targets are coordinates; its control is {ratio:g} times them{plus}")
    if not model.actuator_ctrllimited[k]:
        return
    low, high = sorted((float(bound) - offset) / ratio for bound in model.actuator_ctrlrange[k])
    lower, upper = model.jnt_range[driven.joint] if model.jnt_limited[driven.joint] else (-np.inf, np.inf)
    if low > lower + 1e-6 or high < upper - 1e-6:
        report.add("dropped", title, f"ctrlrange: targets are not cut to [{low:g}, {high:g}]")
