"""The command ``stark``. Each verb is a module of its own that is imported only when it is asked for."""

from __future__ import annotations

import argparse
import importlib
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

from .._interrupts import EXIT_INTERRUPTED, RaisedOnce, forget_unhandled, tell
from .output import complain

#: Verb and what it does; the module of a verb has add_arguments(parser) and run(args) -> exit code.
VERBS: dict[str, str] = {
    "run": "run a scene and record it, or go on with a run",
    "study": "run a scene many times with different options, and show the results",
    "bench": "measure a scene",
    "replay": "write the replay page of a recording",
    "still": "write a picture of a recording",
    "video": "write an mp4 of a recording",
    "export": "write a recording as USD, VTKHDF, VTU, glTF, PC2, PLY, OBJ, Parquet or MCAP",
    "verify": "check a recording and write a certificate",
    "info": "list scenes, or describe a scene, a recording or a checkpoint",
    "doctor": "show what this machine and installation offer",
}

EXIT_OK, EXIT_FAILED, EXIT_BAD_INPUT = 0, 1, 2


def _version() -> str:
    from importlib import metadata

    try:
        return metadata.version("stark-sim")
    except metadata.PackageNotFoundError:
        return "not installed"


#: What does what other programs have a verb for.
_ELSEWHERE = {
    "resume": "stark run --resume DIR",
    "demo": "stark run hello_cloth",
    "view": "stark run SCENE --view",
    "picture": "stark still",
    "list": "stark info",
}


class _Parser(argparse.ArgumentParser):
    """Says which verb or option was probably meant."""

    def error(self, message: str) -> NoReturn:
        import difflib

        known = [*VERBS]
        for verb in self._verbs().values():
            known += verb._option_string_actions
        words = message.replace("argument VERB: invalid choice: ", "unrecognized arguments: ")
        if words.startswith("unrecognized arguments:") and not words.partition(":")[2].strip():
            message = words = "an argument is empty"  # a variable of the shell that is not set, say
        word = words.removeprefix("unrecognized arguments: ").split()[0]
        wrong = word.partition("=")[0].strip("'")
        near = difflib.get_close_matches(wrong, known, n=1) if words.startswith("unrecognized") else []
        if words.startswith("unrecognized") and "=" in word and not word.startswith("-"):
            near = [f"--option {word}"]
        near = [_ELSEWHERE[wrong]] if wrong in _ELSEWHERE else near
        hint = f"; did you mean '{near[0]}'?" if near else ""
        super().error(message + hint)

    def _verbs(self) -> dict[str, argparse.ArgumentParser]:
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                return dict(action.choices)
        return {}


def _parser(verb: str | None) -> argparse.ArgumentParser:
    parser = _Parser(
        prog="stark",
        description="Simulates rigid and deformable bodies with frictional contact.",
        epilog="'stark run hello_cloth' runs a packaged scene; 'stark VERB -h' describes a verb.",
    )
    parser.add_argument("--version", action="version", version=f"stark {_version()}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, help_text in VERBS.items():
        sub = verbs.add_parser(name, help=help_text, description=help_text[0].upper() + help_text[1:] + ".")
        if name == verb:
            importlib.import_module(f"{__name__}.{name}").add_arguments(sub)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code: 0 good, 1 the simulation or the disk failed, 2 bad input, 130
    interrupted."""
    try:
        with RaisedOnce(signal.SIGINT):
            return _run(arguments)
    except KeyboardInterrupt:
        tell()
        return EXIT_INTERRUPTED
    finally:
        forget_unhandled()


def _run(arguments: Sequence[str] | None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    verb = next((word for word in words if not word.startswith("-")), None)
    parser = _parser(verb if verb in VERBS else None)
    if not words:
        parser.print_help(sys.stderr)
        return EXIT_BAD_INPUT
    try:
        args = parser.parse_args(words)
    except SystemExit as stop:
        return int(stop.code or 0)
    try:
        from .._core import Error

        return int(importlib.import_module(f"{__name__}.{args.verb}").run(args))
    except BrokenPipeError:
        return EXIT_OK
    except (Error, ImportError, OSError) as error:
        complain(f"{error}{_place(error, args)}")
        return EXIT_FAILED if _is_of_the_disk(error) else EXIT_BAD_INPUT


def _place(error: BaseException, args: argparse.Namespace) -> str:
    """Where in the scene file of the command an error came from, if it did."""
    scene = getattr(args, "scene", None)
    if not isinstance(scene, str) or not scene.endswith(".py"):
        return ""
    from ..scenes.runner import place_in

    return place_in(error, scene)


def _is_of_the_disk(error: BaseException | None) -> bool:
    """Whether a disk that is full or broken is behind it, and not what was asked for."""
    from ..array_file import DISK_ERRORS

    while error is not None:
        if isinstance(error, OSError) and error.errno in DISK_ERRORS:
            return True
        error = error.__cause__
    return False
