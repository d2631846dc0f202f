"""Replay pages in notebooks: the page itself inside a cell, nothing is fetched."""

from __future__ import annotations

import html
from os import PathLike

from ..arguments import given_path
from ..array_file import write_atomically
from ..recording import Recording
from ..recording.reader import given_recording
from .encode import encode
from .page import assemble


def show(recording: Recording, *, height: int = 480, max_megabytes: float = 20.0) -> InlinePage:
    """The replay page of a recording for a notebook, ``height`` pixels tall; frames are left out where it
    would be larger than about ``max_megabytes``. Raises RecordingError for a recording without frames."""
    given_recording(recording, "show")
    page = assemble(encode(recording, max_megabytes=max_megabytes), recording.telemetry)
    return InlinePage(page, height, f"{len(recording)} frames of '{recording.folder}'")


class InlinePage:
    """A replay page that notebooks show. ``html`` is the page."""

    def __init__(self, page: str, height: int, what: str) -> None:
        self.html: str = page
        self.height: int = height  #: [px]
        self._what = what

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the page as a file that any browser opens."""
        target = given_path(path, "save: path")
        write_atomically(target, lambda file: file.write(self.html.encode("utf-8")))

    def _repr_html_(self) -> str:
        page = html.escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" width="100%" height="{self.height}" style="border: 0"></iframe>'

    def __repr__(self) -> str:
        return f"<replay page of {self._what}: notebooks show it, .save(path) writes it>"
