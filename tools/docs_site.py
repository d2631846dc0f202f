"""Builds the documentation as a site: tools/docs_site.py [--out out/docs]. `./run docs` calls it.

The Markdown pages of the repository are the sources. They are gathered in OUT/source under the names that
they have in the site, with links to match; the reference of the Python and the C++ interface is generated
beside them. Then Sphinx makes OUT/html. Needs the package with its extension and the extra `docs`.
"""

from __future__ import annotations

import argparse
import functools
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import docs_api
import docs_headers
import docs_math
import notebooks
from repository import ROOT

#: Pages outside of docs/, and their names in the site.
ELSEWHERE = {
    "README.md": "overview.md",
    "ARCHITECTURE.md": "architecture.md",
    "CONTRIBUTING.md": "contributing.md",
    "RELEASING.md": "releasing.md",
    "CHANGELOG.md": "changelog.md",
    "SECURITY.md": "security.md",
    "CODE_OF_CONDUCT.md": "code_of_conduct.md",
    "benchmarks/README.md": "benchmarks/index.md",
    "benchmarks/kernels/README.md": "benchmarks/kernels.md",
    "benchmarks/symbolic/README.md": "benchmarks/symbolic.md",
    "benchmarks/results/robots.md": "benchmarks/robots.md",
    "benchmarks/results/scenes.md": "benchmarks/scenes.md",
    "benchmarks/results/larger_scenes.md": "benchmarks/larger_scenes.md",
    "benchmarks/results/growth.md": "benchmarks/growth.md",
    "benchmarks/results/peers.md": "benchmarks/peers.md",
    "benchmarks/results/scene_documents.md": "benchmarks/scene_documents.md",
    "benchmarks/results/torture.md": "benchmarks/torture.md",
    "benchmarks/results/torture_random.md": "benchmarks/torture_random.md",
    "benchmarks/results/torture_damaged.md": "benchmarks/torture_damaged.md",
    "benchmarks/results/torture_sample.md": "benchmarks/torture_sample.md",
}
#: Page with the table of contents, and the section that generated pages are part of.
CONTENTS = "docs/README.md"
GENERATED = {
    "Reference": {
        "api/index.rst": (
            "Python interface",
            "every public name, with its signature, shapes, units and errors",
        ),
        "cpp.md": ("C++ interface", "the public headers"),
    }
}
#: Page of pictures, and the packaged scenes whose replays it embeds.
GALLERY = "docs/gallery.md"
REPLAYS = {
    "hello_cloth": "A cotton cloth over a turning box. Drag to turn the view, click on a body to pick it."
}
_LINK = re.compile(r"(!?)\[((?:[^][]|\[[^][]*\])*)\]\(([^)\s]+)\)")
_ID = re.compile(r'id="([^"]+)"')
_SOURCE_LINK = re.compile(
    r'<a (?:class="viewcode-back" )?href="(?P<path>[^"#:]+)(?:#(?P<name>[^"]+))?">(?P<text>[^<]*)</a>'
)
_CODE = re.compile(r"(^ *```.*?^ *```$)", re.MULTILINE | re.DOTALL)


def page_names(root: Path) -> dict[str, str]:
    """Every page of the repository that the site has, and its name there."""
    inside = {path.relative_to(root).as_posix(): path for path in sorted((root / "docs").rglob("*.md"))}
    names = {page: page.removeprefix("docs/") for page in inside}
    for path in notebooks.notebooks(root):
        page = path.relative_to(root)
        names[page.as_posix()] = page.relative_to("docs").with_suffix(".md").as_posix()
    return names | {CONTENTS: "index.md"} | ELSEWHERE


def gather(root: Path, folder: Path) -> None:
    """Writes the sources of the site into an empty folder."""
    names = page_names(root)
    for page, name in names.items():
        text = with_links(root, page, names, folder)
        if page == CONTENTS:
            text = with_generated(text)
            text += "\n" + contents(text)
        if page == GALLERY:
            text += embedded_replays()
        if page == "docs/theory.md":
            text = docs_math.with_mathml(text)
        _write(folder / name, text)
    for name, text in (docs_api.pages() | docs_headers.pages(root)).items():
        _write(folder / name, text)


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def with_links(root: Path, page: str, names: dict[str, str], folder: Path) -> str:
    """A page of the repository with links that lead to where things are in the site."""
    path = root / page
    text = notebooks.as_markdown(path) if path.suffix == ".ipynb" else path.read_text(encoding="utf-8")
    parts = _CODE.split(text)
    parts[::2] = [
        _LINK.sub(lambda found: _link(root, page, names, folder, found), prose) for prose in parts[::2]
    ]
    return "".join(parts)


