"""The replay page in a browser, used as somebody does who looks: fields, picking, contacts, cuts, filters,
plots, two runs. Nothing goes wrong on the console, and nothing is fetched. Slow, and only where there is
Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _browser import CHROMIUM, Browser
from fake_simulation import record

import stark
from stark.recording import Recorder, Recording
from stark.render.camera import upright
from stark.replay import write_page

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="needs chromium: apt-get install chromium"),
]
FRAMES = 12


def jelly(folder: Path, mass: float) -> Recording:
    """A ball on a block on a table."""
    scene = stark.Scene()
    scene.add_box((0.6, 0.6, 0.05), name="table", motion="fixed", position=(0, 0, -0.025))
    scene.add_solid(stark.mesh.tet_box((0.2, 0.2, 0.15), (4, 4, 3)), name="jelly", position=(0, 0, 0.0755))
    scene.add_sphere(0.05, name="ball", mass=mass, position=(0.03, 0, 0.205))
    sim = stark.Simulation(scene, time_step=0.01)
    options: dict[str, Any] = {"fields": ("stress", "pressure"), "contacts": True}
    with Recorder(folder, sim, scene="jelly", **options) as recorder:
        recorder.record(sim)
        for _ in range(FRAMES - 1):
            report = sim.step()
            recorder.report(report, measured={"ball_height": float(sim["ball"].positions[:, 2].mean())})
            recorder.record(sim)
    return Recording(folder)


#: Of the script of a page: its parts, and the opaque pixels of a canvas that are of a colour.
PARTS = """
const view = byId("view"), marks = byId("marks");
const boxes = () => [...document.querySelectorAll(".body input[type=checkbox]")];
const near = (c) => (r, g, b, a) => a > 250 && Math.hypot(r - c[0], g - c[1], b - c[2]) < 8;
const shown = () => boxes().map((box) => box.checked);
const names = [...document.querySelectorAll(".body .name")];
const solid = () => count(view, (r, g, b, a) => a > 250);
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return jelly(tmp_path_factory.mktemp("jelly") / "run", 0.6)


