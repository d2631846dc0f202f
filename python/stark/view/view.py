"""``sim.view()``: a page in a browser that shows a simulation and takes commands between its steps.

The server has threads of its own, which only put commands into a queue. The thread that takes the steps
empties it between two steps and draws: the simulation is never used by two threads, and what it computes does
not depend on who looks."""

from __future__ import annotations

import queue
import time as clock
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from stark._core import Error, InvalidArgument, StepReport, __version__
from stark.arguments import given_flag, given_path, real_number, shown_value
from stark.array_file import naming
from stark.attributes import AnsweredAttributes
from stark.files import plain_name
from stark.recording import Recorder
from stark.render.fields import FIELDS
from stark.steps import limit_of_step, reached

from .live import add_live_controls
from .panel import Actions, Panel
from .pulls import pulls_of
from .server import address, close_server, open_server
from .stage import Stage

#: From one drawing to the next, and with a field, whose meshes browsers make anew [s].
_PERIOD, _PERIOD_OF_FIELDS = 1.0 / 20.0, 1.0 / 8.0
#: For which a paused view waits at a time [s].
_IDLE = 0.05


class View(AnsweredAttributes):
    """A page that shows a simulation. ``sim.view()`` opens it, ``close()`` or the end of a ``with`` block
    closes it. ``run()`` takes the steps; programs that take their own call ``update()`` after each."""

    def __init__(
        self,
        sim: Any,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        paused: bool = False,
        field: str | None = None,
        contacts: bool = False,
        record_to: str | PathLike[str] = "out/view",
        drive: Callable[[Any], object] | None = None,
    ) -> None:
        if not hasattr(sim, "time") or isinstance(sim, type):
            raise InvalidArgument(f"view: sim = {shown_value(sim)}: must be a stark.Simulation")
        if field is not None and not (isinstance(field, str) and field in FIELDS):
            raise InvalidArgument(f"view: field = {field!r}: must be one of {', '.join(FIELDS)}, or None")
        if drive is not None and not callable(drive):
            raise InvalidArgument(f"view: drive = {drive!r}: must be a function of the simulation, or None")
        self._sim, self._drive = sim, drive
        self._paused, self._single = given_flag(paused, "view: paused"), False
        self._record_to = given_path(record_to, "view: record_to")
        self._recorder: Recorder | None = None
        self._commands: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._report: Any = None
        self._wall, self._drawn, self._strength, self._message = 0.0, -np.inf, 1.0, ""
        self._pace, self._pace_from = True, (clock.perf_counter(), float(sim.time))
        self._pulls = pulls_of(sim)
        contacts = given_flag(contacts, "view: contacts")
        self._server: Any = open_server(host, port, f"Stark: {sim.scene.name}")
        try:
            self._stage = Stage(self._server, sim, self._pulls, self._dragged)
            self._stage.field, self._stage.contacts = field, contacts
            self._panel = Panel(
                self._server.gui,
                self._actions(),
                can_pull=self._pulls is not None,
                field=field,
                contacts=contacts,
            )
            hidden = set() if self._pulls is None else {e._index for e in self._pulls.energies}
            with self._server.gui.add_folder("Live values", expand_by_default=bool(sim.robots)):
                if add_live_controls(self._server.gui, sim, self._later_asked, hidden) == 0:
                    self._server.gui.add_markdown("The scene has none.")
            self._server.on_client_connect(lambda client: self._later(self.draw))
            self.draw()
        except BaseException:
            self.close()
            raise

    # --- the page ---

    @property
    def url(self) -> str:
        """Address of the page."""
        self._require_open("url")
        return address(self._server)

    def __repr__(self) -> str:
        place = f"at {self.url}" if self.is_open else "closed"
        return f"<stark.view.View of {self._sim.scene.name!r}, {place}>"

    @property
    def paused(self) -> bool:
        """Whether ``run()`` and ``update()`` wait; may be assigned."""
        return self._paused

    @paused.setter
    def paused(self, value: bool) -> None:
        self._paused = given_flag(value, "view: paused")
        self._pace_from = clock.perf_counter(), float(self._sim.time)

    @property
    def is_open(self) -> bool:
        """Whether the page is there: not after ``close()``."""
        return self._server is not None

    def close(self) -> None:
        """Ends a recording, lets go of what is pulled, closes the page and ends the threads of its server.
        The simulation stays as it is."""
        server, self._server = self._server, None
        if server is None:
            return
        try:
            self._end_recording()
            if self._pulls is not None:
                self._pulls.let_go()
        finally:
            close_server(server)

    def __enter__(self) -> View:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # --- stepping ---

    def run(self, until: float | None = None, *, stay: bool = True) -> Any:
        """Takes steps, as the page asks for them, up to the time ``until`` [s] (None: without end). There it
        pauses, and the page stays until Ctrl-C; with ``stay`` False it returns the last report. A step that
        fails pauses it, too, and the page says why: Reset goes on."""
        end = np.inf if until is None else real_number(until, "view: until")
        if not end >= 0.0:
            raise InvalidArgument(f"view: until = {until} s: must be >= 0; it is a time, not a duration")
        stay = given_flag(stay, "view: stay")
        self._require_open("run()")
        while self.is_open:
            self._take_commands()
            if not self.is_open:
                break
            if (over := reached(self._sim, end)) and not stay:
                break
            if over and not self._paused:
                self.paused, self._message = True, "the end is reached"
            if (self._paused and not self._single) or over:
                self._single = False
                self._wait()
            else:
                self._single = False
                self._step(None if end == np.inf else limit_of_step(self._sim, end))
                self._keep_pace()
        if self.is_open:
            self.draw()
        return self._report

    def update(self, report: Any = None) -> None:
        """For programs that take their own steps: shows where the simulation is now, does what the page asks
        for, and waits while it is paused. ``report`` is that of the step, for the plots."""
        self._require_open("update()")
        if report is not None and not isinstance(report, StepReport):
            raise InvalidArgument(
                f"view: report = {report!r}: must be the stark.StepReport that sim.step() returned, or None"
            )
        if report is not None:
            self._take_report(report)
        self._take_commands()
        self._draw_sometimes()
        while self._paused and not self._single and self.is_open:
            self._wait()
        self._single = False

    def _step(self, limit: float | None) -> None:
        if self._drive is not None:
            self._drive(self._sim)
        before = clock.perf_counter()
        report = self._sim.step(max_time_step=limit)
        self._wall = clock.perf_counter() - before
        self._take_report(report)
        if report.failed:
            self.paused, self._message = True, f"the step failed: {report.message}"
        self._draw_sometimes()

    def _take_report(self, report: Any) -> None:
        self._report = report
        self._panel.add(report)
        if self._recorder is not None and report.time < self._recorder.last_time:
            self._message = f"the simulation went back in time; recorded in {self._recorder.folder}"
            self._end_recording()
        if self._recorder is not None:
            self._record(self._recorder, report)

    def _record(self, recorder: Recorder, report: Any) -> None:
        """A full disk ends the recording, not the simulation."""
        try:
            recorder.report(report)
            if not report.failed:
                recorder.record(self._sim)
        except OSError as error:
            self._message, self._recorder = f"the recording has ended: {error}", None
            self._panel.show_recording(False)
            with suppress(OSError):
                recorder.close("failed", str(error))

    def _take_commands(self) -> None:
        while True:
            try:
                command = self._commands.get_nowait()
            except queue.Empty:
                return
            self._do(command)

    def _wait(self) -> None:
        """For a command, or a moment."""
        try:
            command = self._commands.get(timeout=_IDLE)
        except queue.Empty:
            return
        self._do(command)
        self._take_commands()
        if self.is_open:
            self.draw()

    def _keep_pace(self) -> None:
        """Waits until as much wall-clock time has passed as the simulation has simulated."""
        began, time = self._pace_from
        ahead = (self._sim.time - time) - (clock.perf_counter() - began)
        if not self._pace or ahead < 0.0:  # what is late is not made up for
            self._pace_from = clock.perf_counter(), float(self._sim.time)
        while self._pace and ahead > 0.0 and self.is_open and self._commands.empty():
            clock.sleep(min(ahead, 0.02))
            ahead = (self._sim.time - time) - (clock.perf_counter() - began)

    def _do(self, command: Callable[[], object]) -> None:
        """What the page asks for may be refused; the page says why."""
        try:
            command()
        except (Error, ImportError, OSError) as error:
            self._message = str(error)

    def _later(self, command: Callable[[], object]) -> None:
        self._commands.put(command)

    def _later_asked(self, command: Callable[[], object]) -> None:
        """What somebody asks for on the page."""
        self._later(partial(self._answer, command))

    def _require_open(self, what: str) -> None:
        if not self.is_open:
            raise InvalidArgument(f"view: {what} after close(): must be open; sim.view() opens another one")

    # --- drawing ---

    def draw(self) -> None:
        """Brings the page up to date now."""
        self._require_open("draw()")
        self._drawn = clock.perf_counter()
        try:
            bar = self._stage.draw()
        except InvalidArgument as error:  # a field that a law of the user does not have
            self._stage.field, self._message = None, str(error)
            bar = self._stage.draw()
        self._panel.show_field(self._stage.field)
        self._panel.show_bar(bar)
        self._tell()
        self._panel.plot(at_once=self._paused)

    def _draw_sometimes(self) -> None:
        """Nobody looks, nothing is drawn: a browser that comes asks for it."""
        period = _PERIOD if self._stage.field is None else _PERIOD_OF_FIELDS
        due = clock.perf_counter() - self._drawn >= period
        if due and self.is_open and self._server.get_clients():
            self.draw()

    def _tell(self) -> None:
        self._panel.tell(
            self._sim, paused=self._paused, report=self._report, wall=self._wall, message=self._message
        )

    # --- what the page asks for ---

    def _actions(self) -> Actions:
        def later(method: Callable[..., object]) -> Callable[..., None]:
            return lambda *values: self._later(partial(self._answer, method, *values))

        return Actions(
            pause=later(self._toggle), step=later(self._one), reset=later(self._reset),
            record=later(self._toggle_recording), picture=later(self._picture),
            field=later(self._show_field), contacts=later(self._show_contacts),
            pace=later(self._set_pace), stiffness=later(self._set_strength),
        )  # fmt: skip

    def _answer(self, method: Callable[..., object], *values: object) -> None:
        """What the page was told before is over when somebody asks for something."""
        self._message = ""
        method(*values)

    def _toggle(self) -> None:
        self.paused = not self._paused

    def _one(self) -> None:
        self.paused, self._single = True, True

    def _reset(self) -> None:
        if self._recorder is not None:  # times of a recording do not go back
            self._message = f"recorded in {self._recorder.folder}"
            self._end_recording()
        if self._pulls is not None:
            self._pulls.let_go()
        self._sim.reset()
        self._report = None
        self._panel.forget()
        self._stage.forget_limits()
        self._pace_from = clock.perf_counter(), float(self._sim.time)
        self.draw()

    def _show_field(self, field: str | None) -> None:
        self._stage.field = field
        self._stage.forget_limits()
        self.draw()

    def _show_contacts(self, on: bool) -> None:
        self._stage.contacts = on
        self.draw()

    def _set_pace(self, on: bool) -> None:
        self._pace, self._pace_from = on, (clock.perf_counter(), float(self._sim.time))

    def _set_strength(self, factor: float) -> None:
        self._strength = factor

    def _dragged(self, body: str, phase: str, start: Any, end: Any) -> None:
        """Called by a thread of the server."""
        self._later(partial(self._pull, body, phase, start, end))

    def _pull(self, body: str, phase: str, start: Any, end: Any) -> None:
        assert self._pulls is not None
        if phase == "end":
            self._pulls.let_go()
            return
        if phase == "start":
            self._pulls.hold(body, start, stiffness=self._strength * self._pulls.default_stiffness(body))
        if self._pulls.held is not None:
            self._pulls.move(end)

    def _toggle_recording(self) -> None:
        if self._recorder is not None:
            folder = self._recorder.folder
            self._message = f"recorded in {folder}"
            self._end_recording()
            return
        folder = _free(self._record_to, "")
        self._recorder = Recorder(folder, self._sim, scene=self._sim.scene.name, stark_version=__version__)
        self._recorder.record(self._sim)
        self._panel.show_recording(True)
        self._message = f"recording to {folder}"

    def _end_recording(self) -> None:
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        if self.is_open:
            self._panel.show_recording(False)
        try:
            recorder.close("complete")
        except OSError as error:
            if not self.is_open:  # no page is left to say it
                raise
            self._message = f"the recording has ended: {error}"

    def _picture(self) -> None:
        folder = self._record_to.parent
        with naming(folder):
            folder.mkdir(parents=True, exist_ok=True)
        path = _free(folder / plain_name(self._sim.scene.name, "scene"), ".png")
        self._sim.picture(path, field=self._stage.field, contacts=self._stage.contacts)
        self._message = f"picture in {path}"


def _free(path: Path, suffix: str) -> Path:
    """A name that nothing has: path, path-2, path-3."""
    names = (path.with_name(f"{path.name}{'' if k == 1 else f'-{k}'}{suffix}") for k in range(1, 1_000_000))
    return next(name for name in names if not name.exists())
