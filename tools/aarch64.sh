#!/bin/sh
# Cross-builds the C++ library for aarch64 Linux and runs all its test suites under qemu-user: hours for all of them;
# hello_cloth alone takes 11 minutes.
# Needs g++-aarch64-linux-gnu, qemu-user, cmake, ninja and doctest (Debian: doctest-dev).
#
#   tools/aarch64.sh [name of a suite ...]
set -eu
cd "$(dirname "$0")/.."
for tool in aarch64-linux-gnu-g++ qemu-aarch64 cmake ninja; do
  command -v "$tool" >/dev/null || { echo "tools/aarch64.sh: $tool is missing; apt-get install g++-aarch64-linux-gnu qemu-user cmake ninja-build doctest-dev" >&2; exit 1; }
done
cmake -S . -B build/aarch64 -G Ninja -DCMAKE_TOOLCHAIN_FILE=cmake/toolchains/aarch64-linux-gnu.cmake \
  -DCMAKE_BUILD_TYPE=Release -DSTARK_BUILD_TESTS=ON -DSTARK_BUILD_PYTHON=OFF >/dev/null
cmake --build build/aarch64
suites="$*"
[ -n "$suites" ] || suites=$(cd build/aarch64/tests && ls | grep -x 'test_[a-z]*')
# qemu-user itself dies in a process that forks with threads.
left_out="a pool goes on in a forked process*"
failed=""
for suite in $suites; do
  echo "== $suite"
  qemu-aarch64 -L /usr/aarch64-linux-gnu "build/aarch64/tests/$suite" -tce="$left_out" || failed="$failed $suite"
done
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }
