"""Actuators that hold a coordinate: stops and gears. Coordinates come from the states; bounds and ratios are
those that were recorded with them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from .certificate import NOT_APPLICABLE, NOT_RECORDED, VERIFIED, VIOLATED, Claim, comparable
from .run import Run, State

_SLACK = 1e-6  # of a tolerance, for the rounding of rotations
_ROUNDING = 1e-10  # of a coordinate

_KINDS = ("limit", "lower_limit", "upper_limit", "gear")
_BASIS = "states; bounds and ratios as recorded"


@dataclass
class StopCheck:
    """``add(state, coordinates)`` for each state, the first one first, then ``claims()``."""

    run: Run
    share: float = -1.0
    worst: tuple[float, float, str, dict[str, Any]] | None = None
    lacking: str = ""
    _previous: State | None = None
    _turned: dict[tuple[int, str], float] = field(default_factory=dict)  # angles over full turns

    def __post_init__(self) -> None:
        self.length: float = self.run.bound("joints.length_tolerance") or 0.0
        self.angle: float = self.run.bound("joints.angle_tolerance") or 0.0
        self.actuators: list[dict[str, Any]] = [a for a in self.run.scene["actuators"] if isinstance(a, dict)]
        if len(self.actuators) < len(self.run.scene["actuators"]):
            self.lacking = "actuators are recorded by name only"
        for actuator in self.actuators:
            if not actuator["built_in"] and actuator["rows"]:
                self.lacking = (
                    f"actuator '{actuator['name']}' has a formula of its own, which is not recorded"
                )

    def add(self, state: State, coordinates: dict[tuple[int, str], tuple[float, str]]) -> None:
        """``coordinates``: value and unit by number of the joint and name."""
        if self._previous is not None and self.run.jumps(self._previous, state):
            self.lacking = "bodies were placed, and how often their joints turned is not recorded"
        self._previous = state
        for key, (value, unit) in coordinates.items():
            before = self._turned.get(key, value)
            turns = round((before - value) / (2.0 * math.pi)) if unit == "rad" else 0
            self._turned[key] = value + 2.0 * math.pi * turns
        if state.has_placed_bodies:
            self._take_turns(state, coordinates)
        if state.actuators is None or state.index == 0 or self.lacking:
            return
        assert state.actuator_values is not None
        first = 0
        for k, actuator in enumerate(self.actuators):
            count = len(actuator["values"])
            values = dict(zip(actuator["values"], state.actuator_values[first : first + count], strict=True))
            first += count
            held = all(state.joints[joint] for joint, _ in actuator["on"])
            if actuator["kind"] in _KINDS and actuator["built_in"] and state.actuators[k] and held:
                self._add(state, actuator, values, coordinates)

    def _take_turns(self, state: State, coordinates: dict[tuple[int, str], tuple[float, str]]) -> None:
        """Full turns of angles that were placed are what the recording says."""
        names = [
            (number, str(name))
            for number, joint in enumerate(self.run.scene["joints"])
            for name, _ in joint.get("coordinates", [])
        ]
        if state.placed_coordinates is None or len(state.placed_coordinates) != len(names):
            return
        for key, recorded in zip(names, state.placed_coordinates.tolist(), strict=True):
            if key in coordinates and coordinates[key][1] == "rad" and math.isfinite(recorded):
                value = coordinates[key][0]
                turns = round((recorded - value) / (2.0 * math.pi))
                self._turned[key] = value + 2.0 * math.pi * turns

    def _add(
        self,
        state: State,
        actuator: dict[str, Any],
        values: dict[str, float],
        coordinates: dict[tuple[int, str], tuple[float, str]],
    ) -> None:
        keys = [(joint, name) for joint, name in actuator["on"]]
        if any(key not in coordinates for key in keys):
            self.lacking = f"a coordinate of actuator '{actuator['name']}' is not recorded"
            return
        q, unit = [self._turned[key] for key in keys], coordinates[keys[0]][1]
        if actuator["kind"] == "gear":
            off = abs(q[0] - values["ratio"] * q[1] - values["offset"])
        else:
            off = max(values.get("lower", -math.inf) - q[0], q[0] - values.get("upper", math.inf))
        # One infinite bound is none; its rounding is not, and no bound is not a number.
        size = max((abs(value) for value in (*q, *values.values()) if math.isfinite(value)), default=0.0)
        off = math.nan if any(math.isnan(value) for value in values.values()) else off
        tolerance = (self.angle if unit == "rad" else self.length) * (1.0 + _SLACK) + _ROUNDING * size
        where = {"time": state.time, "actuator": actuator["name"], "coordinate": q[0]}
        share = comparable(off / tolerance if tolerance > 0.0 else math.copysign(math.inf, off))
        if self.worst is None or share > self.share:
            self.share, self.worst = share, (off, tolerance, unit, where)

    def claims(self) -> list[Claim]:
        name, statement = "stops", "stops and gears are held within the tolerances of joints"
        if self.worst is not None and not self.share <= 1.0:
            return [Claim(name, statement, VIOLATED, _BASIS, *self.worst)]
        if self.lacking:
            return [Claim(name, statement, NOT_RECORDED, _BASIS, detail=self.lacking)]
        if not any(a["kind"] in _KINDS for a in self.actuators):
            return [Claim(name, statement, NOT_APPLICABLE, _BASIS, detail="there are none")]
        if self.worst is None:
            return [Claim(name, statement, VERIFIED, _BASIS, detail="none was ever enabled")]
        return [Claim(name, statement, VERIFIED, _BASIS, *self.worst)]
