#!/bin/sh
# Developer build: makes .venv, then builds the extension in place (python/stark/_core*.so), reusing build/dev.
#   tools/dev.sh [cmake arguments...]      then: PYTHONPATH=python .venv/bin/python ...
# Set CMAKE_BUILD_TYPE and the like through the arguments. Calls are serialised, so several shells may use it at once.
set -eu
case "${1-}" in
-h | --help)
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p;}' "$0"
  exit 0
  ;;
esac
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
mkdir -p build
exec 9>build/dev.lock
flock 9
if [ ! -x .venv/bin/python ]; then
  python3 -m venv .venv
fi
stamp=.venv/dev-requirements
if ! cmp -s pyproject.toml "$stamp"; then
  .venv/bin/python tools/requirements.py build run test >build/dev-requirements.txt
  .venv/bin/python -m pip install -q --disable-pip-version-check -r build/dev-requirements.txt
  cp pyproject.toml "$stamp"
fi
cmake -S . -B build/dev -G Ninja -DSTARK_BUILD_PYTHON=ON -DSTARK_PYTHON_IN_PLACE=ON \
  -DPython_EXECUTABLE="$root/.venv/bin/python" "$@" >build/dev-configure.log || {
  cat build/dev-configure.log
  exit 1
}
nice -n 5 cmake --build build/dev -j2
