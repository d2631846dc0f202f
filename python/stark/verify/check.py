"""Checks a recording: one pass through its states, then its telemetry, then the certificate."""

from __future__ import annotations

import platform
import sys
import time as clock
from collections.abc import Callable
from os import PathLike
from typing import Any

import numpy as np

from .certificate import CERTIFICATE_VERSION, NOT_RECORDED, Certificate, Claim
from .chain import ChainCheck
from .files import UnreadableRecording, as_path
from .frames import FrameCheck
from .geometry import GeometryCheck
from .inertia import InertiaCheck
from .joints import JointCheck
from .limits import excluded_pairs, limits_of
from .prescribed import PrescribedCheck
from .reading import digest, read
from .run import Run
from .shapes import ShapeCheck
from .telemetry import friction_claim, ledger_claim, residual_claim, steps_claim

_WITHOUT_STATES = {
    "no_intersection": "no edge meets a triangle in any accepted state",
    "minimum_distance": "surfaces keep their least distance",
    "paths": "nothing passes through anything on straight paths between accepted states",
    "joints": "joints and attachments are held within the tolerances of the settings",
}


def verify(
    folder: str | PathLike[str], *, progress: Callable[[float, str], None] = lambda done, text: None
) -> Certificate:
    """Checks the run in ``folder`` and says what is certain about it.

    ``progress(done, text)`` is called with the share in [0, 1] that is done. Raises UnreadableRecording for
    folders that are no recording, or a damaged one."""
    begin = clock.perf_counter()
    try:
        run = read(as_path(folder, "verify: folder"))
        claims = _claims_of(run, progress)
        recording, limits = _described(run), tuple(limits_of(run, claims))
    except UnreadableRecording:
        raise
    except (
        ArithmeticError,
        AttributeError,
        LookupError,
        MemoryError,
        RecursionError,
        TypeError,
        ValueError,
    ) as error:
        reason = f"{type(error).__name__}: {error}"
        raise UnreadableRecording(f"'{folder}' lacks or breaks an entry ({reason})") from error
    tools = {
        "checker": f"stark.verify, certificates of version {CERTIFICATE_VERSION}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "platform": f"{sys.platform} {platform.machine()}",
    }
    return Certificate(recording, tools, tuple(claims), limits, clock.perf_counter() - begin)


def _described(run: Run) -> dict[str, Any]:
    """What the certificate says about the recording as such."""
    return {
        "scene": str(run.manifest.get("scene", "")),
        "status": str(run.manifest.get("status", "")),
        "created": str(run.manifest.get("created", "")),
        "resumed": [float(time) for time in run.manifest.get("resumed", [])],
        "stark_version": str(run.manifest.get("stark_version", "")),
        "steps": len(run.rows),
        "states": len(run.times),
        "end_time": float(run.times[-1]) if len(run.times) else None,
        "excluded_pairs": excluded_pairs(run),
        "digest": digest(run.files),
        "files": run.files,
    }


def _claims_of(run: Run, progress: Callable[[float, str], None]) -> list[Claim]:
    chain = ChainCheck(run)
    if run.has_states:
        claims = _claims_of_states(run, chain, progress)
    else:
        claims = [steps_claim(run, []), *_not_recorded()]
    frames = FrameCheck(run, chain)
    frames.check()
    chain.lines()
    reported = [residual_claim(run), ledger_claim(run), friction_claim(run)]
    return [*claims, *reported, frames.claim(), chain.claim()]


def _not_recorded() -> list[Claim]:
    detail = "frames are rounded and few: record with 'stark run --certify', or Recorder(..., certify=True)"
    return [
        Claim(name, text, NOT_RECORDED, "states", detail=detail) for name, text in _WITHOUT_STATES.items()
    ]


def _claims_of_states(run: Run, chain: ChainCheck, progress: Callable[[float, str], None]) -> list[Claim]:
    geometry, prescribed, shapes, joints, inertia = (
        GeometryCheck(run),
        PrescribedCheck(run),
        ShapeCheck(run),
        JointCheck(run),
        InertiaCheck(run),
    )
    broken: list[int] = []
    previous = None
    for state in run.states():
        chain.row("states", state.index, state.row, state.digest)
        if not np.isfinite(np.concatenate([part.reshape(-1) for part in state.parts()])).all():
            broken.append(state.index)
            previous = None
            geometry.interrupt()
            continue
        geometry.add(state)
        prescribed.add(state)
        shapes.add(state)
        joints.add(state)
        row = run.row_of(state)
        if previous is not None and row is not None and not run.jumps(previous, state):
            inertia.add(previous, state, row)
        previous = state
        progress((state.index + 1) / len(run.times), f"t = {state.time:.3f} s")
    checks = (geometry, prescribed, shapes, joints, inertia)
    return [steps_claim(run, broken), *(claim for check in checks for claim in check.claims())]
