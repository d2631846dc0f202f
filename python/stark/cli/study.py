"""``stark study``: many runs of a scene, on this machine or a Ray cluster."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path
from shlex import quote
from typing import Any

from .._core import InvalidArgument
from .._interrupts import EXIT_INTERRUPTED, RaisedOnce, tell
from ..files import printable
from .output import complain, say
from .paths import path_argument
from .progress import Progress

#: Most runs whose failures are told, one a line.
_TOLD = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = "exit codes: 0 all runs are complete; 1 some are not; 2 bad input; 130 interrupted"
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    run = actions.add_parser("run", help="make the runs of a plan, or those that are missing")
    run.add_argument("plan", type=path_argument, metavar="PLAN.toml", help="what to run; docs/studies.md")
    run.add_argument(
        "--out", type=path_argument, metavar="DIR", help="folder of the study; default: out/NAME of the plan"
    )
    resume = actions.add_parser("resume", help="go on with a study")
    resume.add_argument("study", type=path_argument, metavar="DIR", help="folder of a study")
    resume.add_argument(
        "--scene", type=path_argument, metavar="SCENE.py", help="the scene file, if it was moved"
    )
    resume.add_argument(
        "--retry-failed", action="store_true", help="make runs again that did not come to a good end"
    )
    for sub in (run, resume):
        place = sub.add_mutually_exclusive_group()
        place.add_argument(
            "--processes", type=int, metavar="N", help="runs at a time, one thread each; default: all cores"
        )
        place.add_argument(
            "--ray",
            metavar="ADDRESS",
            help="run on the Ray cluster there; 'auto' finds one, 'local' makes one",
        )
        sub.add_argument("--quiet", action="store_true", help="print nothing but errors")
    status = actions.add_parser("status", help="how far a study is")
    status.add_argument("study", type=path_argument, metavar="DIR", help="folder of a study")
    show = actions.add_parser("show", help="write the table and a page of a study")
    show.add_argument("study", type=path_argument, metavar="DIR", help="folder of a study")
    show.add_argument("--out", type=path_argument, metavar="FILE", help="the page; default: DIR/study.html")
    show.add_argument("--no-replays", action="store_true", help="write no replay pages of the runs")
    show.add_argument("--parquet", action="store_true", help="write the table as Parquet, too")


def run(args: argparse.Namespace) -> int:
    if args.action == "status":
        return _status(args)
    if args.action == "show":
        return _show(args)
    with RaisedOnce(signal.SIGINT, signal.SIGTERM):
        return _make(args)


def _make(args: argparse.Namespace) -> int:
    from .. import study

    bar = Progress(1.0, quiet=args.quiet)

    def show(over: int, total: int, done: float) -> None:
        bar.update(done / total, f"{over} of {total} runs")

    folder = _folder(args)
    how: dict[str, Any] = {"processes": args.processes, "ray": args.ray, "on_progress": show}
    try:
        if args.action == "run":
            made = study.run(args.plan, folder, **how)
        else:
            made = study.resume(folder, scene=args.scene, retry_failed=args.retry_failed, **how)
    except KeyboardInterrupt:
        bar.close()
        tell(printable(f"interrupted; go on with: stark study resume {quote(str(folder))}"))
        return EXIT_INTERRUPTED
    finally:
        bar.close()
    return _tell(made, quiet=args.quiet)


def _folder(args: argparse.Namespace) -> Path:
    if args.action == "resume":
        return Path(args.study)
    if args.out is None and args.plan.suffix != ".toml":
        raise InvalidArgument(f"study run: plan '{args.plan}'; must be a TOML file: PLAN.toml")
    return Path("out") / args.plan.stem if args.out is None else Path(args.out)


def _tell(study: Any, quiet: bool = False) -> int:
    """How the runs ended; the exit code."""
    counts = study.counts()
    if not quiet:
        say(f"{study.folder.name}: " + ", ".join(f"{count} {name}" for name, count in counts.items()))
        say(f"  made {study.made}, kept {study.kept} of before")
        _tell_of_others(study)
        say(f"  {study.folder / 'table.csv'}")
    good = counts.get("complete", 0) == len(study.runs)
    bad = [] if good else [r for r in study.rows() if r["status"] not in ("complete", "begun", "waiting")]
    for row in bad[:_TOLD]:
        complain(f"run {row['run']} {row['status']}: {row['message']}")
    if len(bad) > _TOLD:
        complain(f"and {len(bad) - _TOLD} more, see {study.folder / 'table.csv'}")
    return 0 if good else 1


def _tell_of_others(study: Any) -> None:
    if count := study.other_results():
        say(
            f"  {count} result{'s' * (count > 1)} in the folder of other plans, scene files or versions of "
            f"Stark: not in the table"
        )


def _status(args: argparse.Namespace) -> int:
    from ..study import Study

    study = Study(args.study)
    rows, counts = study.rows(), study.counts()
    say(f"{study.folder.name}: {len(rows)} runs of {study.plan.scene}")
    for name, count in counts.items():
        say(f"  {count:6} {name}")
    for row in [r for r in rows if r["message"] and r["status"] != "complete"][:_TOLD]:
        say(f"  run {row['run']} {row['status']}: {row['message']}")
    _tell_of_others(study)
    seconds = sum(row.get("cost.cpu", 0.0) for row in rows)
    say(f"  {seconds:.1f} s of CPU")
    return 0


def _show(args: argparse.Namespace) -> int:
    from ..study import Study

    study = Study(args.study)
    paths = [study.write_page(args.out, replays=not args.no_replays), study.write_csv()]
    if args.parquet:
        paths.append(study.write_parquet())
    for path in paths:
        say(f"{path}  {path.stat().st_size / 1e6:.1f} MB")
    return 0
