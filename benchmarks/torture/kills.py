"""kill -9 at random moments of certified and of plain runs, again and again: each time the run is resumed,
and its recording ends up as that of a run that was never killed.

    PYTHONPATH=python .venv/bin/python benchmarks/torture/kills.py --kills 100 --seed 1

A step of the scene takes milliseconds, so that many kills hit the writing of files. Every folder that a kill
leaves is looked at: its chain of digests must hold. The exit code is 1 if anything went wrong."""

from __future__ import annotations

import argparse
import hashlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import stark
from stark.recording import Recording
from stark.verify import UnreadableRecording, verify

_SCENE = '''
"""A box swings over a sheet that falls."""

import stark

until = 1.0  # [s]


def settings():
    return {"time_step": 0.002}


def build():
    scene = stark.Scene()
    box = scene.add_box(0.1, mass=1.0, position=(0.3, 0.0, 0.0), name="box")
    scene.add_hinge(None, box, anchor=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), position=(0.0, 1.0, 0.0), name="cloth", pins=[0])
    return scene
'''


#: Runs that are killed in turns, with their options.
_KINDS = {"certified": ("--certify",), "plain": ()}


def start(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "stark", "run", *words, "--quiet", "--no-replay", "--no-picture"]
    source = str(Path(stark.__file__).parent.parent)
    return subprocess.Popen(command, cwd=folder, env={**os.environ, "PYTHONPATH": source})


def under_way(process: subprocess.Popen[bytes], run: Path, since: float) -> bool:
    """Waits until the process writes its folder; False when it ends before."""
    while process.poll() is None:
        lock = run / "run.lock"
        if lock.exists() and lock.stat().st_mtime >= since:
            return True
        time.sleep(0.001)
    return False


def kill(process: subprocess.Popen[bytes], wait: float) -> bool:
    """kill -9 after some time [s]; False when the process came to its end before."""
    try:
        process.wait(wait)
        return False
    except subprocess.TimeoutExpired:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        return True


def digest(run: Path) -> str:
    """Of frames and states, which plain runs lack; telemetry holds seconds of the clock."""
    files = sorted([*(run / "frames").glob("*"), *(run / "states").glob("*")])
    return hashlib.sha256(b"".join(path.name.encode() + path.read_bytes() for path in files)).hexdigest()


def defects(run: Path) -> str:
    """What is wrong with a folder that a kill left, "" if nothing."""
    if not (run / "checkpoint.stark").exists():
        return ""
    try:
        Recording(run)
        certificate = verify(run)
    except (stark.Error, UnreadableRecording) as error:
        return str(error)
    return certificate.text() if certificate.verdict == "violated" else ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng, kills, rounds, wrong = np.random.default_rng(arguments.seed), 0, 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder, run = Path(name), Path(name) / "run"
        (folder / "swing.py").write_text(_SCENE)
        whole = {}
        for kind, certify in _KINDS.items():
            assert start(folder, "swing.py", *certify, "--out", kind).wait() == 0
            whole[kind] = digest(folder / kind)
        while kills < arguments.kills and not wrong:
            rounds += 1
            kind = list(_KINDS)[rounds % 2]
            every = str(rng.choice([0.0, 0.0, 0.05, 1e9]))
            words = ["swing.py", *_KINDS[kind], "--out", "run", "--checkpoint-every", every]
            for _ in range(12):
                since = time.time()
                process = start(folder, *words)
                if not under_way(process, run, since - 0.05) or not kill(process, rng.uniform(0.0, 0.3)):
                    break
                kills += 1
                if found := defects(run):
                    wrong += 1
                    print(f"kill {kills} (seed {arguments.seed}): {found}")
                if (run / "checkpoint.stark").exists():
                    words = ["--resume", "run"]
            process = start(folder, *words)
            if process.wait() != 0 or digest(run) != whole[kind] or defects(run):
                wrong += 1
                print(f"round {rounds} (seed {arguments.seed}): the run does not end up as one without kills")
    print(f"{kills} kills in {rounds} runs, {wrong} defects")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
