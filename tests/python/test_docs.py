"""What the documents promise: links lead somewhere, equations cited in sources exist, hello worlds run."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import equations  # noqa: E402

DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


def code_blocks(path: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_relative_links_exist(document: Path) -> None:
    targets = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", document.read_text())
    missing = [t for t in targets if "://" not in t and not (document.parent / t).exists()]
    assert missing == []


def test_files_of_the_architecture_tables_exist() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text()
    layers = r"(?:base|linalg|geometry|symbolic|collision|solve|mechanics|models|contact|sim|io)"
    names = set(re.findall(rf"(?<![\w/])({layers}(?:/\w+)+)(?:\.h|\.cpp)?(?![\w/])", text))
    assert len(names) > 15
    source = ROOT / "src/stark"
    missing = [
        name for name in sorted(names) if not (source / name).is_dir() and not [*source.glob(f"{name}.*")]
    ]
    assert missing == []


def test_equations_of_the_theory_are_numbered_without_gap_or_repetition() -> None:
    numbers = equations.defined()
    assert len(numbers) == len(set(numbers))
    bare = [int(number) for number in numbers if number.isdigit()]
    assert bare == list(range(1, len(bare) + 1)) and len(bare) > 30
    for number in {number[:-1] for number in numbers if not number.isdigit()}:
        letters = sorted(other[-1] for other in numbers if not other.isdigit() and other[:-1] == number)
        assert letters == [chr(ord("a") + k) for k in range(len(letters))], number
        assert number in numbers, number


def test_equations_that_are_cited_exist() -> None:
    numbers, cited, wrong = set(equations.defined()), set(), []
    for path in equations.citing_files():
        if path == Path(__file__).resolve():  # has wrong ones on purpose
            continue
        for number, around in equations.citations(path):
            cited.add((path.suffix, number))
            if number not in numbers:
                wrong.append(f"{path.relative_to(ROOT)}: {around}")
    assert wrong == []
    assert len(cited) > 50 and {suffix for suffix, _ in cited} == {".h", ".cpp", ".py", ".md"}


def test_every_equation_is_cited_by_a_source_that_implements_it() -> None:
    sources = [path for path in equations.citing_files() if path.suffix != ".md"]
    places = [
        path for path in sources if path.is_relative_to(ROOT / "src") or path.is_relative_to(ROOT / "python")
    ]
    cited = {number for path in places for number, _ in equations.citations(path)}
    assert [number for number in equations.defined() if number not in cited] == []


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("// [theory eq. 7, 9a]", ["7", "9a"]),
        ("see [the theory](../theory.md#5-contact), eq. 28 to 31", ["28", "29", "30", "31"]),
        ("[theory, eq. 20b](theory.md#6-friction)", ["20b"]),
        ("theory eqs. 11 and\n// 14a", ["11", "14a"]),
        ("(theory eq. (26b)), not [Li et al. 2020, eq. 17]", ["26b"]),
        ("the paper's eq. 18", []),
    ],
)
def test_citations_are_read_with_lists_and_ranges(tmp_path: Path, text: str, numbers: list[str]) -> None:
    path = tmp_path / "a.cpp"
    path.write_text(text)
    assert [number for number, _ in equations.citations(path)] == numbers


def test_a_citation_in_a_source_says_of_what(tmp_path: Path) -> None:
    path = tmp_path / "a.cpp"
    path.write_text("// as in [eq. 24]")
    with pytest.raises(ValueError, match="of which paper"):
        list(equations.citations(path))
    document = tmp_path / "a.md"
    document.write_text("as in (eq. 24)")
    assert [number for number, _ in equations.citations(document)] == ["24"]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_cpp_hello_world_of_the_readme_compiles() -> None:
    (code,) = code_blocks(ROOT / "README.md", "cpp")
    command = ["g++", "-std=c++20", "-fsyntax-only", "-Wall", "-I", str(ROOT / "src"), "-x", "c++", "-"]
    done = subprocess.run(command, input=code, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
