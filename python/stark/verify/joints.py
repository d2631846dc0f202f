"""Joints and attachments of the states: what their frames are apart by, from poses and positions alone.

The residuals are those of docs/joints.md, written down here once more."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .certificate import INCONCLUSIVE, NOT_APPLICABLE, NOT_RECORDED, VERIFIED, VIOLATED, Claim, comparable
from .formulas import Frames, UnknownFormula, evaluate
from .held_places import carried, on_carrier, places, taken_anew
from .joint_kinds import KINDS
from .run import Run, State, pair_count
from .stops import StopCheck

Floats = NDArray[np.float64]

_SLACK = 1e-6  # of a tolerance, for the rounding of rotations
_ROUNDING = 1e-12  # [m], [rad]


@dataclass
class _Worst:
    """The largest share of a tolerance, and where."""

    share: float = -1.0
    value: float = 0.0
    tolerance: float = 0.0
    unit: str = "m"
    where: dict[str, Any] | None = None

    def keep(self, value: float, tolerance: float, unit: str, where: dict[str, Any]) -> None:
        share = comparable(value / (tolerance if tolerance > 0.0 else _ROUNDING))
        if share > self.share:
            self.share, self.value, self.tolerance, self.unit = share, value, tolerance, unit
            self.where = where

    @property
    def holds(self) -> bool:
        return self.value <= self.tolerance * (1.0 + _SLACK) + _ROUNDING


@dataclass
class JointCheck:
    """``add(state)`` for each state, the first one first, then ``claims()``."""

    run: Run
    joints: _Worst = field(default_factory=_Worst)
    attachments: _Worst = field(default_factory=_Worst)
    start: State | None = None

    def __post_init__(self) -> None:
        settings = self.run.settings
        self.length: float = self.run.bound("joints.length_tolerance") or 0.0
        self.angle: float = self.run.bound("joints.angle_tolerance") or 0.0
        self.lacking: str = self.run.lacks("joints.length_tolerance", "joints.angle_tolerance")
        #: Joints that cannot be looked at, and why.
        self.unknown: dict[str, str] = {}
        self.stops: StopCheck = StopCheck(self.run)
        self.previous: State | None = None
        # With bdf2, what formulas take for the start of a step is not a state.
        self._has_start = settings.get("time.integrator") in ("implicit_euler", "quasistatic")
        for joint in self.run.scene["joints"]:
            if not (joint["kind"] in KINDS if joint["built_in"] else joint.get("formula")):
                self.unknown[joint["name"]] = "has a formula of its own, which is not recorded"

    def add(self, state: State) -> None:
        self.start = self.start or state
        coordinates: dict[tuple[int, str], tuple[float, str]] = {}
        for k, joint in enumerate(self.run.scene["joints"]):
            if joint["name"] in self.unknown:
                continue
            try:
                found = self._add_joint(state, joint, bool(state.joints[k]))
            except UnknownFormula as error:
                self.unknown[joint["name"]] = f"has a formula of its own: {error}"
                continue
            coordinates |= {(k, name): value for name, value in found.items()}
        self.stops.add(state, coordinates)
        first = 0
        for attachment in self.run.scene["attachments"]:
            count = pair_count(attachment)
            held = state.attachments[first : first + count] == 1
            first += count
            self._add_attachment(state, attachment, held)
        self.previous = state

    def _add_attachment(self, state: State, attachment: dict[str, Any], held: NDArray[np.bool_]) -> None:
        """Looks at the pairs that hold, and whether places that were taken anew are where the points were."""
        numbers = places(state, attachment)
        found = [(state, held)]
        if taken_anew(self._start_of(state), state, attachment):
            assert self.previous is not None and numbers is not None
            before = places(self.previous, attachment)
            new = (numbers.reshape(-1, 3) != before.reshape(-1, 3)).any(axis=1)  # type: ignore[union-attr]
            found.append((self.previous, new))
        for at, rows in found:
            if rows.any():
                apart = np.linalg.norm(self._apart(at, attachment, numbers)[rows], axis=1)
                where = {"time": at.time, "attachment": attachment["name"]}
                pair = int(np.flatnonzero(rows)[apart.argmax()])
                self.attachments.keep(float(apart.max()), self.length, "m", where | {"pair": pair})

    def _start_of(self, state: State) -> State | None:
        """The state that a step to this one began with, if it is recorded."""
        return None if self.previous and self.run.jumps(self.previous, state) else self.previous

    def _add_joint(self, state: State, joint: dict[str, Any], is_held: bool) -> dict[str, tuple[float, str]]:
        """Looks at what a joint holds; returns its coordinates with their units."""
        units = {name: unit for name, unit in joint.get("coordinates", [])}
        if joint["built_in"]:
            frames = self._frames(state, joint, places(state, joint))
            kind = KINDS[joint["kind"]]
            if taken_anew(self._start_of(state), state, joint):
                assert self.previous is not None  # there is where the frames were
                found = self._frames(self.previous, joint, places(state, joint))
                self._keep(self.previous, joint, *kind.held(*found, joint["values"]))
            lengths, angles = kind.held(*frames, joint["values"])
            values = {name: float(f(*frames)) for name, f in kind.coordinates.items()}
        elif (state.index == 0 or state.is_placed) and joint["formula"]["uses_motion"]:
            return {}  # no step led there
        else:
            outputs = self._evaluated(state, joint)
            lengths, angles = [], []
            for unit, size in joint["formula"]["groups"]:
                (lengths if unit == "m" else angles).append(np.array(outputs[:size]))
                outputs = outputs[size:]
            values = dict(zip(units, outputs, strict=True))
        if is_held:
            self._keep(state, joint, lengths, angles)
        return {name: (value, units[name]) for name, value in values.items() if name in units}

    def _frames(self, state: State, joint: dict[str, Any], place: Floats | None = None) -> Frames:
        return (*self._frame(state, joint["a"]), *on_carrier(self._frame(state, joint["b"]), place))

    def _evaluated(self, state: State, joint: dict[str, Any]) -> list[float]:
        """Outputs of a recorded formula."""
        start = self.previous if self._has_start else None
        assert self.start is not None
        frames = {
            "x": self._frames(state, joint),
            "x_prev": None if start is None else self._frames(start, joint),
            "x_initial": self._frames(self.start, joint),
        }
        row = self.run.row_of(state) or {}
        clocks = {"time": state.time, "time_step": float(row.get("time_step") or math.nan)}
        return evaluate(joint["formula"], frames, joint["values"], clocks)

    def _keep(self, state: State, joint: dict[str, Any], lengths: list[Floats], angles: list[Floats]) -> None:
        where = {"time": state.time, "joint": joint["name"]}
        for rows, tolerance, unit in ((lengths, self.length, "m"), (angles, self.angle, "rad")):
            for row in rows:
                self.joints.keep(float(np.linalg.norm(row)), tolerance, unit, where)

    def _frame(self, state: State, side: dict[str, Any]) -> tuple[Floats, Floats]:
        """Origin and axes (columns) of a side of a joint in a state."""
        position = np.array(side["position"])
        rotation = np.array(side["rotation"]).reshape(3, 3)
        if side["carrier"] == "world":
            return position, rotation
        if side["carrier"] == "patch":
            assert self.start is not None
            corners = np.array(side["vertices"])
            before, now = (s.positions[side["body"]][corners][None] for s in (self.start, state))
            carried = _on_patch(before, now, position[None])[0]
            return carried, _patch_axes(now)[0] @ _patch_axes(before)[0].T @ rotation
        if side["carrier"] == "node":  # placed in the world at time 0, like a patch
            assert self.start is not None
            origin, axes = self._carrier(self.start, side)
            position, rotation = axes.T @ (position - origin), axes.T @ rotation
        origin, axes = self._carrier(state, side)
        return origin + axes @ position, axes @ rotation

    @staticmethod
    def _carrier(state: State, side: dict[str, Any]) -> tuple[Floats, Floats]:
        body = side["body"]
        pose, frames = state.poses[body], state.frames[body]
        if "node" in side and frames is not None:
            return state.positions[body][side["node"]], frames[side["node"]]
        assert pose is not None
        return pose[0], pose[1:]

    # --- attachments ---

    def _apart(self, state: State, attachment: dict[str, Any], numbers: Floats | None) -> Floats:
        """Points of side a less what carries them (n, 3) [m]; ``numbers``: of places that were taken anew."""
        a = self._places(state, attachment["a"])
        if "patches" not in attachment:
            apart: Floats = a - np.concatenate([self._places(state, b) for b in carried(attachment, numbers)])
            return apart
        assert self.start is not None
        corners = np.array(attachment["patches"])
        before, now = (s.positions[attachment["patch_body"]][corners] for s in (self.start, state))
        return a - _on_patch(before, now, self._places(self.start, attachment["a"]))

    def _places(self, state: State, points: dict[str, Any]) -> Floats:
        """Where described points are in a state (n, 3) [m]."""
        kind = points["kind"]
        if kind == "world":
            return np.array(points["local"]).reshape(-1, 3)
        x = state.positions[points["body"]]
        if kind == "vertices":
            vertices: Floats = x[np.array(points["vertices"])]
            return vertices
        if kind == "embedded":
            inside: Floats = np.einsum(
                "ni,nij->nj", np.array(points["weights"]), x[np.array(points["supports"])]
            )
            return inside
        origin, axes = self._carrier(state, points)
        return origin + np.array(points["local"]).reshape(-1, 3) @ axes.T

    # --- claims ---

    def claims(self) -> list[Claim]:
        basis = "states, formulas of joints"
        unknown = next((f"joint '{name}' {why}" for name, why in self.unknown.items()), "")
        joints = _claim("joints", "joints are held within the tolerances of the settings", basis, self.joints)
        if self.unknown and joints.status != VIOLATED:
            joints = Claim("joints", joints.statement, NOT_RECORDED, basis, detail=unknown)
        statement = "attached points stay within joints.length_tolerance"
        attachments = _claim("attachments", statement, basis, self.attachments)
        claims = [joints, attachments, *self.stops.claims()]
        return [self._without_tolerances(claim) for claim in claims] if self.lacking else claims

    def _without_tolerances(self, claim: Claim) -> Claim:
        """A claim that was looked at, but with no tolerance to compare with."""
        if claim.status not in (VERIFIED, VIOLATED):
            return claim
        return replace(claim, status=INCONCLUSIVE, tolerance=None, detail=self.lacking)


def _claim(name: str, statement: str, basis: str, worst: _Worst) -> Claim:
    if worst.where is None:
        return Claim(name, statement, NOT_APPLICABLE, basis, detail="there are none")
    status = VERIFIED if worst.holds else VIOLATED
    return Claim(name, statement, status, basis, worst.value, worst.tolerance, worst.unit, worst.where)


def _patch_axes(corners: Floats) -> Floats:
    """Axes of triangles (n, 3, 3), as columns: along the first side, across it, along the normal."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal, tangent = _unit(np.cross(u, v)), _unit(u)
    return np.stack([tangent, np.cross(normal, tangent), normal], axis=2)


