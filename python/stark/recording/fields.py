"""Fields and contacts beside the frames of a recording, for those that were asked for.

Layout, one file for each chunk of frames::

    fields/chunk_000000.npz    values_00_0000 (k, n) float32: field 0 at the drawn vertices of body 0;
                               contact_counts (k,) int32; of all contacts of the chunk in a row
                               contact_points (c, 3) [m], contact_forces (c, 3) [N] on the first body of
                               contact_bodies (c, 2) int32; body_forces (k, bodies, 3) float32 [N]: sums on
                               each body

The manifest has the fields in ``fields``: name, label, unit and the numbers of the bodies that have it. They
are what is looked at, not what is certified: no digest of the chain covers them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .._core import InvalidArgument
from ..arguments import given_word, is_iterable, shown_value
from ..array_file import DamageError, make_folder, read_arrays, write_arrays
from .format import FIELDS, RecordingError, field_path

VERSION = 1
#: Contacts of a frame that are kept: those of the largest forces.
MOST_CONTACTS = 1000

#: Of a user: values at all vertices of some bodies (n,), by handle, name or pattern.
Arrays = Callable[[Any], Mapping[Any, Any]]


class FieldEntry(NamedTuple):
    """A recorded field. ``bodies`` are the numbers of those that have it."""

    name: str
    label: str
    unit: str
    bodies: tuple[int, ...]

    def to_json(self) -> dict[str, Any]:
        """The entry as the manifest has it: a dictionary."""
        return {**self._asdict(), "bodies": list(self.bodies)}


class Contacts(NamedTuple):
    """Contacts of one frame: ``points`` (c, 3) [m], ``forces`` (c, 3) [N] on the first of the two bodies with
    the numbers ``bodies`` (c, 2), and the sums of all ``body_forces`` (bodies, 3) [N]."""

    points: np.ndarray
    forces: np.ndarray
    bodies: np.ndarray
    body_forces: np.ndarray


def check_given(sim: Any, scene: Any, version: Any, settings: Any, arrays: Any) -> None:
    """What a recorder is given."""
    if not hasattr(sim, "time"):
        raise RecordingError(f"recording: sim = {shown_value(sim)}: must be a stark.Simulation")
    given_word(scene, "recording: scene")
    given_word(version, "recording: stark_version")
    for what, given in (("settings", settings), ("arrays", arrays)):
        if given is not None and not isinstance(given, Mapping):
            raise RecordingError(
                f"recording: {what} = {shown_value(given)}: must be a dictionary, by name, or None"
            )


def given_fields(fields: Any) -> tuple[str, ...]:
    """Names of fields, none of None. Raises RecordingError for anything but a list of names."""
    if isinstance(fields, str):
        raise RecordingError(f"recording: fields = '{fields}': must be several names: ('{fields}',)")
    names = () if fields is None else tuple(fields) if is_iterable(fields) else (fields,)
    if not all(isinstance(name, str) for name in names):
        raise RecordingError(
            f"recording: fields = {shown_value(fields)}: must be several names, such as ('speed',)"
        )
    return names


class FieldWriter:
    """Takes fields and contacts of a simulation, frame after frame."""

    def __init__(self, sim: Any, fields: Sequence[str], arrays: Mapping[str, Arrays], contacts: bool) -> None:
        for title, function in arrays.items():
            if not isinstance(title, str) or not callable(function):
                raise RecordingError(
                    f"recording: arrays = {{{title!r}: {shown_value(function)}}}: must be functions of the "
                    f"simulation by name"
                )
        if contacts and not hasattr(sim, "contacts"):
            raise RecordingError("recording: contacts = True needs a simulation")
        self.contacts = contacts
        self._arrays = dict(arrays)
        names = [body.name for body in sim.bodies]
        self.entries: list[FieldEntry] = [_built_in(sim, name) for name in dict.fromkeys(fields)]
        for title, function in self._arrays.items():
            if any(title == entry.name for entry in self.entries):
                raise RecordingError(f"recording: field '{title}' is given twice; choose another name")
            bodies = tuple(names.index(name) for name in _given(sim, title, function))
            label, _, unit = title.partition("[")
            entry = FieldEntry(title, label.strip(), unit.strip().rstrip("]"), bodies)
            self.entries.append(entry)

    @classmethod
    def resumed(cls, sim: Any, recording: Any) -> FieldWriter | None:
        """Goes on with the fields of a recording, if it has any. Raises RecordingError for those of other
        bodies, and for those that functions of a program gave."""
        if "fields" not in recording.manifest:
            return None
        writer = cls(sim, [entry.name for entry in recording.fields], {}, recording.has_contacts)
        if writer.entries != recording.fields:
            raise RecordingError(f"'{recording.folder}' has fields of other bodies; run the scene anew")
        return writer

    @property
    def manifest(self) -> dict[str, Any]:
        return {
            "version": VERSION,
            "contacts": self.contacts,
            "entries": [entry.to_json() for entry in self.entries],
        }

    def take(self, sim: Any) -> dict[str, np.ndarray]:
        """The arrays of one frame, as a chunk has them but without the first axis."""
        from ..render.fields import field_values
        from ..render.pieces import at_surface

        row: dict[str, np.ndarray] = {}
        bodies = list(sim.bodies)
        for k, entry in enumerate(self.entries):
            chosen = [bodies[i] for i in entry.bodies]
            if entry.name in self._arrays:
                values = _given(sim, entry.name, self._arrays[entry.name])
            else:
                values = field_values(sim, entry.name, chosen) if chosen else {}
            for i, body in zip(entry.bodies, chosen, strict=True):
                if body.name not in values:
                    raise RecordingError(f"recording: field '{entry.name}' has no values of '{body.name}'")
                row[f"values_{k:02d}_{i:04d}"] = at_surface(body, values[body.name]).astype(np.float32)
        return row | (_contacts(sim, len(bodies)) if self.contacts else {})


def _built_in(sim: Any, name: str) -> FieldEntry:
    """A field of the house, of moving bodies that have it; bodies of laws whose stress is unknown have
    none."""
    from ..render.fields import FIELDS as KNOWN

    if name not in KNOWN:
        raise RecordingError(f"recording: field '{name}' is unknown; choose of {', '.join(KNOWN)}")
    kind, having = KNOWN[name], []
    for i, body in enumerate(sim.bodies):
        if body.kind in kind.kinds and body.motion != "fixed":
            try:
                if kind.together is None:  # else all bodies of its kinds have it
                    kind.compute(body)
            except InvalidArgument:
                continue
            having.append(i)
    return FieldEntry(name, kind.label, kind.unit, tuple(having))


def _given(sim: Any, title: str, function: Arrays) -> dict[str, np.ndarray]:
    from ..render.fields import field_of

    try:
        return field_of(sim, function(sim)).values
    except InvalidArgument as error:
        raise RecordingError(f"recording: field '{title}': {error}") from error


def _contacts(sim: Any, body_count: int) -> dict[str, np.ndarray]:
    found = sim.contacts
    points = 0.5 * (found.points_a + found.points_b)
    forces, bodies = np.asarray(found.forces), np.asarray(found.bodies).reshape(-1, 2)
    sums = np.zeros((body_count, 3))
    np.add.at(sums, bodies[:, 0], forces)
    np.subtract.at(sums, bodies[:, 1], forces)
    largest = np.argsort(-np.linalg.norm(forces, axis=1), kind="stable")[:MOST_CONTACTS]
    kept = np.sort(largest)
    return {
        "contact_counts": np.int32(len(kept)),
        "contact_points": points[kept].astype(np.float32),
        "contact_forces": forces[kept].astype(np.float32),
        "contact_bodies": bodies[kept].astype(np.int32),
        "body_forces": sums.astype(np.float32),
    }


#: Arrays that have as many rows as there are contacts.
_RAGGED = ("contact_points", "contact_forces", "contact_bodies")


def write_chunk(folder: Path, index: int, rows: Sequence[Mapping[str, np.ndarray]]) -> None:
    """The rows of the frames of one chunk."""
    make_folder(folder / FIELDS)
    join = {name: np.concatenate if name in _RAGGED else np.stack for name in rows[0]}
    write_arrays(folder / field_path(index), {name: join[name]([r[name] for r in rows]) for name in rows[0]})


def read_entries(manifest: Mapping[str, Any], body_count: int) -> tuple[list[FieldEntry], bool]:
    """The fields of a manifest and whether there are contacts. Raises TypeError, KeyError or ValueError for
    what no recorder writes."""
    given = manifest.get("fields")
    if given is None:
        return [], False
    if not isinstance(given, dict) or given.get("version") != VERSION:
        raise ValueError(f"fields must be an object of version {VERSION}")
    if not isinstance(given["entries"], list) or not isinstance(given["contacts"], bool):
        raise TypeError("fields must have a list of entries, and contacts true or false")
    entries = []
    for item in given["entries"]:
        entry = FieldEntry(item["name"], item["label"], item["unit"], tuple(item["bodies"]))
        if not all(isinstance(text, str) for text in entry[:3]):
            raise TypeError("name, label and unit of a field must be texts")
        if not all(type(i) is int and 0 <= i < body_count for i in entry.bodies):
            raise ValueError(f"field '{entry.name}' names a body that there is not")
        entries.append(entry)
    return entries, given["contacts"]


def read_chunk(
    place: Path, path: Path, manifest: Mapping[str, Any], vertices: Sequence[int], frames: int
) -> dict[str, np.ndarray]:
    """The arrays of a chunk at ``place``, which messages call ``path``, of at least so many ``frames``."""
    entries, contacts = read_entries(manifest, len(vertices))
    try:
        arrays = read_arrays(place)
        for k, entry in enumerate(entries):
            for i in entry.bodies:
                _need(arrays, f"values_{k:02d}_{i:04d}", "f", (frames, vertices[i]), more=True)
        if contacts:
            _need(arrays, "contact_counts", "i", (frames,), more=True)
            counts = arrays["contact_counts"]
            if counts.size and counts.min() < 0:
                raise DamageError("contact_counts must be >= 0")
            total = int(counts.sum(dtype=np.int64))
            for name in ("contact_points", "contact_forces"):
                _need(arrays, name, "f", (total, 3))
            _need(arrays, "contact_bodies", "i", (total, 2))
            pairs = arrays["contact_bodies"]
            if pairs.size and not (pairs.min() >= 0 and pairs.max() < len(vertices)):
                raise DamageError("contact_bodies name a body that there is not")
            found = arrays.get("body_forces", np.zeros(0))
            if found.ndim != 3 or found.dtype.kind != "f" or found.shape[1] > len(vertices):
                raise DamageError("body_forces are missing or have a wrong shape")
            _need(arrays, "body_forces", "f", (frames, found.shape[1], 3), more=True)
    except (OSError, DamageError) as error:
        raise RecordingError(f"'{path}' is missing or damaged ({error}); run the scene anew") from error
    return arrays


def _need(
    arrays: Mapping[str, np.ndarray], name: str, kind: str, shape: tuple[int, ...], more: bool = False
) -> None:
    """An array of finite numbers of this shape; with ``more``, of at least so many rows."""
    found = arrays.get(name)
    fits = (
        found is not None
        and found.dtype.kind == kind
        and found.ndim == len(shape)
        and found.shape[1:] == shape[1:]
        and (found.shape[0] >= shape[0] if more else found.shape[0] == shape[0])
    )
    if found is None or not fits or (kind == "f" and not np.isfinite(found).all()):
        raise DamageError(f"{name} are missing, not finite or of a wrong shape")


def row_of(chunk: Mapping[str, np.ndarray], row: int) -> dict[str, np.ndarray]:
    """The arrays of one frame of a chunk, as ``FieldWriter.take`` gives them."""
    counts = chunk.get("contact_counts", np.zeros(row + 1, dtype=np.int32))
    end = int(counts[: row + 1].sum(dtype=np.int64))
    own = slice(end - int(counts[row]), end)
    return {name: array[own] if name in _RAGGED else array[row] for name, array in chunk.items()}
