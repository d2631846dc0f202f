"""The published schema is that of the code, and says the same as the reader."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from _everything import everything

from stark import document
from stark.document.format import DOCUMENT, schema

ROOT = Path(__file__).resolve().parents[3]
PUBLISHED = ROOT / "docs/schemas/stark-scene-1.schema.json"
RULES = schema()


def test_the_published_schema_is_that_of_the_code() -> None:
    text = json.dumps(schema(), indent=1) + "\n"
    assert PUBLISHED.read_text() == text, "PYTHONPATH=python python -m stark.document > docs/schemas/..."
    assert document.schema() == schema()


def accepts(rule: dict[str, Any], value: Any) -> bool:
    """A validator of what of JSON Schema occurs here."""
    if "$ref" in rule:
        return accepts(RULES["$defs"][rule["$ref"].rpartition("/")[2]], value)
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}
    name = rule.get("type")
    if name in kinds and not isinstance(value, kinds[name]):
        return False
    if name in ("number", "integer"):
        types = (int,) if name == "integer" else (int, float)
        if isinstance(value, bool) or not isinstance(value, types):
            return False
        if not rule.get("minimum", value) <= value <= rule.get("maximum", value):
            return False
    if "const" in rule and value != rule["const"]:
        return False
    if "enum" in rule and value not in rule["enum"]:
        return False
    if isinstance(value, list) and "items" in rule:
        if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", len(value)):
            return False
        if not all(accepts(rule["items"], item) for item in value):
            return False
    if isinstance(value, dict) and name == "object":
        known = rule.get("properties", {})
        if any(key not in value for key in rule.get("required", [])):
            return False
        rest = rule.get("additionalProperties", True)
        for key, item in value.items():
            inner = known.get(key, rest)
            if inner is False or (isinstance(inner, dict) and not accepts(inner, item)):
                return False
    if "anyOf" in rule and not any(accepts(choice, value) for choice in rule["anyOf"]):
        return False
    return "oneOf" not in rule or sum(accepts(choice, value) for choice in rule["oneOf"]) == 1


def test_the_schema_accepts_what_is_written(tmp_path: Path) -> None:
    given = json.loads(everything().save(tmp_path / "a.json", until=1.0).read_text())
    assert accepts(RULES, given)
    assert set(given) <= set(DOCUMENT.fields)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("version",), 2),
        (("bodies", 0, "kind"), "gas"),
        (("bodies", 0, "position"), [0.0, 0.0]),
        (("bodies", 0, "pins"), 3),
        (("bodies", 0, "colour"), None),
        (("formulas", 0, "outputs"), [-1]),
        (("joints", 0, "enabled"), 1),
        (("pairs", 0, "rule"), "glue"),
        (("motions", 0, "body"), "cloth"),
    ],
)
def test_schema_and_reader_refuse_the_same(place: tuple[Any, ...], value: Any, tmp_path: Path) -> None:
    path = everything().save(tmp_path / "a.json")
    given = json.loads(path.read_text())
    twisted = copy.deepcopy(given)
    target = twisted
    for key in place[:-1]:
        target = target[key]
    target[place[-1]] = value
    assert accepts(RULES, given) and not accepts(RULES, twisted)
    path.write_text(json.dumps(twisted))
    with pytest.raises(document.DocumentError):
        document.read(path)
