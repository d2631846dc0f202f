"""``stark video``: an mp4 of a recording, with the packages of the extra 'video'."""

from __future__ import annotations

import argparse

from .output import say
from .paths import path_argument
from .progress import Progress
from .still import add_picture_arguments, parse_size, picture_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=path_argument, metavar="RUN", help="folder of a run")
    parser.add_argument(
        "--out",
        type=path_argument,
        metavar="FILE.mp4",
        help="the film, or a .mov or .mkv; default: RUN/video.mp4",
    )
    parser.add_argument("--fps", type=float, default=30.0, help="pictures per second (30)")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second (1)")
    add_picture_arguments(parser, "draft")


def run(args: argparse.Namespace) -> int:
    from ..recording import Recording
    from ..render import write_video

    width, height = parse_size(args.size)
    options = picture_options(args)
    progress = Progress(1.0)
    path = write_video(
        Recording(args.run),
        args.out or args.run / "video.mp4",
        width=width,
        height=height,
        fps=args.fps,
        speed=args.speed,
        progress=lambda done, total: progress.update(done / total, f"picture {done} of {total}"),
        **options,
    )
    progress.close()
    say(path)
    return 0
