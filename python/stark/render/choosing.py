"""Which bodies of a scene are meant: by handle, name or pattern of names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

from .._core import InvalidArgument
from ..arguments import is_iterable, nearest, real_number


def matching(chosen: Any, names: Sequence[str], what: str) -> list[int]:
    """Indices of the bodies that are ``chosen``, in the order of ``names``: by one or more handles, names, or
    patterns such as ``"finger*"`` (a name that a body has is that body, whatever characters it has).
    InvalidArgument calls what matches no body ``what``."""
    parts = [chosen] if isinstance(chosen, str) or not is_iterable(chosen) else list(chosen)
    places: dict[str, list[int]] = {}  # by name
    for i, name in enumerate(names if len(parts) > 1 else ()):
        places.setdefault(name, []).append(i)
    found: set[int] = set()
    for part in parts:
        pattern = part if isinstance(part, str) else getattr(part, "name", None)
        if not isinstance(pattern, str):
            raise InvalidArgument(
                f"{what} = {part!r}: must be bodies, their names, or patterns like 'finger*'"
            )
        hits = places.get(pattern, []) if places else [i for i, name in enumerate(names) if name == pattern]
        hits = hits or [i for i, name in enumerate(names) if fnmatchcase(name, pattern)]
        if not hits:
            raise InvalidArgument(f"{what} = '{pattern}': no body has such a name; {_known(pattern, names)}")
        found.update(hits)
    return sorted(found)


def opacities(given: Mapping[Any, Any] | None, names: Sequence[str]) -> list[float]:
    """Of each body: 1 where nothing is given; later entries win."""
    result = [1.0] * len(names)
    if given is not None and not isinstance(given, Mapping):
        raise InvalidArgument(f"opacity = {given!r}: must be a dictionary: {{'glass*': 0.3}}")
    for key, value in (given or {}).items():
        for i in matching(key, names, "opacity: body"):
            opacity = real_number(value, f"opacity of '{names[i]}'")
            if not 0.0 <= opacity <= 1.0:
                raise InvalidArgument(
                    f"opacity of '{names[i]}' = {opacity:g}: must be in [0, 1]; 1 hides what is behind, 0 is "
                    f"not seen"
                )
            result[i] = opacity
    return result


def _known(pattern: str, names: Sequence[str]) -> str:
    if near := nearest(pattern, names):
        return f"did you mean '{near}'?"
    shown = ", ".join(f"'{name}'" for name in names[:8])
    return f"there are {shown}{', ...' if len(names) > 8 else ''}"