def _link(root: Path, page: str, names: dict[str, str], folder: Path, found: re.Match[str]) -> str:
    mark, text, target = found.groups()
    place, hash_sign, anchor = target.partition("#")
    if not place or "://" in place or place.startswith("mailto:"):
        return found[0]
    path = Path(os.path.normpath((root / page).parent / place))
    if not path.exists():
        raise SystemExit(f"{page}: a link leads to {target}, which is not there")
    here = (folder / names[page]).parent
    if path.is_dir():
        return f"[{text}]" if text.startswith("`") else text  # a folder has no page
    known = path.relative_to(root).as_posix()
    if known in names:
        return f"{mark}[{text}]({os.path.relpath(folder / names[known], here)}{hash_sign}{anchor})"
    copy = folder / "files" / known
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(path, copy)
    return f"{mark}[{text}]({os.path.relpath(copy, here)})"


def with_generated(text: str) -> str:
    """The page of contents with entries of the generated pages at the top of their sections."""
    for section, entries in GENERATED.items():
        rows = "".join(f"- [{title}]({page}): {what}\n" for page, (title, what) in entries.items())
        text = text.replace(f"## {section}\n\n", f"## {section}\n\n{rows}")
    return text


def embedded_replays() -> str:
    """A section that shows the pages of add_replays()."""
    frames = "\n".join(
        f"{text}\n\n```{{raw}} html\n"
        f'<iframe src="replays/{name}.html" title="{name}" width="100%" height="560" loading="lazy" '
        f'style="border: 1px solid #8886; border-radius: 6px"></iframe>\n```\n'
        for name, text in REPLAYS.items()
    )
    return f"\n## Replays\n\n{frames}"


def add_replays(html: Path) -> int:
    """Runs the packaged scenes of REPLAYS and puts their pages into the site; returns the exit status."""
    (html / "replays").mkdir(exist_ok=True)
    local = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    for name in REPLAYS:
        run = html.parent / "runs" / name
        shutil.rmtree(run, ignore_errors=True)
        command = [sys.executable, "-m", "stark", "run", name, "--quiet", "--no-picture", "--out", str(run)]
        if status := subprocess.run(command, env=local, check=False).returncode:
            return status
        shutil.copyfile(run / "replay.html", html / "replays" / f"{name}.html")
    return 0


def contents(text: str) -> str:
    """Navigation in the order of the page's own list: a table of contents for each section."""
    tables = []
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        entries = re.findall(r"\]\(([^)#:]+)\.(?:md|rst)\)", body)
        rows = "\n".join(dict.fromkeys(entries))
        tables.append(f"```{{toctree}}\n:hidden:\n:caption: {title.strip()}\n\n{rows}\n```\n")
    return "\n".join(tables)


def build(out: Path, root: Path = ROOT) -> int:
    """Makes the site in a folder; returns the exit status, which is not 0 after any warning."""
    source = out / "source"
    for folder in (source, out / "html"):
        shutil.rmtree(folder, ignore_errors=True)
    gather(root, source)
    command = [sys.executable, "-m", "sphinx", "-E", "-W", "--keep-going", "-q", "-c", str(root / "docs")]
    done = subprocess.run([*command, "-d", str(out / "cache"), str(source), str(out / "html")], check=False)
    if done.returncode == 0:
        mend_sources(out / "html")
    return done.returncode


def mend_sources(html: Path) -> None:
    """Links of the pages of sources. They lead back to the names under which things are defined, which are
    not always those under which they are public, and to modules that have no text."""
    anchors: dict[Path, set[str]] = {}

    def mended(page: Path, link: re.Match[str]) -> str:
        path = (page.parent / link["path"]).resolve()
        if path not in anchors:
            anchors[path] = set(_ID.findall(path.read_text(encoding="utf-8"))) if path.is_file() else set()
        known, name = anchors[path], link["name"]
        if name is None and path.is_file():
            return link[0]
        if public := next((other for other in _shortened(name or "") if other in known), None):
            return link[0].replace(f"#{name}", f"#{public}")
        return "" if "viewcode-back" in link[0] else link["text"]

    for page in sorted((html / "_modules").rglob("*.html")):
        text = page.read_text(encoding="utf-8")
        body = text.partition('<article role="main"')
        mend = functools.partial(mended, page)
        page.write_text(body[0] + body[1] + _SOURCE_LINK.sub(mend, body[2]), encoding="utf-8")


def _shortened(name: str) -> Iterator[str]:
    """A dotted name, and the same without some modules in its middle."""
    parts = name.split(".")
    yield name
    for start in range(1, len(parts)):
        for end in range(start + 1, len(parts)):
            yield ".".join(parts[:start] + parts[end:])


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds the documentation as a site.")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "docs", help="folder of the site")
    out = parser.parse_args().out.resolve()
    docs_api.use_local_package()
    status = build(out) or add_replays(out / "html")
    print(f"Open {out / 'html' / 'index.html'}" if status == 0 else "The site has defects, see above")
    return status


if __name__ == "__main__":
    sys.exit(main())
