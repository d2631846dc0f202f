"""Every public header compiles on its own: no header leans on what others happened to include before it."""

import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FLAGS = [
    "-std=c++20",
    "-fsyntax-only",
    "-march=x86-64-v3",
    "-Wall",
    "-Wextra",
    "-Wshadow",
    "-Werror",
    "-x",
    "c++",
]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_every_header_compiles_alone() -> None:
    headers = sorted(path.relative_to(ROOT / "src") for path in (ROOT / "src/stark").rglob("*.h"))
    assert len(headers) > 20

    def compile_alone(header: Path) -> str:
        # Included twice: the guard is part of the header.
        source = f"#include <{header}>\n#include <{header}>\n"
        done = subprocess.run(
            ["g++", *FLAGS, "-I", str(ROOT / "src"), "-"],
            input=source,
            capture_output=True,
            text=True,
            check=False,
        )
        return "" if done.returncode == 0 else f"{header}:\n{done.stderr[:2000]}"

    with ThreadPoolExecutor(max_workers=2) as pool:
        failures = [text for text in pool.map(compile_alone, headers) if text]
    assert failures == []
