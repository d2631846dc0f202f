"""docs/parity.md: every entry of its last column is resolved in the running program, so that no row names
what is not there, gives a default that is not the default, or a test that does not exist."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import stark
from stark import _core

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "parity.md"
VERDICTS = ("Same", "More", "Different", "Not needed", "Open")
# An entry is `stark.x`, kind `name`, kind `name` = value, or a link to a heading.
_ENTRY = re.compile(
    r"(?:(?P<kind>[a-z]+) )?`(?P<name>[^`]+)`(?: = (?P<value>[^,\s]+))?|\[[^\]]*\]\((?P<link>[^)]+)\)"
)


class Row(NamedTuple):
    section: str
    item: str
    there: str
    here: str
    where: str


def rows_of(text: str) -> list[Row]:
    """Rows of all tables of a page, with the heading that they stand under."""
    rows, section = [], ""
    for line in text.splitlines():
        if line.startswith("#"):
            section = line.lstrip("# ")
        elif line.startswith("|") and not line.startswith(("|---", "| item |")):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            assert len(cells) == 4, f"{line}: {len(cells)} cells"
            rows.append(Row(section, *cells))
    return rows


ROWS = rows_of(PAGE.read_text())


# --- what the kinds of entries are resolved to; each raises for names that do not exist ---


def attribute(path: str) -> Any:
    """An attribute of the package: modules are imported, annotations without a value count."""
    value: Any = stark
    for name in path.split(".")[1:]:
        if hasattr(value, name):
            value = getattr(value, name)
        elif isinstance(value, type) and any(
            name in vars(c).get("__annotations__", {}) for c in value.__mro__
        ):
            return None
        else:
            value = importlib.import_module(f"{value.__name__}.{name}")
    return value


def setting(name: str) -> str:
    return _row_named(name, stark.Settings.fields())["default"]


def material(path: str) -> Any:
    kind, name = path.split(".")
    return _row_named(name, getattr(stark, kind).parameters())["default"]


def _row_named(name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    return next(row for row in rows if row["name"] == name)


def potential(name: str) -> None:
    assert name in {row["name"] for row in _core.potentials()}


def law(name: str) -> None:
    laws = [*_core.solid_laws(), *_core.shell_laws(), *_core.rod_laws()]
    assert name in {each.name for each in laws}


def preset(name: str) -> None:
    assert stark.materials.presets[name].source


def report(name: str) -> None:
    assert hasattr(_core.StepReport, name)


def link(target: str) -> None:
    file, _, anchor = target.partition("#")
    text = (PAGE.parent / file).read_text()
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    assert not anchor or anchor in {_slug(heading) for heading in headings}, target


def _slug(heading: str) -> str:
    """The anchor that Markdown viewers give to a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def test(path: str) -> None:
    """``file.py::function``, ``file.py::function[id]`` or ``file.cpp::part of the title of a test case``."""
    file, _, name = path.partition("::")
    source = ROOT / "tests" / ("python" if file.endswith(".py") else "") / file
    if file.endswith(".cpp"):
        titles = re.findall(r'TEST_CASE\(\s*((?:"[^"]*"\s*)+)', source.read_text())
        assert any(name in re.sub(r'"\s*"|\n|"', "", title) for title in titles), path
        return
    function, _, case = name.rstrip("]").partition("[")
    assert re.search(rf"^def {function}\(", source.read_text(), re.MULTILINE), path
    assert not case or f'"{case}"' in source.read_text(), path


test.__test__ = False  # type: ignore[attr-defined]  # a resolver, not a test

RESOLVERS: dict[str, Callable[[str], Any]] = {
    "attribute": cache(attribute),
    "setting": setting,
    "material": material,
    "potential": potential,
    "law": law,
    "preset": preset,
    "joint": _core.find_joint,
    "actuator": _core.find_actuator,
    "report": report,
    "link": link,
    "test": cache(test),
}


def resolve(cell: str) -> int:
    """Number of entries of a cell; raises for the first that does not exist, and for text between them."""
    entries = list(_ENTRY.finditer(cell))
    assert not _ENTRY.sub("", cell).strip(", "), f"'{cell}' holds more than entries"
    for entry in entries:
        name = entry["link"] or entry["name"]
        kind = "link" if entry["link"] else entry["kind"] or "attribute"
        assert kind != "attribute" or name.startswith("stark."), name
        found = RESOLVERS[kind](name)
        if entry["value"] is not None:
            assert _is_value(entry["value"], found), f"{name} is {found}, not {entry['value']}"
    return len(entries)


