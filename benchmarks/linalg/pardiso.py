"""Factorisation by MKL's Pardiso in single and double precision, on the systems that bench_linalg writes:

bench_linalg 1 FOLDER; python benchmarks/linalg/pardiso.py FOLDER

Needs ``pip install mkl``, which nothing else of Stark uses. One thread, ordering by METIS, SPD; CPU
milliseconds, the best of seven."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from pathlib import Path
from typing import Any

os.environ["MKL_NUM_THREADS"] = "1"

import numpy as np

_SPD = 2  # real, symmetric, positive definite
_ANALYSE, _FACTOR, _SOLVE, _RELEASE = 11, 22, 33, -1
_FILL, _SINGLE, _FROM_ZERO, _FLOPS, _METIS = 1, 27, 34, 18, 2  # places in iparm, and a value


def read(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts of rows, columns and values of the upper triangle."""
    data = path.read_bytes()
    n, count = np.frombuffer(data, np.int64, 2)
    start = np.frombuffer(data, np.int64, n + 1, 16).astype(np.int32)
    column = np.frombuffer(data, np.int32, count, 16 + 8 * (n + 1))
    value = np.frombuffer(data, np.float64, count, 16 + 8 * (n + 1) + 4 * count)
    return start, column, value


def pardiso(library: ctypes.CDLL, path: Path, real: type) -> str:
    start, column, value = read(path)
    value = value.astype(real)
    n = len(start) - 1
    handle, parameters = np.zeros(64, np.int64), np.zeros(64, np.int32)
    b, x, error = np.ones(n, real), np.zeros(n, real), ctypes.c_int(0)
    parameters[0], parameters[_FILL], parameters[_FROM_ZERO] = 1, _METIS, 1
    parameters[_SINGLE], parameters[_FLOPS] = real is np.float32, -1

    def pointer(array: np.ndarray) -> Any:
        return array.ctypes.data_as(ctypes.c_void_p)

    def call(phase: int) -> float:
        one, kind, silent, unused = (ctypes.c_int(k) for k in (1, _SPD, 0, 0))
        begin = time.process_time()
        library.pardiso(
            pointer(handle),
            *(ctypes.byref(k) for k in (one, one, kind, ctypes.c_int(phase), ctypes.c_int(n))),
            *(pointer(array) for array in (value, start, column)),
            *(ctypes.byref(unused), ctypes.byref(one), pointer(parameters), ctypes.byref(silent)),
            *(pointer(b), pointer(x), ctypes.byref(error)),
        )
        if error.value:
            raise RuntimeError(f"pardiso: phase {phase} of '{path}': error {error.value}")
        return 1e3 * (time.process_time() - begin)

    analyse = call(_ANALYSE)
    factor = min(call(_FACTOR) for _ in range(7))
    solve = min(call(_SOLVE) for _ in range(3))
    call(_RELEASE)
    return (
        f"{np.dtype(real).name}: {parameters[_FLOPS] / 1e3:.3f} Gflop; ordering + symbolic {analyse:.1f}, "
        f"factor {factor:.2f} ({parameters[_FLOPS] / factor:.1f} GF/s), solve {solve:.2f}"
    )


def main() -> None:
    library = ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libmkl_rt.so.3"))
    for path in sorted(Path(sys.argv[1]).glob("*.bin")):
        print(path.stem.replace("_", " "))
        for real in (np.float64, np.float32):
            print(f"  {pardiso(library, path, real)}")


if __name__ == "__main__":
    main()
