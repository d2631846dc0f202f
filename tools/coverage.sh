#!/bin/sh
# Which lines the tests run:  tools/coverage.sh [python|cpp]...      both if left out
# Writes build/coverage/*.json and the tables of docs/coverage.md. Python: the fast tests, by coverage.py. C++: its own
# tests, built by gcc with --coverage and without optimisation, which takes an hour on one core.
set -eu
cd "$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)"
out=build/coverage
mkdir -p "$out"
if [ $# -eq 0 ]; then set -- python cpp; fi
for part; do
  case $part in
    python)
      PYTHONPATH=python COVERAGE_FILE="$out/python.coverage" .venv/bin/python -m pytest tests/python -m "not slow" -q \
        --ignore=tests/python/physics --ignore=tests/python/engine \
        --cov=python/stark --cov-report="json:$out/python.json" --cov-report=
      ;;
    cpp)
      cmake -S . -B "$out/cpp" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS="--coverage -O0 -fprofile-update=atomic" \
        -DSTARK_BUILD_TESTS=ON >"$out/configure.log"
      nice -n 5 cmake --build "$out/cpp" -j "${JOBS:-1}"
      find "$out/cpp" -name '*.gcda' -delete
      # The test of the installed package links without --coverage.
      ctest --test-dir "$out/cpp" --output-on-failure -j "${JOBS:-1}" -E package
      # From the build folder: gcov looks for sources from there. Lines of kernels run billions of times: "suspicious".
      (cd "$out/cpp" && ../../../.venv/bin/python -m gcovr --root ../../.. --filter ../../../src/stark/ . --exclude-throw-branches \
        --gcov-ignore-parse-errors suspicious_hits.warn_once_per_file \
        --json ../cpp.json)
      ;;
    *)
      echo "tools/coverage.sh: '$part' is neither python nor cpp" >&2
      exit 2
      ;;
  esac
done
.venv/bin/python tools/coverage_table.py "$out" docs/coverage.md
