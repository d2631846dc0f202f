"""``python path/to/stark/verify RUN [--out FILE]``: the checker alone, where Stark itself cannot be
imported."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

if not __package__:
    sys.path[0] = str(Path(__file__).resolve().parents[1])
    from verify import UnreadableRecording, verify  # type: ignore[import-not-found, no-redef, unused-ignore]
    from verify.files import printable  # type: ignore[import-not-found, no-redef, unused-ignore]
else:
    from . import UnreadableRecording, verify
    from .files import printable


def main() -> int:
    """Writes the certificate beside the recording and prints it; the exit codes are those of ``stark
    verify``."""
    parser = argparse.ArgumentParser(prog="verify", description="Checks a recording of Stark.")
    parser.add_argument("run", type=Path, metavar="RUN", help="folder of a run")
    parser.add_argument("--out", type=Path, metavar="FILE", help="certificate; default: RUN/certificate.json")
    args = parser.parse_args()
    path = args.out or args.run / "certificate.json"
    try:
        certificate = verify(args.run)
    except (UnreadableRecording, OSError) as error:
        print(f"verify: {printable(str(error))}", file=sys.stderr)
        return 2
    try:
        certificate.write(path)
    except OSError as error:
        reason = error.strerror or error
        print(
            f"verify: certificate '{path}' cannot be written: {reason}; give another --out", file=sys.stderr
        )
        return 2
    print(certificate.text())
    exit_code: int = certificate.exit_code
    return exit_code


if __name__ == "__main__":
    sys.exit(main())
