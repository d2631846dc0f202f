"""Handles: what users hold of the parts of a scene, and which simulation they read. This is the one place
that decides it.

A handle of ``sim[body]``, ``sim.joints`` and the like belongs to that simulation. Those that ``scene.add_*``
returned read the newest simulation of the scene that is alive: a temporary second one changes nothing for
them once it is gone. Handles know links to their scene and simulation, not what stands above them:
``stark.Scene`` and ``stark.Simulation`` are links."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol, Self, TypeAlias

from stark import _core
from stark._core import Simulation as CoreSimulation
from stark.arguments import added_later, needs_simulation
from stark.caller import warn
from stark.mesh import Indices, Polyline, SolidMesh, TetMesh, TriangleMesh
from stark.scene_record import RecordedScene
from stark.settings import Settings


class SimulationLink:
    """What handles know of a simulation."""

    _core: _core.Simulation
    _scene: SceneLink
    _pins: list[Indices]  # of the bodies, when it was made
    _clamped: list[Indices]
    _live_values: list[Any]  # of the energies, then of rest states of bodies
    _energy_count: int

    @property
    def settings(self) -> Settings:
        """The settings it was made with."""
        raise NotImplementedError

    def _to_place(self, what: str) -> CoreSimulation:
        """The core, to place bodies with; raises where ``what`` must not be placed now."""
        raise NotImplementedError

    def contact_distance(self, body: Any) -> float:
        """[m] within which surfaces of the body repel others."""
        raise NotImplementedError


@contextmanager
def placed_together(core: CoreSimulation) -> Iterator[None]:
    """All that is placed in the block holds at its end, or nothing changes."""
    core.begin_placing()
    try:
        yield
    except BaseException:
        core.cancel_placing()
        raise
    core.end_placing()


class Follower(Protocol):
    """Targets of a body for the end of each step."""

    @property
    def title(self) -> str:
        """What it is, in messages."""

    def apply(self, simulation: SimulationLink, time: float, duration: float) -> None:
        """Sets them for the step that ends at a time [s] and takes a duration [s]."""

    def jump(self) -> str:
        """How they differ at time 0 from where the body starts; empty if they do not."""


#: How the core begins what it says of the size of a mesh: when a body is added, and of a simulation.
_SAID, _SIZE = ": the mesh has an extent of ", ": extent of the mesh = "


class Waiting:
    """Something that was made for a scene, and does nothing before it is added."""

    def __init__(self, what: str) -> None:
        self.what = what


class SceneLink:
    """What handles know of their scene, and what it knows of its simulations."""

    name: str
    _core: RecordedScene
    _actuators: list[Any]
    _layers: list[Any]
    _followers: dict[int, list[Follower]]  # by body
    _courses: dict[tuple[str, int, str], Any]  # values over time (stark.courses), by what they are of
    _simulations: list[weakref.ref[SimulationLink]]  # in the order in which they were made
    _simulated_bodies: int  # that some simulation had
    _not_added: dict[Waiting, None]  # in the order in which they were made
    _places: dict[str, dict[str, int]]  # numbers of parts by kind and name (stark.named)
    _warned: int  # warnings of the core that were passed on
    _changes: int  # of pairs of bodies that were simulated already
    _last_change: str
    _adds_a_whole: bool = False  # parts that are added do not warn of being late

    def _begin_simulations(self) -> None:
        self._simulations, self._simulated_bodies, self._warned, self._places = [], 0, 0, {}
        self._changes, self._last_change, self._not_added = 0, "", {}

    def _is_simulated_by(self, simulation: SimulationLink) -> None:
        """Handles of the scene read the newest simulation that is alive. Weak, or a scene would keep all of
        its simulations alive."""
        self._simulations = [known for known in self._simulations if known() is not None]
        self._simulations.append(weakref.ref(simulation))
        self._simulated_bodies = max(self._simulated_bodies, simulation._core.body_count)

    def _latest_simulation(self) -> SimulationLink | None:
        for known in reversed(self._simulations):
            if (simulation := known()) is not None:
                return simulation
        return None

    def __getitem__(self, name: str) -> Any:
        raise NotImplementedError

    def __contains__(self, name: object) -> bool:
        raise NotImplementedError

    def add_actuator(
        self, kind: Any, on: Any, *, name: str | None = None, enabled: bool = True, **values: Any
    ) -> Any:
        """Adds an actuator to joints."""
        raise NotImplementedError

    def _actuators_on(self, joint: int) -> list[Any]:
        """Those on coordinates of a joint, by its index."""
        raise NotImplementedError

    def _pair(self, pair: Any) -> tuple[int, int]:
        """Indices of two bodies, given as handles or names."""
        raise NotImplementedError

    def _append_layer(self, layer: Any) -> None:
        self._layers.append(layer)
        self._warn_of_late(f"layer '{layer.name}'")
        self._warn()

    # --- warnings ---

    def _warn(self) -> None:
        """Passes on what the core has warned about since the last call."""
        found = self._core.warnings
        for message in found[self._warned :]:
            warn(message)
        self._warned = len(found)

    def _warn_of_late(self, what: str) -> None:
        """After something that acts was added to a scene that is being simulated."""
        if self._latest_simulation() is not None and not self._adds_a_whole:
            warn(
                f"{what} was added after the simulation was created and does not affect it: add it before "
                f"stark.Simulation(scene), or create a new simulation"
            )

    @contextmanager
    def _adding_a_whole(self) -> Iterator[None]:
        """While many parts are added as one: what adds them warns once of being late, not each part."""
        before, self._adds_a_whole = self._adds_a_whole, True
        try:
            yield
        finally:
            self._adds_a_whole = before

    def _unused_warnings(self) -> list[str]:
        """Of what was made for the scene and not added to it, each once."""
        waiting, self._not_added = self._not_added, {}
        return [
            f"energy {each.what} was bound and not added to the scene, so it does nothing here: write "
            f"scene.add(...) around it before stark.Simulation(scene)"
            for each in waiting
        ]

    def _unit_warnings(self, settings: Any) -> list[str]:
        """Values that are probably in other units. What was said of the size of a mesh when it was added is
        not said again."""
        said = [text.partition(_SAID)[0] for text in self._core.warnings if _SAID in text]
        found: list[str] = self._core.check_units(settings._core)
        return [text for text in found if _SIZE not in text or text.partition(_SIZE)[0] not in said]

    def _note_change(self, what: str, *bodies: int) -> None:
        """After a change of what bodies have with each other: simulations that have them warn of it when they
        go on, not before, as another one may be made next."""
        if all(body < self._simulated_bodies for body in bodies):
            self._changes, self._last_change = self._changes + 1, what

    def _warn_of_simulation(self, body: BodyHandle, what: str, remedy: str | None = None) -> None:
        """After a change of a body that one may take for a change of the simulation that it is in."""
        how = remedy or what
        latest = self._latest_simulation()
        if latest is not None and body._index < latest._core.body_count:
            warn(
                f"'{body.name}': {what} does not affect the existing simulation; {how} before you create "
                f"stark.Simulation(scene), or create a new one"
            )


class Handle:
    """A part of a scene, of one simulation or of the newest one that is alive."""

    _scene: SceneLink
    _index: int
    _of: SimulationLink | None  # the simulation that it belongs to

    def __init__(self, scene: SceneLink, index: int) -> None:
        self.__dict__.update(_scene=scene, _index=index, _of=None)  # beside what __setattr__ refuses

    @property
    def name(self) -> str:
        """Name, unique in its scene."""
        raise NotImplementedError

    @property
    def _title(self) -> str:
        """As messages call it."""
        return f"'{self.name}'"

    def _count_in(self, simulation: SimulationLink) -> int:
        """How many parts of this kind a simulation has."""
        raise NotImplementedError

    def _if_gone(self) -> None:
        """Where no simulation is alive."""

    def _newest(self) -> SimulationLink | None:
        """That of sim[body]; of handles of the scene the newest one that is alive."""
        return self._scene._latest_simulation() if self._of is None else self._of

    def _simulation(self) -> SimulationLink | None:
        """The simulation to read; None while there is none with this part."""
        simulation = self._newest()
        if simulation is None:
            self._if_gone()
            return None
        return simulation if self._index < self._count_in(simulation) else None

    def _require_simulation(self, what: str) -> SimulationLink:
        simulation = self._simulation()
        if simulation is None:
            raise (needs_simulation if self._newest() is None else added_later)(self._title, what)
        return simulation

    def _bound_to(self, simulation: SimulationLink) -> Self:
        """The same part, of one simulation."""
        handle = object.__new__(type(self))
        handle.__dict__.update(self.__dict__, _of=simulation)
        return handle


AnyMesh: TypeAlias = TriangleMesh | TetMesh | SolidMesh | Polyline


class BodyHandle(Handle):
    """What points, joints and sensors know of a body."""

    kind: str = ""
    _mesh: AnyMesh
    _rest_placement: tuple[Any, Any] | None  # of bodies that start in another shape than rest

    @property
    def name(self) -> str:
        """Name of the body, unique in its scene."""
        return self._scene._core.name(self._index)

    @property
    def motion(self) -> str:
        """ "dynamic", "fixed" or "scripted"."""
        return self._scene._core.motion(self._index)

    @property
    def mesh(self) -> AnyMesh:
        """The mesh it was made from, in the frame of the body [m]; a copy, whose arrays are read-only."""
        return self._mesh

    def _count_in(self, simulation: SimulationLink) -> int:
        return simulation._core.body_count


def names_of(simulation: SimulationLink) -> tuple[str, ...]:
    """Names of the bodies of a simulation, which do not change."""
    known: dict[str, Any] = simulation.__dict__
    if "_body_names" not in known:
        core = simulation._scene._core
        known["_body_names"] = tuple(core.name(k) for k in range(simulation._core.body_count))
    names: tuple[str, ...] = known["_body_names"]
    return names
