"""``stark verify``: checks a recording independently of the solver and writes a certificate."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from .progress import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "exit codes: 0 certified; 1 a claim is violated; 2 the recording cannot be read, or the "
        "certificate not written; 3 nothing is violated, but not everything could be shown"
    )
    parser.add_argument("run", type=Path, metavar="RUN", help="folder of a run, best of one with --certify")
    parser.add_argument("--out", type=Path, metavar="FILE", help="certificate; default: RUN/certificate.json")
    parser.add_argument("--json", action="store_true", help="print the certificate as JSON")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def run(args: argparse.Namespace) -> int:
    from ..array_file import naming, refuse_special
    from ..verify import UnreadableRecording, verify

    progress = Progress(1.0, quiet=args.quiet)
    try:
        certificate = verify(args.run, progress=progress.update)
    except UnreadableRecording as error:
        progress.close()
        print(f"stark: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    finally:
        progress.close()
    path = args.out or args.run / "certificate.json"
    try:
        with naming(path):
            refuse_special(path)
            certificate.write(path)
    except OSError as error:  # 1 would say that a claim is violated
        print(f"stark: certificate {error}", file=sys.stderr)
        return 2
    if args.json:
        print(json.dumps(certificate.to_json(), indent=1, allow_nan=False))
    elif not args.quiet:
        print(certificate.text())
        print(f"  {path}")
    return certificate.exit_code
