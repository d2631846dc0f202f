"""Sources of the site of the documentation, without Sphinx: pages, links, entries of the reference.
`./run docs` builds the site from them, and `./run test --all` does so, too."""

from __future__ import annotations

import functools
import os
import re
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

import stark

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import docs_api  # noqa: E402
import docs_headers  # noqa: E402
import docs_math  # noqa: E402
import docs_site  # noqa: E402
import equations  # noqa: E402

LINK = re.compile(r"\]\(([^)\s]+)\)")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "source"
    docs_site.gather(ROOT, folder)
    return folder


def prose(text: str) -> str:
    """A page without its code."""
    return re.sub(r"^ *(```+).*?^ *\1|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(text: str) -> set[str]:
    """What links to headings of a page may name, by the rule of GitHub and MyST."""
    titles = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def test_every_document_is_a_page(site: Path) -> None:
    names = docs_site.page_names(ROOT)
    documents = {
        path.relative_to(ROOT).as_posix() for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    }
    assert documents <= set(names)
    assert len(set(names.values())) == len(names)
    assert [name for name in names.values() if not (site / name).is_file()] == []


def test_links_lead_to_pages_and_headings(site: Path) -> None:
    wrong = []
    for page in sorted(site.rglob("*.md")):
        for target in LINK.findall(prose(page.read_text(encoding="utf-8"))):
            if "://" in target:
                continue
            place, _, anchor = target.partition("#")
            path = Path(os.path.normpath(page.parent / place)) if place else page
            known = path.is_file() and path.is_relative_to(site)
            if not known or (anchor and anchor not in anchors(path.read_text(encoding="utf-8"))):
                wrong.append(f"{page.relative_to(site)}: {target}")
    assert wrong == []


def test_a_link_to_nothing_is_refused(tmp_path: Path) -> None:
    (tmp_path / "page.md").write_text("[this] and [that\nthing](gone.md)\n")
    with pytest.raises(SystemExit, match=r"page\.md: a link leads to gone\.md, which is not there"):
        docs_site.with_links(tmp_path, "page.md", {"page.md": "page.md"}, tmp_path / "out")


def test_links_in_code_stay(tmp_path: Path) -> None:
    text = "```\n[a](gone.md)\n```\n[b](https://x.example/y.md)\n"
    (tmp_path / "page.md").write_text(text)
    assert docs_site.with_links(tmp_path, "page.md", {"page.md": "page.md"}, tmp_path / "out") == text


def test_every_page_is_in_the_navigation(site: Path) -> None:
    pages = {path.relative_to(site).with_suffix("").as_posix() for path in site.rglob("*.*") if is_page(path)}
    listed = {"index"}
    for page in [*site.rglob("*.md"), *site.rglob("*.rst")]:
        for table in re.findall(r"(?:\{toctree\}|toctree::)\n(.*?)(?:```|\Z)", page.read_text(), re.DOTALL):
            rows = re.findall(r"^\s*([\w/]+)$", table, re.MULTILINE)
            listed |= {(page.parent / row).relative_to(site).as_posix() for row in rows}
    assert listed == pages


def is_page(path: Path) -> bool:
    return path.suffix in (".md", ".rst") and "files" not in path.parts


def test_every_public_name_has_an_entry(site: Path) -> None:
    shown = set()
    for page in (site / "api").glob("*.rst"):
        text = page.read_text(encoding="utf-8")
        module = "".join(re.findall(r"^\.\. py:currentmodule:: (\S+)", text, re.MULTILINE))
        for kind, name in re.findall(r"^\.\. (\w+|py:data|py:type):: ([\w.]+)", text, re.MULTILINE):
            shown.add(f"{module}.{name}" if kind.startswith("py:") else name)
        also = re.findall(r":py:obj:`stark\.(\w+)`", text)
        shown |= {f"{module}.{name}" for name in also}
    public = {f"stark.{name}" for name in docs_api.public_names()}
    for module in docs_api.public_modules():
        public |= {f"stark.{module}"} | {
            f"stark.{module}.{name}" for name in docs_api.public_names(f"stark.{module}")
        }
    assert len(public) > 250
    assert public - shown == set()


@pytest.mark.parametrize("page", ["coming_from", "troubleshooting"])
def test_names_that_a_page_gives_are_there(page: str) -> None:
    text = (ROOT / f"docs/{page}.md").read_text(encoding="utf-8")
    owners: dict[str, Any] = {
        "scene": stark.Scene,
        "sim": stark.Simulation,
        "report": stark.StepReport,
        "joint": stark.Joint,
        "body": stark.RigidBody,
        "cloth": stark.Cloth,
        "motor": stark.Actuator,
    }
    given = re.findall(rf"\b({'|'.join(owners)})\.(\w+)", text)
    values = {("motor", "target")}  # of some actuators
    assert [name for name in given if not hasattr(owners[name[0]], name[1]) and name not in values] == []
    settings = set(re.findall(r"`((?:time|contact|linear|execution|joints)\.\w+)`", text))
    assert settings and settings <= set(stark.Settings().names())
    for name in re.findall(r"`stark\.([\w.]+)", text):
        functools.reduce(getattr, name.split("."), stark)


def test_a_public_name_without_a_group_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    names = docs_api.public_names
    monkeypatch.setattr(docs_api, "public_names", lambda module="stark": [*names(module), *new(module)])
    with pytest.raises(SystemExit, match="Novelty: enter new names in GROUPS"):
        docs_api.pages()


def new(module: str) -> list[str]:
    return ["Novelty"] if module == "stark" else []


def test_every_public_header_is_a_page_with_its_types_and_functions(site: Path) -> None:
    headers = docs_headers.public_headers(ROOT)
    assert len(headers) > 10
    for header in headers:
        text = (ROOT / "src" / header).read_text(encoding="utf-8")
        page = (site / "cpp" / header.removeprefix("stark/").replace(".h", ".md")).read_text(encoding="utf-8")
        types = re.findall(
            r"^(?:class|struct|enum class) (\w+)(?: final)?(?: :[^;]*)? \{", text, re.MULTILINE
        )
        functions = re.findall(r"^\w[\w:<>*& ]* [*&]?(\w+)\([^;{]*\);", text, re.MULTILINE)
        assert docs_headers.leading_comment(text), header
        for name in [*types, *(f"{function}()" for function in functions)]:
            assert f"\n## `{name}`\n" in page, (header, name)


def test_declarations_of_a_header() -> None:
    text = """// What it is.
namespace stark {

class Elsewhere;

/// A body.
struct Body final {
 public:
  /// Its mass [kg].
  double mass() const { return mass_; }

 private:
  double mass_ = 1.0;
};

inline constexpr int kCount = size(2);

namespace inner {
Body make(  // a comment; with signs {
    int count);
}  // namespace inner
}  // namespace stark
"""
    found = docs_headers.declarations(text)
    assert [declaration.name for declaration in found] == ["Body", "kCount", "make()"]
    assert found[0].comment == "A body." and "mass_ = 1.0" not in found[0].code
    assert found[0].code.endswith("}\n};") and "Its mass [kg]" in found[0].code


def test_every_equation_is_drawn_and_can_be_linked(site: Path) -> None:
    text = (site / "theory.md").read_text(encoding="utf-8")
    drawn = re.findall(r"<math.*?</math>", text)
    for element in drawn:
        assert len(ElementTree.fromstring(element)) > 0
    assert len(drawn) > len(equations.defined())
    assert [number for number in equations.defined() if f'id="eq-{number}"' not in text] == []


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        ("½ m", '<mfrac><mn>1</mn><mn>2</mn></mfrac><mspace width="0.17em"/><mi>m</mi>'),
        ("x̂", '<mover accent="true"><mi>x</mi><mo>^</mo></mover>'),
        ("√a", "<msqrt><mi>a</mi></msqrt>"),
        ("vⁿ⁺¹", "<msup><mi>v</mi><mrow><mi>n</mi>"),
    ],
)
def test_notation_of_the_theory(formula: str, expected: str) -> None:
    assert expected in docs_math.mathml(formula)


