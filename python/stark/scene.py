"""The scene: what is simulated. Everything is checked when it is added."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeAlias, TypeGuard

from stark import _core
from stark._core import InvalidArgument
from stark.actuators.scene_actuators import SceneActuators
from stark.arguments import given_name, is_iterable, real_number, refuse_copy
from stark.attachments.scene_attachments import SceneAttachments
from stark.attributes import AnsweredAttributes
from stark.bodies.body import Body
from stark.bodies.friction import FrictionTable
from stark.bodies.layers import Layer
from stark.bodies.locking import thin_warnings
from stark.bodies.restitution import RestitutionTable
from stark.bodies.rings import ring_warnings
from stark.bodies.scene_bodies import SceneBodies
from stark.bodies.strained import strained_warnings
from stark.bodies.unfolding import unfolding_warnings
from stark.bodies.unjoined import unjoined_warnings
from stark.handle import Follower
from stark.joints.joined_ends import joined_ends_warnings
from stark.joints.scene_joints import SceneJoints
from stark.joints.unfit_starts import unfit_start_warnings
from stark.loads.idle import idle_actuator_warnings, idle_joint_warnings, idle_load_warnings
from stark.loads.scene_loads import SceneLoads
from stark.named import NamedTuple
from stark.robots.scene_robots import SceneRobots
from stark.scene_record import RecordedScene
from stark.settings import Settings

if TYPE_CHECKING:
    from stark.formulas.energy import Binding
    from stark.formulas.handle import Energy
    from stark.robots.link import RobotLink

#: A body or several: handles or names.
Bodies: TypeAlias = Body | str | Sequence[Body | str]


def _is_group(bodies: Any) -> TypeGuard[Sequence[Body | str]]:
    return isinstance(bodies, (list, tuple, set, frozenset))


class Scene(
    SceneBodies, SceneJoints, SceneActuators, SceneAttachments, SceneLoads, SceneRobots, AnsweredAttributes
):
    """Bodies, their materials, pins, friction. Lengths in metres, z is up unless gravity says otherwise."""

    name: str
    _given_by: ClassVar[Mapping[str, str]] = {
        "friction": "scene.friction[a, b] = 0.5, or scene.default_friction = 0.5 for all bodies",
        "restitution": "scene.restitution[a, b] = 0.5",
    }
    _elsewhere: ClassVar[Mapping[str, str]] = {
        "set_friction": "scene.friction[a, b] = 0.5, or friction=0.5 where a body is added",
        "add_ground": "scene.add_floor()",
        "add_plane": "scene.add_floor()",
        "add_cube": "scene.add_box(0.1, mass=1.0)",
        "remove": "a new scene without the body",
        "add_mesh": "scene.add_rigid, add_cloth or add_solid, by what it is made of",
        "add_body": "scene.add_rigid, add_cloth, add_solid or add_rod",
        "add_revolute": "scene.add_hinge",
        "add_prismatic": "scene.add_slider",
        "add_motor": "joint.add_motor(...), with the joint that scene.add_hinge or add_slider returns",
        "add_servo": "joint.add_servo(...), with the joint that scene.add_hinge or add_slider returns",
        "add_gravity": "stark.Simulation(scene, gravity=(0, 0, -9.81))",
        "step": "sim = stark.Simulation(scene), then sim.step()",
        "run": "sim = stark.Simulation(scene), then for step in sim.run(until=1.0): ...",
        "picture": "stark.Simulation(scene).picture(...)",
    }

    def __init__(self, name: str = "scene") -> None:
        self.name = given_name(name) or "scene"
        self._core = RecordedScene()
        self._bodies = []
        self._ghosts = []
        self._sizeless_floors = []
        self._energies: list[Energy] = []
        self._joints = []
        self._actuators, self._listed_actuators = [], ([], {})
        self._attachments = []
        self._robots = []
        self._layers = []
        self._followers = {}
        self._courses = {}
        self._begin_simulations()

    # --- pairs ---

    @property
    def friction(self) -> FrictionTable:
        """Coefficients of pairs: ``scene.friction[a, b] = 0.3``; see FrictionTable for pairs that are not
        set."""
        return FrictionTable(self)

    @property
    def restitution(self) -> RestitutionTable:
        """Coefficients of pairs of rigid bodies: ``scene.restitution[ball, floor] = 0.8``; see
        RestitutionTable."""
        return RestitutionTable(self)

    @property
    def default_friction(self) -> float:
        """Coefficient of bodies that were given none, 0.5 at first."""
        return self._core.default_friction

    @default_friction.setter
    def default_friction(self, coefficient: float) -> None:
        self._core.default_friction = real_number(coefficient, "scene: default_friction")
        if self._simulated_bodies:
            self._note_change("default_friction")

    def disable_contact(self, a: Bodies, b: Bodies | None = None) -> None:
        """Lets two bodies pass through each other; ``a`` with itself switches its self-contact off. With
        groups, ``disable_contact(fingers, palm)``, each body of the one with each of the other;
        ``disable_contact(fingers)`` all of a group among each other, self-contact excepted."""
        groups = self._groups("disable_contact", a, b)
        if groups is None:
            first, second = self._pair((a, b))
            self._core.disable_contact(first, second)
            self._note_change("disable_contact", first, second)
        else:
            self._core.disable_contacts(*groups)
            self._note_change("disable_contact", *groups[0], *groups[1])

    def enable_contact(self, a: Bodies, b: Bodies | None = None) -> None:
        """Undoes ``disable_contact``, of two bodies or of groups."""
        groups = self._groups("enable_contact", a, b)
        if groups is None:
            first, second = self._pair((a, b))
            self._core.enable_contact(first, second)
            self._note_change("enable_contact", first, second)
        else:
            self._core.enable_contacts(*groups)
            self._note_change("enable_contact", *groups[0], *groups[1])

    def disable_overlapping(
        self, bodies: Iterable[Body | str | RobotLink] | None = None
    ) -> list[tuple[Body, Body]]:
        """Lets the bodies that overlap at the start pass through each other, as neighbouring links of robots
        often do, and returns them in pairs: all that ``disable_contact`` was called for.

        A simulation refuses such bodies one pair at a time. Looked at are ``bodies``, such as
        ``robot.links.values()``, or all of the scene: pairs whose surfaces intersect, or one of which is
        inside of another that is filled, unless they have no contact anyway. Certificates list the pairs as
        excluded by the scene. Raises InvalidArgument for bodies of another scene, and where there is a
        simulation already."""
        from stark.bodies.overlaps import overlapping
        from stark.robots.link import RobotLink

        if isinstance(bodies, (str, Body)) or not (bodies is None or is_iterable(bodies)):
            raise InvalidArgument(
                f"disable_overlapping: bodies = {bodies!r}: must be a list of bodies; leave it out for all"
            )
        # Links of a robot may be parts of the same body, or of the world.
        named = [b.body if isinstance(b, RobotLink) else b for b in bodies or ()]
        indices = sorted({self._index(b) for b in named if b is not None})
        pairs = overlapping(self, self._bodies if bodies is None else [self._bodies[k] for k in indices])
        for a, b in pairs:
            self.disable_contact(a, b)
        return pairs

    def _groups(self, caller: str, a: Bodies, b: Bodies | None) -> tuple[list[int], list[int]] | None:
        """Indices of both groups; None where both sides are single bodies."""
        if b is not None and not (_is_group(a) or _is_group(b)):
            return None
        if b is None and not _is_group(a):
            raise InvalidArgument(f"{caller}: a = {a!r}: must be several bodies, or give another one as b")
        sides = [self._members(caller, side) for side in (a, a if b is None else b)]
        return sides[0], sides[1]

    def _members(self, caller: str, group: Bodies) -> list[int]:
        members: list[Any] = list(group) if _is_group(group) else [group]
        indices = [self._index(body) for body in members]
        if not indices:
            raise InvalidArgument(f"{caller}: a group has no bodies: must have one or more")
        return indices

    def contact_enabled(self, a: Body | str, b: Body | str) -> bool:
        """Whether two bodies act on each other by contact: not where ``disable_contact`` or a joint between
        them says otherwise. A body with itself: whether it has self-contact. Raises InvalidArgument for
        bodies of another scene and unknown names."""
        return self._core.contact_enabled(*self._pair((a, b)))

    # --- energies ---

    def add(self, energy: Binding, *, name: str | None = None) -> Energy:
        """Adds an energy of your own, bound to points: ``scene.add(spring(cloth.edges, stiffness=10.0))``.

        Returns the handle that has its parameters. Values and derivatives have to be finite at time 0."""
        from stark.formulas.adding import add_energy

        handle = add_energy(self, energy, name)
        self._energies.append(handle)
        self._warn_of_late(f"energy '{handle.name}'")
        return handle

    @property
    def energies(self) -> NamedTuple[Energy]:
        """Energies that were added, in the order of adding."""
        return NamedTuple("energy", self._energies, self)

    def _start_warnings(self, settings: Settings) -> list[str]:
        """What is probably not meant, of a scene that is simulated with these settings."""
        return [
            *self._core.check_contact_distances(settings._core),
            *self._unit_warnings(settings),
            *self._unused_warnings(),
            *thin_warnings(self._bodies, self._energies, self._attachments),
            *unfolding_warnings(self._bodies),
            *strained_warnings(self._bodies),
            *joined_ends_warnings(self._core, self._joints, settings),
            *ring_warnings(self._bodies, self._joints, self._attachments),
            *unjoined_warnings(self._bodies, self._energies, self._attachments, self._joints, self._layers),
            *self._twin_warnings(),
            *idle_load_warnings(self._energies),
            *idle_actuator_warnings(self._core, self._actuators),
            *idle_joint_warnings(self._core, self._joints, self._actuators),
        ]

    def _uneven_starts(self, simulation: _core.Simulation, followers: Iterable[Follower]) -> list[str]:
        """Of motions and velocities with which a simulation begins."""
        jumps = [text for text in (follower.jump() for follower in followers) if text]
        return jumps + unfit_start_warnings(self._core, simulation, self._joints[: simulation.joint_count])

    def _twin_warnings(self) -> list[str]:
        if len(self._energies) < 2:
            return []
        from stark.formulas.twins import twin_warnings

        return twin_warnings(self._energies, self._courses)

    # --- files ---

    def save(
        self,
        path: str | PathLike[str],
        *,
        settings: Settings | Mapping[str, Any] | None = None,
        until: float | None = None,
        description: str = "",
        sample_functions: bool = False,
    ) -> Path:
        """Writes the scene as a document, ``name.json`` beside ``name.npz``, to be loaded anywhere by
        ``stark.load_scene(path)`` and run by ``stark run name.json``; returns the path. ``settings`` of the
        simulation, ``until`` [s], the end of a run, and ``description`` go with it. Both replace those of a
        document saved before; a ``name.npz`` of anything else, as a checkpoint, is an error.

        It holds what was added to the scene, with the present values of energies and actuators; formulas of
        your own are recorded as formulas. A Python function of the time cannot be saved: use ``stark.motion``
        through knots, or give ``sample_functions=True``, which saves its values at the ends of all steps up
        to ``until``. Raises ``stark.DocumentError`` for what cannot be saved before anything is written, and
        a ``stark.Error`` that is an ``OSError`` where files cannot be."""
        from stark.document.writing import write

        return write(
            self, path, settings=settings, until=until, description=description,
            sample_functions=sample_functions,
        )  # fmt: skip

    # --- bodies ---

    @property
    def bodies(self) -> NamedTuple[Body]:
        """All bodies in the order of adding."""
        return NamedTuple("body", self._bodies, self)

    @property
    def layers(self) -> NamedTuple[Layer]:
        """Skins and fibres of all bodies, in the order of adding."""
        return NamedTuple("layer", self._layers, self)

    def __getitem__(self, name: str) -> Any:
        """The body of a name; what kind of body it is, type checkers do not know."""
        return self._bodies[self._index(name)]

    def __contains__(self, name: object) -> bool:
        if isinstance(name, str):
            return self._core.contains(name)
        return any(body is name for body in self._bodies)

    def __iter__(self) -> Iterator[Body]:
        return iter(self._bodies)

    def __len__(self) -> int:
        return len(self._bodies)

    @property
    def warnings(self) -> list[str]:
        """What was warned about so far."""
        return self._core.warnings

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        refuse_copy(
            f"scene '{self.name}'",
            "its bodies and joints are handles; build it again by a function, each time and in each process",
        )

    def __repr__(self) -> str:
        bodies = ", ".join(f"{body.name} ({body.kind})" for body in self._bodies)
        return f"<stark.Scene '{self.name}': {bodies or 'empty'}>"

    # --- details ---

    def _unknown_attribute(self, name: str) -> str:
        names = _core.Settings.fields()
        known = {"time_step", "contact_distance", "threads"} | {f["name"].partition(".")[0] for f in names}
        if name in known:
            return (
                f"{self!r} has no attribute '{name}': it is a setting of the simulation, "
                f"stark.Simulation(scene, {name}=...)"
            )
        return super()._unknown_attribute(name)

    def _index(self, body: Body | str) -> int:
        if isinstance(body, Body):
            if body._scene is not self:
                raise InvalidArgument(
                    f"'{body.name}' belongs to another scene: must be a body of this one; add it here"
                )
            return body._index
        if isinstance(body, str):
            return self._core.find(body)
        raise InvalidArgument(f"body = {body!r}: must be a body of the scene or its name")

    def _pair(self, pair: Any) -> tuple[int, int]:
        if not isinstance(pair, tuple) or len(pair) != 2:
            raise InvalidArgument(
                f"pair = {pair!r}: must be two bodies or names, as in scene.friction[box, 'floor']"
            )
        return self._index(pair[0]), self._index(pair[1])
