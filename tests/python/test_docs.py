"""What the documents promise: links lead somewhere, equations cited in sources exist, hello worlds run."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
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
    names = set(re.findall(rf"(?<![\w/])({layers}/\w+)(?:\.h|\.cpp)?(?![\w/])", text))
    assert len(names) > 15
    missing = [name for name in sorted(names) if not list((ROOT / "src/stark").glob(f"{name}.*"))]
    assert missing == []


def test_equations_cited_in_sources_exist() -> None:
    theory = (ROOT / "docs/theory.md").read_text()
    numbers = [int(n) for n in re.findall(r"^    .*\((\d+)\)$", theory, re.MULTILINE)]
    assert numbers == list(range(1, len(numbers) + 1))
    cited = 0
    for path in (ROOT / "src").rglob("*"):
        if path.suffix in (".h", ".cpp"):
            for citation in re.findall(r"theory eq\. (\d+(?:, \d+)*)", path.read_text()):
                for number in citation.split(", "):
                    cited += 1
                    assert int(number) in numbers, f"{path.name} cites equation {number}"
    assert cited > 0


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_cpp_hello_world_of_the_readme_compiles() -> None:
    (code,) = code_blocks(ROOT / "README.md", "cpp")
    command = ["g++", "-std=c++20", "-fsyntax-only", "-Wall", "-I", str(ROOT / "src"), "-x", "c++", "-"]
    done = subprocess.run(command, input=code, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
