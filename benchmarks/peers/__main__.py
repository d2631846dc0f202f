"""The same cases in Stark, MuJoCo and PyBullet, each peer in an environment of its own:

    PYTHONPATH=python python -m benchmarks.peers [CASE...] [--environment FOLDER] [--write]

The environment (out/peers unless said otherwise) is made with benchmarks/peers/requirements.txt if it is not
there. ``--write`` makes benchmarks/results/peers.md and its rows."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from benchmarks.peers import cases
from benchmarks.peers.page import page

HERE = Path(__file__).resolve().parent
ROOT, RESULTS = HERE.parents[1], HERE.parent / "results"
PEERS = ("in_mujoco", "in_pybullet")
#: One thread, whatever the libraries of the peers would take.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def interpreter(folder: Path) -> Path:
    """Of the environment with the peers, which is made if need be."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run(
            [str(python), "-m", "pip", "install", "-q", "-r", str(HERE / "requirements.txt")], check=True
        )
    return python


def peer_rows(python: Path, module: str, names: list[str]) -> list[dict[str, Any]]:
    """Rows of a peer, from its interpreter."""
    program = "import sys, json; sys.path.insert(0, sys.argv[1]); import " + module + " as m\n"
    program += "rows = [{'case': c, 'system': m.VERSION} | row for c in sys.argv[2:] for row in m.run(c)]\n"
    program += "print('rows ' + json.dumps(rows))"
    command = [str(python), "-c", program, str(HERE), *names]
    output = subprocess.run(
        command, check=True, capture_output=True, text=True, env=os.environ | ONE_THREAD
    ).stdout
    line = next(line for line in output.splitlines() if line.startswith("rows "))
    rows: list[dict[str, Any]] = json.loads(line.removeprefix("rows "))
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.peers", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(cases.CASES)}; default: all")
    parser.add_argument("--environment", type=Path, default=ROOT / "out" / "peers", metavar="FOLDER")
    parser.add_argument("--write", action="store_true", help="write benchmarks/results/peers.*")
    arguments = parser.parse_args()
    names = arguments.cases or list(cases.CASES)
    from benchmarks.peers import in_stark

    rows = [{"case": case, "system": in_stark.VERSION} | row for case in names for row in in_stark.run(case)]
    python = interpreter(arguments.environment)
    for module in PEERS:
        rows += peer_rows(python, module, names)
    text = page(rows)
    print(text)
    if arguments.write:
        (RESULTS / "peers.md").write_text(text)
        (RESULTS / "peers.json").write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