def _is_value(text: str, value: Any) -> bool:
    return text == str(value).lower() if not _is_number(text) else float(text) == float(value)


def _is_number(text: str) -> bool:
    return bool(re.fullmatch(r"[-+.\de]+", text)) and any(c.isdigit() for c in text)


# --- tests ---


@pytest.mark.parametrize("row", ROWS, ids=[f"{row.section}: {row.item}" for row in ROWS])
def test_every_row_leads_somewhere(row: Row) -> None:
    if row.where == "open":
        assert row.here.startswith("Open: ")
    else:
        assert resolve(row.where) > 0


def test_every_verdict_is_known_and_has_its_reason() -> None:
    behaviours = ("As a guest of its process", "Physics", "Engineering")
    for row in ROWS:
        assert all(row), row
        if row.section in behaviours:
            assert "test `" in row.where, f"{row.item}: no test"
            continue
        verdict = next((v for v in VERDICTS if re.match(rf"{v}\b", row.here)), None)
        assert verdict, f"{row.item}: '{row.here}' says neither of {VERDICTS}"
        if verdict in ("Different", "Not needed", "Open"):
            assert len(row.here.removeprefix(verdict).split()) >= 4, f"{row.item}: no reason"
        assert (verdict == "Open") == (row.where == "open"), row.item


def test_the_tables_are_whole() -> None:
    assert len({(row.section, row.item) for row in ROWS}) == len(ROWS)
    assert len(ROWS) > 130
    behaviours = [
        row for row in ROWS if row.section in ("As a guest of its process", "Physics", "Engineering")
    ]
    assert len(behaviours) == 37


@pytest.mark.parametrize(
    "cell",
    [
        "`stark.Scene.add_wings`",
        "setting `time.steps`",
        "setting `newton.max_iterations` = 201",
        "setting `newton.projection` = always",
        "potential `levity`",
        "law `hooke`",
        "preset `adamant`",
        "joint `knee`",
        "actuator `muscle`",
        "report `mood`",
        "material `ShellMaterial.colour`",
        "[theory](theory.md#magic)",
        "test `test_parity.py::test_nothing`",
        "test `test_bad_input.py::test_bad_input_is_refused[good input]`",
        "test `sim/step/test_step_runner.cpp::a step that flies`",
        "`stark.Scene` somewhere",
        "thing `x`",
    ],
)
def test_what_does_not_exist_is_refused(cell: str) -> None:
    with pytest.raises((AssertionError, LookupError, StopIteration, ImportError, stark.Error)):
        resolve(cell)


def test_a_rope_and_a_strut_of_two_bodies() -> None:
    """Limits on both sides of a distance: two boxes fly apart and are reflected together."""
    scene = stark.Scene()
    bodies = [scene.add_box(0.1, mass=1.0, position=(x, 0, 0), velocity=(-x, 0, 0)) for x in (-0.5, 0.5)]
    span = scene.add_span(*bodies, (-0.5, 0, 0), (0.5, 0, 0))
    span.add_limit(lower=0.8, upper=1.2)
    sim = stark.Simulation(scene, time_step=0.01, gravity=(0, 0, 0))
    distances = [span.distance for report in sim.run(1.0) if not report.failed]
    assert len(distances) == 100
    assert min(distances) == pytest.approx(0.8, abs=1e-5)
    assert np.ptp(distances) < 0.2 + 1e-5  # the stop takes the speed and gives none back


def test_a_body_grows_into_a_scaled_rest_shape() -> None:
    """A rest shape of 1.2 times the size, started in the old one: the free block settles at 1.2."""
    scene = stark.Scene()
    mesh = stark.mesh.tet_box(0.1, 2)
    gel = stark.materials.soft_rubber.replace(mass_damping=20.0, strain_limit=np.inf)
    block = scene.add_solid(mesh.scaled(1.2), gel, initial_positions=mesh.vertices)
    sim = stark.Simulation(scene, time_step=0.02, gravity=(0, 0, 0))
    assert np.ptp(block.positions, axis=0) == pytest.approx(np.full(3, 0.1))
    for report in sim.run(2.0):
        assert not report.failed
    assert np.ptp(block.positions, axis=0) == pytest.approx(np.full(3, 0.12), rel=1e-3)
