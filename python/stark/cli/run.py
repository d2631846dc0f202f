"""``stark run``: runs a scene and leaves recording, telemetry, replay page and a picture in a folder; goes on
with a run that was killed or stopped."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._core import InvalidArgument
from .._interrupts import RaisedOnce, tell
from ..files import printable
from .output import complain, say
from .paths import path_argument
from .progress import Progress
from .settings_arguments import add_option_argument, add_setting_arguments, parse_options, parse_settings

if TYPE_CHECKING:
    from ..scenes import SceneFile

#: Of a step that takes longer, the bar shows the iterations [s].
LONG_STEP = 2.0

#: Fields that are recorded for the page where nothing is said.
FIELDS = ("stress", "pressure")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scene",
        metavar="SCENE.py|SCENE.json|NAME",
        nargs="?",
        help="a scene file or document, or the name of a packaged scene; with --resume only if it was moved",
    )
    parser.add_argument(
        "--until", type=float, metavar="T", help="simulated time [s]; default: the scene's own"
    )
    parser.add_argument(
        "--out", type=path_argument, metavar="DIR", help="folder of the run; default: out/NAME"
    )
    parser.add_argument("--fps", type=float, help="most recorded frames per simulated second (60)")
    parser.add_argument(
        "--checkpoint-every",
        type=float,
        metavar="SECONDS",
        help="wall-clock time between them; a killed run loses no more (60; 0: after each step)",
    )
    parser.add_argument("--no-checkpoint", action="store_true", help="write no checkpoints")
    parser.add_argument(
        "--resume",
        type=path_argument,
        metavar="DIR",
        help="go on with the run in DIR from its last checkpoint, as if it had never stopped",
    )
    add_option_argument(parser)
    parser.add_argument(
        "--certify", action="store_true", help="record every step in double precision, for stark verify"
    )
    parser.add_argument(
        "--fields",
        nargs="+",
        metavar="FIELD",
        help="recorded for replay, stills and exports: stress, strain, pressure, contact_force, speed "
        "(stress pressure)",
    )
    parser.add_argument("--no-fields", action="store_true", help="record neither fields nor contacts")
    parser.add_argument(
        "--view", action="store_true", help="watch and handle it in a browser; records when the page asks"
    )
    parser.add_argument("--host", help="address of the page of --view (127.0.0.1: this machine only)")
    parser.add_argument("--port", type=int, help="port of the page of --view (8080)")
    parser.add_argument("--no-replay", action="store_true", help="write no replay page")
    parser.add_argument("--no-picture", action="store_true", help="write no picture")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    add_setting_arguments(parser)


def _check(args: argparse.Namespace) -> None:
    """Which arguments go together."""
    if not args.view and (args.host is not None or args.port is not None):
        raise InvalidArgument("run: --host and --port are of the page: give --view, too")
    if args.no_fields and args.fields is not None:
        raise InvalidArgument("run: --fields and --no-fields: give one of them")
    if args.resume is None:
        if args.scene is None:
            raise InvalidArgument("run: give a scene, or --resume DIR to go on with a run")
        return
    fixed = {
        "--out": args.out is not None,
        "--fps": args.fps is not None,
        "--option": bool(args.option),
        "--checkpoint-every": args.checkpoint_every is not None,
        "--no-checkpoint": args.no_checkpoint,
        "--certify": args.certify,
        "--fields": args.fields is not None,
        "--no-fields": args.no_fields,
    }
    if given := [name for name, is_given in fixed.items() if is_given]:
        raise InvalidArgument(f"run: {given[0]} is that of the run in {args.resume}; leave it out")


def _end(args: argparse.Namespace, scene_file: SceneFile | None) -> float:
    """Simulated time at the end [s], of a scene file that is to be run or a run that is to be continued."""
    from ..scenes.resuming import planned_end
    from ..scenes.runner import end_time

    if scene_file is None:
        return planned_end(args.resume) if args.until is None else args.until
    return end_time(scene_file, args.until)


def _run(args: argparse.Namespace, scene_file: SceneFile | None, shown: Shown) -> Any:
    from .. import scenes

    common: dict[str, Any] = {
        "until": args.until,
        "settings": parse_settings(args),
        "replay": not args.no_replay,
        "picture": not args.no_picture,
        "on_step": shown.step,
        "on_progress": shown.progress,
    }
    if scene_file is None:
        return scenes.resume(args.resume, scene=args.scene, **common)
    looked_at = not args.no_fields and not args.no_replay
    period = scenes.CHECKPOINT_PERIOD if args.checkpoint_every is None else args.checkpoint_every
    return scenes.run(
        scene_file,
        out=args.out,
        fps=60.0 if args.fps is None else args.fps,
        checkpoint_every=None if args.no_checkpoint else period,
        certify=args.certify,
        fields=args.fields or (FIELDS if looked_at else ()),
        contacts=args.fields is not None or looked_at,
        **common,
    )


def _shown(path: Path) -> Path:
    """As seen from the current folder, where it is below that."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


class Shown:
    """What the bar says of a run, and of a step that takes long."""

    def __init__(self, bar: Progress) -> None:
        self._bar = bar

    def step(self, sim: Any, report: Any) -> None:
        iterations, contacts = int(report.newton_iterations), int(report.contact_count)
        self._bar.update(sim.time, f"t = {sim.time:.3f} s  {iterations} iterations  {contacts} contacts")

    def progress(self, progress: Any) -> None:
        if progress.seconds < LONG_STEP:
            return
        attempt = f", attempt {progress.attempt}" if progress.attempt > 1 else ""
        text = f"step {progress.step}: {progress.iterations} iterations in {progress.seconds:.0f} s{attempt}"
        self._bar.update(progress.time, f"t = {progress.time:.3f} s  {text}")


def run(args: argparse.Namespace) -> int:
    _check(args)
    if args.view:
        from .run_view import run_view

        with RaisedOnce(signal.SIGINT, signal.SIGTERM):  # a recording that the page asked for is ended
            return run_view(args, parse_options(args))
    from ..scenes import load

    with RaisedOnce(signal.SIGINT, signal.SIGTERM):
        scene_file = load(args.scene, parse_options(args)) if args.resume is None else None
        bar = Progress(_end(args, scene_file), quiet=args.quiet)
        try:
            result = _run(args, scene_file, Shown(bar))
        finally:
            bar.close()
    if not args.quiet:
        say(
            f"{result.scene}: {result.simulated:.4g} s simulated in {result.wall:.1f} s"
            f"; {result.steps} steps, "
            f"{result.rejected_steps} rejected, {result.newton_iterations} Newton iterations, "
            f"at most {result.max_contacts} contacts"
        )
        for path in [result.folder, *result.files]:
            say(f"  {_shown(path)}")
        if result.message and result.status == "complete":
            say(f"  {result.message}")
    if result.status == "interrupted":
        tell(printable(f"{result.scene}: interrupted: {result.message}"))
    elif result.status != "complete":
        complain(f"{result.scene}: {result.status}: {result.message}")
    exit_code: int = result.exit_code
    return exit_code
