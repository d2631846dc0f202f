"""Every lint, cheapest first: tools/lint.py [--no-format]. Exit status 1 when any of them finds an error."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import check_forbidden
import check_layers
import check_mirror
import check_prose
import check_sizes
import check_types
import check_versions
from repository import ROOT, run_check


def command(title: str, *arguments: str) -> int:
    """Runs a tool in the root of the repository and shows what it prints."""
    done = subprocess.run(arguments, cwd=ROOT, capture_output=True, text=True, check=False)
    print(done.stdout + done.stderr, end="")
    return run_check(title, ["see above"] if done.returncode else [])


def main(arguments: list[str]) -> int:
    """Runs all lints; returns the exit status."""
    tools = Path(sys.executable).parent
    status = run_check("layers", check_layers.check(ROOT))
    status |= run_check("sizes", *check_sizes.check(ROOT))
    status |= run_check("forbidden", check_forbidden.check(ROOT))
    status |= run_check("versions", check_versions.check(ROOT))
    status |= run_check("mirror", check_mirror.check(ROOT))
    status |= run_check("prose", check_prose.check(ROOT))
    status |= run_check("types", check_types.check(ROOT))
    status |= command("ruff", str(tools / "ruff"), "check", "-q", ".")
    if "--no-format" not in arguments:
        status |= command("format", "sh", "tools/format.sh", "--check")
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
