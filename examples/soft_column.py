"""soft_column: five soft boxes pressed by a plate and let go.

What it shows: scripted motion, soft solids in a strongly coupled stack.
The scene itself is python/stark/scenes/soft_column.py; this script runs it, checks it, and leaves
recording, replay page and picture in out/soft_column.

    python examples/soft_column.py            the same as: stark run soft_column
    python examples/soft_column.py 0.5        only half a second
"""

import sys

import stark.scenes


def main() -> int:
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    result = stark.scenes.run("soft_column", until=until)
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    print(*result.files, sep="\n")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
