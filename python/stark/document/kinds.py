"""Kinds of values of a document: each checks what a file holds at a place, and has a JSON Schema.

What is read is bounded before memory is asked for: lists by the length that their kind allows, arrays by
the file that they come from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arguments import nearest, shown_value
from .errors import DocumentError

Schema: TypeAlias = dict[str, Any]
Arrays: TypeAlias = Mapping[str, NDArray[Any]]

#: Longest text [characters].
LONGEST_TEXT = 100_000
#: Arrays of more numbers are written beside the document.
INLINE = 16

_INFINITE = {"inf": math.inf, "-inf": -math.inf}


def shown(value: Any) -> str:
    """A value in a message, cut."""
    return f"a {type(value).__name__}" if isinstance(value, (list, dict)) else shown_value(value)


def wrong(where: str, value: Any, rule: str) -> DocumentError:
    return DocumentError(f"{where} = {shown(value)}: must be {rule}")


class Kind:
    """What a value may be."""

    def read(self, value: Any, where: str, arrays: Arrays) -> Any:
        """The value, checked; DocumentError otherwise."""
        raise NotImplementedError

    def schema(self) -> Schema:
        """JSON Schema of it, draft 2020-12."""
        raise NotImplementedError


@dataclass(frozen=True)
class Number(Kind):
    """A finite number, or "inf" and "-inf" where these mean something."""

    unit: str = "1"
    least: float = -math.inf
    infinite: bool = False

    def read(self, value: Any, where: str, arrays: Arrays) -> float:
        if self.infinite and isinstance(value, str) and value in _INFINITE:
            return _INFINITE[value]
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise wrong(where, value, f"a number{self._unit}" + (' or "inf"' if self.infinite else ""))
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number) or number < self.least:
            low = f" >= {self.least:g}" if self.least > -math.inf else ""
            raise wrong(where, value, f"a finite number{low}{self._unit}")
        return number

    @property
    def _unit(self) -> str:
        return "" if self.unit == "1" else f" [{self.unit}]"

    def schema(self) -> Schema:
        number: Schema = {"type": "number"}
        if self.least > -math.inf:
            number["minimum"] = self.least
        if self.unit != "1":
            number["description"] = f"[{self.unit}]"
        return {"anyOf": [number, {"enum": list(_INFINITE)}]} if self.infinite else number


@dataclass(frozen=True)
class Whole(Kind):
    """An integer of a range, both ends included."""

    low: int = 0
    high: int = 2**31 - 1

    def read(self, value: Any, where: str, arrays: Arrays) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not self.low <= value <= self.high:
            raise wrong(where, value, f"an integer in [{self.low}, {self.high}]")
        return value

    def schema(self) -> Schema:
        return {"type": "integer", "minimum": self.low, "maximum": self.high}


@dataclass(frozen=True)
class Text(Kind):
    """A text that can be shown; ``words``: one of these."""

    words: tuple[str, ...] = ()

    def read(self, value: Any, where: str, arrays: Arrays) -> str:
        if self.words:
            if not isinstance(value, str) or value not in self.words:
                raise wrong(where, value, " or ".join(f"'{word}'" for word in self.words))
        elif not isinstance(value, str) or len(value) > LONGEST_TEXT:
            raise wrong(where, value, f"a text of at most {LONGEST_TEXT} characters")
        elif any("\ud800" <= character <= "\udfff" for character in value):
            raise wrong(where, value, "of characters that can be shown")
        return value

    def schema(self) -> Schema:
        return {"enum": list(self.words)} if self.words else {"type": "string", "maxLength": LONGEST_TEXT}


@dataclass(frozen=True)
class Flag(Kind):
    """True or false."""

    def read(self, value: Any, where: str, arrays: Arrays) -> bool:
        if not isinstance(value, bool):
            raise wrong(where, value, "true or false")
        return value

    def schema(self) -> Schema:
        return {"type": "boolean"}


@dataclass(frozen=True)
class Maybe(Kind):
    """A value or null."""

    kind: Kind

    def read(self, value: Any, where: str, arrays: Arrays) -> Any:
        return None if value is None else self.kind.read(value, where, arrays)

    def schema(self) -> Schema:
        return {"anyOf": [self.kind.schema(), {"type": "null"}]}


@dataclass(frozen=True)
class Either(Kind):
    """One of some kinds that JSON tells apart by its types: number, string, object."""

    kinds: Mapping[str, Kind]

    def read(self, value: Any, where: str, arrays: Arrays) -> Any:
        kind = self.kinds.get(_json_type(value))
        if kind is None:
            raise wrong(where, value, " or ".join(f"a {name}" for name in self.kinds))
        return kind.read(value, where, arrays)

    def schema(self) -> Schema:
        return {"anyOf": [kind.schema() for kind in self.kinds.values()]}


def _json_type(value: Any) -> str:
    if isinstance(value, bool):
        return "boolean"
    names = {int: "number", float: "number", str: "string", dict: "object", list: "list"}
    return names.get(type(value), "null")


@dataclass(frozen=True)
class Array(Kind):
    """Numbers of a shape, None for any extent: nested lists, or {"array": name} beside the document."""

    shape: tuple[int | None, ...]
    unit: str = "1"
    integers: bool = False

    def read(self, value: Any, where: str, arrays: Arrays) -> NDArray[Any]:
        array = self._found(value, where, arrays)
        fits = len(array.shape) == len(self.shape) and all(
            known in (None, extent) for known, extent in zip(self.shape, array.shape, strict=True)
        )
        if not fits:
            raise DocumentError(f"{where}: has the shape {array.shape}: must be {self.text}")
        if self.integers:
            if array.dtype.kind not in "iu" and array.size:
                raise DocumentError(f"{where}: has the type {array.dtype}: must be integers")
            if array.size and (int(array.min()) < -(2**31) or int(array.max()) >= 2**31):
                raise DocumentError(f"{where}: has {int(np.abs(array).max())}: must be below 2^31")
            return np.ascontiguousarray(array, dtype=np.int32)
        if array.dtype.kind not in "iuf":
            raise DocumentError(f"{where}: has the type {array.dtype}: must be numbers")
        numbers = np.ascontiguousarray(array, dtype=np.float64)
        if not np.isfinite(numbers).all():
            raise DocumentError(f"{where}: has numbers that are not finite: must be finite")
        return numbers

    def _found(self, value: Any, where: str, arrays: Arrays) -> NDArray[Any]:
        if isinstance(value, dict):
            name = value.get("array")
            if len(value) != 1 or not isinstance(name, str):
                raise wrong(where, value, f'numbers, or {{"array": name}}, {self.text}')
            if name not in arrays:
                raise DocumentError(f"{where}: the array '{name[:80]}' is not in the file of arrays")
            return arrays[name]
        if not isinstance(value, list) or not _is_regular(value, len(self.shape)):
            raise wrong(where, value, f"numbers of the shape {self.text}")
        if not value:
            return np.empty(tuple(extent or 0 for extent in self.shape))
        return np.array(value, dtype=None)

    @property
    def text(self) -> str:
        """The shape in words."""
        shape = ", ".join("n" if extent is None else str(extent) for extent in self.shape)
        return f"({shape}{',' if len(self.shape) == 1 else ''})" + (
            f" [{self.unit}]" if self.unit != "1" else ""
        )

    def schema(self) -> Schema:
        nested: Schema = {"type": "integer" if self.integers else "number"}
        for extent in reversed(self.shape):
            nested = {"type": "array", "items": nested}
            if extent is not None:
                nested |= {"minItems": extent, "maxItems": extent}
        beside = {
            "type": "object",
            "properties": {"array": {"type": "string"}},
            "required": ["array"],
            "additionalProperties": False,
        }
        return {"description": f"shape {self.text}", "anyOf": [nested, beside]}


def _is_regular(value: Any, depth: int) -> bool:
    """Whether nested lists hold plain numbers in rows of one length."""
    if depth == 0:
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return is_number and (isinstance(value, float) or -(2**63) <= value < 2**63)
    if not isinstance(value, list):
        return False
    if depth > 1 and len({len(row) if isinstance(row, list) else -1 for row in value}) > 1:
        return False
    return all(_is_regular(row, depth - 1) for row in value)


@dataclass(frozen=True)
class Listing(Kind):
    """A list of values of one kind."""

    kind: Kind
    most: int = 1_000_000

    def read(self, value: Any, where: str, arrays: Arrays) -> list[Any]:
        if not isinstance(value, list) or len(value) > self.most:
            raise wrong(where, value, f"a list of at most {self.most}")
        return [self.kind.read(item, f"{where}[{k}]", arrays) for k, item in enumerate(value)]

    def schema(self) -> Schema:
        return {"type": "array", "items": self.kind.schema(), "maxItems": self.most}


@dataclass(frozen=True)
class Named(Kind):
    """Values of one kind by name."""

    kind: Kind
    most: int = 10_000

    def read(self, value: Any, where: str, arrays: Arrays) -> dict[str, Any]:
        if not isinstance(value, dict) or len(value) > self.most:
            raise wrong(where, value, f"an object of at most {self.most} names")
        return {name: self.kind.read(item, f"{where}.{name[:80]}", arrays) for name, item in value.items()}

    def schema(self) -> Schema:
        return {"type": "object", "additionalProperties": self.kind.schema()}


REQUIRED = object()


@dataclass(frozen=True)
class Field:
    """A value of a record; ``default`` is what it is where it is left out, as it would be in the file."""

    kind: Kind
    default: Any = REQUIRED
    doc: str = ""


@dataclass(frozen=True)
class Record(Kind):
    """Values by name, each of its own kind; others are refused."""

    fields: Mapping[str, Field]
    doc: str = field(default="")

    def read(self, value: Any, where: str, arrays: Arrays) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise wrong(where, value, "an object")
        for name in value:
            if name not in self.fields:
                raise DocumentError(f"{where}: unknown field '{name[:80]}'{_hint(name, self.fields)}")
        found = {}
        for name, entry in self.fields.items():
            given = value.get(name, entry.default)
            if given is REQUIRED:
                raise DocumentError(f"{where}: has no '{name}': must be given")
            found[name] = entry.kind.read(given, f"{where}.{name}", arrays)
        return found

    def schema(self) -> Schema:
        properties = {}
        for name, entry in self.fields.items():
            properties[name] = entry.kind.schema()
            if entry.doc:
                properties[name] = {"description": entry.doc, **properties[name]}
            if entry.default is not REQUIRED:
                properties[name]["default"] = entry.default
        required = [name for name, entry in self.fields.items() if entry.default is REQUIRED]
        schema = {"type": "object", "properties": properties, "required": required}
        return {**schema, "additionalProperties": False, **({"description": self.doc} if self.doc else {})}


@dataclass(frozen=True)
class Tagged(Kind):
    """One of several records, told apart by a word in one of their fields."""

    tag: str
    records: Mapping[str, Record]

    def read(self, value: Any, where: str, arrays: Arrays) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise wrong(where, value, "an object")
        word = value.get(self.tag)
        if not isinstance(word, str) or word not in self.records:
            raise wrong(f"{where}.{self.tag}", word, " or ".join(f"'{known}'" for known in self.records))
        rest = {name: item for name, item in value.items() if name != self.tag}
        return {self.tag: word, **self.records[word].read(rest, where, arrays)}

    def schema(self) -> Schema:
        choices = []
        for word, record in self.records.items():
            schema = record.schema()
            schema["properties"] = {self.tag: {"const": word}, **schema["properties"]}
            schema["required"] = [self.tag, *schema["required"]]
            choices.append(schema)
        return {"oneOf": choices}


def _hint(name: str, known: Sequence[str] | Mapping[str, Any]) -> str:
    near = nearest(name, known)
    return f"; did you mean '{near}'?" if near else f"; known are {', '.join(known)}"


@dataclass(frozen=True)
class AnyArray(Kind):
    """A number, or numbers of any shape of up to three dimensions."""

    def read(self, value: Any, where: str, arrays: Arrays) -> NDArray[Any]:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return np.array(Number().read(value, where, arrays))
        shape: tuple[int | None, ...] = (None,)
        if isinstance(value, dict) and isinstance(name := value.get("array"), str) and name in arrays:
            shape = (None,) * arrays[name].ndim
        first = value[0] if isinstance(value, list) and value else None
        while isinstance(first, list) and len(shape) < 3:
            shape, first = (*shape, None), first[0] if first else None
        return Array(shape).read(value, where, arrays)

    def schema(self) -> Schema:
        return {"anyOf": [{"type": "number"}, Array((None,)).schema(), {"type": "array"}]}
