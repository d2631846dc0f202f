"""hello_cloth: a scripted box turns under a cotton cloth.

What it shows: contact between a scripted rigid body and cloth, self-contact.
The scene itself is python/stark/scenes/hello_cloth.py; this script runs it, checks it, and leaves
recording, replay page and picture in out/hello_cloth.

    python examples/hello_cloth.py            the same as: stark run hello_cloth
    python examples/hello_cloth.py 0.5        only half a second
"""

import sys

import stark.scenes


def main() -> int:
    until = float(sys.argv[1]) if len(sys.argv) > 1 else None
    result = stark.scenes.run("hello_cloth", until=until)
    print(f"{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    print(*result.files, sep="\n")
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
