"""Functions of formulas, called with symbols or numbers: within another formula, or to look at a value."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stark._core import TraceError
from stark.formulas.internal import InternalDeclaration
from stark.formulas.parameters import Declaration


def applied(name: str, function: Callable[..., Any], args: Sequence[Any], keywords: Mapping[str, Any]) -> Any:
    """What a function of a formula returns; parameters that are left out have the values that they declare.
    TraceError for arguments that it does not have, and for those that must be given."""
    signature = inspect.signature(function)
    try:
        bound = signature.bind_partial(*args, **keywords)
    except TypeError as error:
        known = ", ".join(signature.parameters)
        raise TraceError(f"{name}: {error}: its arguments are {known}") from None
    for argument in signature.parameters.values():
        if argument.name not in bound.arguments:
            bound.arguments[argument.name] = _default(name, argument)
    return function(*bound.args, **bound.kwargs)


def _default(name: str, argument: inspect.Parameter) -> Any:
    declared: Any = argument.default
    if isinstance(declared, Declaration):
        value, unit = declared.default, f" [{declared.unit}]" if declared.unit else ""
    else:
        is_given = declared is not argument.empty and not isinstance(declared, InternalDeclaration)
        value, unit = declared if is_given else None, ""
    if value is None:
        raise TraceError(
            f"{name}: '{argument.name}'{unit} has no value: must be given where it is called as a function"
        )
    return value if np.ndim(value) == 0 else np.asarray(value, dtype=np.float64)
