"""What the library must never do: end the process, print, write files, keep unresolved notes."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from repository import CPP, ROOT, run_check, source_files

STRIPPED = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)*'", re.DOTALL)

# (pattern over code without comments and strings, reason)
FORBIDDEN = [
    (r"\b(?:std::)?(?:exit|_exit|quick_exit|_Exit)\s*\(", "the library never ends the process; throw"),
    (r"\b(?:std::)?(?:abort|terminate)\s*\(", "the library never ends the process; throw"),
    (r"(?<![.>\w])assert\s*\(", "use STARK_CHECK, which throws"),
    (r"\bstd::(?:cout|cerr|clog)\b", "the library never prints"),
    (r"\b(?:std::)?(?:printf|fprintf|puts|putchar|perror)\s*\(", "the library never prints"),
    (r"\bstd::(?:ofstream|fstream)\b|\bfopen\s*\(", "the library writes no files; that is Python's part"),
    (r"^\s*using\s+namespace\b", "no using namespace at file level"),
    (r"\b(?:rand|srand)\s*\(", "no hidden random state"),
    (r"#\s*pragma\s+omp\b", "threads go through base/thread_pool.h"),
]
# The vocabulary in which energies are written; included by files that do nothing else.
USING_NAMESPACE_ALLOWED = {"src/stark/mechanics/define.h"}
TODO = re.compile(r"\b(?:TODO|FIXME|XXX)\b")


def code_only(text: str) -> str:
    """The text with comments and literals blanked, line structure kept."""
    digit_separators_removed = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "", text)
    return STRIPPED.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), digit_separators_removed)


def check(root: Path) -> list[str]:
    """Forbidden constructs in src/, and unresolved notes anywhere in the sources."""
    errors = []
    for path in source_files(root, CPP, "src"):
        code = code_only(path.read_text())
        for pattern, reason in FORBIDDEN:
            if "namespace" in pattern and str(path.relative_to(root)) in USING_NAMESPACE_ALLOWED:
                continue
            for match in re.finditer(pattern, code, re.MULTILINE):
                start = match.end() - len(match.group().lstrip())
                line = code.count("\n", 0, start) + 1
                errors.append(f"{path.relative_to(root)}:{line}: {match.group().strip()} - {reason}")
    for folder in ("src", "python", "tests", "examples", "benchmarks"):
        for path in source_files(root, (*CPP, ".py", ".js"), folder):
            for number, line in enumerate(path.read_text().splitlines(), 1):
                if TODO.search(line) and path.name != "test_lints.py":
                    errors.append(
                        f"{path.relative_to(root)}:{number}: unresolved note; open an issue instead"
                    )
    return errors


if __name__ == "__main__":
    sys.exit(run_check("forbidden", check(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT)))
