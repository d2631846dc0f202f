"""``stark run --view``: a scene in a browser, without a run folder. Who watches may pull bodies and change
values, so it is no run that could be taken again or resumed; the page records what is asked for."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .._core import InvalidArgument
from .output import say
from .settings_arguments import parse_settings


def run_view(args: argparse.Namespace, options: Mapping[str, str]) -> int:
    """Opens the page and takes steps until Ctrl-C."""
    _check(args)
    from ..scenes import load
    from ..scenes.runner import DRIVE_RULE, end_time
    from ..simulation import Simulation
    from ..view import View, add_pulls

    scene_file = load(args.scene, options)
    end = None if args.until is None and scene_file.until is None else end_time(scene_file, args.until)
    scene, settings = scene_file.build()
    add_pulls(scene)
    sim = Simulation(scene, **{**settings, **parse_settings(args)})

    def drive(simulation: Any) -> None:
        with simulation._held_still("drive(sim) of the scene", DRIVE_RULE, may_place=True):
            scene_file.drive(simulation)

    record_to = Path("out") / scene_file.name if args.out is None else args.out
    host, port = args.host or "127.0.0.1", 8080 if args.port is None else args.port
    with View(sim, host=host, port=port, record_to=record_to, drive=drive) as view:
        if not args.quiet:
            say(f"{scene_file.name}: {view.url} (Ctrl-C ends)", flush=True)
        view.run(end)
    return 0


def _check(args: argparse.Namespace) -> None:
    """What belongs to recorded runs is refused."""
    refused = {
        "--resume": args.resume is not None,
        "--certify": args.certify,
        "--fps": args.fps is not None,
        "--checkpoint-every": args.checkpoint_every is not None,
        "--no-checkpoint": args.no_checkpoint,
        "--no-replay": args.no_replay,
        "--no-picture": args.no_picture,
    }
    if given := [name for name, is_given in refused.items() if is_given]:
        raise InvalidArgument(f"run --view: {given[0]} is of a run that is recorded; leave it or --view out")
