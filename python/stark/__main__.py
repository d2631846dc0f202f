"""`python -m stark` is the command `stark`."""

import sys

from stark.cli import main

if __name__ == "__main__":
    sys.exit(main())
