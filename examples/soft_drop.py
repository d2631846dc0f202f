"""soft_drop: a soft cube of 17,261 nodes falls.

What it shows: a larger solid, direct solver.
The scene itself is python/stark/scenes/soft_drop.py; this script runs it, checks it, and leaves recording,
replay page and picture in out/soft_drop.

    python examples/soft_drop.py            the same as: stark run soft_drop
    python examples/soft_drop.py 0.5        only half a second
"""

import sys

import stark.scenes


def main() -> int:
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    result = stark.scenes.run("soft_drop", until=until)
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    print(*result.files, sep="\n")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
