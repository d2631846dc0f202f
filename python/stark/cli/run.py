"""``stark run``: runs a scene and leaves recording, telemetry, replay page and a picture in a folder."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from types import FrameType
from typing import Any

from .._core import InvalidArgument
from .progress import Progress
from .settings_arguments import add_setting_arguments, parse_settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scene", metavar="SCENE.py|NAME", help="a scene file, or the name of a packaged scene"
    )
    parser.add_argument(
        "--until", type=float, metavar="T", help="simulated time [s]; default: the scene's own"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the run; default: out/NAME")
    parser.add_argument(
        "--fps", type=float, default=60.0, help="most recorded frames per simulated second (60)"
    )
    parser.add_argument(
        "--option", action="append", default=[], metavar="NAME=VALUE", help="an option of the scene file"
    )
    parser.add_argument(
        "--certify", action="store_true", help="record every step in double precision, for stark verify"
    )
    parser.add_argument("--no-replay", action="store_true", help="write no replay page")
    parser.add_argument("--no-picture", action="store_true", help="write no picture")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    add_setting_arguments(parser)


def _stop(signal_number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _option(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise InvalidArgument(f"--option {text}: must be NAME=VALUE")
    return name, value


def run(args: argparse.Namespace) -> int:
    from ..scenes import load
    from ..scenes import run as run_scene
    from ..scenes.runner import end_time

    scene_file = load(args.scene, dict(_option(text) for text in args.option))
    progress = Progress(end_time(scene_file, args.until), quiet=args.quiet)

    def on_step(sim: Any, report: Any) -> None:
        iterations, contacts = int(report.newton_iterations), int(report.contact_count)
        progress.update(sim.time, f"t = {sim.time:.3f} s  {iterations} iterations  {contacts} contacts")

    previous = signal.signal(signal.SIGTERM, _stop)
    try:
        result = run_scene(
            scene_file,
            out=args.out,
            until=args.until,
            settings=parse_settings(args),
            fps=args.fps,
            replay=not args.no_replay,
            picture=not args.no_picture,
            certify=args.certify,
            on_step=on_step,
        )
    finally:
        signal.signal(signal.SIGTERM, previous)
        progress.close()
    if not args.quiet:
        print(
            f"{result.scene}: {result.simulated:.4g} s simulated in {result.wall:.1f} s"
            f"; {result.steps} steps, "
            f"{result.rejected_steps} rejected, {result.newton_iterations} Newton iterations, "
            f"at most {result.max_contacts} contacts"
        )
        for path in [result.folder, *result.files]:
            print(f"  {path}")
        if result.message and result.status == "complete":
            print(f"  {result.message}")
    if result.status != "complete":
        print(f"stark: {result.scene}: {result.status}: {result.message}", file=sys.stderr)
    return result.exit_code
