"""Values of other types in functions of all parts of the package: refused by name. They raised TypeError,
ValueError, AttributeError, OverflowError or OSError from inside."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stark
import stark.calibration
import stark.curves
import stark.exports
import stark.gym
import stark.recording
import stark.render
import stark.replay
import stark.reproducer
import stark.robots
import stark.scenes
import stark.study
import stark.telemetry
import stark.verify

ARRAY = np.zeros(2)
NUMBER = np.array(2.0)  # which says that it can be gone through
RAGGED = [[1, 2], [3]]
HUGE = 10**400


@pytest.fixture(scope="module")
def sim() -> stark.Simulation:
    scene = stark.Scene()
    scene.add_box(0.1, mass=1.0, name="tool")
    scene.add_cloth(stark.mesh.grid(0.2, 0.2, cells=2), position=(0, 0, 1), name="sheet")
    return stark.Simulation(scene, time_step=0.01)


@pytest.fixture(scope="module")
def recording(sim: stark.Simulation, tmp_path_factory: pytest.TempPathFactory) -> stark.recording.Recording:
    folder = tmp_path_factory.mktemp("recordings") / "run"
    with stark.recording.Recorder(folder, sim, fields=["speed"]) as recorder:
        recorder.record(sim)
    return stark.recording.Recording(folder)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda sim: sim.scene.disable_overlapping(3), "bodies = 3: must be a list of bodies"),
        (lambda sim: sim.scene.disable_overlapping("tool"), "bodies = 'tool': must be a list of bodies"),
        (lambda sim: sim.scene.disable_overlapping(sim["tool"]), "bodies = .*: must be a list of bodies"),
        (lambda sim: sim["sheet"].vertices[[[1, 2], [3]]], r"the index = .*: must be an array, with rows of"),
        (lambda sim: sim.contacts.vertex_forces(-1), "count = -1: must be the number of vertices"),
        (lambda sim: sim.contacts.vertex_forces(2.5), "count = 2.5: must be the number of vertices"),
        (lambda sim: sim.contacts.vertex_forces(HUGE), "count = 1000.*: must be the number of vertices"),
        (lambda sim: sim.settings.update(3), "3: must be a dictionary of settings by name"),
        (lambda sim: sim.settings.update(ARRAY), "must be a dictionary of settings by name"),
        (lambda sim: sim.settings.set_text(3), "3: must have the form name=value"),
        (lambda sim: stark.Settings().update("time.step"), "must be a dictionary of settings by name"),
        (lambda sim: stark.Settings().update({3: 1}), "3: must be the name of a setting"),
        (lambda sim: stark.Settings()[3], "3: must be the name of a setting"),
        (lambda sim: sim.settings.__setitem__(None, 1), "None: must be the name of a setting"),
        (lambda sim: stark.materials.cotton.replace(name=ARRAY), "ShellMaterial: name = .*must be a text"),
        (lambda sim: sim.scene.add_symmetry(sim["sheet"].vertices, HUGE), "normal = 1000.*: must be 'x'"),
        (lambda sim: stark.render.render(sim, quality=[1]), r"quality \[1\] is unknown"),
        (lambda sim: stark.render.render(sim, width=[1]), r"size \[1\] x .*: each must be in"),
        (lambda sim: stark.render.scene_bounds(), "got no frames: must be at least one"),
        (lambda sim: stark.render.auto_camera((0, 0, 1)), "bounds = .*: must be those of scene_bounds"),
        (
            lambda sim: stark.render.auto_camera(stark.render.scene_bounds(sim), view=[1]),
            r"view \[1\] is unk",
        ),
        (lambda sim: stark.render.tensor_values(sim, ARRAY), "is unknown: must be one of"),
        (lambda sim: stark.render.field_values(3, "speed"), "field_values: sim = 3: must be a stark.Sim"),
        (lambda sim: stark.exports.Exporter("a.usd", sim, fields=3), "fields = 3: must be several names"),
        (lambda sim: stark.exports.Exporter("a.usd", sim, fields=[[1]]), r"fields = \[\[1\]\]: must be sev"),
        (lambda sim: stark.curves.bending([0, 1], axis=ARRAY), "axis = .*: must be 1 or 2"),
        (lambda sim: stark.exports.Exporter("a.pc2", sim, fields=["speed"]), "'pc2' has none"),
        (lambda sim: stark.render.render(sim, limits=(0, 1)), r"limits = \(0, 1\): .*must come with field="),
        (lambda sim: stark.render.render(sim, label="speed"), "label = 'speed': .*must come with field="),
        (lambda sim: stark.gym.SceneEnv("drop", render_mode=ARRAY), "render_mode = .*: must be None or"),
        (lambda sim: stark.gym.SceneEnv("drop", settings=[1]), r"settings = \[1\]: must be a dictionary"),
        (lambda sim: stark.scenes.load("drop", options="size"), "options = 'size': must be a dictionary"),
        (lambda sim: stark.scenes.load(3), "scene = 3: must be the name of a packaged scene, or a path"),
        (lambda sim: stark.study.Plan("drop", 3), "samples = 3, repetitions = 1: must be a list of options"),
        (lambda sim: stark.study.Plan("drop", [{}], repetitions="a"), "repetitions = 'a': must be a list"),
        (lambda sim: stark.calibration.fit(ARRAY, []), "fit: law = .*must be a law or a material"),
        (lambda sim: stark.recording.Recording("x" * 300), "folder = .*in names of at most 255 bytes"),
        (lambda sim: stark.recording.Recorder("run", sim, chunk_frames="a"), "chunk_frames = 'a': must be a"),
        (lambda sim: stark.recording.Recorder("run", sim.scene), "sim = .*: must be a stark.Simulation"),
        (lambda sim: stark.recording.Recorder("run", stark.Scene), "sim = .*: must be a stark.Simulation"),
        (lambda sim: stark.recording.Recorder("run", sim, scene=b"x"), "scene = b'x': must be a text"),
        (lambda sim: stark.recording.Recorder("run", sim, settings="x"), "settings = 'x': must be a dict"),
        (lambda sim: stark.recording.Recorder("run", sim, arrays=["x"]), r"arrays = \['x'\]: must be a dict"),
        (lambda sim: stark.recording.Recorder("run", sim, arrays={"x": 2}), "'x': 2.*: must be functions"),
        (lambda sim: stark.recording.Recorder("run", sim, fields=[[1]]), r"fields = \[\[1\]\]: must be sev"),
        (lambda sim: stark.recording.Recorder("run", sim, fields=NUMBER), "fields = array.*: must be sever"),
        (lambda sim: stark.exports.Exporter("a.usd", sim, fields=NUMBER), "fields = array.*: must be sever"),
        (
            lambda sim: stark.exports.Exporter("a.pvd", sim, fps=24.0),
            "fps = 24.0: must be left out: only USD",
        ),
        (lambda sim: sim.scene.disable_overlapping(NUMBER), "bodies = array.*: must be a list of bodies"),
        (lambda sim: sim.picture(bodies=NUMBER), "bodies = array.*: must be bodies, their names"),
        (lambda sim: sim.view(field=["speed"]), r"view: field = \['speed'\]: must be one of"),
        (lambda sim: stark.reproducer.write(sim.scene, "x"), "sim = .*Scene.*: must be a stark.Simulation"),
        (lambda sim: stark.telemetry.TelemetryWriter(None), "telemetry: path = None: must be a path"),
        (lambda sim: stark.telemetry.TelemetryWriter("x", kept="a"), "kept = 'a': must be bytes"),
        (lambda sim: stark.render.read_png("none.png"), "read_png: 'none.png': No such file .*readable pict"),
        (
            lambda sim: stark.render.write_png("a.png", RAGGED),
            r"picture = \[\[1, 2\], \[3\]\]: must be an arr",
        ),
        (lambda sim: stark.replay.decode(None, 0, 0), "decode: replay = None: must be what encode returned"),
        (
            lambda sim: stark.mesh.SolidMesh(np.zeros((8, 3)), RAGGED),
            "elements: got no rows of equal length: must be",
        ),
        (lambda sim: stark.mesh.joined(NUMBER), "joined: got ndarray: must be a list of surfaces"),
        (
            lambda sim: stark.mesh.cleaned(stark.mesh.box(0.1), report=[]),
            r"report = \[\]: must be a stark.mes",
        ),
        (lambda sim: stark.mesh.solid_from_scan("x.ply", edge_length=1.0, progress=3), "progress = 3: must"),
        (lambda sim: stark.mesh.lattice_from_scan("x.ply", cell_size=1.0, progress=3), "progress = 3: must"),
        (lambda sim: stark.mesh.tetrahedralise(stark.mesh.box(0.1), keep=ARRAY), "keep = .*True or False"),
        (lambda sim: stark.motion.rotations([0.0, 1.0], NUMBER), "values = array.*: must be matrices"),
        (lambda sim: stark.surfaces.Surface("x", HUGE, 1e5, "guess"), "thickness = 1000.*: must be"),
        (lambda sim: stark.surfaces.relative_pressure(""), "relative_pressure: gap = '': must be of real"),
        (lambda sim: stark.robots.Link("a", visuals=NUMBER), "visuals = array.*: must be"),
        (lambda sim: stark.gym.SceneEnv("drop", settings={1: 2}), "settings = {1: 2}: must be a dictionary"),
    ],
)
def test_of_simulations(
    sim: stark.Simulation, call: Callable[[Any], object], text: str, tmp_path: Path, monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(stark.InvalidArgument, match=text):
        call(sim)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda run: run.nearest([0.1]), r"time = \[0.1\]: must be a number"),
        (lambda run: run.beyond({}), "time = {}: must be a number"),
        (lambda run: run.still("end"), "time = 'end': must be a number"),
        (lambda run: run.body_index(ARRAY), "has no body .*; it has: tool, sheet"),
        (lambda run: run.positions(None, 0), "has no body None; it has: tool, sheet"),
        (lambda run: run.field(ARRAY, 0), "field: name = .*: must be a text"),
        (lambda run: run.telemetry.unit({}), "the name of a series = {}: must be a text"),
        (
            lambda run: stark.render.render(run),
            r"is a recording: must be a simulation, or a frame: recording\.fr",
        ),
        (lambda run: stark.render.scene_bounds(run), "is a recording: must be a simulation, or a frame"),
        (lambda run: stark.telemetry.Telemetry.read(ARRAY), "telemetry: path = .*: must be a path"),
        (lambda run: stark.exports.export_recording(str(run.folder), "files"), "must be a stark.recording.R"),
        (lambda run: stark.exports.export_recording(run, "files", ARRAY), "format .* is unknown"),
        (lambda run: stark.exports.export_recording(run, "files", "ply", fields=["speed"]), "'ply' has none"),
        (lambda run: stark.exports.export_recording(run, "files", "pc2", fields=["speed"]), "'pc2' has none"),
        (lambda run: stark.exports.export_recording(run, "files", "ply", fields=3), "fields = 3: 'ply' has"),
        (
            lambda run: stark.exports.export_recording(run, "files", "mcap", frames=[0]),
            "of every step: leave",
        ),
        (lambda run: stark.replay.encode(str(run.folder)), "must be a stark.recording.Recording"),
        (
            lambda run: stark.replay.decode(stark.replay.encode(run), 2, 0),
            r"body = 2: must be a number in \[0, 2",
        ),
        (lambda run: stark.replay.decode(stark.replay.encode(run), 0, 0.5), "frame = 0.5: must be a number"),
        (lambda run: stark.replay.encode(run, stride=[1]), r"stride = \[1\]; must be at least 1, and whole"),
        (lambda run: stark.replay.encode(run, max_megabytes="a"), "max_megabytes = 'a': must be a number"),
        (lambda run: stark.replay.write_page(run, overlay="run"), "overlay: recording = 'run': must be a st"),
    ],
)
def test_of_recordings(
    recording: stark.recording.Recording, call: Callable[[Any], object], text: str, tmp_path: Path
) -> None:
    with pytest.raises(stark.InvalidArgument, match=text):
        call(recording)


def test_paths_that_no_file_has() -> None:
    """``stark.verify`` stands alone, with an exception of its own."""
    with pytest.raises(ValueError, match=r"verify: folder = .*: must be a path"):
        stark.verify.verify("x" * 300)


def test_targets_that_no_float_holds() -> None:
    """The question whether degrees are meant overflowed."""
    scene = stark.Scene()
    hinge = scene.add_hinge(None, scene.add_box(0.1, mass=1.0), anchor=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(stark.InvalidArgument, match="target = 1000"):
        hinge.add_servo(target=HUGE, stiffness=1.0, damping=1.0, cap=1.0)
    assert len(scene.actuators) == 0
