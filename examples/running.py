"""What examples do when they are run as programs: run, with progress, then numbers, plots and pictures."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import stark
import stark.scenes
from stark.recording import Recording

#: What came out, what is expected and how far it may be off, by name.
Results = Mapping[str, tuple[float, float, float]]


def main(file: str) -> int:
    """Runs a scene file with the options of the command line, as NAME=VALUE, and returns the exit code. The
    file has ``results(run)`` and ``draw(run, path)``, and may have ``plot(run, path)`` and
    ``on_step(sim, report)``."""
    scene = stark.scenes.load(file, dict(word.split("=", 1) for word in sys.argv[1:]))
    module: Any = scene.module

    def on_step(sim: Any, report: Any) -> None:
        print(f"\r{scene.name}: {sim.time:.2f} of {scene.until:g} s", end="", flush=True)
        if hasattr(module, "on_step"):
            module.on_step(sim, report)

    result = stark.scenes.run(scene, on_step=on_step)
    print(f"\n{result.scene}: {result.status} {result.message}, {result.steps} steps in {result.wall:.1f} s")
    run = Recording(result.folder)
    if result.status in ("complete", "wrong"):
        for name, (value, reference, tolerance) in module.results(run).items():
            print(f"  {name}: {value:.5g}, expected {reference:.5g} within {tolerance:.2g}")
        if hasattr(module, "plot"):
            print(module.plot(run, run.folder / "curves.svg"))
        print(module.draw(run, run.folder / f"{Path(file).stem}.png"))
    return result.exit_code


def installed(package: str, folder: str) -> Path:
    """A folder of files that came with a package, as seen from the folder in which packages are."""
    spec = importlib.util.find_spec(package)
    found = Path(spec.origin).parents[1] / folder if spec is not None and spec.origin else None
    if found is None or not found.is_dir():
        raise ImportError(f"this example reads files of {folder}: pip install 'stark-sim[examples]'")
    return found


def assert_close(found: Results) -> None:
    """Raises AssertionError for the first number that is further off than it may be."""
    for name, (value, reference, tolerance) in found.items():
        assert abs(value - reference) <= tolerance, f"{name} is {value:.6g}, expected {reference:.6g}"


def measured(run: Recording) -> dict[str, Any]:
    """Series of the telemetry (n,) by name, those of ``measure`` under their own."""
    return {name.removeprefix("measured."): run.telemetry[name] for name in run.telemetry.names}
