"""Running a scene: ``for step in stark.Simulation(scene, time_step=1/30).run(until=1.0)``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, TypeVar

from numpy.typing import ArrayLike

from stark import _core
from stark._core import InvalidArgument, State, StepReport
from stark.arguments import added_later, given_path, real_number, refuse_copy
from stark.attributes import AnsweredAttributes
from stark.bodies import Body, Layer
from stark.bodies.floor_edges import FloorEdges
from stark.bodies.following import limit_of_turns
from stark.bodies.rest_state import LiveRestState, RestState
from stark.bodies.sensors import ClosestPoints, Contacts, FreePath, contacts_of, free_path_of
from stark.caller import warn
from stark.handle import Follower, placed_together
from stark.named import NamedList
from stark.overloads import overload
from stark.pictures import Pictures
from stark.rotations import vector
from stark.scene import Scene
from stark.settings import FixedSettings, Settings
from stark.steps import (
    LastStep,
    OnProgress,
    StepFailed,
    Stepping,
    Steps,
    TakenStep,
    limit_of_step,
    reached,
    require_callable,
)

if TYPE_CHECKING:
    from stark.attachments import Attachment
    from stark.formulas.handle import Energy
    from stark.joints.handle import Actuator, Joint
    from stark.robots.handle import Robot

AnyBody = TypeVar("AnyBody", bound=Body)

#: What motions and other functions of time must do.
_TIME_RULE = (
    "only return the value for a time; take steps, save, place and rewind between steps, not while one begins"
)

#: From one call of a progress callback to the next, and to the first [s].
PROGRESS_PERIOD = 0.25


class Simulation(Pictures, Stepping, AnsweredAttributes):
    """A scene being simulated.

    ``Simulation(scene, settings)`` or ``Simulation(scene, {"time.integrator": "bdf2"}, time_step=1/30)``:
    ``settings`` is a ``stark.Settings`` or values by dotted name, keyword arguments are settings by name, see
    ``stark.Settings``; both may be given, keywords win. The scene is copied: later changes to it do not reach
    the simulation. Initial intersections raise ``InitialIntersection``.

    Several simulations of one scene may live side by side. ``sim[body]``, ``sim.joints`` and the like are
    handles of one simulation; those that ``scene.add_*`` returned are of the newest one that is alive."""

    _scene: Scene
    _elsewhere: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(
            ("dt", "h", "timestep"), "sim.time_step; it is set by stark.Simulation(scene, time_step=...)"
        ),
        "t": "sim.time",
        "gravity": "sim.settings.gravity; it is set by stark.Simulation(scene, gravity=(0, 0, -9.81))",
        **dict.fromkeys(("simulate", "advance", "forward"), "sim.step(), or for step in sim.run(until=1.0)"),
        **dict.fromkeys(("render", "draw", "screenshot", "image"), "sim.picture('now.png')"),
        **dict.fromkeys(("viewer", "visualize"), "sim.view() to watch it live, sim.show() in notebooks"),
        **dict.fromkeys(
            ("record", "export", "save_video", "video"),
            "stark.recording.Recorder(folder, sim), then stark video, stark export or stark replay",
        ),
        "plot": "values of each step into a list, for matplotlib; the replay page plots recorded ones",
        **dict.fromkeys(
            ("energy", "energies_by_name", "kinetic_energy"), "report.energy of what sim.step() returns"
        ),
        **dict.fromkeys(("report", "last_report"), "what sim.step() and sim.run_until() return"),
        **dict.fromkeys(("positions", "velocities", "vertices"), "sim['cloth'].positions, of each body"),
        "body": "sim['name']",
        **dict.fromkeys(
            ("add_force", "add_cloth", "add_rigid", "add_box", "add_sphere", "add_solid", "add"),
            "it with the scene, before the simulation is made",
        ),
        **dict.fromkeys(("restore", "set_state", "rewind"), "sim.state = state, or sim.reset(state)"),
        "get_state": "sim.state",
    }
    _given_by: ClassVar[Mapping[str, str]] = {
        "time_step": "stark.Simulation(scene, time_step=...), or sim.step(max_time_step=...)",
        "time": "sim.reset(), or sim.state = ... for a state of another time",
        "settings": "stark.Simulation(scene, settings)",
        "threads": "stark.Simulation(scene, threads=...)",
    }

    def __init__(
        self, scene: Scene, settings: Settings | Mapping[str, Any] | None = None, **options: Any
    ) -> None:
        if not isinstance(scene, Scene):
            raise InvalidArgument(f"scene = {scene!r}: must be a stark.Scene")
        self._settings = settings.copy() if isinstance(settings, Settings) else Settings()
        if isinstance(settings, Mapping):
            self._settings.update(settings)
        elif settings is not None and not isinstance(settings, Settings):
            raise InvalidArgument(
                f"settings = {settings!r}: must be a stark.Settings, or values by dotted name: "
                f'{{"time.integrator": "bdf2"}}'
            )
        self._settings.update(options)
        self._settings.validate()
        if len(scene) == 0:
            raise InvalidArgument(
                f"scene '{scene.name}' has 0 bodies: must have at least one to simulate; "
                f"add one with scene.add_cloth, add_solid or add_rigid"
            )
        self._scene = scene
        for message in scene._start_warnings(self._settings):
            warn(message)
        self._core = _core.Simulation(scene._core, self._settings._core)
        for message in self._core.check_state():
            warn(message)
        # Of rows of targets: bodies of the scene may be pinned after this.
        self._pins = [scene._core.pins(k) for k in range(len(scene))]
        self._clamped = [scene._core.clamped(k) for k in range(len(scene))]
        scene._is_simulated_by(self)
        self._changes = scene._changes  # of the scene that it has
        self._known_bodies = len(scene._bodies)  # that it has, or has told that it has not
        self._looked_for_jumps = False
        self._energy_count = len(scene.energies)
        self._live_values = [energy._live_values() for energy in scene.energies]
        self._live_values += [
            LiveRestState(body) for body in scene.bodies if isinstance(body, RestState) and body._rest_values
        ]
        self._edges = FloorEdges(scene._sizeless_floors, scene._bodies, self._core)
        self._held: tuple[str, str, bool] | None = None
        self._is_asking = False  # functions of time for the targets of a step that begins
        self._loaded: LastStep | None = None
        self._taken: TakenStep | None = None
        # The scene may grow after this: the simulation is of what it is now.
        self._calls = [*scene._core.calls, ("default_friction", (scene.default_friction,))]

    def contact_distance(self, body: Body | str) -> float:
        """[m] Within which surfaces of the body repel others, together with theirs: its own, that of the
        settings, or (``contact.distance`` 0) 1 mm, but at most 1 % of the size of the body and half the least
        height of triangles that can touch their own body. Such heights, of which a warning tells where they
        are small, make it at most ten times smaller."""
        return self._scene._core.contact_distance_in(self[body]._index, self._settings._core)

    # --- stepping ---

    def step(self, *, max_time_step: float | None = None, progress: OnProgress | None = None) -> StepReport:
        """One time step. A step that fails is a value: look at ``report.status``. Ctrl-C stops it between
        iterations and leaves the state as it was. ``max_time_step`` [s] shortens this step, to end at a given
        time.

        ``progress(p)`` is called four times a second at most while the step is under way; ``p.iterations``,
        ``p.seconds``, ``p.residual`` and the other attributes say how far it has come. The simulation itself
        cannot be used before the step is over. What the callback raises ends the step as Ctrl-C does."""
        self._require_free("step()")
        require_callable(progress, "step")
        if max_time_step is None:
            return self._step(None, progress)
        limit = real_number(max_time_step, "step: max_time_step")
        if not limit > 0.0:
            raise InvalidArgument(f"step: max_time_step = {max_time_step} s: must be > 0")
        return self._step(limit, progress)

    def run(self, until: float, *, progress: OnProgress | None = None) -> Iterator[StepReport]:
        """Steps up to the time ``until`` [s] and yields the report of each; the last two are shortened to end
        there. ``progress`` is that of ``step``.

        A failed step is yielded as well; going on after it raises StepFailed. Steps are taken as the loop
        asks for them: without a loop there are none, and a StarkWarning says so."""
        require_callable(progress, "run")
        end = real_number(until, "run: until")
        if not end >= 0.0:  # also NaN
            raise InvalidArgument(f"run: until = {until} s: must be >= 0; it is a time, not a duration")
        if reached(self, end) and end < self.time * (1.0 - 1e-9):
            warn(
                f"run: until = {end:g} s has passed, the simulation is at {self.time:g} s: no step is "
                f"taken; until is a time, not a duration: for {end:g} s more write "
                f"run(until=sim.time + {end:g})"
            )
        return Steps(self._run(end, progress), end, is_due=not reached(self, end))

    def _run(self, until: float, progress: OnProgress | None) -> Iterator[StepReport]:
        while not reached(self, until):
            self._require_free("run()")
            report = self._step(limit_of_step(self, until), progress)
            yield report
            if report.failed:
                raise StepFailed(report)

    def _step(
        self, limit: float | None, progress: OnProgress | None, period: float | None = None
    ) -> StepReport:
        self._warn_of_late_changes()
        self._warn_of_jumps()
        if self._scene._followers or self._scene._courses:
            limit = self._follow_motions(limit)
        for values in self._live_values:
            values.push(self._core)
        before = self._core.state
        report = self._core.step(limit, progress, PROGRESS_PERIOD if period is None else period)
        pushed = [values.pushed() for values in self._live_values]
        self._loaded, self._taken = None, TakenStep(before, limit, report, pushed)
        self._edges.look(self._core)
        return report

    def _warn_of_late_changes(self) -> None:
        """Of what the scene has and this simulation has not; once, when the simulation goes on."""
        told = []
        if self._changes != self._scene._changes:
            self._changes = self._scene._changes
            told.append(f"{self._scene._last_change} was changed")
        if late := self._scene._bodies[self._known_bodies :]:
            self._known_bodies += len(late)
            told.append(f"{', '.join(repr(body.name) for body in late)} was added")
        for what in told:
            warn(
                f"scene '{self._scene.name}': {what} after the simulation was made and does not affect "
                f"it; do so before you make stark.Simulation(scene), or make a new simulation"
            )

    def _follow_motions(self, limit: float | None) -> float | None:
        """Targets and values of the coming step, from functions of the user: what these ask of the simulation
        would come in the middle of the step, with some targets set and others not. Returns its limit."""
        self._is_asking = True
        try:
            limit = limit_of_turns(self, self._followers(), self._asking, limit)
            duration, end = self._core.next_step(limit)
            for course in list(self._scene._courses.values()):
                with self._held_still(f"the function of time given to '{course.name}'", _TIME_RULE):
                    course.apply(self, end)
            for follower in self._followers():
                with self._asking(follower):
                    follower.apply(self, end, duration)
        finally:
            self._is_asking = False
        return limit

    def _asking(self, follower: Follower) -> AbstractContextManager[None]:
        return self._held_still(follower.title, _TIME_RULE)

    @contextmanager
    def _held_still(self, caller: str, remedy: str, *, may_place: bool = False) -> Iterator[None]:
        """While the function ``caller`` of the user runs: refuses steps and other states, which the
        recording of the run would not have; and placing, unless it ``may_place``."""
        self._held = caller, remedy, may_place
        try:
            yield
        finally:
            self._held = None

    def _require_free(self, what: str) -> None:
        if self._held is not None:
            caller, remedy, _ = self._held
            raise InvalidArgument(f"{caller} uses sim.{what} at {self.time:g} s: must {remedy}")

    def _to_place(self, what: str) -> _core.Simulation:
        if self._held is not None and not self._held[2]:
            self._require_free(f"bodies: {what} = ...")
        return self._core

    @contextmanager
    def placing(self) -> Iterator[None]:
        """Places bodies together: ``with sim.placing(): a.position = ...; b.position = ...``. What is
        assigned in the block holds at once, and is checked at its end instead of one by one: so bodies may
        change places, or move with what they are joined to. Where surfaces meet then, a joint does not hold,
        or the block raises, it raises, and everything is as it was before the block."""
        with placed_together(self._to_place("placing()")):
            yield

    def _warn_of_jumps(self) -> None:
        """Once, before the first step: motions and velocities that do not fit what follows or holds them."""
        if self._looked_for_jumps or self.time > 0.0:
            return
        self._looked_for_jumps = True
        for message in self._scene._uneven_starts(self._core, self._followers()):
            warn(message)

    def _followers(self) -> list[Follower]:
        """Of the bodies that this simulation has."""
        rows = sorted(self._scene._followers.items())
        return [f for body, followers in rows if body < self._core.body_count for f in followers]

    def run_until(
        self, until: float, stop: Callable[[], bool] | None = None, *, progress: OnProgress | None = None
    ) -> StepReport | None:
        """As ``run``, without a loop: returns the last report, None if there was nothing to do. ``stop()`` is
        asked after each step and ends the run when true."""
        if stop is not None and not callable(stop):
            raise InvalidArgument(f"run_until: stop = {stop!r}: must be a function without arguments")
        if stop is None and real_number(until, "run_until: until") == math.inf:
            raise InvalidArgument("run_until: until = inf s without stop=: would never end; give either")
        report = None
        for report in self.run(until, progress=progress):
            if stop is not None and not report.failed and stop():
                break
        return report

    @property
    def time(self) -> float:
        """Simulated time [s]: after n whole steps of length h exactly ``n * h``, rounded once."""
        return self._core.time

    @property
    def time_step(self) -> float:
        """Length of the next step [s]. It may come out shorter: what fails is halved, in parts that end where
        the whole step would have ended, and scripted bodies turn by a sixteenth of a turn in a step at
        most."""
        return self._core.time_step

    @property
    def threads(self) -> int:
        """Threads that it runs on: the setting ``execution.threads``, but no more than there are processors
        for this process."""
        return self._core.thread_count

    # --- state ---

    @property
    def state(self) -> State:
        """Everything that changes in time, as a value: ``before = sim.state``; ``sim.state = before`` rewinds
        bitwise."""
        return self._core.state

    @state.setter
    def state(self, state: State) -> None:
        self._require_free("state = ...")
        if not isinstance(state, _core.State):
            raise InvalidArgument(
                f"state = {state!r}: must be a state that sim.state of a simulation of this scene returned"
            )
        self._core.state = state
        self._loaded = self._taken = None

    def reset(self, state: State | None = None) -> None:
        """Goes back to the start: the state that the simulation was made with, bit for bit; or to ``state``,
        as ``sim.state = state`` does. Cheaper than a step, and far cheaper than another simulation. Live
        values of energies stay; sensors read nothing before the next step."""
        if state is not None:
            self.state = state
            return
        self._require_free("reset()")
        self._core.reset()
        self._loaded = self._taken = None

    def save(self, path: str | PathLike[str], *, memory: dict[str, Any] | None = None) -> None:
        """Writes where it is to a file, to go on from bit for bit: the state, the live values of energies,
        and ``memory``, what a controller remembers (numbers, texts, lists, dictionaries, arrays). The file is
        written whole or not at all. Raises ``stark.CheckpointError`` when it cannot be written."""
        from stark.checkpoint.value import Checkpoint

        if self._is_asking:
            self._require_free("save()")
        file = given_path(path, "save: path")
        Checkpoint.of(self, memory=memory).write(file)

    def load(self, path: str | PathLike[str], *, exact: bool = True) -> dict[str, Any]:
        """Goes on from a file that ``save`` wrote, of the same scene and settings; returns its ``memory``.

        The last step is taken again, so that contacts, reactions and other sensors read what they read.
        ``exact=False`` accepts other materials, values and settings. Values of energies become those of the
        file for all simulations of the scene. Raises ``stark.CheckpointError`` for files that are missing,
        damaged or of another scene, and leaves everything as it was."""
        from stark.checkpoint.value import Checkpoint

        file = given_path(path, "load: path")
        checkpoint = Checkpoint.read(file)
        checkpoint.put_into(self, exact=exact, owner=f"checkpoint '{file}'")
        return checkpoint.memory

    def write_reproducer(self, folder: str | PathLike[str], *, reduce: bool = False) -> Path:
        """Writes the step that was taken last, failed or not, as a folder that takes it again anywhere: the
        scene as data, the settings, the state before the step, and a script; returns the script. Formulas of
        the user's own are code and not in it; the script says which. ``reduce`` leaves out bodies that have
        no part in a failure, if the rest is found to fail for the same cause. Raises
        ``stark.ReproducerError`` when no step was taken since the simulation was made, loaded or rewound."""
        from stark.reproducer.writing import write

        return write(self, folder, reduce=reduce)

    @property
    def settings(self) -> Settings:
        """The settings it was made with, which stay as they are; ``sim.settings.copy()`` can be changed, for
        another simulation."""
        return FixedSettings._of(self._settings._core.copy())

    # --- bodies ---

    @property
    def scene(self) -> Scene:
        """The scene that is simulated."""
        return self._scene

    @property
    def bodies(self) -> NamedList[Body]:
        """Handles of all bodies, bound to this simulation, in the order of the scene."""
        return NamedList("body", self._scene._bodies[: self._core.body_count], self)

    @overload
    def __getitem__(self, body: AnyBody) -> AnyBody: ...

    @overload
    def __getitem__(self, body: str) -> Any: ...

    def __getitem__(self, body: Body | str) -> Any:
        """The handle of a body, bound to this simulation."""
        found = self._scene._bodies[self._scene._index(body)]
        if found._index >= self._core.body_count:
            raise added_later(f"'{found.name}'", f"sim['{found.name}']")
        return found._bound_to(self)

    @property
    def layers(self) -> NamedList[Layer]:
        """Handles of all skins and fibres, bound to this simulation, in the order of the scene."""
        counts = {"skin": self._core.skin_count, "fibres": self._core.fibres_count}
        known = (layer for layer in self._scene.layers if layer._index < counts[layer.kind])
        return NamedList("layer", known, self)

    @property
    def joints(self) -> NamedList[Joint]:
        """Handles of the joints of the scene, by number or name (``sim.joints["elbow"]``, and so with what
        follows here); their coordinates and reactions are those of this simulation."""
        return NamedList("joint", self._scene._joints[: self._core.joint_count], self)

    @property
    def actuators(self) -> NamedList[Actuator]:
        """Handles of the actuators of the scene; their values and efforts are those of this simulation."""
        return NamedList("actuator", self._scene._actuators[: self._core.actuator_count], self)

    @property
    def robots(self) -> NamedList[Robot]:
        """Handles of the robots of the scene; their coordinates and efforts are those of this simulation."""
        return NamedList("robot", (robot for robot in self._scene.robots if robot._is_in(self)), self)

    @property
    def attachments(self) -> NamedList[Attachment]:
        """Handles of the attachments of the scene; their forces are those of this simulation."""
        return NamedList("attachment", self._scene._attachments[: self._core.attachment_count], self)

    @property
    def energies(self) -> NamedList[Energy]:
        """Handles of the energies of the scene; their energies and forces are those of this simulation."""
        known = self._live_values[: self._energy_count]
        return NamedList("energy", (live.energy for live in known), self)

    @property
    def contacts(self) -> Contacts:
        """All contacts of the last step: points, forces, slip. ``sim.contacts.of("cup", "finger")`` are those
        of two bodies; ``sim["cup"].contact_force`` and its siblings sum them up."""
        return contacts_of(self)

    def distance(self, a: Body | str, b: Body | str) -> float:
        """Distance of the surfaces of two bodies as they are now [m], of rods that of their centre lines; 0
        where they intersect. Contact between them may be disabled."""
        return self.closest_points(a, b).distance

    def closest_points(self, a: Body | str, b: Body | str) -> ClosestPoints:
        """Where two bodies are nearest to each other: ``distance`` [m], ``point_a`` and ``point_b`` (3,) [m],
        as ``distance(a, b)`` has it."""
        return ClosestPoints(*_core.closest_points(self._core, self[a]._index, self[b]._index))

    def free_path(self, body: Body | str, displacement: ArrayLike) -> FreePath:
        """How far a body can be moved along ``displacement`` (3,) [m], without turning, before its surface
        meets another one, all others where they are now: ``fraction`` of the displacement that is certainly
        free, at most a millionth below the true one, and the name of the body that is ``blocking``, None
        where nothing is. Bodies whose contact is disabled count; of rods it is the centre line."""
        return free_path_of(self, self[body]._index, vector(displacement, "free_path: displacement"))

    @property
    def close_bodies(self) -> dict[tuple[str, str], float]:
        """Bodies that started within their contact distance, by name, with the smaller one [m] that they
        have until they part: the smallest gap that there was between them (docs/surfaces.md)."""
        bodies = self._scene.bodies
        return {(bodies[a].name, bodies[b].name): d for a, b, d in self._core.close_bodies()}

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        refuse_copy(
            "a simulation",
            "make another one of the same scene and assign its state (sim.state), or use sim.save(path) and "
            "sim.load(path)",
        )

    def __repr__(self) -> str:
        return f"<stark.Simulation of '{self._scene.name}' at {self.time:g} s>"


Simulation._again = Scene, Simulation
