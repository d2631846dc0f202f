"""``stark verify``: checks a recording independently of the solver and writes a certificate."""

from __future__ import annotations

import argparse
import json

from .output import complain, say
from .paths import path_argument
from .progress import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "exit codes: 0 certified; 1 a claim is violated; 2 the recording cannot be read, or the "
        "certificate not written; 3 nothing is violated, but not everything could be shown"
    )
    parser.add_argument(
        "run", type=path_argument, metavar="RUN", help="folder of a run, best of one with --certify"
    )
    parser.add_argument(
        "--out", type=path_argument, metavar="FILE", help="certificate; default: RUN/certificate.json"
    )
    parser.add_argument("--json", action="store_true", help="print the certificate as JSON")
    parser.add_argument(
        "--strict", action="store_true", help="a certificate with limits counts as inconclusive: exit code 3"
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def run(args: argparse.Namespace) -> int:
    from ..array_file import naming, refuse_special
    from ..verify import UnreadableRecording, verify
    from ..verify.certificate import EXIT_INCONCLUSIVE

    progress = Progress(1.0, quiet=args.quiet)
    try:
        certificate = verify(args.run, progress=progress.update)
    except UnreadableRecording as error:
        progress.close()
        complain(error)
        return 2
    finally:
        progress.close()
    path = args.out or args.run / "certificate.json"
    try:
        with naming(path):
            refuse_special(path)
            certificate.write(path)
    except OSError as error:  # 1 would say that a claim is violated
        complain(f"certificate {error}")
        return 2
    if args.json:
        print(json.dumps(certificate.to_json(), indent=1, allow_nan=False))  # in ASCII
    elif not args.quiet:
        for line in certificate.text().split("\n"):
            say(line)
        say(f"  {path}")
    limited = args.strict and certificate.verdict == "certified" and certificate.limits
    return EXIT_INCONCLUSIVE if limited else certificate.exit_code
