"""Notebooks of the documentation: valid, without stored outputs, run from the first cell to the last."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import stark

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import notebooks  # noqa: E402

NOTEBOOKS = notebooks.notebooks(ROOT)


def test_the_notebooks_are_listed_and_have_no_outputs() -> None:
    assert NOTEBOOKS
    contents = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    for path in NOTEBOOKS:
        assert f"({path.relative_to(ROOT / 'docs')})" in contents
        code = [cell for cell in notebooks.cells(path) if cell["cell_type"] == "code"]
        assert len(code) > 3
        assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


def test_a_notebook_as_a_page_has_all_cells() -> None:
    page = notebooks.as_markdown(ROOT / "docs/tutorials/first_hour.ipynb")
    assert page.startswith("# The first hour\n") and page.count("```python\n") >= 4
    for cell in notebooks.cells(ROOT / "docs/tutorials/first_hour.ipynb"):
        assert cell["source"] in page


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a kernel of its own, as somebody who presses Run All; its assertions are its checks."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", str(Path(stark.__file__).resolve().parents[1]))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    book = nbformat.read(path, 4)
    nbformat.validate(book)
    resources = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(book, timeout=300, kernel_name="python3", resources=resources).execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    shown = [kind for output in outputs for kind in output.get("data", {})]
    assert shown.count("image/png") >= 2  # the simulation, and a picture
    assert any("<iframe" in output.get("data", {}).get("text/html", "") for output in outputs)  # the replay
    assert not [output for output in outputs if output.get("name") == "stderr"]