def test_pages_of_sources_link_to_public_names(tmp_path: Path) -> None:
    """Sphinx links back to the places of definitions, and to modules without a text."""
    (tmp_path / "_modules" / "stark").mkdir(parents=True)
    (tmp_path / "api.html").write_text('<dt id="stark.hold"><dt id="stark.mesh.Mesh.save">')
    back = '<a class="viewcode-back" href="../../api.html#{}">[docs]</a>'
    page = tmp_path / "_modules" / "stark" / "joints.html"
    names = "stark.joints.hold", "stark.mesh.types.Mesh.save", "stark.mesh.Mesh.save", "stark.gone"
    start = '<a href="gone.html">theme</a><article role="main">'
    page.write_text(start + "\n".join(map(back.format, names)))
    index = tmp_path / "_modules" / "index.html"
    index.write_text('<article role="main"><li><a href="stark/joints.html">j</a><a href="core.html">core</a>')
    docs_site.mend_sources(tmp_path)
    kept = [back.format(name) for name in ("stark.hold", "stark.mesh.Mesh.save", "stark.mesh.Mesh.save")]
    assert page.read_text() == start + "\n".join([*kept, ""])
    assert index.read_text() == '<article role="main"><li><a href="stark/joints.html">j</a>core'


def test_names_of_guides_in_docstrings_lead_to_them() -> None:
    lines = ["Robots. docs/robots.md is the guide.", "``docs/scene_files.md`` (docs/a.md); docs/README.md"]
    docs_api._docstring(None, "module", "m", None, None, lines)
    assert lines == [
        "Robots. :doc:`/robots` is the guide.",
        ":doc:`/scene_files` (:doc:`/a`); docs/README.md",
    ]
