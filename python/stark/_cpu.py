"""Refuses processors that cannot run the compiled core, before it is loaded.

The core is compiled for x86-64-v3; on an older processor its first AVX2 instruction ends the interpreter.
"""

import os
import sys

REQUIRED_FLAGS = ("avx2", "fma")


def missing_flags(cpuinfo: str) -> list[str]:
    """Required instruction sets that the first `flags` line of a Linux /proc/cpuinfo does not list."""
    for line in cpuinfo.splitlines():
        name, _, value = line.partition(":")
        if name.strip() == "flags":
            present = set(value.split())
            return [flag for flag in REQUIRED_FLAGS if flag not in present]
    return []


def require_supported_processor() -> None:
    """Raises ImportError on x86-64 Linux without AVX2 or FMA; elsewhere the core checks by itself."""
    if not sys.platform.startswith("linux") or os.uname().machine != "x86_64":
        return
    try:
        with open("/proc/cpuinfo") as file:
            cpuinfo = file.read(8192)
    except OSError:
        return
    missing = missing_flags(cpuinfo)
    if missing:
        raise ImportError(
            f"Stark needs a processor with AVX2 and FMA (Intel Haswell 2013, AMD Zen 2017 or newer); "
            f"this one lacks {', '.join(missing)}"
        )
