"""drop: a CAD part, filled with tetrahedra, falls into a hammock.

What it shows: meshes from files, pytetwild (pip install 'stark-sim[mesh]'), three kinds of bodies in contact.
The scene itself is python/stark/scenes/drop.py; this script runs it, checks it, and leaves recording,
replay page and picture in out/drop.

    python examples/drop.py            the same as: stark run drop
    python examples/drop.py 0.5        only half a second
"""

import sys

import stark.scenes


def main() -> int:
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    result = stark.scenes.run("drop", until=until)
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    print(*result.files, sep="\n")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