def _on_patch(before: Floats, now: Floats, places: Floats) -> Floats:
    """Where places (n, 3) at time 0 are carried to by their triangles (n, 3, 3): barycentric in the plane,
    and at a fixed height above it."""
    u, v, w = before[:, 1] - before[:, 0], before[:, 2] - before[:, 0], places - before[:, 0]
    normal = np.cross(u, v)
    area = np.einsum("ni,ni->n", normal, normal)
    with np.errstate(invalid="ignore", divide="ignore"):
        beta = np.einsum("ni,ni->n", np.cross(w, v), normal) / area
        gamma = np.einsum("ni,ni->n", np.cross(u, w), normal) / area
        height = np.einsum("ni,ni->n", w, normal) / np.sqrt(area)
    weights = np.stack([1.0 - beta - gamma, beta, gamma], axis=1)
    up = _unit(np.cross(now[:, 1] - now[:, 0], now[:, 2] - now[:, 0]))
    carried_to: Floats = np.einsum("ni,nij->nj", weights, now) + height[:, None] * up
    return carried_to


def _unit(v: Floats) -> Floats:
    with np.errstate(invalid="ignore"):  # of nothing: not a number, which is violated
        unit: Floats = v / np.linalg.norm(v, axis=1)[:, None]
        return unit
