"""``study.html``: one page of a study with all in it: plots of all runs, a table that can be sorted, and
pictures of the last frames, links to the replays. It opens from disk and makes no network request."""

from __future__ import annotations

import base64
import html
import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from .._core import Error
from ..array_file import write_atomically
from ..files import printable
from ..recording import Recording
from ..recording.format import PAGE
from .table import Row, columns

#: Runs with a row, and those of them with a picture and lines in the plots.
MOST_ROWS, MOST_PICTURES = 5000, 500

#: Points of a line in a plot.
_POINTS = 300
_THUMBNAIL = (256, 144)  # pixels, shown at half the size


@dataclass
class _Runs:
    """What the recordings of the runs give to the page, by number of the run."""

    thumbnails: dict[int, str] = field(default_factory=dict)
    replays: dict[int, str] = field(default_factory=dict)
    lines: dict[str, list[dict[str, Any]]] = field(default_factory=dict)


def write_page(
    path: Path, title: str, rows: Sequence[Row], folder_of: Callable[[str], Path], replays: bool
) -> None:
    """Writes the page; ``folder_of(key)`` is the folder of a run. With ``replays`` the replay pages that are
    missing are written, too."""
    rows = list(rows)[:MOST_ROWS]
    runs = _Runs()
    for number, row in enumerate(rows[:MOST_PICTURES]):
        _add(runs, number, folder_of(str(row["key"])), path.parent, replays)
    text = _assemble(title, _data(rows, runs))
    write_atomically(path, lambda file: file.write(text.encode("utf-8")))


def _add(runs: _Runs, number: int, folder: Path, base: Path, replays: bool) -> None:
    """A run that has no recording, or one that is damaged, has a row only."""
    if folder.is_symlink() or folder.parent.is_symlink():
        return
    try:
        recording = Recording(folder)
        if len(recording):
            runs.thumbnails[number] = _thumbnail(recording)
        telemetry = recording.telemetry
        for name in telemetry.names:
            if name.startswith("measured.") and len(telemetry) > 1:
                line = _line(telemetry["time"], telemetry[name])
                runs.lines.setdefault(name.partition(".")[2], []).append({"run": number, **line})
        if replays and not (folder / PAGE).is_file() and len(recording):
            from ..replay import write_page as write_replay

            write_replay(recording)
        if (folder / PAGE).is_file():
            runs.replays[number] = quote(os.path.relpath(folder / PAGE, base))
    except (Error, ValueError):
        return


def _thumbnail(recording: Recording) -> str:
    """A picture of the last frame as an address."""
    from ..render import render
    from ..render.png import png_bytes

    picture = render(recording.frame(-1), *_THUMBNAIL)
    return "data:image/png;base64," + base64.b64encode(png_bytes(picture)).decode()


def _line(times: np.ndarray, values: np.ndarray) -> dict[str, list[float | None]]:
    """A series with few enough points for a plot: evenly thinned, ends kept."""
    chosen = np.unique(np.linspace(0, len(times) - 1, min(_POINTS, len(times))).round().astype(int))
    return {"x": [_plain(float(t)) for t in times[chosen]], "y": [_plain(float(v)) for v in values[chosen]]}


def _plain(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return printable(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _data(rows: Sequence[Row], runs: _Runs) -> dict[str, Any]:
    """What the script of the page reads."""
    hidden = {"key", "cost.host"} | (set() if any(row["repetition"] for row in rows) else {"repetition"})
    names = [name for name in columns(rows) if name not in hidden]
    names.sort(key=lambda name: name == "message")  # the longest comes last
    statuses = [str(row["status"]) for row in rows]
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    limits = [f"The table shows the first {MOST_ROWS} runs."] if len(rows) == MOST_ROWS else []
    if len(rows) > MOST_PICTURES:
        limits.append(f"Pictures and lines are of the first {MOST_PICTURES} runs.")
    return {
        "summary": ", ".join(f"{count} {status}" for status, count in counts.items()),
        "limits": " ".join(limits),
        "columns": [printable(name) for name in names],
        "rows": [[_cell(row.get(name)) for name in names] for row in rows],
        "labels": [_label(row) for row in rows],
        "thumbnails": runs.thumbnails,
        "replays": runs.replays,
        "plots": [{"title": printable(name), "lines": lines} for name, lines in runs.lines.items()],
    }


def _label(row: Row) -> str:
    chosen = [
        f"{name.partition('.')[2]} = {value}" for name, value in row.items() if name.startswith("option.")
    ]
    return printable(f"run {row['run']}: {', '.join(chosen)}")


def _assemble(title: str, data: dict[str, Any]) -> str:
    sources = resources.files(__package__)
    encoded = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    values = {
        "title": html.escape(printable(title)),
        "style": sources.joinpath("page.css").read_text(encoding="utf-8"),
        "data": encoded,
        "script": sources.joinpath("page.js").read_text(encoding="utf-8"),
    }
    first, *rest = sources.joinpath("page.html").read_text(encoding="utf-8").split("{{")
    parts = [part.partition("}}") for part in rest]
    return first + "".join(values[name] + after for name, _, after in parts)
