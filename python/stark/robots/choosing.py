"""Which joints of a robot are meant."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from stark._core import InvalidArgument

Choice: TypeAlias = str | Sequence[str] | None
"""Some joints: names, patterns such as "finger_*", names of groups; None for all that have a coordinate of
their own."""


def chosen_rows(
    owner: str, joints: Choice, names: Sequence[str], groups: Mapping[str, Sequence[str]]
) -> list[int]:
    """Places of some joints among ``names``, those of all coordinates. InvalidArgument for unknown ones, and
    for anything but a name or a list of names."""
    if joints is None:
        return list(range(len(names)))
    given = [joints] if isinstance(joints, str) else joints
    if not isinstance(given, (Sequence, np.ndarray)) or np.ndim(np.array(given, dtype=object)) != 1:
        raise InvalidArgument(
            f"{owner}: joints = {joints!r}: must be the name of a joint or a group, a pattern, or a list of "
            f"them"
        )
    if len(given) == 0:
        raise InvalidArgument(f"{owner}: joints = {joints!r}: must be at least one; leave it out for all")
    rows: list[int] = []
    for pattern in [name for part in given for name in groups.get(str(part), (part,))]:
        found = [k for k, name in enumerate(names) if fnmatch.fnmatchcase(name, str(pattern))]
        if not found:
            raise InvalidArgument(
                f"{owner}: joints = '{pattern}': must be the name or pattern of a joint with a coordinate of "
                f"its own: {', '.join(names)}"
            )
        rows += [k for k in found if k not in rows]
    return rows
