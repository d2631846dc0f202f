"""What tells the scene of a checkpoint from that of a simulation."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

#: A part of a scene: its name, whether a state depends on it, its hash.
Part = tuple[str, bool, str]

#: Settings that change no bit of a result.
_WITHOUT_EFFECT = ("execution.threads", "execution.oversubscribe", "execution.backend")


def of_parts(saved: Sequence[Part], mine: Sequence[Part], *, structure_only: bool) -> list[str]:
    """Names of the parts that differ: first those that a state depends on, in the order of the scene."""
    ours = {name: (is_structure, digest) for name, is_structure, digest in mine}
    theirs = {name: (is_structure, digest) for name, is_structure, digest in saved}
    found = []
    names = dict.fromkeys([*ours, *theirs])
    for name in sorted(names, key=lambda name: not (ours.get(name) or theirs[name])[0]):
        is_structure = (ours.get(name) or theirs[name])[0]
        if structure_only and not is_structure:
            continue
        if name not in theirs:
            found.append(f"{name} (not in the checkpoint)")
        elif name not in ours:
            found.append(f"{name} (only in the checkpoint)")
        elif ours[name][1] != theirs[name][1]:
            found.append(name)
    return found


def of_settings(saved: Mapping[str, Any], mine: Mapping[str, Any]) -> list[str]:
    """Settings that differ, with both values; those that change no result are left out."""
    mine = json.loads(json.dumps(dict(mine)))  # tuples as lists
    names = dict.fromkeys([*mine, *saved])
    return [
        f"setting {name} ({saved.get(name, 'not set')} in the checkpoint, {mine.get(name, 'not set')} here)"
        for name in names
        if name not in _WITHOUT_EFFECT and saved.get(name) != mine.get(name)
    ]


def listed(differences: Sequence[str], most: int = 4) -> str:
    """The first few of them in a row."""
    text = ", ".join(differences[:most])
    return text + (f" and {len(differences) - most} more" if len(differences) > most else "")
