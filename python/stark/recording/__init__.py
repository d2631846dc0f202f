"""Recordings: a run folder with the motion of every surface and the telemetry of every step.

Layout of a run folder (format version 1)::

    manifest.json              what was run: scene, settings, bodies, units, status, frame count
    telemetry.jsonl            one JSON object a time step
    frames/topology.npz        triangles of every body, once
    frames/chunk_000000.npz    times (k,) float64 [s] and positions (k, n, 3) float32 [m] of k frames

A recording for certification (``stark run --certify``) has every accepted step in double precision as well,
in ``states/``: see ``stark.recording.states``. Fields and contacts that were asked for are in ``fields/``:
see ``stark.recording.fields``.

Every file but the telemetry is written beside its final name and moved into place, so a killed run never
leaves a half-written file: it only lacks the frames of its last chunk.
"""

from .export import export
from .fields import Contacts, FieldEntry
from .format import FORMAT_NAME, FORMAT_VERSION, BodyEntry, Frame, FrameBody, RecordingError
from .reader import Recording
from .writer import Recorder

__all__ = [
    "FORMAT_NAME",
    "FORMAT_VERSION",
    "BodyEntry",
    "Contacts",
    "FieldEntry",
    "Frame",
    "FrameBody",
    "Recorder",
    "Recording",
    "RecordingError",
    "export",
]
