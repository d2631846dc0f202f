#!/bin/sh
# clang-tidy over the library: tools/tidy.sh [files...]. Needs a configured build/dev and `pip install clang-tidy`.
set -eu
cd "$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)"
if [ ! -f build/dev/compile_commands.json ]; then
  echo "Configure first: tools/dev.sh" >&2
  exit 1
fi
if [ $# -eq 0 ]; then
  # Source names hold no blanks; the list is meant to be split.
  set -- $(find src -name '*.cpp' | sort)
fi
exec .venv/bin/clang-tidy -p build/dev --quiet "$@"
