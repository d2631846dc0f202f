"""Writes the tables of docs/coverage.md from what tools/coverage.sh measured:

    tools/coverage_table.py FOLDER PAGE

A table that was not measured stays as it is in the page."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path

#: Lines of a file: how many there are, which of them ran.
Counts = tuple[int, int]


def of_python(path: Path) -> dict[str, Counts]:
    """Lines by file, from the JSON of coverage.py."""
    files = json.loads(path.read_text(encoding="utf-8"))["files"]
    return {
        name.partition("python/stark/")[2]: (
            entry["summary"]["num_statements"],
            entry["summary"]["covered_lines"],
        )
        for name, entry in files.items()
    }


def of_cpp(path: Path) -> dict[str, Counts]:
    """Lines by file, from the JSON of gcovr."""
    result = {}
    for entry in json.loads(path.read_text(encoding="utf-8"))["files"]:
        counts: dict[int, int] = {}
        for line in entry["lines"]:
            if not line.get("gcovr/noncode", False):
                counts[line["line_number"]] = counts.get(line["line_number"], 0) + line["count"]
        result[entry["file"].partition("src/stark/")[2]] = (len(counts), sum(n > 0 for n in counts.values()))
    return result


def layer_of(name: str) -> str:
    """The folder of a file, for the files on top the package itself."""
    return name.rpartition("/")[0].partition("/")[0] or "(package)"


def table(files: dict[str, Counts]) -> list[str]:
    """Rows of a table by layer, and the three files with most lines that did not run."""
    layers: dict[str, list[Counts]] = {}
    for name, counts in files.items():
        layers.setdefault(layer_of(name), []).append(counts)
    rows = ["| layer | files | lines | run |", "|---|---|---|---|"]
    rows += [_row(f"`{name}`", layers[name]) for name in sorted(layers)]
    rows.append(_row("all", files.values()))
    least = sorted(files.items(), key=lambda item: item[1][1] - item[1][0])[:5]
    listed = ", ".join(f"`{name}` ({lines - run})" for name, (lines, run) in least if run < lines)
    return [*rows, "", f"Most lines that did not run: {listed}."]


def _row(name: str, files: Iterable[Counts]) -> str:
    found = list(files)
    lines, run = (sum(counts[i] for counts in found) for i in range(2))
    return f"| {name} | {len(found)} | {lines} | {100.0 * run / max(1, lines):.1f} % |"


def fill(page: str, name: str, rows: list[str]) -> str:
    """The page with the rows between the marks of a table."""
    start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    pattern = re.compile(re.escape(start) + ".*?" + re.escape(end), re.S)
    if not pattern.search(page):
        raise SystemExit(f"the page has no place for the table '{name}'")
    return pattern.sub(lambda match: start + "\n".join(rows) + "\n" + end, page)


def main() -> None:
    folder, path = Path(sys.argv[1]), Path(sys.argv[2])
    page = path.read_text(encoding="utf-8")
    for name, read in (("python", of_python), ("cpp", of_cpp)):
        if (folder / f"{name}.json").exists():
            page = fill(page, name, table(read(folder / f"{name}.json")))
    path.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
