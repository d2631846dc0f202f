"""Bodies and pins that follow motions: targets for the end of each step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import as_array, shown_value
from stark.caller import warn
from stark.handle import BodyHandle, Follower, SceneLink, SimulationLink
from stark.mesh import Indices
from stark.motion import Motion, as_motion
from stark.rotations import as_matrix, check_places, vector

Floats = NDArray[np.float64]
_Places = TypeVar("_Places")

#: A motion starts elsewhere than its body if it is farther from it than this part of its size, or turned by
#: more than this [rad].
_ELSEWHERE = 0.01
#: Turn of what follows a rotation in a step at most [rad], as the core has it of bodies with a velocity:
#: friction sees chords. From half a turn on nothing would tell the sense, in quasistatic steps either.
_LARGEST_TURN, _LARGEST_STILL_TURN = np.pi / 8.0, 0.75 * np.pi
#: Part of a step over which the rate of a rotation is taken.
_RATE_OVER = 1e-3
#: What an assignment may change, rounding aside, of what follows a motion [m, 1, m/s, rad/s].
_SAME = 1e-12


class PinnedBody(Protocol):
    """What following needs of a deformable body."""

    _scene: SceneLink
    _index: int

    @property
    def name(self) -> str: ...

    @property
    def pins(self) -> Indices: ...


@dataclass
class PoseFollower:
    """A scripted body on a path."""

    body: BodyHandle
    position: Motion | None
    rotation: Motion | None
    #: Its pose at time 0, where a user gave the motion.
    first: tuple[Floats, Floats] | None = field(default=None, init=False)

    def pose(self, time: float) -> tuple[Floats, Floats]:
        """At a time [s]; what no motion prescribes is as at time 0."""
        owner = f"'{self.body.name}'"
        position, rotation = self.body._scene._core.pose(self.body._index)
        if self.position is not None:
            position = vector(self.position(time), f"{owner}: position at {time:g} s")
        return position, rotation if self.rotation is None else self.turn(time)

    @property
    def title(self) -> str:
        return f"the motion that '{self.body.name}' follows"

    def _standing_still(self) -> str:
        """What is wrong with a velocity at time 0 of what no motion prescribes; else empty."""
        if (simulation := self.body._simulation()) is None:
            return ""
        names, motions = ("velocity", "angular_velocity"), (self.position, self.rotation)
        units, parts = ("m/s", "rad/s"), ("position", "rotation")
        for k, rate in enumerate(simulation._core.twist(self.body._index)):
            if motions[k] is None and np.abs(rate).max() > 0.0:
                return (
                    f"'{self.body.name}': {names[k]} = {shown_value(tuple(map(float, rate)))} {units[k]} "
                    f"ends with the first step, as it follows a motion without {parts[k]}=, which stays as "
                    f"at time 0: give follow() the {parts[k]} over time, too"
                )
        return ""

    def apply(self, simulation: SimulationLink, time: float, duration: float) -> None:
        simulation._core.set_pose(self.body._index, *self.pose(time), duration)

    def turn(self, time: float) -> Floats:
        """Its rotation."""
        if self.rotation is None:
            return np.eye(3)
        return as_matrix(self.rotation(time), f"'{self.body.name}': rotation at {time:g} s")

    def jump(self) -> str:
        """What is wrong with a motion that does not start where the body is; else empty."""
        if self.first is None:
            return ""
        (start, turned), (position, rotation) = self.body._scene._core.pose(self.body._index), self.first
        if (text := _distance_text(self.body, float(np.linalg.norm(position - start)))) != "":
            return text + "; positions are those of the body in the world"
        angle = _angle_of(rotation @ turned.T)
        if angle <= _ELSEWHERE:
            return self._standing_still()
        return (
            f"'{self.body.name}': at 0 s its motion is turned by {angle:.3g} rad from it, and the first step "
            f"turns it there: add the body with rotation= as the motion starts, or let the motion start as "
            f"it is turned; rotations are those of the body in the world, not changes as those of pins"
        )


@dataclass
class PinFollower:
    """Pinned vertices on paths: each on its own, or all like a rigid body."""

    body: PinnedBody
    rows: NDArray[np.intp]  # among the pins of the body
    targets: Motion | None
    displacement: Motion | None
    rotation: Motion | None
    center: Floats
    #: Positions at time 0, where a user gave the motion.
    first: Floats | None = field(default=None, init=False)

    def positions(self, time: float) -> Floats:
        """Positions (k, 3) [m] at a time [s]."""
        owner = f"'{self.body.name}'"
        if self.targets is not None:
            places = self.targets(time)
            if places.shape != (len(self.rows), 3):
                raise InvalidArgument(
                    f"{owner}: targets at {time:g} s have the shape {places.shape}: must be "
                    f"({len(self.rows)}, 3), a position [m] for each pinned vertex that follows"
                )
            check_places(places, f"{owner}: targets at {time:g} s")
            return places
        start = self.body._scene._core.initial_positions(self.body._index)[self.body.pins[self.rows]]
        places = self.center + (start - self.center) @ self.turn(time).T
        if self.displacement is None:
            return places
        what = f"{owner}: displacement at {time:g} s"
        moved = as_array(self.displacement(time), what)
        if moved.ndim > 1:
            raise InvalidArgument(
                f"{what} has the shape {moved.shape}: must be three numbers [m], which move all pins alike; "
                f"pins that move apart follow targets, as by follow(lambda t: start + moved(t))"
            )
        return places + vector(moved, what)

    def jump(self) -> str:
        """What is wrong with a motion that does not start where the pins are; else empty."""
        if self.first is None:
            return ""
        start = self.body._scene._core.initial_positions(self.body._index)[self.body.pins[self.rows]]
        angle = _angle_of(self.turn(0.0))
        if angle > _ELSEWHERE:  # clamped nodes turn even where no pin moves
            return (
                f"'{self.body.name}': at 0 s its motion has turned its pins by {angle:.3g} rad, and the "
                f"first step turns them there: let rotation= start without a turn, by lambda t: motion(t) @ "
                f"motion(0.0).T; rotations of pins are changes since time 0, not those of the body"
            )
        apart = np.linalg.norm(self.first - start, axis=1)
        return _distance_text(self.body, float(apart.max(initial=0.0)))

    def turn(self, time: float) -> Floats:
        """Rotation since time 0."""
        if self.rotation is None:
            return np.eye(3)
        return as_matrix(self.rotation(time), f"'{self.body.name}': rotation at {time:g} s")

    @property
    def title(self) -> str:
        return f"the motion that '{self.body.name}' follows"

    def apply(self, simulation: SimulationLink, time: float, duration: float) -> None:
        core, index = simulation._core, self.body._index
        targets = core.pin_targets(index)
        # Pins are appended: those that the simulation was made with are the first ones.
        held = self.rows < len(targets)
        targets[self.rows[held]] = self.positions(time)[held]
        core.set_pin_targets(index, targets, duration)
        clamped = getattr(self.body, "clamped", np.empty(0))
        if self.rotation is None or len(clamped) == 0:
            return
        frames = core.clamp_targets(index).reshape(-1, 3, 3)
        clamped = clamped[: len(frames)]
        turning = np.isin(clamped, self.body.pins[self.rows])
        start = self.body._scene._core.initial_frames(index).reshape(-1, 3, 3)[clamped]
        frames[turning] = self.turn(time) @ start[turning]
        core.set_clamp_targets(index, np.ascontiguousarray(frames.reshape(-1, 9)), duration)


def limit_of_turns(
    simulation: SimulationLink,
    followers: Sequence[Follower],
    held: Callable[[Follower], AbstractContextManager[None]],
    limit: float | None,
) -> float | None:
    """What the coming step has to be shortened to [s], a whole part of it, so that nothing that
    follows a rotation turns too far; ``limit`` where nothing does. Motions are asked while ``held``."""
    duration, end = simulation._core.next_step(limit)
    is_still = simulation.settings["time.integrator"] == "quasistatic"
    allowed, largest = _LARGEST_STILL_TURN if is_still else _LARGEST_TURN, 0.0
    for follower in followers:
        if isinstance(follower, PoseFollower | PinFollower) and follower.rotation is not None:
            with held(follower):
                largest = max(largest, _angle_in_step(follower.turn, end, duration, allowed))
    if largest <= allowed * (1.0 + 1e-6):
        return limit
    shortest: float = simulation.settings["time.min_step"]
    parts = math.ceil(largest / allowed * (1.0 - 1e-6))
    return duration / max(1, min(parts, math.floor(duration / shortest)))


def _angle_in_step(turn: Callable[[float], Floats], end: float, duration: float, enough: float) -> float:
    """Angle [rad] of the step that ends at a time [s], from the rates at its end and, beyond ``enough``, in
    its middle: both ends do not tell full turns. The lesser of both, as a rotation that jumps has no rate."""
    apart = _RATE_OVER * duration

    def angle(time: float) -> float:
        change = float(np.linalg.norm(turn(time) - turn(time - apart)))
        return change / (math.sqrt(2.0) * _RATE_OVER)

    found = angle(end)
    return found if found <= enough else min(found, angle(end - 0.5 * duration))


def _angle_of(rotation: Floats) -> float:
    """[rad]"""
    return float(np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0)))


def _distance_text(body: BodyHandle | PinnedBody, distance: float) -> str:
    """What is wrong with a motion that starts at a distance [m] from a body, unless it is small."""
    size = np.linalg.norm(np.ptp(body._scene._core.initial_positions(body._index), axis=0))
    if distance <= _ELSEWHERE * size:
        return ""
    return (
        f"'{body.name}': at 0 s its motion is {distance:.3g} m from it, and the first step takes it there: "
        f"add the body where the motion starts, or let the motion start where it is"
    )


_OTHER_MOTION = {
    "displacement": "of pins, a change since time 0: must be position= of a rigid body in the world; "
    "follow(position=lambda t: start + displacement(t)) goes on from where it starts",
    "position": "of rigid bodies: must be targets, a position of each pin, or displacement=, a change since "
    "time 0",
}


def refuse_other_motion(owner: str, name: str, value: Any) -> None:
    """InvalidArgument where pins get what rigid bodies follow, or the other way round."""
    if value is not None:
        raise InvalidArgument(f"'{owner}': follow: {name} is {_OTHER_MOTION[name]}")


def follow_pose(body: BodyHandle, position: Any, rotation: Any) -> None:
    """``RigidBody.follow``."""
    if body.motion != "scripted":
        raise InvalidArgument(
            f"'{body.name}' is {body.motion}: it cannot follow a motion; only bodies with "
            f"motion='scripted' do"
        )
    follower = PoseFollower(
        body,
        None if position is None else as_motion(position, f"'{body.name}': position"),
        None if rotation is None else as_motion(rotation, f"'{body.name}': rotation"),
    )
    follower.first = _at_start(follower.pose, body.name)  # says at once what is wrong with the values
    stops = position is None and rotation is None
    for known in [] if stops else body._scene._followers.get(body._index, []):
        for name, now, before in _parts(follower, known):
            if now is None and before is not None:
                warn(
                    f"'{body.name}': follow: its {name} follows no motion any more, stays as at time 0: give "
                    f"follow(position=, rotation=) both, or call follow() before if this is meant"
                )
    body._scene._followers[body._index] = [] if stops else [follower]
    if stops and (core := _core_after_failure(body)) is not None:
        core.set_pose(body._index, *core.pose(body._index))


def refuse_replaced_pose(body: BodyHandle, what: str, *changes: tuple[Floats, Floats]) -> None:
    """Raises InvalidArgument where (given, present) values of a body that follows a motion differ: the coming
    step takes those of the motion, and the assignment would be lost without a word."""
    followers = body._scene._followers.get(body._index, [])
    if not any(isinstance(follower, PoseFollower) for follower in followers):
        return
    if any(np.abs(given - present).max() > _SAME for given, present in changes):
        raise InvalidArgument(
            f"'{body.name}': {what} is assigned, but the body follows a motion, which has its position and "
            f"its rotation in each step: must be left to it; give the motion both, follow(position=, "
            f"rotation=), or end it before with follow()"
        )


def refuse_replaced_targets(body: PinnedBody, what: str, given: Floats, present: Floats) -> None:
    """The same of ``pin_targets`` (k, 3) [m] and ``clamp_targets`` (k, 3, 3)."""
    changed = np.abs(given - present).max(axis=tuple(range(1, given.ndim)), initial=0.0) > _SAME
    clamps = what == "clamp_targets"
    vertices = getattr(body, "clamped" if clamps else "pins")[: len(given)]
    for follower in body._scene._followers.get(body._index, []):
        if not isinstance(follower, PinFollower) or (clamps and follower.rotation is None):
            continue
        lost = np.flatnonzero(changed & np.isin(vertices, body.pins[follower.rows]))
        if len(lost):
            raise InvalidArgument(
                f"'{body.name}': {what}[{lost[0]}] is assigned, but vertex {vertices[lost[0]]} follows a "
                f"motion, which has its place in each step: must be left to it; end it before with follow()"
            )


def _parts(follower: PoseFollower, known: Follower) -> list[tuple[str, Motion | None, Motion | None]]:
    """Names of what a motion prescribes, its motions and those of the one that it replaces."""
    if not isinstance(known, PoseFollower):
        return []
    return [
        ("position", follower.position, known.position),
        ("rotation", follower.rotation, known.rotation),
    ]


def _core_after_failure(body: Any) -> Any:
    """Of its simulation, if the last step failed: the target of that step is still to be reached."""
    simulation = body._simulation()
    has_failed = simulation is not None and simulation._core.report.status == "failed"
    return simulation._core if has_failed else None


def _let_pins_stay(body: Any, core: Any) -> None:
    """And clamps, where the simulation has them now."""
    index, count = body._index, len(core.pin_targets(body._index))
    core.set_pin_targets(index, np.ascontiguousarray(core.positions(index)[body.pins[:count]]))
    if clamps := len(core.clamp_targets(index)) if body.kind == "rod" else 0:
        frames = core.frames(index).reshape(-1, 9)[body.clamped[:clamps]]
        core.set_clamp_targets(index, np.ascontiguousarray(frames))


def _at_start(places: Callable[[float], _Places], owner: str) -> _Places:
    """Where a motion is at time 0; InvalidArgument for functions of something else than the time."""
    try:
        return places(0.0)
    except TypeError as error:
        raise InvalidArgument(
            f"'{owner}': follow: must be a motion, or a function of the time [s]: at 0 s it raises {error}"
        ) from error


def follow_pins(
    body: PinnedBody,
    targets: Any,
    displacement: Any,
    rotation: Any,
    center: ArrayLike | None,
    vertices: ArrayLike | None,
) -> None:
    """``follow`` of deformable bodies."""
    owner = f"'{body.name}'"
    followers = body._scene._followers
    if targets is None and displacement is None and rotation is None:
        if vertices is not None or center is not None:
            given = "center" if vertices is None else "vertices"
            raise InvalidArgument(
                f"{owner}: follow: {given} is given without a motion: must come with targets, displacement "
                f"or rotation; to end the motions of all pins, leave it out"
            )
        followers[body._index] = []
        if (core := _core_after_failure(body)) is not None:
            _let_pins_stay(body, core)
        return
    if targets is not None and not (displacement is None and rotation is None):
        raise InvalidArgument(
            f"{owner}: follow: targets and displacement or rotation are given: give positions of all pins, "
            f"or how they move together"
        )
    if center is not None and rotation is None:
        raise InvalidArgument(
            f"{owner}: follow: center is given without a rotation, which turns pins about it: must come with "
            f"rotation=; a displacement alone moves all pins alike, and targets are places of their own"
        )
    rows = _pin_rows(body, vertices)
    follower = PinFollower(
        body,
        rows,
        None if targets is None else as_motion(targets, f"{owner}: targets"),
        None if displacement is None else as_motion(displacement, f"{owner}: displacement"),
        None if rotation is None else as_motion(rotation, f"{owner}: rotation"),
        body._scene._core.initial_positions(body._index)[body.pins[rows]].mean(axis=0)
        if center is None
        else vector(center, f"{owner}: center"),
    )
    follower.first = _at_start(follower.positions, body.name)
    others = followers.get(body._index, [])
    kept = [f for f in others if isinstance(f, PinFollower) and not np.isin(f.rows, rows).any()]
    if len(kept) < len(others) and vertices is not None and not _covers(others, rows):
        raise InvalidArgument(
            f"{owner}: follow: some of the vertices follow another motion together with others: give the "
            f"same vertices again to replace it, or call follow() first to stop it"
        )
    followers[body._index] = [*kept, follower]


def _covers(others: Sequence[object], rows: NDArray[np.intp]) -> bool:
    """Whether the followers that share pins with these have no other ones."""
    return all(
        np.isin(f.rows, rows).all()
        for f in others
        if isinstance(f, PinFollower) and np.isin(f.rows, rows).any()
    )


def _pin_rows(body: PinnedBody, vertices: ArrayLike | None) -> NDArray[np.intp]:
    pins = body.pins
    if len(pins) == 0:
        raise InvalidArgument(
            f"'{body.name}' has no pinned vertices that follow() could move: call "
            f"scene['{body.name}'].pin(vertices) before stark.Simulation(scene)"
        )
    if vertices is None:
        return np.arange(len(pins))
    chosen = np.atleast_1d(as_array(vertices, f"'{body.name}': follow: vertices"))
    count = len(body._scene._core.initial_positions(body._index))
    if chosen.size == 0 or (chosen.dtype == bool and len(chosen) == count and not chosen.any()):
        raise InvalidArgument(
            f"'{body.name}': follow: vertices = {vertices!r}: must be at least one; leave it out for all pins"
        )
    if chosen.dtype.kind not in "biuf" or chosen.ndim != 1 or (chosen.dtype == bool and len(chosen) != count):
        raise InvalidArgument(
            f"'{body.name}': follow: vertices = {shown_value(vertices)}: must be indices of pinned vertices, "
            f"or a mask of shape ({count},)"
        )
    if chosen.dtype == bool:
        chosen = np.flatnonzero(chosen)
    place = {int(v): k for k, v in enumerate(pins)}
    for v in chosen.tolist():
        if v not in place:
            raise InvalidArgument(
                f"'{body.name}': follow: vertex {v} is not pinned: must be one of the pinned vertices; "
                f"pin it first"
            )
    return np.array([place[int(v)] for v in chosen], dtype=np.intp)
