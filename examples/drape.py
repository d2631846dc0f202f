"""drape: cloth over a sphere and a floor.

What it shows: friction for each pair of bodies.
The scene itself is python/stark/scenes/drape.py; this script runs it, checks it, and leaves recording,
replay page and picture in out/drape.

    python examples/drape.py            the same as: stark run drape
    python examples/drape.py 0.5        only half a second
"""

import sys

import stark.scenes


def main() -> int:
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    result = stark.scenes.run("drape", until=until)
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    print(*result.files, sep="\n")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
