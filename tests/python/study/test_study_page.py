"""The page of a study: complete in itself, and safe whatever the folder holds."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from _studies import grid, write_study

import stark
from stark.study import Study

_CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
EVIL = "</script><script>alert(1)</script>\x1b[31m\u202e"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("page")
    plan = write_study(folder, grid(height="[1.0, 2.0]", label=json.dumps(["a", EVIL.replace("\x1b", "")])))
    return stark.study.run(plan, folder / "out", processes=1)


def data_of(page: Path) -> dict[str, Any]:
    found = re.search(
        r'<script id="data" type="application/json">(.*?)</script>', page.read_text(), re.DOTALL
    )
    assert found is not None
    return json.loads(found[1])  # type: ignore[no-any-return]


def test_the_page_has_table_plots_pictures_and_links(study: Study) -> None:
    page = study.write_page()
    text, data = page.read_text(), data_of(page)
    assert "http" not in text.replace("http://www.w3.org/2000/svg", "").replace("http-equiv", "")
    assert "alert(1)</script>" not in text and "\u202e" not in text
    assert data["summary"] == "4 complete"
    fallen = data["columns"].index("observables.fallen")
    assert [row[fallen] for row in data["rows"]] == [row["observables.fallen"] for row in study.rows()]
    (plot,) = data["plots"]
    assert plot["title"] == "height" and [line["run"] for line in plot["lines"]] == [0, 1, 2, 3]
    assert plot["lines"][2]["x"] == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
    assert plot["lines"][2]["y"][-1] == pytest.approx(2.0 - 9.81e-4 * 15, rel=1e-5)
    assert len(data["thumbnails"]) == 4 and all(
        (page.parent / link).is_file() for link in data["replays"].values()
    )


def test_damaged_runs_are_rows_without_pictures(study: Study, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(study.folder, tmp_path / "out"))
    runs = [folder / "runs" / entry.key for entry in study.runs]
    shutil.rmtree(runs[0])
    (runs[1] / "manifest.json").write_text("{")
    shutil.rmtree(runs[2])
    runs[2].symlink_to(tmp_path)
    data = data_of(Study(folder).write_page(tmp_path / "elsewhere.html", replays=False))
    assert list(data["thumbnails"]) == ["3"] and len(data["rows"]) == 4
    assert {path.name for path in tmp_path.iterdir()} == {"out", "elsewhere.html"}


@pytest.mark.skipif(_CHROMIUM is None, reason="needs chromium: apt-get install chromium")
def test_a_browser_shows_it(study: Study, tmp_path: Path) -> None:
    words = [str(_CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    page = study.write_page(tmp_path / "page.html", replays=False)
    # A click on the heading sorts; another one sorts the other way.
    click = "document.querySelectorAll('th button')[0].click();"
    page.write_text(page.read_text().replace("</body>", f"<script>{click}{click}</script></body>"))
    done = subprocess.run(
        [*words, f"--user-data-dir={tmp_path}/profile", page.as_uri()],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    dom = done.stdout
    assert dom.count("<tr") == 5 and dom.count('class="run"') == 4 and dom.count('class="dot"') == 4
    assert "4 complete" in dom and 'aria-sort="descending"' in dom
    assert re.findall(r'<tr data-run="(\d)"', dom) == ["3", "2", "1", "0"]