@pytest.fixture(scope="module")
def browser(run: Recording, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    folder = tmp_path_factory.mktemp("browser")
    page = write_page(run, overlay=jelly(folder / "light", 0.2))
    with Browser(page, folder) as opened:
        opened.key("End")
        yield opened
        assert opened.errors == []
        assert opened.requests == [f"file://{page}"]  # itself


def test_keys_and_the_time(browser: Browser) -> None:
    browser.key("End")
    clock = 'return byId("clock").textContent'
    assert browser.run(clock) == "0.110 sframe 12 of 12"
    browser.key("ArrowLeft")
    assert browser.run(clock) == "0.100 sframe 11 of 12"
    browser.key("End")


def test_a_click_tells_body_place_and_force(run: Recording, browser: Browser) -> None:
    """The ray through a pixel and the projection of what it hits are two ways between pixels and places."""
    facts = """
const facts = {}, terms = byId("selected-facts").querySelectorAll("dt");
for (const item of terms) facts[item.textContent] = item.nextSibling.textContent;
return [byId("selection").hidden, byId("selected-name").textContent, facts];
"""
    left, top, width, height = browser.run(
        "const a = byId('view').getBoundingClientRect(); return [a.left, a.top, a.width, a.height]"
    )
    seen = []
    for across, down in ((0.45, 0.5), (0.5, 0.5), (0.5, 0.6), (0.55, 0.55), (0.5, 0.42)):
        x, y = round(across * width), round(down * height)
        browser.click(left + x, top + y)
        hidden, name, told = browser.run(facts)
        if hidden:
            continue
        seen.append(name)
        assert browser.run(f"return at(byId('marks'), {x}, {y})") == [
            47,
            111,
            222,
            255,
        ]  # the point is drawn there
        positions, triangles = run.positions(name, -1), run.triangles(name)
        place = np.array(told["Position [m]"].replace("\N{MINUS SIGN}", "-").split(","), dtype=float)
        assert distance(place, positions[triangles].astype(float)) < 1e-3  # [m], three digits
        force = np.linalg.norm(run.contacts(-1).body_forces[run.body_index(name)])
        value, unit = told["Contact force"].split()
        assert float(value) * {"N": 1.0, "mN": 1e-3}[unit] == pytest.approx(force, rel=6e-3)
    assert {"jelly", "ball"} <= set(seen) and len(seen) >= 4
    browser.key("Escape")
    assert browser.run(facts)[0]
    browser.click(left + 5, top + height - 150)
    assert browser.run(facts)[0]  # nothing there


def test_fields_by_colour(run: Recording, browser: Browser) -> None:
    script = """
const changed = (a, b) => a.reduce((sum, v, i) => sum + (Math.abs(v - b[i]) > 40 ? 1 : 0), 0);
const plain = pixels(view).data;
await choose("field", "stress");
const viridis = pixels(view).data, limits = ["low", "high"].map((id) => Number(byId(id).value));
const scale = [count(marks, near([68, 1, 84])), count(marks, near([253, 231, 37]))];
await choose("colormap", "magma");
const magma = pixels(view).data;
await choose("high", "1e9");
const yellow = count(view, (r, g, b, a) => a > 250 && r > 200 && g > 120 && b < 140);
await press(byId("limits-reset"));
const reset = Number(byId("high").value);
await choose("colormap", "viridis");
await choose("field", "");
const last = pixels(view).data;
const changes = [changed(viridis, plain), changed(magma, viridis), changed(last, plain)];
return { limits, scale, reset, yellow, changes };
"""
    told = browser.run(PARTS + script)
    stress = np.stack([run.field("stress", k)["jelly"] for k in range(FRAMES)])
    assert told["limits"][0] == 0.0 and 0.3 * stress.max() < told["limits"][1] <= 1.001 * stress.max()
    assert told["reset"] == told["limits"][1] and min(told["scale"]) > 10
    assert min(told["changes"][:2]) > 5000 and told["changes"][2] == 0
    assert told["yellow"] == 0  # all values are at the lower end


def test_contacts_as_arrows(browser: Browser) -> None:
    script = """
const red = () => count(marks, near([204, 23, 33])), told = [red()];
for (let i = 0; i < 2; ++i) { await press(byId("contacts")); told.push(red()); }
return told;
"""
    without, with_arrows, again = browser.run(PARTS + script)
    assert without == again == 0 and with_arrows > 200


def test_cuts_opacity_one_alone_and_filters(browser: Browser) -> None:
    script = """
const told = { solid: [solid()] };
await choose("clip-axis", "y");
told.solid.push(solid());
await choose("clip-axis", "");
await press(names[0]);
await choose("opacity", "0.3");
told.solid.push(solid());
await choose("opacity", "1");
told.solid.push(solid());
await press(byId("solo"));
told.alone = shown();
await press(byId("solo"));
told.together = shown();
await choose("filter", "soli*");
told.rows = [...document.querySelectorAll(".body")].map((row) => !row.hidden);
await press(byId("hide-these"));
told.hidden = shown();
await press(byId("show-all"));
await choose("filter", "");
await press(byId("unselect"));
return told;
"""
    told = browser.run(PARTS + script)
    whole, cut, thin, again = told["solid"]
    assert cut < 0.8 * whole and thin < 0.8 * whole and again >= 0.999 * whole
    assert told["alone"] == [True, False, False] and told["together"] == [True] * 3
    assert told["rows"] == [False, True, False] and told["hidden"] == [True, False, True]


def test_the_cut_of_a_closed_body_is_filled(browser: Browser) -> None:
    """From the front a ball cut through its middle is a flat disc: one colour, on the area that its width
    says. The inside of a hollow one has another colour in each of its facets."""
    script = """
await press(names[2]);
await press(byId("solo"));
await choose("clip-axis", "y");
await choose("clip-at", "0.5");
byId("clip-flip").checked = true;
await choose("clip-flip", "on");
const { data, width } = pixels(view), colours = new Map();
let columns = new Set();
for (let i = 0; i < data.length; i += 4) {
  if (data[i + 3] < 250) continue;
  columns.add((i / 4) % width);
  const key = data.subarray(i, i + 3).join(",");
  colours.set(key, (colours.get(key) || 0) + 1);
}
return [columns.size, Math.max(...colours.values())];
"""
    browser.key("2")
    wide, alike = browser.run(PARTS + script)
    assert wide > 60 and alike == pytest.approx(np.pi / 4 * wide**2, rel=0.06)  # the rim is blended
    area = "const a = byId('view').getBoundingClientRect(); "
    middle = """
const { data, width } = pixels(view);
let x = 0, y = 0, n = 0;
for (let i = 0; i < data.length; i += 4)
  if (data[i + 3] > 250) { x += (i / 4) % width; y += Math.floor(i / 4 / width); ++n; }
return [a.left + x / n, a.top + y / n];
"""
    told = "return [byId('selected-name').textContent, byId('selected-facts').textContent.slice(0, 10)]"
    place = browser.run(PARTS + area + middle)
    browser.click(*place)
    assert browser.run(told) == ["ball", "Middle [m]"]  # the section, which has no point of the surface
    browser.run('byId("clip-flip").checked = false; await choose("clip-flip", "on")')
    browser.click(*place)
    assert browser.run(told) == ["ball", "Position ["]  # its front, before the section
    browser.run(
        PARTS + 'await choose("clip-axis", ""); await press(byId("solo")); await press(byId("unselect"))'
    )
    browser.key("1")


def test_only_surfaces_without_a_border_are_filled(browser: Browser) -> None:
    script = """
const corners = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
const faces = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], turned = [...faces.slice(0, 9), 1, 3, 2];
const apart = new Float32Array(faces.flatMap((i) => [...corners.subarray(3 * i, 3 * i + 3)]));
return [
  isClosed(faces, corners), isClosed(faces.slice(3), corners), isClosed([0, 1, 2, 0, 2, 1], corners),
  isClosed([...apart.keys()].slice(0, 12), apart), isClosed(turned, corners), isClosed([], corners),
];
"""
    # A tetrahedron, one side missing, a triangle and its back, STL, a side turned, nothing.
    assert browser.run(script) == [True, False, True, True, False, False]


def test_plots_have_switches_and_another_run(browser: Browser) -> None:
    script = """
const plots = [...document.querySelectorAll(".plot")], title = (plot) => plot.querySelector("b").textContent;
const energy = plots.find((plot) => title(plot) === "Energy"), canvas = energy.querySelector("canvas");
const gravity = [...energy.querySelectorAll("button")].find((item) => item.textContent === "gravity");
const off = [gravity.classList.contains("off")], before = pixels(canvas).data;
await press(gravity);
off.push(gravity.classList.contains("off"));
const redrawn = pixels(canvas).data.some((v, i) => v !== before[i]);
canvas.scrollIntoView();
const area = canvas.getBoundingClientRect();
return {
  titles: plots.map(title), off, redrawn, overlay: byId("overlay-legend").textContent,
  colours: [...energy.querySelectorAll(".legend i")].map((item) => item.style.background),
  place: [area.left + 50, area.top + 30],
};
"""
    told = browser.run(script)
    assert {"Energy", "Contacts", "ball_height"} <= set(told["titles"])
    assert told["off"] == [True, False] and told["redrawn"]
    assert len(set(told["colours"])) == len(told["colours"]) >= 4
    assert told["overlay"] == "this runlight"
    browser.click(*told["place"])  # at the left end of the axis
    assert browser.run('return byId("clock").textContent') == "0.011 sframe 2 of 12"
    browser.key("End")


def test_no_text_lies_over_another(browser: Browser) -> None:
    """All that is to be read beside the picture, with a body selected and a field on show."""
    script = """
await press(names[1]);
await choose("field", "stress");
await choose("clip-axis", "x");
const tags = "header > *, footer > *, #panel :is(label, button, dt, dd, h2, select)" +
  ", .body span, .plot :is(b, i)";
const isSeen = (item) => item.getClientRects().length && item.textContent.trim();
const seen = [...document.querySelectorAll(tags)].filter(isSeen);
const places = seen.map((item) => item.getBoundingClientRect()), over = [];
for (let i = 0; i < seen.length; ++i)
  for (let k = 0; k < i; ++k) {
    const [a, b] = [places[i], places[k]];
    if (byId("panel").contains(seen[i]) !== byId("panel").contains(seen[k])) continue;  // it scrolls
    const inside = seen[i].contains(seen[k]) || seen[k].contains(seen[i]);
    const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const tall = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    if (!inside && wide > 1 && tall > 1) over.push([seen[i].textContent, seen[k].textContent]);
  }
await choose("clip-axis", "");
await choose("field", "");
await press(byId("unselect"));
const panel = byId("panel"), beyond = panel.scrollWidth - panel.clientWidth;
return { over, count: seen.length, wide: document.documentElement.scrollWidth, beyond };
"""
    told = browser.run(PARTS + script)
    assert told["over"] == [] and told["count"] > 40
    assert told["wide"] == 1280 and told["beyond"] == 0


def distance(point: np.ndarray, corners: np.ndarray) -> float:
    """From a point to the nearest of many points that are spread over triangles (m, 3, 3) [m]."""
    n = 80
    weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
    places = np.einsum("kc,mcx->mkx", weights, corners).reshape(-1, 3)
    return float(np.linalg.norm(places - point, axis=1).min())


def test_old_recordings_offer_what_they_have(tmp_path: Path) -> None:
    with Browser(write_page(record(tmp_path / "run", 5)), tmp_path) as browser:
        parts = '["fields", "contacts-option", "overlay-legend", "selection"]'
        assert browser.run(f"return {parts}.map((id) => byId(id).hidden)") == [True] * 4
        x, y = browser.run("return [byId('view').clientWidth / 2, 44 + byId('view').clientHeight / 2]")
        browser.click(x, y)
        facts = browser.run("return byId('selected-facts').textContent")
        assert facts.startswith("Position [m]") and "force" not in facts
        assert browser.errors == []


def test_many_bodies_are_in_groups(tmp_path: Path) -> None:
    scene = stark.Scene()
    for k in range(5):
        scene.add_box(0.08, name=f"brick_{k}", mass=0.1, position=(0.1 * k, 0, 0))
        scene.add_box(0.08, name=f"robot/link{k}", mass=0.1, position=(0.1 * k, 0, 0.1))
    sim = stark.Simulation(scene)
    with Recorder(tmp_path / "run", sim) as recorder:
        recorder.record(sim)
    script = """
const groups = [...document.querySelectorAll(".group")], box = groups[0].querySelector("summary input");
const told = { groups: groups.map((group) => group.querySelector("summary").textContent) };
await press(box);
told.shown = [shown(), box.checked, count(view, (r, g, b, a) => a > 250)];
await press(boxes()[1]);
told.some = [box.checked, box.indeterminate, count(view, (r, g, b, a) => a > 250)];
await choose("filter", "LINK*");
told.hidden = groups.map((group) => group.hidden);
return told;
"""
    with Browser(write_page(Recording(tmp_path / "run")), tmp_path) as browser:
        told = browser.run(PARTS + script)
        assert browser.errors == []
    assert told["groups"] == ["brick5", "robot5"]
    assert told["shown"][:2] == [[False] * 5 + [True] * 5, False]
    assert told["some"][:2] == [False, True] and told["some"][2] > told["shown"][2] > 1000
    assert told["hidden"] == [True, False]


def test_a_narrow_page_has_room_for_all(run: Recording, tmp_path: Path) -> None:
    script = """
await choose("field", "stress");
const scale = count(marks, near([68, 1, 84])), panel = byId("panel");
const beyond = panel.scrollWidth - panel.clientWidth;
return [document.documentElement.scrollWidth, beyond, view.clientHeight, scale];
"""
    with Browser(write_page(run, tmp_path / "page.html"), tmp_path, size=(390, 844)) as browser:
        wide, beyond, height, scale = browser.run(PARTS + script)
        assert browser.errors == []
    assert wide == 390 and beyond == 0 and height > 250 and scale > 10


def upright_scene(folder: Path, up: tuple[float, float, float]) -> Path:
    """The page of a scene whose up is an axis: a block and a ball on a floor."""
    turn = upright(up).T  # takes z to up
    scene = stark.Scene()
    floor = {"motion": "fixed", "name": "floor"}
    scene.add_box((2.0, 2.0, 0.05), position=turn @ (0, 0, -0.025), rotation=turn, **floor)
    scene.add_box((0.1, 0.2, 0.15), mass=1.0, position=turn @ (0, 0, 0.0755), rotation=turn)
    scene.add_sphere(0.05, mass=0.6, position=turn @ (0.2, 0, 0.4))
    sim = stark.Simulation(scene, time_step=0.01, gravity=tuple(-9.81 * np.array(up)))
    with Recorder(folder / "run", sim) as recorder:
        recorder.record(sim)
        recorder.report(sim.step())
        recorder.record(sim)
    return write_page(Recording(folder / "run"))


def test_scenes_with_another_axis_up_look_the_same(tmp_path: Path) -> None:
    """Cameras, light, grid and shadows follow gravity: pages of a scene that was turned with it are equal."""
    pictures: dict[tuple[float, ...], list[np.ndarray]] = {}
    for number, up in enumerate([(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)]):
        folder = tmp_path / str(number)
        folder.mkdir()
        script = "await drawn(); return [...pixels(view).data.filter((v, i) => i % 4 < 3)]"
        with Browser(upright_scene(folder, up), folder, size=(640, 400)) as browser:
            pictures[up] = []
            for key in ("1", "2", "4"):  # oblique, front, top
                browser.key(key)
                pictures[up].append(np.array(browser.run(PARTS + script)))
            assert browser.errors == []
    first, *others = pictures.values()
    assert all(np.abs(np.diff(picture)).max() > 50 for picture in first)  # something is seen
    for other in others:
        for mine, its in zip(first, other, strict=True):
            apart = np.abs(mine - its)
            assert apart.mean() < 0.1 and (apart > 30).mean() < 1e-3  # edges may differ by rounding
