"""Names of joints in other simulators."""

from __future__ import annotations

#: What to write instead of them, by the name that a user tries.
ELSEWHERE = {
    **dict.fromkeys(("position", "q", "value"), "joint.coordinates"),
    **dict.fromkeys(("velocity", "rate", "qd", "speed", "angular_velocity"), "joint.rates"),
    **dict.fromkeys(("force", "torque", "wrench"), "joint.reaction, or the effort of an actuator"),
    **dict.fromkeys(("target", "motor", "drive"), "motor = joint.add_motor(...), before the simulation"),
    **dict.fromkeys(("limits", "limit", "lower", "upper"), "joint.add_limit(lower, upper)"),
    "friction": "joint.add_friction(cap)",
    **dict.fromkeys(("damping", "add_damping", "add_damper"), "joint.add_spring(0.0, damping=...)"),
    **dict.fromkeys(("add_torque", "add_force"), "joint.add_effort(...)"),
}
