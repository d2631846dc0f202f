"""stack: 27 rigid boxes stay standing.

What it shows: rigid bodies with density, friction.
The scene itself is python/stark/scenes/stack.py; this script runs it, checks it, and leaves recording,
replay page and picture in out/stack.

    python examples/stack.py            the same as: stark run stack
    python examples/stack.py 0.5        only half a second
"""

import sys

import stark.scenes


def main() -> int:
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    result = stark.scenes.run("stack", until=until)
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    print(*result.files, sep="\n")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
