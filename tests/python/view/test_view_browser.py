"""The page in a browser: Chromium without a window. Slow, and only where there is one."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _views import falling, free_port

import stark

pytest.importorskip("viser", reason="needs the extra 'view'")
playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright, from PyPI")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium: apt-get install chromium"),
]
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
#: Graphics without a graphics card on a busy machine take their time [s].
PATIENCE = 30.0


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, "it did not come about in time"
        time.sleep(0.05)


def picture(page: Any, path: Path) -> np.ndarray:
    """What is seen beside the panel (h, w, 3) uint8."""
    import imageio.v3 as imageio

    page.screenshot(path=path, timeout=2000.0 * PATIENCE)
    return np.asarray(imageio.imread(path))[200:, :440, :3].astype(int)


def browse(view: Any, folder: Path, seen: dict[str, Any]) -> None:
    """What somebody does who looks."""
    with playwright.sync_playwright() as start:
        browser = start.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 760, "height": 480})
        page.on("console", lambda m: seen["errors"].append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: seen["errors"].append(str(error)))
        page.goto(view.url)
        button = lambda name: page.get_by_role("button", name=name, exact=True)  # noqa: E731
        button("Pause").wait_for(timeout=1000.0 * PATIENCE)
        button("Pause").click()
        until(lambda: view.paused)
        time.sleep(3.0)  # bodies fade in
        seen["bodies"] = picture(page, folder / "bodies.png")
        at = view._report.time
        button("Step").click()
        until(lambda: view._report.time > at)
        time.sleep(0.3)
        seen["step"] = view._report.time - at
        page.get_by_role("checkbox", name="Contact forces").or_(
            page.get_by_label("Contact forces")
        ).first.click()
        until(lambda: bool(view._stage.contacts))
        view._later(lambda: view._show_field("stress"))
        time.sleep(2.0)
        seen["field"] = picture(page, folder / "field.png")
        button("Reset").click()
        until(lambda: view._report is None)
        button("Continue").click()
        until(lambda: view._report is not None and not view.paused)
        browser.close()
    until(lambda: not view._server.get_clients())
    at = view._report.time
    until(lambda: view._report.time > at + 0.05)
    seen["goes on without it"] = True


def test_a_browser_shows_it_and_handles_it(tmp_path: Path) -> None:
    scene = falling()
    stark.view.add_pulls(scene)
    sim = stark.Simulation(scene, time_step=0.01)
    seen: dict[str, Any] = {"errors": []}
    view = sim.view(port=free_port())

    def act() -> None:
        try:
            browse(view, tmp_path, seen)
        finally:
            view._later(view.close)

    thread = threading.Thread(target=act)
    thread.start()
    view.run()
    thread.join()
    assert seen["errors"] == []
    assert seen["step"] == pytest.approx(0.01)
    assert seen["goes on without it"]
    # The block of jelly is teal: green and blue over red; the picture is not empty and not all floor.
    red, green, blue = np.moveaxis(seen["bodies"], -1, 0)
    assert ((green > red + 25) & (blue > red + 25)).sum() > 500
    # Viridis has yellow or violet, which no body of the palette here has.
    red, green, blue = np.moveaxis(seen["field"], -1, 0)
    assert ((blue > green + 25) | (green > blue + 60)).sum() > 500
