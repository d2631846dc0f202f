"""``stark still``: a picture of a recording."""

from __future__ import annotations

import argparse

from .output import say
from .paths import path_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=path_argument, metavar="RUN", help="folder of a run")
    parser.add_argument("--time", type=float, metavar="T", help="time [s]; default: the end")
    parser.add_argument(
        "--out", type=path_argument, metavar="FILE.png", help="the picture; default: RUN/still.png"
    )
    add_picture_arguments(parser, "good")


def add_picture_arguments(parser: argparse.ArgumentParser, quality: str) -> None:
    parser.add_argument("--size", default="1280x720", metavar="WxH", help="size in pixels (1280x720)")
    parser.add_argument("--view", default="oblique", choices=("oblique", "front", "side", "top"))
    parser.add_argument("--quality", default=quality, choices=("draft", "good", "best"))
    parser.add_argument("--edges", action="store_true", help="draw mesh edges")


def parse_size(text: str) -> tuple[int, int]:
    """Width and height of ``1280x720``."""
    from .._core import InvalidArgument

    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and 1 <= int(width) <= 16384 and 1 <= int(height) <= 16384):
        raise InvalidArgument(
            f"size '{text}': must be WIDTHxHEIGHT in pixels, each in [1, 16384], like 1280x720"
        )
    return int(width), int(height)


def run(args: argparse.Namespace) -> int:
    from ..recording import Recording
    from ..render import write_png

    width, height = parse_size(args.size)
    recording = Recording(args.run)
    time = float("inf") if args.time is None else args.time
    picture = recording.still(
        time, width=width, height=height, camera=args.view, quality=args.quality, edges=args.edges
    )
    path = args.out or args.run / "still.png"
    write_png(path, picture)
    say(path)
    return 0
