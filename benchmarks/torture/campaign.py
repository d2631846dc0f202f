"""Thousands of random scenes, each of its own seed: what became of them, one line of JSON a scene."""

from __future__ import annotations

import json
import signal
import traceback
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

from .case import Outcome, run
from .random_scenes import Generator, build, draw

#: CPU seconds after which a scene counts as hanging.
_PATIENCE = 120


def run_one(seed: int, index: int, **settings: Any) -> Outcome:
    """Scene ``index`` of a seed; exceptions are problems."""
    name = f"random {seed}:{index}"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return run(name, build(draw(Generator(seed, index))), **settings)
    except Exception as error:
        outcome = Outcome(name, status="exception", message=f"{type(error).__name__}: {error}")
        outcome.problems.append(traceback.format_exc(limit=-3))
        return outcome


def run_campaign(seed: int, first: int, count: int, path: Path) -> list[dict[str, Any]]:
    """Appends to ``path`` what became of each scene; the line before the last names one that crashed."""

    def give_up(*_: Any) -> None:
        raise TimeoutError(f"no end after {_PATIENCE} CPU seconds")

    signal.signal(signal.SIGVTALRM, give_up)
    rows = []
    with path.open("a") as file:
        for index in range(first, first + count):
            file.write(json.dumps({"begun": index}) + "\n")
            file.flush()
            signal.setitimer(signal.ITIMER_VIRTUAL, _PATIENCE)
            row = {"index": index, **run_one(seed, index).row()}
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            file.write(json.dumps(row) + "\n")
            file.flush()
            rows.append(row)
    return rows


def read(path: Path) -> list[dict[str, Any]]:
    """Rows of a file, and those scenes that were begun and never ended as crashes."""
    rows: dict[int, dict[str, Any]] = {}
    for line in path.read_text().splitlines():
        entry = json.loads(line)
        if "begun" in entry:
            rows[entry["begun"]] = {"index": entry["begun"], "status": "crash", "problems": ["crash"]}
        else:
            rows[entry["index"]] = entry
    return list(rows.values())


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts of outcomes, of messages of failed steps, and the numbers of scenes with problems."""
    done = [row for row in rows if row["status"] != "crash"]
    problems = Counter(kind_of(problem) for row in rows for problem in row["problems"])
    return {
        "scenes": len(rows),
        "outcomes": dict(Counter(row["status"] for row in rows)),
        "steps": sum(row["steps"] for row in done),
        "iterations": sum(row["iterations"] for row in done),
        "retries": sum(row["retries"] for row in done),
        "around": sum(row["around"] for row in done),
        "open": sum(row["open"] for row in done),
        "seconds": sum(row["seconds"] for row in done),
        "slowest": max((row["seconds"] for row in done), default=0.0),
        "imbalance": max((row["imbalance"] for row in done), default=0.0),
        "growth": max((row["growth"] for row in done), default=0.0),
        "problems": dict(problems),
        "where": {
            kind: [row["index"] for row in rows if any(kind_of(p) == kind for p in row["problems"])]
            for kind in problems
        },
    }


def kind_of(problem: str) -> str:
    """A problem without numbers of steps and values."""
    last = problem.strip().splitlines()[-1]
    text = last.split(": ", 1)[-1] if last.startswith(("step ", "random ")) else last
    return "".join(c for c in text.split(";")[0] if not c.isdigit())[:70].strip()
