"""Buttons, numbers and plots of a view. What they do is done by the thread that takes the steps."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stark.render.fields import FIELDS

#: Points of a plot; older ones are left out.
_LONGEST = 2000
#: From one drawing of the plots to the next [s].
_PERIOD = 0.3
_NO_FIELD = "none"
_ENERGIES = ("kinetic", "elastic", "gravity", "contact")


class Actions(NamedTuple):
    """What buttons call, from threads of the server."""

    pause: Callable[[], None]
    step: Callable[[], None]
    reset: Callable[[], None]
    record: Callable[[], None]
    picture: Callable[[], None]
    field: Callable[[str | None], None]
    contacts: Callable[[bool], None]
    pace: Callable[[bool], None]
    stiffness: Callable[[float], None]


class Panel:
    """The panel beside the bodies. Its methods are called by the thread that takes the steps."""

    def __init__(
        self, gui: Any, actions: Actions, *, can_pull: bool, field: str | None, contacts: bool
    ) -> None:
        self._gui, self._rows = gui, []
        self._drawn = -_PERIOD
        self._plots: dict[str, Any] = {}
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        self._status = gui.add_markdown("")
        self._pause = gui.add_button("Pause")
        self._pause.on_click(lambda event: actions.pause())
        gui.add_button("Step").on_click(lambda event: actions.step())
        gui.add_button("Reset").on_click(lambda event: actions.reset())
        self._pace = gui.add_checkbox("Not faster than real time", initial_value=True)
        self._pace.on_update(lambda event: actions.pace(bool(self._pace.value)))
        self._add_looks(actions, field, contacts)
        self._add_pull(actions, can_pull)
        with gui.add_folder("Keep", expand_by_default=False):
            self._record = gui.add_button("Record")
            self._record.on_click(lambda event: actions.record())
            gui.add_button("Picture").on_click(lambda event: actions.picture())
        self._add_plots()

    _rows: list[list[float]]

    def _add_looks(self, actions: Actions, field: str | None, contacts: bool) -> None:
        with self._gui.add_folder("Show"):
            self._field = self._gui.add_dropdown(
                "Field", (_NO_FIELD, *FIELDS), initial_value=_NO_FIELD if field is None else field
            )
            self._field.on_update(
                lambda event: actions.field(None if self._field.value == _NO_FIELD else self._field.value)
            )
            blank = np.full((2, 2, 3), 255, dtype=np.uint8)
            self._bar = self._gui.add_image(blank, label=None, format="png", visible=False)
            self._contacts = self._gui.add_checkbox("Contact forces", initial_value=contacts)
            self._contacts.on_update(lambda event: actions.contacts(bool(self._contacts.value)))

    def _add_pull(self, actions: Actions, can_pull: bool) -> None:
        with self._gui.add_folder("Pull", expand_by_default=can_pull):
            if not can_pull:
                self._gui.add_markdown("To pull bodies: `stark.view.add_pulls(scene)` before the simulation.")
                return
            self._gui.add_markdown("Drag a body.")
            self._factor = self._gui.add_slider(
                "Strength", min=0.1, max=10.0, step=0.1, initial_value=1.0,
                hint="1: the weight of the body stretches the spring by a tenth of its size",
            )  # fmt: skip
            self._factor.on_update(lambda event: actions.stiffness(float(self._factor.value)))

    def _add_plots(self) -> None:
        with self._gui.add_folder("Plots"):
            self._add_plot("Energy [J]", _ENERGIES)
            self._add_plot("Newton iterations", ("iterations",))
            self._add_plot("Contacts", ("contacts",))

    def _add_plot(self, title: str, names: tuple[str, ...]) -> None:
        strokes = ("#0b67a3", "#c0392b", "#2e8b57", "#8e5ea2")
        series = [{"label": "t [s]"}]
        series += [{"label": name, "stroke": stroke} for name, stroke in zip(names, strokes, strict=False)]
        none = tuple(np.zeros(1) for _ in series)
        self._plots[title] = self._gui.add_uplot(
            none,
            tuple(series),
            title=title,
            height=170,
            scales={"x": {"time": False}},
            axes=({}, {"size": 70}),
        )

    # --- what is told ---

    def tell(self, sim: Any, *, paused: bool, report: Any, wall: float, message: str) -> None:
        """Time, state and cost of the last step."""
        state = "paused" if paused else "running"
        lines = [f"**{sim.time:.3f} s**, {state}"]
        if report is not None:
            lines.append(
                f"step {report.step}: {report.newton_iterations} iterations, "
                f"{report.contact_count} contacts, {1000.0 * wall:.0f} ms"
            )
        if message:
            lines.append(f"*{message}*")
        text = "  \n".join(lines)
        if text != self._status.content:
            self._status.content = text
        if self._pause.label != (label := "Continue" if paused else "Pause"):
            self._pause.label = label

    def add(self, report: Any) -> None:
        """The measures of a step, for the plots."""
        energies = [float(report.energy[name]) for name in _ENERGIES]
        numbers = [float(report.newton_iterations), float(report.contact_count)]
        self._rows.append([float(report.time), *energies, *numbers])
        del self._rows[:-_LONGEST]

    def forget(self) -> None:
        """Begins the plots anew."""
        self._rows.clear()
        self._drawn = -_PERIOD

    def plot(self, *, at_once: bool = False) -> None:
        """Draws the plots, a few times a second at most."""
        now = clock.perf_counter()
        if not self._rows or (now - self._drawn < _PERIOD and not at_once):
            return
        self._drawn = now
        times, *columns = np.array(self._rows).T
        count = len(_ENERGIES)
        rows = (columns[:count], columns[count : count + 1], columns[count + 1 :])
        for plot, values in zip(self._plots.values(), rows, strict=True):
            plot.data = (times, *values)

    def show_bar(self, bar: Any) -> None:
        """The scale of colours (h, w, 3) uint8, or None."""
        if bar is None:
            if self._bar.visible:
                self._bar.visible = False
            return
        if self._bar.image.shape != bar.shape or not np.array_equal(self._bar.image, bar):
            self._bar.image = bar
        if not self._bar.visible:
            self._bar.visible = True

    def show_field(self, field: str | None) -> None:
        """What the choice of the field says."""
        word = _NO_FIELD if field is None else field
        if self._field.value != word:
            self._field.value = word

    def show_recording(self, on: bool) -> None:
        """What the button of recordings says."""
        self._record.label = "End the recording" if on else "Record"
