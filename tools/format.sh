#!/bin/sh
# Formats the tree in place: tools/format.sh, or only reports what it would change: tools/format.sh --check
set -eu
cd "$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)"
bin=.venv/bin
cpp=$(find src python/bindings tests benchmarks examples \( -name '*.h' -o -name '*.cpp' \) -type f | sort)
status=0
# Source names hold no blanks; the lists are meant to be split.
if [ "${1:-}" = --check ]; then
  $bin/clang-format --dry-run --Werror $cpp 2>&1 | grep -E 'error:' | cut -d: -f1 | uniq -c || true
  $bin/clang-format --dry-run --Werror $cpp >/dev/null 2>&1 || status=1
  $bin/ruff format -q --check . || status=1
else
  $bin/clang-format -i $cpp
  $bin/ruff format -q .
  $bin/ruff check -q --fix . || status=1
fi
exit $status
