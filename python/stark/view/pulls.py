"""Springs with which a view pulls bodies. A simulation takes no new energies, so they are in the scene from
the start, without stiffness: energies that are zero leave every bit of the states as it is."""

from __future__ import annotations

import weakref
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stark._core import InvalidArgument
from stark.arguments import real_number
from stark.attributes import AnsweredAttributes
from stark.body_kinds import has_pose
from stark.formulas import Frame, Point, TimeStep, Vec3, energy, parameter
from stark.formulas.handle import Energy
from stark.handle import SceneLink
from stark.rotations import vector
from stark.symbolic import Scalar, dot

Floats = NDArray[np.float64]

_STIFFNESS = parameter(unit="N/m", min=0.0, doc="of the spring; 0: it does not pull")
_DAMPING = parameter(unit="N s/m", min=0.0, doc="of the velocity of the point")

#: A spring stretched by a tenth of the size of its body carries the weight that the body has on Earth.
_EARTH = 9.81  # [m/s^2]
_STRETCH = 0.1
#: Of the critical damping of the whole body on the spring.
_DAMPING_RATIO = 0.25

_known: weakref.WeakKeyDictionary[SceneLink, Pulls] = weakref.WeakKeyDictionary()


@energy(translation_invariant=False)
def pull_of_vertex(
    p: Point,
    h: TimeStep,
    stiffness: float = _STIFFNESS,
    damping: float = _DAMPING,
    target: Vec3 = parameter(unit="m", doc="where the spring is held"),
) -> Scalar:
    """A spring k/2 |x - t|^2 with damping c h/2 |v|^2, from a vertex to a place in the world."""
    apart = p.x - target
    return 0.5 * stiffness * dot(apart, apart) + 0.5 * damping * h * dot(p.v, p.v)


@energy(translation_invariant=False)
def pull_of_frame(
    f: Frame,
    h: TimeStep,
    stiffness: float = _STIFFNESS,
    damping: float = _DAMPING,
    place: Vec3 = parameter(unit="m", doc="of the point in the frame of the body"),
    target: Vec3 = parameter(unit="m", doc="where the spring is held"),
) -> Scalar:
    """A spring k/2 |x - t|^2 with damping c h/2 |v|^2, from any point of a rigid body to a place in the
    world; v is the velocity of the origin of the body."""
    apart = f.point(place) - target
    return 0.5 * stiffness * dot(apart, apart) + 0.5 * damping * h * dot(f.velocity, f.velocity)


class Held(NamedTuple):
    """What is pulled: a vertex of a body, or a place in the frame of a rigid one (3,) [m]."""

    body: str
    vertex: int | None
    place: Floats


