"""Thousands of random scenes, each of its own seed: what became of them, one line of JSON a scene."""

from __future__ import annotations

import json
import signal
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from stark.recording import Recorder
from stark.verify import verify

from .case import Outcome, Setup, is_over, run, simulate
from .random_kinds import KINDS
from .random_scenes import Description, Generator

#: CPU seconds after which a scene counts as hanging.
PATIENCE = 120.0
#: Accepted steps after which a scene of a campaign is over.
_MOST_STEPS = 400


def kind_at(index: int, kinds: Sequence[str]) -> str:
    return kinds[index % len(kinds)]


def description_of(seed: int, index: int, kind: str = "mixed") -> Description:
    return KINDS[kind][0](Generator(seed, index))


def run_one(seed: int, index: int, kind: str = "mixed", most_steps: int = 10**9, **settings: Any) -> Outcome:
    """Scene ``index`` of a seed; exceptions are problems."""
    outcome = Outcome(f"{kind} {seed}:{index}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            description = description_of(seed, index, kind)

            def make() -> Setup:
                setup = KINDS[kind][1](description)
                setup.most_steps = min(setup.most_steps, most_steps)
                return setup

            outcome = run(outcome.name, make(), **settings)
            if outcome.status != "refused":
                outcome.problems += _once_more(make, description, outcome)
    except TimeoutError as error:
        outcome.status, outcome.message = "no end", str(error)
        outcome.problems.append(f"{error}")
    except Exception as error:
        outcome.status, outcome.message = "exception", f"{type(error).__name__}: {error}"
        outcome.problems.append(traceback.format_exc(limit=-3))
    return outcome


def _once_more(make: Callable[[], Setup], d: Description, outcome: Outcome) -> list[str]:
    """The same scene on another number of threads, from a checkpoint on, or recorded and certified."""
    how = d.get("again", "")
    if not how:
        return []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        threads = {"threads": 1 if d["threads"] > 1 else 3} if how == "threads" else {}
        half = outcome.steps // 2 if how == "resume" else -1
        found = _hash(make, half, folder / "run" if how == "certify" else None, folder, **threads)
        if found != outcome.hash:
            return [f"once more with {how}: other bits"]
        if how != "certify":
            return []
        certificate = verify(folder / "run")
        # That prescribed bodies meet is what the steps have said themselves.
        told = {"prescribed_motion"} if "prescribed_overlap" in outcome.caveats else set()
        false = [c for c in certificate.claims if c.status == "violated" and c.name not in told]
        return [f"certificate: {claim.name}: {claim.detail} {claim.where}" for claim in false]


def _hash(make: Callable[[], Setup], half: int, record: Path | None, folder: Path, **settings: Any) -> str:
    """Of the last state. ``half``: steps after which another simulation goes on from a checkpoint."""
    setup = make()
    sim, steps = simulate(setup, **settings), 0
    recorder = None
    if record is not None:
        recorder = Recorder(record, sim, certify=True)
        recorder.record(sim)
        recorder.record_state(sim)
    while not is_over(sim, setup, steps):
        if steps == half:
            sim.save(folder / "half.stark")
            setup = make()
            sim = simulate(setup, **settings)
            sim.load(folder / "half.stark")
        if setup.drive is not None:
            setup.drive(sim)
        report = sim.step(max_time_step=setup.until - sim.time)
        if recorder is not None:
            recorder.report(report)
        if report.failed:
            break
        steps += 1
        if recorder is not None:
            recorder.record_state(sim)
    if recorder is not None:
        recorder.record(sim)
        recorder.close()
    return sim.state.hash


def run_campaign(
    seed: int,
    first: int,
    count: int,
    path: Path,
    kinds: Sequence[str] = ("mixed",),
    patience: float = PATIENCE,
) -> list[dict[str, Any]]:
    """Appends to ``path`` what became of each scene; the line before the last names one that crashed."""

    def give_up(*_: Any) -> None:
        raise TimeoutError(f"no end after {patience:g} CPU seconds")

    signal.signal(signal.SIGVTALRM, give_up)
    rows = []
    with path.open("a") as file:
        for index in range(first, first + count):
            kind = kind_at(index, kinds)
            begun = {"begun": index, "kind": kind}
            file.write(json.dumps(begun) + "\n")
            file.flush()
            signal.setitimer(signal.ITIMER_VIRTUAL, patience)
            row = {"index": index, "kind": kind, **run_one(seed, index, kind, _MOST_STEPS).row()}
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
            crash = {"kind": entry.get("kind", "mixed"), "status": "crash", "problems": ["crash"]}
            rows[entry["begun"]] = {"index": entry["begun"], **crash}
        else:
            rows[entry["index"]] = entry
    return list(rows.values())


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts of outcomes, of causes of failed steps and of caveats, and the numbers of scenes with
    problems; of each kind, too."""
    kinds = sorted({row.get("kind", "mixed") for row in rows})
    total = _counts(rows)
    if len(kinds) > 1:
        total["kinds"] = {k: _counts([row for row in rows if row.get("kind") == k]) for k in kinds}
    problems = total["problems"]
    total["where"] = {
        kind: [row["index"] for row in rows if any(kind_of(p) == kind for p in row["problems"])]
        for kind in problems
    }
    return total


def _counts(rows: list[dict[str, Any]]) -> dict[str, Any]:
    done = [row for row in rows if row["status"] != "crash"]
    caveats: Counter[str] = Counter()
    for row in done:
        caveats.update(row.get("caveats", {}))
    return {
        "scenes": len(rows),
        "outcomes": dict(Counter(row["status"] for row in rows)),
        "causes": dict(Counter(row["cause"] for row in done if row.get("cause"))),
        "caveats": dict(caveats),
        "steps": sum(row["steps"] for row in done),
        "iterations": sum(row["iterations"] for row in done),
        "retries": sum(row["retries"] for row in done),
        "around": sum(row["around"] for row in done),
        "open": sum(row["open"] for row in done),
        "seconds": sum(row["seconds"] for row in done),
        "slowest": max((row["seconds"] for row in done), default=0.0),
        "imbalance": max((row["imbalance"] for row in done), default=0.0),
        "growth": max((row["growth"] for row in done), default=0.0),
        "problems": dict(Counter(kind_of(problem) for row in rows for problem in row["problems"])),
    }


def kind_of(problem: str) -> str:
    """A problem without numbers of steps and values."""
    last = problem.strip().splitlines()[-1]
    text = last.split(": ", 1)[-1] if last.startswith(("step ", "random ")) else last
    return "".join(c for c in text.split(";")[0] if not c.isdigit())[:70].strip()
