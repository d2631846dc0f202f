"""``stark export``: frames of a recording as files of other programs."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=Path, metavar="RUN", help="folder of a run")
    parser.add_argument("--format", default="vtu", choices=("vtu", "ply", "obj"), help="vtu is for ParaView")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the files; default: RUN/FORMAT")
    parser.add_argument("--time", type=float, metavar="T", help="only the frame nearest to this time [s]")
    parser.add_argument("--csv", action="store_true", help="write the telemetry as CSV, too")


def run(args: argparse.Namespace) -> int:
    from ..recording import Recording, export

    recording = Recording(args.run)
    folder = args.out or args.run / args.format
    frames = None if args.time is None else [recording.nearest(args.time)]
    written = export(recording, folder, args.format, frames=frames)
    if args.csv:
        path = folder / "telemetry.csv"
        recording.telemetry.to_csv(path)
        written.append(path)
    print(f"{len(written)} files in {folder}; the last is {written[-1].name}")
    return 0
