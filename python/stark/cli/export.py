"""``stark export``: frames of a recording as files of other programs."""

from __future__ import annotations

import argparse

from .output import say
from .paths import path_argument
from .progress import Progress
from .still import tell_of_time


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=path_argument, metavar="RUN", help="folder of a run")
    parser.add_argument(
        "--format",
        default="vtu",
        choices=("vtu", "ply", "obj", "vtkhdf", "usd", "glb", "pc2", "parquet", "mcap"),
        help="vtu, vtkhdf: ParaView; usd: Blender, Omniverse; pc2: point caches of bodies; "
        "parquet, mcap: the numbers of every step",
    )
    parser.add_argument(
        "--out", type=path_argument, metavar="DIR", help="folder of the files; default: RUN/FORMAT"
    )
    parser.add_argument("--time", type=float, metavar="T", help="only the frame nearest to this time [s]")
    parser.add_argument("--csv", action="store_true", help="write the telemetry as CSV, too")


def run(args: argparse.Namespace) -> int:
    from ..array_file import refuse_link
    from ..exports import export_recording
    from ..recording import Recording

    recording = Recording(args.run)
    folder = args.out or args.run / args.format
    if args.out is None:
        refuse_link(folder)
    frames = None if args.time is None else [recording.nearest(args.time)]
    if args.time is not None:
        tell_of_time(recording, args.time)
    bar = Progress(1.0)
    try:
        written = export_recording(
            recording,
            folder,
            args.format,
            frames=frames,
            progress=lambda done, total: bar.update(done / total, f"frame {done} of {total}"),
        )
    finally:
        bar.close()
    if args.csv:
        path = folder / "telemetry.csv"
        recording.telemetry.to_csv(path)
        written.append(path)
    say(f"{len(written)} files in {folder}; the last is {written[-1].name}")
    return 0
