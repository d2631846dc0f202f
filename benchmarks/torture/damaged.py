"""Damaged run folders, checkpoints and scene documents through every verb, thousands in one process: counts
of what was said. The damages are those of tests/python/fuzz, which `tools/fuzz.py` runs, too, in processes of
their own.

    PYTHONPATH=python .venv/bin/python -m benchmarks.torture.damaged --count 20000 --seed 1 --write
    PYTHONPATH=python .venv/bin/python -m benchmarks.torture.damaged checkpoints --seconds 600

Each case must end in what it should or in one clear line; nothing is written outside, nothing is lost, and
memory stays bounded: the process may not have more than 4 GB. Inputs that fail are written to ``out/fuzz``;
run them once more with ``tools/fuzz.py TARGET --input FILE``. The exit code is 1 if there are any."""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/python/fuzz"), str(ROOT / "tools")]

from _draw import Draw  # noqa: E402
from _targets import seeds  # noqa: E402

from fuzz import run_one  # noqa: E402

TARGETS = ("run_folders", "checkpoints", "scene_documents")
RESULTS = ROOT / "benchmarks/results"
_BATCH = 200  # cases of a seed
_MEMORY = 4 << 30  # [bytes]


def run(name: str, count: int, seconds: float, seed: int, folder: Path) -> dict[str, Any]:
    """Cases of seeds ``seed``, ``seed + 1``, ... until there are so many, or so many seconds are over."""
    said: Counter[str] = Counter()
    failures: list[str] = []
    began, cpu, cases, first = time.monotonic(), time.process_time(), 0, 0
    while cases < count and time.monotonic() - began < seconds:
        for data in seeds(name, min(_BATCH, count - cases), seed + cases // _BATCH):
            draw = Draw(data)
            found = run_one(name, draw)
            cases += 1
            said.update(_outcomes(draw.trace))
            if found:
                path = folder / f"{name}-{seed}-{cases - 1}.bin"
                path.write_bytes(data)
                failures.append(f"{path.name}: {found[:400]}")
                print(failures[-1], flush=True)
            if cases == _BATCH:
                first = _peak()
            if time.monotonic() - began > seconds:
                break
    return {
        "seed": seed,
        "cases": cases,
        "failures": failures,
        "said": dict(sorted(said.items())),
        "cpu_seconds": round(time.process_time() - cpu, 1),
        "peak_megabytes": _peak(),
        "grown_megabytes": _peak() - first if first else 0,
    }


def _outcomes(trace: list[str]) -> list[str]:
    """`verify: 3`, `load: refused`, `info: done`, without what was said and which damages there were."""
    verbs = ("info", "verify", "export", "still", "replay", "run", "load", "step", "read")
    found = []
    for line in trace:
        verb, arrow, rest = line.partition(" -> ")
        if verb.split()[0] in verbs or arrow:
            code = rest.split(" ", 1)[0]
            word = f"exit {code}" if code.isdigit() else "refused"
            found.append(f"{verb if verb in verbs else 'read'}: {word if arrow else 'done'}")
    return found


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024


def table(results: dict[str, dict[str, Any]]) -> str:
    """Markdown."""
    lines = [
        "| | cases | failures | what was said | CPU ms a case | peak MB (grown after 200 cases) |",
        "|---|--:|--:|---|--:|--:|",
    ]
    for name, row in results.items():
        said = ", ".join(f"{what} {count:,}" for what, count in row["said"].items())
        cost = 1e3 * row["cpu_seconds"] / max(row["cases"], 1)
        memory = f"{row['peak_megabytes']} ({row['grown_megabytes']})"
        lines.append(
            f"| {name} | {row['cases']:,} | {len(row['failures'])} | {said} | {cost:.0f} | {memory} |"
        )
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.torture.damaged", description=__doc__)
    parser.add_argument(
        "targets", nargs="*", metavar="TARGET", help=f"of {', '.join(TARGETS)}; all if left out"
    )
    parser.add_argument("--count", type=int, default=20_000, help="cases of each target")
    parser.add_argument("--seconds", type=float, default=1e9, help="for each target, at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"), help="folder of inputs that fail")
    parser.add_argument("--write", action="store_true", help="write benchmarks/results")
    arguments = parser.parse_args()
    names = arguments.targets or list(TARGETS)
    if unknown := set(names) - set(TARGETS):
        parser.error(f"unknown target {', '.join(sorted(unknown))}; there are {', '.join(TARGETS)}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    path = RESULTS / "torture_damaged.json"
    results = json.loads(path.read_text()) if path.exists() else {}
    for name in names:
        results[name] = run(name, arguments.count, arguments.seconds, arguments.seed, arguments.out)
        print(table({name: results[name]}))
        if arguments.write:
            path.write_text(json.dumps(results, indent=1) + "\n")
            title = "# Damaged run folders, checkpoints and scene documents\n\n"
            path.with_suffix(".md").write_text(title + table(results))
    return 1 if any(results[name]["failures"] for name in names) else 0


if __name__ == "__main__":
    sys.exit(main())