class Pulls(AnsweredAttributes):
    """Springs of a scene, one of which pulls at a time: ``hold`` a point, move its ``target``, ``let_go``.
    Energies of the scene, so every simulation of it feels them. ``add_pulls`` makes them."""

    def __init__(self, scene: SceneLink, springs: dict[str, Energy]) -> None:
        self._scene, self._springs = scene, springs
        self._held: Held | None = None

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that can be pulled."""
        return tuple(self._springs)

    @property
    def energies(self) -> tuple[Energy, ...]:
        """The springs, one per body."""
        return tuple(self._springs.values())

    @property
    def held(self) -> Held | None:
        """What is pulled now; None if nothing is."""
        return self._held

    @property
    def point(self) -> Floats | None:
        """Where the point that is pulled is now (3,) [m]; None if nothing is pulled."""
        if self._held is None:
            return None
        body = self._scene[self._held.body]
        if self._held.vertex is not None:
            return np.asarray(body.positions[self._held.vertex], dtype=np.float64)
        position, rotation = body.pose
        return np.asarray(position + rotation @ self._held.place)

    @property
    def target(self) -> Floats | None:
        """Where the spring is held (3,) [m]; None if nothing is pulled."""
        return None if self._held is None else np.array(self._springs[self._held.body].target)

    def default_stiffness(self, body: Any) -> float:
        """[N/m] of a spring that carries the weight of a body on Earth, stretched by a tenth of its size."""
        handle = self._scene[self._name(body)]
        points = np.asarray(handle.positions)
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        return float(handle.mass) * _EARTH / (_STRETCH * max(size, 1e-6))

    def hold(self, body: Any, point: ArrayLike, *, stiffness: float | None = None) -> None:
        """Begins to pull ``body``, a handle or a name, at the place of its surface that is nearest to
        ``point`` (3,) [m]: of rigid bodies the point itself, of others the nearest vertex. The spring is held
        at ``point`` until ``move``. ``stiffness`` [N/m] is that of ``default_stiffness`` if left out. Raises
        InvalidArgument for bodies that cannot be pulled."""
        name, at = self._name(body), vector(point, "pull: point")
        given = (
            self.default_stiffness(name) if stiffness is None else real_number(stiffness, "pull: stiffness")
        )
        if not 0.0 < given < np.inf:
            raise InvalidArgument(f"pull of '{name}': stiffness = {given:g} N/m: must be > 0 and finite")
        self.let_go()
        handle, spring = self._scene[name], self._springs[name]
        damping = 2.0 * _DAMPING_RATIO * float(np.sqrt(given * handle.mass))
        if has_pose(handle):
            position, rotation = handle.pose
            place = np.asarray(rotation.T @ (at - position))
            self._held = Held(name, None, place)
            spring.place, spring.stiffness, spring.damping = place, given, damping
        else:
            gaps = np.linalg.norm(np.asarray(handle.positions) - at, axis=1)
            vertex = int(np.argmin(gaps))
            self._held = Held(name, vertex, np.zeros(3))
            spring.stiffness[vertex], spring.damping[vertex] = given, damping
        spring.target = at

    def move(self, target: ArrayLike) -> None:
        """Holds the spring at another place (3,) [m], from the next step on."""
        if self._held is None:
            raise InvalidArgument("pull: nothing is held: call hold(body, point) before move(target)")
        self._springs[self._held.body].target = vector(target, "pull: target")

    def let_go(self) -> None:
        """Ends the pull."""
        if self._held is None:
            return
        spring, self._held = self._springs[self._held.body], None
        spring.stiffness = 0.0
        spring.damping = 0.0

    def _name(self, body: Any) -> str:
        name = body if isinstance(body, str) else getattr(body, "name", None)
        if name not in self._springs:
            raise InvalidArgument(
                f"pull of {body!r}: must be one of {', '.join(self._springs) or 'none: no body moves freely'}"
            )
        return str(name)


def add_pulls(scene: Any) -> Pulls:
    """Prepares a scene for being pulled in a view: adds a spring without stiffness to each body that moves
    freely. Call it when all bodies are in the scene and before the simulation is made. Called again, it gives
    the same. Raises InvalidArgument for anything but a scene, and for a scene that is simulated already."""
    if not isinstance(scene, SceneLink):
        raise InvalidArgument(f"add_pulls: scene = {scene!r}: must be a stark.Scene")
    if scene in _known:
        return _known[scene]
    if scene._latest_simulation() is not None:
        raise InvalidArgument(
            f"add_pulls: scene '{scene.name}' has a simulation already, which takes no new energies: call "
            f"add_pulls(scene) before stark.Simulation(scene) is made"
        )
    springs = {body.name: _spring(scene, body) for body in scene.bodies if body.motion == "dynamic"}  # type: ignore[attr-defined]
    _known[scene] = Pulls(scene, springs)
    return _known[scene]


def pulls_of(sim: Any) -> Pulls | None:
    """Those of the scene of a simulation; None if there are none, or if they came too late for it."""
    found = _known.get(sim.scene)
    known = {energy._index for energy in sim.energies}
    return found if found is not None and all(e._index in known for e in found.energies) else None


def _spring(scene: Any, body: Any) -> Energy:
    none, name = np.zeros(3), f"pull of {body.name}"
    if has_pose(body):
        pull = pull_of_frame(body, stiffness=0.0, damping=0.0, place=none, target=none)
    else:
        still = np.zeros(len(body.mesh.vertices))
        pull = pull_of_vertex(body.vertices, stiffness=still, damping=still.copy(), target=none)
    spring: Energy = scene.add(pull, name=name)
    return spring
