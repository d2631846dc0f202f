"""``typing.overload`` for type checkers alone. The one of Python keeps every function in a register, and with
it the compiled module beyond the end of the process, which nanobind reports as leaks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing import overload as overload
else:

    def overload(function: Any) -> Any:
        """Leaves the function as it is."""
        return function
