"""How definitions of joints and actuators are pickled: by name, as functions are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Self

from stark import _core


class PickledByName:
    """Of frozen definitions, which copies share: made of a function, built in, or of a scene document."""

    KIND: ClassVar[str]
    """What it is called in errors."""

    name: str
    recorded: _core.Formula | None
    function: Callable[..., Any] | None

    def __post_init__(self) -> None:
        if self.function is not None:
            object.__setattr__(self, "__module__", self.function.__module__)

    def __reduce__(self) -> str | tuple[Any, ...]:
        if self.function is not None:
            return self.function.__qualname__
        if self.recorded is None:
            return self._finder(), (self.name,)
        raise TypeError(
            f"{self.KIND} '{self.name}' cannot be pickled: it is of a scene document and has no function; "
            f"load the document again where it is needed"
        )

    def _finder(self) -> Callable[[str], Any]:
        """A function that finds a built-in one by its name."""
        raise NotImplementedError

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __copy__(self) -> Self:
        return self
