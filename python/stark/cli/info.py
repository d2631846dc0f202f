"""``stark info``: the packaged scenes, one scene, one recording or one checkpoint."""

from __future__ import annotations

import argparse
from pathlib import Path
from shlex import quote

from .output import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what",
        nargs="?",
        metavar="SCENE|RUN|FILE.stark",
        help="a scene, the folder of a run, or a checkpoint",
    )
    parser.add_argument(
        "--settings", action="store_true", help="list all settings with unit, default and meaning"
    )


def run(args: argparse.Namespace) -> int:
    if args.settings:
        return _settings()
    if args.what is None:
        return _scenes()
    path = Path(args.what)
    if path.is_dir():
        return _recording(path)
    return _checkpoint(path) if path.suffix == ".stark" else _scene(args.what)


def _settings() -> int:
    from ..settings import Settings

    for field in Settings.fields():
        unit = f" {field['unit']}" if field.get("unit") not in (None, "", "1") else ""
        say(f"{field['name']} = {field.get('default')}{unit}")
        say(f"    {field.get('doc', '')}")
    return 0


def _scenes() -> int:
    from ..scenes import load, names

    for name in names():
        scene = load(name)
        say(f"{name:24} {scene.until:5g} s  {scene.description}")
    return 0


def _scene(name: str) -> int:
    from ..scenes import load

    scene = load(name)
    built, settings = scene.build()
    say(f"{scene.name}: {scene.description}")
    say(f"  runs for {scene.until:g} s" if scene.until else "  needs --until")
    for key, value in getattr(scene.module, "options", {}).items():
        say(f"  option {key} = {value}")
    for key, value in settings.items():
        say(f"  {key} = {value}")
    for body in getattr(built, "bodies", []):
        say(f"  {getattr(body, 'kind', '?'):6} {body.name}")
    return 0


def _recording(folder: Path) -> int:
    from ..checkpoint import Checkpoint
    from ..recording import Recording
    from ..recording.format import CHECKPOINT

    recording = Recording(folder)
    manifest = recording.manifest
    telemetry = recording.telemetry
    say(f"{recording.scene}: {recording.status} {manifest.get('message', '')}".rstrip())
    say(f"  {manifest.get('created', '')}, Stark {manifest.get('stark_version', '')}")
    if len(recording):
        say(
            f"  {len(recording)} frames from {recording.times[0]:g} to {recording.times[-1]:g} s, "
            f"{len(telemetry)} steps"
        )
    for body in recording.bodies:
        say(f"  {body.kind:6} {body.name}: {body.vertex_count} vertices, {body.triangle_count} triangles")
    for name, value in manifest.get("summary", {}).get("observables", {}).items():
        say(f"  {name} = {'nothing' if value is None else format(value, '.6g')}")
    if (folder / CHECKPOINT).exists():
        time = Checkpoint.read(folder / CHECKPOINT).time
        say(f"  checkpoint at {time:g} s: stark run --resume {quote(str(folder))}")
    return 0


def _checkpoint(path: Path) -> int:
    from ..checkpoint import Checkpoint

    checkpoint = Checkpoint.read(path)
    state = checkpoint.state
    say(f"{checkpoint.scene}: checkpoint at {checkpoint.time:g} s, after {state.step_count} steps")
    say(f"  Stark {checkpoint.stark_version}, state {state.hash}")
    for name, array in state.arrays().items():
        if array.size and array.ndim:
            say(f"  {name}: {len(array)}")
    for name in checkpoint.memory:
        say(f"  memory {name}")
    return 0
