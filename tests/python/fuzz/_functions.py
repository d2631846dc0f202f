"""Functions beside scenes, of all parts of the package, with arguments of any type: recordings and what is
made of them, pictures, formulas, surfaces, motions, lists of parts."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from _draw import ODD_NUMBERS, Draw

import stark
import stark.exports
import stark.recording
import stark.render
import stark.replay
import stark.robots
import stark.symbolic

#: Of other types than numbers.
ODD_VALUES: tuple[Any, ...] = (
    *(value for value in ODD_NUMBERS if value is not len), "", "box*", "\0", {}, {1: 2}, {"a": None}, set(),
    [[1, 2], [3]], [None], ["a"], [[1.0]], np.array("a", dtype=object), stark.Scene, b"",
)  # fmt: skip


class Parts(NamedTuple):
    """What functions are called with."""

    sim: stark.Simulation
    run: stark.recording.Recording
    page: Any
    folder: Path
    kept: object
    """Removes the folder at the end of the process."""


@cache
def parts() -> Parts:
    """Made once."""
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="box")
    sim = stark.Simulation(scene, {"time.step": 0.01, "execution.threads": 1})
    kept = tempfile.TemporaryDirectory(prefix="stark-fuzz-")
    folder = Path(kept.name)
    with stark.recording.Recorder(folder / "run", sim, fields=["speed"]) as recorder:
        for _ in range(3):
            recorder.record(sim)
            sim.step()
    stark.render.write_png(folder / "a.png", np.zeros((2, 2, 3), dtype=np.uint8))
    run = stark.recording.Recording(folder / "run")
    return Parts(sim, run, stark.replay.encode(run), folder, kept)


def _recorder(place: Path, **given: Any) -> None:
    stark.recording.Recorder(place / "run", parts().sim, **given).close()


def _exporter(place: Path, **given: Any) -> None:
    sim = parts().sim
    with stark.exports.Exporter(place / "a.pvd", sim, **given) as export:
        export.record(sim)


def _png(place: Path, picture: Any) -> None:
    stark.render.write_png(place / "b.png", picture)


def _cut(place: Path, share: Any) -> None:
    """A picture that is not there to its end."""
    data = (parts().folder / "a.png").read_bytes()
    length = share if isinstance(share, int) and 0 <= share < len(data) else len(data)
    (place / "c.png").write_bytes(data[:length])
    stark.render.read_png(place / "c.png")


def _without(function: Callable[..., Any]) -> Callable[..., Any]:
    """One that writes nothing."""
    return lambda place, **given: function(**given)


def _law(F: Any, **values: Any) -> Any:
    return stark.j2_plasticity(F, plastic_metric=np.eye(3), plastic_strain=0.0, **values)


def _calls() -> Mapping[str, tuple[Callable[..., Any], dict[str, Any]]]:
    sim, run, page, *_ = parts()
    metal = {"shear_modulus": 1.0, "bulk_modulus": 1.0, "yield_stress": 1.0}
    turned = stark.rotation(axis="z", angle=0.1)
    return {
        "Recorder": (
            _recorder,
            {"scene": "a", "settings": {}, "chunk_frames": 2, "certify": False, "fields": ["speed"],
             "arrays": None, "contacts": False, "stark_version": ""},
        ),
        "export": (
            lambda place, **given: stark.exports.export_recording(run, place, **given),
            {"format": "ply", "frames": [0, 1], "fields": None},
        ),
        "Exporter": (_exporter, {"fields": ["speed"], "fps": 60.0}),
        "write_png": (_png, {"picture": np.zeros((2, 2, 3), dtype=np.uint8)}),
        "read_png": (_cut, {"share": None}),
        "bounds": (lambda place, source: stark.render.scene_bounds(source), {"source": sim}),
        "encode": (_without(stark.replay.encode), {"recording": run, "stride": 1, "max_megabytes": 50.0}),
        "decode": (_without(stark.replay.decode), {"replay": page, "body": 0, "frame": 1}),
        "positions": (_without(run.positions), {"body": "box", "frames": 0}),
        "nearest": (_without(run.nearest), {"time": 0.0}),
        "overlapping": (_without(sim.scene.disable_overlapping), {"bodies": None}),
        "Surface": (
            _without(stark.surfaces.Surface),
            {"name": "a", "thickness": 1e-3, "stiffness": 1e5, "source": "", "core": 0.0},
        ),
        "relative_pressure": (_without(stark.surfaces.relative_pressure), {"gap": [0.1, 0.5]}),
        "rotations": (
            _without(stark.motion.rotations),
            {"times": [0.0, 1.0], "values": [np.eye(3), turned], "smooth": False},
        ),
        "joined": (_without(stark.mesh.joined), {"surfaces": [stark.mesh.box(0.1)]}),
        "cleaned": (_without(stark.mesh.cleaned), {"mesh": stark.mesh.box(0.1), "report": None}),
        "SolidMesh": (
            _without(stark.mesh.SolidMesh), {"vertices": np.eye(4, 3), "elements": [[0, 1, 2, 3]]}
        ),
        "Link": (
            _without(stark.robots.Link), {"name": "a", "inertia": None, "visuals": (), "collisions": ()}
        ),
        "is_same": (
            lambda place, **given: stark.symbolic.is_same(**given), {"a": 1.0, "b": 2.0}
        ),
        "Vec": (_without(stark.symbolic.Vec), {"entries": [1.0, 2.0]}),
        "Mat": (_without(stark.symbolic.Mat), {"rows": [[1.0, 2.0]]}),
        "law": (lambda place, F: _law(F, **metal), {"F": np.eye(3)}),
        "material": (lambda place, **given: stark.j2_plasticity(**given), metal),
    }  # fmt: skip


def functions(draw: Draw) -> None:
    """A call that succeeds or is refused by name."""
    calls = _calls()
    name = draw.pick(list(calls))
    function, good = calls[name]
    given = {key: draw.value(value, ODD_VALUES) for key, value in good.items()}
    draw.trace.append(f"{name}({', '.join(f'{key}={str(value)[:40]}' for key, value in given.items())})")
    with tempfile.TemporaryDirectory(dir=draw.memory) as place, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with np.errstate(all="ignore"):
                function(Path(place), **given)
        except stark.Error as error:
            assert len(str(error)) > 10, f"{error!r} says nothing"
            draw.trace[-1] += f" -> {str(error)[:160]}"
