"""``stark replay``: writes the self-contained page of a recording."""

from __future__ import annotations

import argparse

from .output import say
from .paths import path_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=path_argument, metavar="RUN", help="folder of a run")
    parser.add_argument(
        "--out", type=path_argument, metavar="FILE", help="the page; default: RUN/replay.html"
    )
    parser.add_argument("--stride", type=int, metavar="N", help="keep every Nth frame; default: by size")
    parser.add_argument(
        "--overlay", type=path_argument, metavar="RUN", help="another run, whose numbers the plots show, too"
    )
    parser.add_argument("--max-megabytes", type=float, default=60.0, help="size to stay below (60)")


def run(args: argparse.Namespace) -> int:
    from ..recording import Recording
    from ..replay import write_page

    path = write_page(
        Recording(args.run),
        args.out,
        stride=args.stride,
        max_megabytes=args.max_megabytes,
        overlay=None if args.overlay is None else Recording(args.overlay),
    )
    say(f"{path}  {path.stat().st_size / 1e6:.1f} MB")
    return 0
