"""Reads the files of a document, which others may have made: nothing outside its folder is opened, sizes are
looked at before memory is taken, and nothing is executed."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path, PurePosixPath
from typing import Any, NoReturn

from stark.array_file import DamageError, read_arrays
from stark.files import open_regular, printable, read_bytes

from .errors import DocumentError, told
from .format import DOCUMENT, FORMAT_NAME, FORMAT_VERSION
from .kinds import Arrays

#: Largest document [bytes]; arrays are beside it.
LARGEST = 1 << 26


def read(path: Path) -> dict[str, Any]:
    """The document of a file, checked against its format, with its arrays in place. Raises DocumentError."""
    owner = f"scene document '{printable(str(path))}'"
    given = _json(path, owner)
    _check_version(given, owner)
    try:
        arrays = _arrays(path, given.get("arrays"))
        return DOCUMENT.read(given, "scene", arrays)
    except DocumentError as error:
        raise DocumentError(f"{owner}: {told(error)}") from None


def _json(path: Path, owner: str) -> dict[str, Any]:
    try:
        found = json.loads(
            read_bytes(path, LARGEST).decode("utf-8-sig"),  # some editors write a byte-order mark
            parse_constant=_refuse_constant,
            object_pairs_hook=_unique,
        )
    except FileNotFoundError:
        raise DocumentError(f"{owner}: there is no such file; check the path") from None
    except OSError as error:
        raise DocumentError(f"{owner} cannot be read: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise DocumentError(f"{owner} is damaged or no JSON: {printable(str(error)[:200])}") from None
    if not isinstance(found, dict):
        raise DocumentError(f"{owner} is a {type(found).__name__}: must be an object")
    return found


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f'{name} is no number of JSON; "inf" is written as a text')


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name occurs twice in an object")
    return found


def _check_version(given: dict[str, Any], owner: str) -> None:
    if given.get("format") != FORMAT_NAME:
        raise DocumentError(f"{owner} is no scene document: its format must be '{FORMAT_NAME}'")
    version = given.get("version")
    if isinstance(version, int) and not isinstance(version, bool) and version > FORMAT_VERSION:
        raise DocumentError(
            f"{owner} has version {str(version)[:20]} of the format; this Stark reads up to "
            f"{FORMAT_VERSION}: use a newer Stark (it was written by "
            f"{printable(str(given.get('stark_version'))[:40])})"
        )


def _digest(path: Path) -> str:
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]


def _arrays(path: Path, given: Any) -> Arrays:
    if given is None:
        return {}
    row = DOCUMENT.fields["arrays"].kind.read(given, "scene.arrays", {})
    file = inside(path.parent, row["file"], "scene.arrays.file")
    try:
        if row["sha256"] is not None and _digest(file) != row["sha256"]:
            raise DocumentError(
                f"'{row['file']}' is not what the document was written with: take both from one place; "
                f"where it was changed on purpose, remove sha256"
            )
        return read_arrays(file)
    except FileNotFoundError:
        raise DocumentError(
            f"the file of arrays '{row['file']}' is missing: must be beside the document"
        ) from None
    except (OSError, DamageError) as error:
        raise DocumentError(
            f"the file of arrays '{row['file']}' cannot be read: {str(error)[:300]}"
        ) from None


def inside(folder: Path, name: str, where: str) -> Path:
    """A file in a folder or below it. Raises DocumentError for names that lead out of it, also by links."""
    parts = PurePosixPath(name).parts
    strange = not parts or name.startswith("/") or "\\" in name or "\0" in name or ":" in name
    if strange or ".." in parts or len(name) > 1000:
        raise DocumentError(f"{where} = {name[:80]!r}: must be a name in the folder of the document")
    try:
        root, file = os.path.realpath(folder), os.path.realpath(folder / name)
    except (OSError, ValueError) as error:
        raise DocumentError(f"{where} = {name[:80]!r}: {error}") from None
    if os.path.commonpath([root, file]) != root:
        raise DocumentError(
            f"{where} = {name[:80]!r}: is a link that leads out of the folder of the document"
        )
    return Path(file)
