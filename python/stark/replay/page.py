"""Assembles ``replay.html`` from the viewer's source files and an encoded recording."""

from __future__ import annotations

import base64
import html
import json
import math
from collections.abc import Sequence
from importlib import resources
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import given_path
from ..array_file import write_atomically
from ..files import printable
from ..recording import Recording
from ..recording.format import PAGE
from ..recording.reader import given_recording
from ..render.colormaps import COLORMAPS, Colormap
from ..telemetry import Telemetry
from .encode import EncodedReplay, encode

_SCRIPTS = (
    "decode.js", "shaders.js", "draw.js", "caps.js", "pick.js", "marks.js", "plots.js",
    "panel.js", "viewer.js",
)  # fmt: skip

#: Plots of the page: title, unit, series, scale. A plot without data is left out.
_PLOTS: tuple[tuple[str, str, str, tuple[tuple[str, str], ...]], ...] = (
    ("Newton iterations", "", "linear", (("newton_iterations", "iterations"),)),
    ("Contacts", "", "linear", (("contact_count", "contacts"),)),
    ("Smallest distance", "m", "log", (("min_distance", "distance"),)),
    ("Residual", "N", "log", (("residual", "residual"),)),
    ("Energy", "J", "linear", ()),
    ("Wall time per step", "s", "linear", (("wall", "wall"),)),
)


def _number(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None


def plots(telemetry: Telemetry) -> dict[str, Any]:
    """The plots of the page: time of each step [s] and the series with their units."""
    if not len(telemetry) or "time" not in telemetry:
        return {"time": [], "plots": []}
    names = telemetry.names
    energies = [
        (name, name.split(".", 1)[1].replace("_", " ")) for name in names if name.startswith("energy.")
    ]
    charts = []
    for title, unit, scale, series in _PLOTS:
        wanted = energies if title == "Energy" else [entry for entry in series if entry[0] in names]
        columns = _columns(telemetry, wanted)
        if title == "Energy":
            columns = [(label, values) for label, values in columns if np.any(np.nan_to_num(values) != 0.0)]
        charts += _chart(title, unit, scale, columns)
    for name in names:  # what the scene measures: each has a unit of its own
        if name.startswith("measured."):
            charts += _chart(name.split(".", 1)[1], "", "linear", _columns(telemetry, [(name, "measured")]))
    return {"time": [_number(t) for t in telemetry["time"]], "plots": charts}


def _columns(telemetry: Telemetry, wanted: Sequence[tuple[str, str]]) -> list[tuple[str, np.ndarray]]:
    """Series with at least one finite number, by label."""
    columns = [(label, telemetry[name]) for name, label in wanted]
    return [(label, values) for label, values in columns if np.any(np.isfinite(values))]


def _chart(
    title: str, unit: str, scale: str, columns: Sequence[tuple[str, np.ndarray]]
) -> list[dict[str, Any]]:
    if not columns:
        return []
    lines = [{"label": label, "values": [_number(v) for v in values]} for label, values in columns]
    return [{"title": title, "unit": unit, "scale": scale, "series": lines}]


def _overlaid(other: Recording) -> dict[str, Any]:
    """The numbers of another run, for the plots."""
    name = printable(other.folder.name) or "other run"
    return {"name": name, **plots(other.telemetry)}


def _script_json(value: Any) -> str:
    """JSON that is safe inside a script element, whatever the names of bodies are."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def assemble(replay: EncodedReplay, telemetry: Telemetry, overlay: Recording | None = None) -> str:
    """The page as text. ``overlay``: another run, whose numbers the plots show, too."""
    sources = resources.files(__package__)
    template = sources.joinpath("viewer.html").read_text(encoding="utf-8")
    blocks = "\n".join(
        f'<script type="application/octet-stream" class="block">{base64.b64encode(block).decode()}</script>'
        for block in replay.blocks
    )
    header = {
        **replay.header,
        "telemetry": plots(telemetry),
        "overlay": None if overlay is None else _overlaid(overlay),
        "colormaps": {name: Colormap(name).points.round(4).tolist() for name in COLORMAPS},
    }
    values = {
        "title": html.escape(printable(replay.header["scene"]) or "Stark replay"),
        "style": sources.joinpath("viewer.css").read_text(encoding="utf-8"),
        "header": _script_json(header),
        "blocks": blocks,
        "script": "\n".join(sources.joinpath(name).read_text(encoding="utf-8") for name in _SCRIPTS),
    }
    parts = template.split("{{")
    text = [parts[0]]
    for part in parts[1:]:
        name, rest = part.split("}}", 1)
        text += [values[name], rest]
    return "".join(text)


def write_page(
    recording: Recording,
    path: str | PathLike[str] | None = None,
    *,
    stride: int | None = None,
    max_megabytes: float = 60.0,
    overlay: Recording | None = None,
) -> Path:
    """Writes ``replay.html`` beside the recording (or to ``path``) and returns where it lies.

    ``stride`` keeps every so-many-th frame; when not given, it is chosen so that the page stays below about
    ``max_megabytes`` megabytes. ``overlay``: another run, whose numbers the plots show as dashed lines.
    """
    given_recording(recording, "write_page")
    if overlay is not None:
        given_recording(overlay, "write_page: overlay")
    target = recording.folder / PAGE if path is None else given_path(path, "write_page: path")
    page = assemble(
        encode(recording, stride=stride, max_megabytes=max_megabytes), recording.telemetry, overlay
    )
    write_atomically(target, lambda file: file.write(page.encode("utf-8")))
    return target
