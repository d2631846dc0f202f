#!/bin/sh
# Runs the fast suites, C++ and Python, under a sanitizer:  tools/sanitize.sh address|thread [pytest arguments...]
# "address" is AddressSanitizer and UndefinedBehaviorSanitizer with the assertions of the standard library. Uses the
# .venv of tools/dev.sh; everything it builds goes into build/sanitize-*. Any finding ends the run with an error.
set -eu
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
case ${1:-} in
  address) flags=address,undefined library=libasan.so ;;
  thread) flags=thread library=libtsan.so ;;
  *) sed -n '2,4s/^# //p' "$0" >&2; exit 2 ;;
esac
build=build/sanitize-$1
shift
[ -x .venv/bin/python ] || sh tools/dev.sh
mkdir -p build
# -O1: half of the time to compile, and calls that are still there to be named.
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" \
  -DSTARK_SANITIZE="$flags" -DSTARK_BUILD_TESTS=ON \
  -DSTARK_BUILD_PYTHON=ON -DPython_EXECUTABLE="$root/.venv/bin/python" >"$build-configure.log"
# Not the stub of the extension: making it loads the extension, which needs the library of the sanitizer first.
targets=$(cmake --build "$build" --target help | sed -n 's/^\(test_[a-z_]*\): phony$/\1/p')
cmake --build "$build" -j2 --target _core $targets

# The package: the sources, copied because tests look at where they are, with the sanitized extension.
rm -rf "$build/package"
mkdir -p "$build/package"
cp -r python/stark "$build/package/"
rm -f "$build"/package/stark/_core*.so
cp "$build"/python/_core*.so "$build/package/stark/"

# Python itself keeps memory until the end; the extension does not unload.
export ASAN_OPTIONS=detect_leaks=0:halt_on_error=1:allocator_may_return_null=1
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:suppressions=$root/tools/thread_sanitizer.supp
ctest --test-dir "$build" --output-on-failure -E package
# The disassembler is loaded in a way that no sanitizer allows; without a word, the run would end there.
unsuited=$(grep -rl capstone tests/python --include='test_*.py' | sed 's/^/--ignore=/')
# Tests that look at the process itself: what it loads, how much memory it takes, how fast it stops.
for test in formulas/test_formulas_energy.py::test_no_compiler_is_needed \
  test_behaviours.py::test_steps_leave_nothing_behind cli/test_cli_run.py::test_stopping_leaves_a_complete_recording \
  test_import.py::test_import_is_fast_and_loads_nothing_optional test_import.py::test_type_information_is_shipped; do
  unsuited="$unsuited --deselect=tests/python/$test"
done
LD_PRELOAD="$(gcc -print-file-name=$library) $(gcc -print-file-name=libstdc++.so)" PYTHONPATH="$build/package" \
  .venv/bin/python -m pytest tests/python tests/torture -m "not slow" -q -p no:cacheprovider --capture=sys $unsuited "$@"
