"""``stark doctor``: what this machine and installation offer, and whether a first step works."""

from __future__ import annotations

import argparse
import importlib.util
import os
import platform
import sys
from importlib import metadata
from pathlib import Path

from .output import say

#: Optional packages: distribution, module, what it adds, extra.
_OPTIONAL = (
    ("pytetwild", "pytetwild", "tetrahedral meshes of closed surfaces", "mesh"),
    ("trimesh", "trimesh", "more mesh formats", "mesh"),
    ("yourdfpy", "yourdfpy", "robots of URDF files", "robots"),
    ("mujoco", "mujoco", "robots of MJCF files", "robots"),
    ("usd-core", "pxr", "robots of USD files, export to USD", "usd"),
    ("gymnasium", "gymnasium", "environments for learning", "rl"),
    ("viser", "viser", "live view in a browser", "view"),
    ("imageio", "imageio", "mp4 films", "video"),
    ("imageio-ffmpeg", "imageio_ffmpeg", "mp4 films", "video"),
    ("h5py", "h5py", "export to VTKHDF", "export"),
    ("pyarrow", "pyarrow", "export to Parquet", "export"),
    ("mcap", "mcap", "export to MCAP", "export"),
    ("scipy", "scipy", "fits of laws to measured curves", "fit"),
    ("ray", "ray", "studies on a cluster", "sweep"),
    ("ipctk", "ipctk", "independent check for intersections", "test"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--no-step", action="store_true", help="skip the trial step")


def processor() -> tuple[str, set[str]]:
    """Name and instruction sets of the processor, as Linux reports them."""
    name, flags = platform.processor() or platform.machine(), set()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                name = value.strip()
            elif key.strip() == "flags":
                flags = set(value.split())
                break
    except OSError:
        pass
    return name, flags


def _is_arm() -> bool:
    return platform.machine().lower() in ("aarch64", "arm64")


def _usable(backend: str) -> bool:
    """Whether this processor runs the machine code of ``execution.backend``."""
    import stark.symbolic as sym

    x = sym.symbols("x")
    try:
        sym.compile([x], x * x, backend=backend)(1.0)
    except ValueError:
        return False
    return True


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return "unknown version"


def _line(label: str, text: str) -> None:
    say(f"{label:16}{text}")


def run(args: argparse.Namespace) -> int:
    import numpy as np

    from .. import _core

    name, flags = processor()
    wanted = ("asimd",) if _is_arm() else ("avx2", "fma", "avx512f", "avx512dq")
    _line("stark", f"{_core.__version__}  {Path(__file__).resolve().parents[1]}")
    _line("python", f"{platform.python_version()}  {sys.executable}")
    _line("numpy", np.__version__)
    _line("system", platform.platform())
    _line("processor", name)
    _line("vector sets", "  ".join(f"{flag} {'yes' if flag in flags else 'no'}" for flag in wanted))
    _line("cores", f"{_core.usable_threads()} usable of {os.cpu_count()}")
    if hasattr(_core, "Settings"):
        for field in _core.Settings.fields():
            if field["name"] in ("execution.backend", "linear.solver") and field.get("choices"):
                backends = field["name"].startswith("exec")
                choices = [c for c in field["choices"] if not backends or _usable(c)]
                _line("back ends" if backends else "linear solvers", ", ".join(choices))
    _line("compiler", "not needed")
    say()
    say("optional packages")
    for distribution, module, adds, extra in _OPTIONAL:
        if importlib.util.find_spec(module):
            say(f"  {distribution:16}{_version(distribution):12}{adds}")
        else:
            say(f"  {distribution:16}{'missing':12}{adds}: pip install 'stark-sim[{extra}]'")
    return 0 if args.no_step else _trial_step()


def _trial_step() -> int:
    import time

    import stark

    begin = time.perf_counter()
    scene = stark.Scene()
    scene.add_cloth(stark.mesh.grid(0.1, 0.1, cells=4), stark.materials.cotton)
    report = stark.Simulation(scene, time_step=0.01).step()
    status = str(getattr(report.status, "name", report.status)).lower()
    say()
    say(f"trial step: {status} in {1e3 * (time.perf_counter() - begin):.0f} ms")
    return 0 if status == "accepted" else 1
