"""Feeds random input to Stark until told to stop: the long mode of tests/python/fuzz.

    PYTHONPATH=python .venv/bin/python tools/fuzz.py                        # all targets, a minute each
    PYTHONPATH=python .venv/bin/python tools/fuzz.py scene --seconds 3600
    PYTHONPATH=python .venv/bin/python tools/fuzz.py run_folders --count 20000 --seed 1
    PYTHONPATH=python .venv/bin/python tools/fuzz.py scene --input out/fuzz/scene-0.bin     # once more
    PYTHONPATH=python .venv/bin/python tools/fuzz.py scene --atheris     # guided by coverage, needs atheris

Inputs run in a process of their own, so that crashes and hangs are found, too. Failing inputs are written to
``out/fuzz``, one for each kind of failure. The exit code is 1 if there are any."""

from __future__ import annotations

import argparse
import faulthandler
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/python/fuzz"))

if "--atheris" in sys.argv:
    import atheris

    with atheris.instrument_imports(include=["stark"]):
        import stark.scene
        import stark.verify  # noqa: F401
from _draw import Draw  # noqa: E402
from _targets import TARGETS, seeds  # noqa: E402

_BATCH = 200
_HANG = 60  # [s] of the processor for one input
_BLOCKED = 600.0  # [s] of the clock for one input, also on a machine that does other things


def run_one(name: str, draw: Draw) -> str:
    """What went wrong, in short, "" if nothing did."""
    faulthandler.dump_traceback_later(_BLOCKED, exit=True)
    faulthandler.register(signal.SIGXCPU, chain=True)
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + 1 + _HANG, hard))
    try:
        TARGETS[name](draw)
    except Exception as error:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if "stark" in f.filename]
        place = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else "the core"
        return f"{type(error).__name__} at {place}: {error} after {', '.join(draw.trace[-3:])}".replace(
            "\n", " "
        )
    finally:
        faulthandler.cancel_dump_traceback_later()
    return ""


def run_batch(name: str, seed: int, folder: Path) -> None:
    """In a process of its own: a line for each failure, and the input at hand in a file."""
    current = folder / f"{name}-current.bin"
    for data in seeds(name, _BATCH, seed):
        current.write_bytes(data)
        if found := run_one(name, Draw(data)):
            print(f"{data.hex()} {found}", flush=True)
    current.unlink()


def fuzz(name: str, seconds: float, count: int, seed: int, folder: Path) -> int:
    """Number of kinds of failures in so many seconds, or inputs if there is a count."""
    end, runs, kinds = time.monotonic() + seconds, 0, set()
    while runs < count if count else time.monotonic() < end:
        command = [sys.executable, __file__, name, "--batch", str(seed), "--out", str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        lines = [line.partition(" ")[::2] for line in done.stdout.splitlines()]
        current = folder / f"{name}-current.bin"
        if done.returncode != 0 and current.exists():
            tail = done.stderr.strip().splitlines()
            what = f"the process ended with {done.returncode}: {' '.join(tail[:1] + tail[-3:])}"
            lines.append((current.read_bytes().hex(), what))
        for data, what in lines:
            kind = what.partition(":")[0] + what.partition(":")[2].split(":")[0][:8]
            if kind not in kinds:
                kinds.add(kind)
                path = folder / f"{name}-{len(kinds) - 1}.bin"
                path.write_bytes(bytes.fromhex(data))
                print(f"{path}: {what[:600]}")
        runs, seed = runs + _BATCH, seed + 1
    print(f"{name}: {runs} inputs, {len(kinds)} failures")
    return len(kinds)


def guided(name: str, folder: Path) -> None:
    """Lets atheris look for inputs that reach new code; it never returns."""
    corpus = folder / f"{name}-corpus"
    corpus.mkdir(parents=True, exist_ok=True)
    for k, data in enumerate(seeds(name, 50)):
        (corpus / f"seed-{k}").write_bytes(data)

    def test(data: bytes) -> None:
        if found := run_one(name, Draw(data)):
            raise AssertionError(found)

    atheris.Setup([sys.argv[0], str(corpus), f"-artifact_prefix={folder}/{name}-"], test)
    atheris.Fuzz()


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("target", nargs="*", help=f"of {', '.join(TARGETS)}; all if left out")
    parser.add_argument("--seconds", type=float, default=60.0, help="for each target (60)")
    parser.add_argument("--count", type=int, default=0, help="so many inputs for each target, instead")
    parser.add_argument("--seed", type=int, help="of the first batch; drawn if left out")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"), help="folder of failing inputs")
    parser.add_argument("--input", type=Path, help="run this input alone, and raise what it raises")
    parser.add_argument("--atheris", action="store_true", help="inputs guided by coverage")
    parser.add_argument("--batch", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    names = args.target or list(TARGETS)
    if unknown := set(names) - set(TARGETS):
        parser.error(f"unknown target {', '.join(unknown)}")
    args.out.mkdir(parents=True, exist_ok=True)
    if args.input is not None:
        draw = Draw(args.input.read_bytes())
        try:
            TARGETS[names[0]](draw)
        finally:
            print("\n".join(draw.trace))
    elif args.batch is not None:
        run_batch(names[0], args.batch, args.out)
    elif args.atheris:
        guided(names[0], args.out)
    else:
        seed = int.from_bytes(os.urandom(4), "little") if args.seed is None else args.seed
        return int(sum([fuzz(name, args.seconds, args.count, seed, args.out) for name in names]) > 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
