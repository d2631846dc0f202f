"""``stark still``: a picture of a recording."""

from __future__ import annotations

import argparse
import math
from typing import Any

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
    parser.add_argument(
        "--camera", metavar="X,Y,Z", help="where the camera is [m], instead of a view: --camera=-1,0,0.5"
    )
    parser.add_argument(
        "--target", metavar="X,Y,Z|BODY", help="what it looks at: a point [m], or a body by name or pattern"
    )
    parser.add_argument("--fov", type=float, metavar="DEG", help="vertical field of view [degrees] (35)")
    parser.add_argument("--only", nargs="+", metavar="BODY", help="draw only these, by name or pattern")
    parser.add_argument("--hide", nargs="+", metavar="BODY", default=(), help="leave these out")
    parser.add_argument(
        "--opacity", nargs="+", metavar="BODY=A", default=(), help="see through bodies: 'glass*=0.3'"
    )
    parser.add_argument(
        "--clip",
        metavar="POINT:NORMAL",
        help="takes away the side of a plane that the normal points to: --clip=0,0,0.1:0,-1,0",
    )
    parser.add_argument("--field", metavar="FIELD", help="colours bodies by a field that was recorded")
    parser.add_argument("--limits", metavar="LOW,HIGH", help="of the colours; default: those of the values")
    parser.add_argument("--colormap", default="viridis", choices=("viridis", "magma", "coolwarm"))
    parser.add_argument("--contacts", action="store_true", help="draws forces of contact that were recorded")


def parse_size(text: str) -> tuple[int, int]:
    """Width and height of ``1280x720``."""
    from .._core import InvalidArgument

    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and 1 <= int(width) <= 16384 and 1 <= int(height) <= 16384):
        raise InvalidArgument(
            f"size '{text}': must be WIDTHxHEIGHT in pixels, each in [1, 16384], like 1280x720"
        )
    return int(width), int(height)


def parse_point(text: str, what: str) -> tuple[float, float, float]:
    """Three numbers of ``0.1,-2,0.5``."""
    from .._core import InvalidArgument

    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise InvalidArgument(f"{what} '{text}': must be three numbers like 0.5,-0.7,0.4") from None
    return x, y, z


def parse_opacities(texts: list[str] | tuple[()]) -> dict[str, float]:
    """Names or patterns with numbers, of ``glass*=0.3``."""
    from .._core import InvalidArgument

    result = {}
    for text in texts:
        name, _, number = text.rpartition("=")
        try:
            result[name] = float(number)
        except ValueError:
            name = ""
        if not name:
            raise InvalidArgument(f"--opacity '{text}': must be BODY=NUMBER like 'glass*=0.3'")
    return result


def run(args: argparse.Namespace) -> int:
    from ..recording import Recording
    from ..render import render, write_png

    width, height = parse_size(args.size)
    options = picture_options(args)
    recording = Recording(args.run)
    time = float("inf") if args.time is None else args.time
    picture = render(recording.frame(recording.nearest(time)), width=width, height=height, **options)
    tell_of_time(recording, time)
    path = args.out or args.run / "still.png"
    write_png(path, picture)
    say(path)
    return 0


def tell_of_time(recording: Any, time: float) -> None:
    """Where the recording does not have a time [s]."""
    if message := recording.beyond(time):
        say(f"--time {time:g}: {message}", error=True)


def picture_options(args: argparse.Namespace) -> dict[str, Any]:
    """Those of ``stark.render.render``."""
    return {
        "camera": args.view if args.camera is None else parse_point(args.camera, "--camera"),
        "target": args.target and _target(args.target),
        "field_of_view": None if args.fov is None else math.radians(args.fov),
        "quality": args.quality,
        "edges": args.edges,
        "bodies": args.only,
        "hide": args.hide,
        "opacity": parse_opacities(args.opacity),
        "clip": args.clip and _plane(args.clip),
        "field": args.field,
        "limits": args.limits and _limits(args.limits),
        "colormap": args.colormap,
        "contacts": args.contacts,
    }


def _limits(text: str) -> tuple[float, float]:
    from .._core import InvalidArgument

    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        raise InvalidArgument(f"--limits '{text}': must be two numbers like 0,2000") from None
    return low, high


def _target(text: str) -> Any:
    """A point, else the name of a body."""
    parts = text.split(",")
    try:
        return tuple(float(part) for part in parts) if len(parts) == 3 else text
    except ValueError:
        return text


def _plane(text: str) -> tuple[Any, Any]:
    point, _, normal = text.partition(":")
    return parse_point(point, "--clip: point"), parse_point(normal, "--clip: normal")
