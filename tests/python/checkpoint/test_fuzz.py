"""Damaged checkpoints and recordings give exceptions of Stark or what was written, never anything else."""

from __future__ import annotations

import io
import json
import shutil
import sys
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest
from _damage import COUNT, SEED, damaged, strange_arrays, strange_json
from _runs import write_scene
from _zoo import CASES, advance

import stark
from stark import scenes
from stark.array_file import DamageError, read_arrays
from stark.checkpoint import Checkpoint, CheckpointError
from stark.recording import Recording, RecordingError
from stark.verify.files import UnreadableRecording, read_npz

sys.path.append(str(Path(__file__).parent.parent))
from fake_simulation import record

CASE = CASES["energies"]


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkpoint with everything that one can hold."""
    path = tmp_path_factory.mktemp("good") / "good.stark"
    sim = CASE.simulate()
    advance(CASE, sim, {}, 3)
    sim.save(path, memory={"n": 3, "text": "a", "list": [1.5, (2, None)], "array": np.arange(3)})
    return path


def arrays_of(path: Path) -> tuple[dict, dict[str, np.ndarray]]:
    arrays = dict(read_arrays(path))
    return json.loads(arrays.pop("header").tobytes()), arrays


def rewrite(path: Path, header: dict, arrays: dict[str, np.ndarray]) -> Path:
    """A file with good CRCs, whatever is in it."""
    text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez(path.open("wb"), header=text, **arrays)
    return path


def test_damaged_files(good: Path, tmp_path: Path) -> None:
    rng, data, path = np.random.default_rng(SEED), good.read_bytes(), tmp_path / "bad.stark"
    expected, refused = Checkpoint.read(good), 0
    for k in range(COUNT):
        path.write_bytes(damaged(data, rng))
        try:
            read = Checkpoint.read(path)
        except CheckpointError as error:
            refused += 1
            assert str(path) in str(error), f"seed {SEED}, mutation {k}"
            continue
        # What nothing depends on has changed, such as a date.
        assert read.state == expected.state and read.settings == expected.settings
        assert read.parts == expected.parts and str(read.memory) == str(expected.memory)
    assert refused > 0.8 * COUNT


def test_strange_headers(good: Path, tmp_path: Path) -> None:
    """Well-formed files that say strange things: refused when read or when put in, or harmless."""
    rng, path = np.random.default_rng(SEED), tmp_path / "bad.stark"
    header, arrays = arrays_of(good)
    sim, refused = CASE.simulate(), 0
    for k in range(COUNT):
        rewrite(path, strange_json(header, rng), arrays)
        before = sim.state
        try:
            sim.load(path)
        except CheckpointError as error:
            refused += 1
            assert str(path) in str(error), f"seed {SEED}, mutation {k}"
            assert sim.state == before
        else:
            assert sim.time == pytest.approx(0.03)
    assert refused > 0.3 * COUNT


@pytest.mark.filterwarnings("ignore::stark.StarkWarning")
@pytest.mark.parametrize("name", ["energies", "mechanism", "scripted", "peel"])
def test_strange_arrays(name: str, tmp_path: Path) -> None:
    """Arrays of other types, shapes and values under hashes that fit: refused, or something to step from."""
    rng, path, case = np.random.default_rng(SEED), tmp_path / "bad.stark", CASES[name]
    sim = case.simulate()
    advance(case, sim, {}, 2)
    sim.save(path)
    header, arrays = arrays_of(path)
    for k in range(COUNT // 3):
        mended, changed = strange_arrays(header, arrays, rng)
        before = sim.state
        try:
            sim.load(rewrite(path, mended, changed))
        except CheckpointError:
            assert sim.state == before, f"seed {SEED}, mutation {k}"
        else:
            sim.step()  # may fail, as a value


def test_marks_of_time_that_are_not_there(tmp_path: Path) -> None:
    """The next step was 0.02 s before the start of a simulation whose marks are 1e-300 s apart."""
    case, path = CASES["peel"], tmp_path / "bad.stark"
    sim = case.simulate()
    advance(case, sim, {}, 2)
    sim.save(path)
    header, arrays = arrays_of(path)
    arrays["state/mark_step"] = np.full_like(arrays["state/mark_step"], 1e-300)
    fields = {n.partition("/")[2]: a for n, a in arrays.items() if n.startswith("state/")}
    header["state_hash"] = stark._core.State.of_arrays(fields).hash
    sim.load(rewrite(path, header, arrays))
    assert sim.step().time == pytest.approx(0.03)


def npy(header: str, data: bytes = b"") -> bytes:
    text = header.encode() + b" " * (-(len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (999999999999,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (999999999999999999, 999999999999999999), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 999999999999999999), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }",
        "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
        "{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1,), }",
        "{'descr': '|b8', 'fortran_order': False, 'shape': (1,), }",
        "(" * 60000,
        "{'descr': '<f8'",
    ],
)
def test_headers_of_arrays_that_lie_take_no_memory(header: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("header.npy", npy(header, b"\0" * 8))
    tracemalloc.start()
    with pytest.raises(DamageError):
        read_arrays(tmp_path / "a.npz")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3e6


def test_errors_do_not_quote_long_names(tmp_path: Path) -> None:
    """Names of an archive may have 64 kB, and what its reader says of two that differ has both."""
    path = tmp_path / "a.npz"
    np.savez(path, **{"x" * 5000: np.zeros(3)})
    data = path.read_bytes()
    at = data.rindex(b"x" * 5000)
    path.write_bytes(data[:at] + b"y" + data[at + 1 :])
    with pytest.raises(DamageError, match="BadZipFile") as raised:
        read_arrays(path)
    assert len(str(raised.value)) <= 300
    with pytest.raises(UnreadableRecording, match="cut off") as unreadable:
        read_npz(path)
    assert len(str(unreadable.value)) < 500


def test_bombs_are_refused(tmp_path: Path) -> None:
    """Compressed arrays, arrays that share bytes, and pickles are not what Stark writes."""
    np.savez_compressed(tmp_path / "a.npz", header=np.zeros(10_000_000, dtype=np.uint8))
    with pytest.raises(DamageError, match="is compressed"):
        read_arrays(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", header=np.array([{}], dtype=object))
    with pytest.raises(DamageError, match="not one of plain numbers"):
        read_arrays(tmp_path / "b.npz")
    one = io.BytesIO()
    with zipfile.ZipFile(one, "w") as archive:
        header = "{'descr': '|u1', 'fortran_order': False, 'shape': (100000,), }"
        archive.writestr("a.npy", npy(header, bytes(100000)))
        for k in range(20):
            member = archive.infolist()[0]
            twin = zipfile.ZipInfo(f"{k}.npy")
            for name in ("CRC", "compress_size", "file_size", "header_offset", "compress_type"):
                setattr(twin, name, getattr(member, name))
            archive.filelist.append(twin)
    (tmp_path / "c.npz").write_bytes(one.getvalue())
    with pytest.raises(DamageError, match="larger than the file"):
        read_arrays(tmp_path / "c.npz")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "damaged or no checkpoint"),
        (b"hello", "damaged or no checkpoint"),
        (None, "there is no such file"),
    ],
)
def test_files_that_are_no_checkpoints(content: bytes | None, message: str, tmp_path: Path) -> None:
    path = tmp_path / "a.stark"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(CheckpointError, match=message):
        Checkpoint.read(path)
    with pytest.raises(CheckpointError, match="damaged or no checkpoint"):
        Checkpoint.read(tmp_path)  # a folder


def test_other_formats_and_versions(good: Path, tmp_path: Path) -> None:
    header, arrays = arrays_of(good)
    later = {**header, "version": 4, "stark_version": "9.9"}
    with pytest.raises(CheckpointError, match=r"format version 4; this Stark reads 3: use .*'9.9'"):
        Checkpoint.read(rewrite(tmp_path / "a.stark", later, arrays))
    with pytest.raises(CheckpointError, match="is no checkpoint of Stark"):
        Checkpoint.read(rewrite(tmp_path / "a.stark", {**header, "format": "x"}, arrays))
    fewer = {name: array for name, array in arrays.items() if name != "state/joint_rate"}
    with pytest.raises(CheckpointError, match=r"field 'joint_rate' is missing.*written by Stark 0.0.1"):
        Checkpoint.read(rewrite(tmp_path / "a.stark", {**header, "stark_version": "0.0.1"}, fewer))
    np.savez(tmp_path / "b.npz", a=np.zeros(3))
    with pytest.raises(CheckpointError, match="is no checkpoint of Stark"):
        Checkpoint.read(tmp_path / "b.npz")


def open_all(folder: Path) -> None:
    """Reads everything that a recording has."""
    run = Recording(folder)
    for frame in run.frames():
        assert len(frame.bodies) == len(run.bodies)
    for name in run.telemetry.names:
        assert run.telemetry[name].shape == (len(run.telemetry),)
    assert isinstance(run.settings, dict)


def test_damaged_recordings(tmp_path: Path) -> None:
    rng = np.random.default_rng(SEED)
    record(tmp_path / "good", 40)
    files = [p.relative_to(tmp_path / "good") for p in sorted((tmp_path / "good").rglob("*")) if p.is_file()]
    expected = [frame.bodies[0].positions for frame in Recording(tmp_path / "good").frames()]
    folder, refused = tmp_path / "bad", 0
    shutil.copytree(tmp_path / "good", folder)
    for k in range(2 * COUNT):
        name = files[int(rng.integers(len(files)))]
        data = (tmp_path / "good" / name).read_bytes()
        if name.name == "manifest.json" and k % 2:
            (folder / name).write_text(json.dumps(strange_json(json.loads(data), rng)))
        else:
            (folder / name).write_bytes(damaged(data, rng))
        try:
            open_all(folder)
        except RecordingError as error:
            refused += 1
            assert str(folder) in str(error), f"seed {SEED}, mutation {k}"
        else:
            if name.suffix == ".npz":
                run = Recording(folder)
                assert all(np.array_equal(run.positions(0, i), x) for i, x in enumerate(expected))
        (folder / name).write_bytes(data)
    assert refused > 0.5 * COUNT


@pytest.mark.filterwarnings("ignore::stark.StarkWarning")
def test_resuming_damaged_folders(tmp_path: Path) -> None:
    """A damaged folder is refused, or resumed to the end."""
    rng = np.random.default_rng(SEED)
    quiet = {"replay": False, "picture": False, "check": False}
    scenes.run(write_scene(tmp_path), out=tmp_path / "good", until=0.1, **quiet)
    files = [p.relative_to(tmp_path / "good") for p in sorted((tmp_path / "good").rglob("*")) if p.is_file()]
    refused = 0
    for _ in range(COUNT // 3):
        shutil.rmtree(tmp_path / "bad", ignore_errors=True)
        shutil.copytree(tmp_path / "good", tmp_path / "bad")
        name = files[int(rng.integers(len(files)))]
        data = (tmp_path / "good" / name).read_bytes()
        if name.name == "manifest.json":
            data = json.dumps(strange_json(json.loads(data), rng)).encode()
        (tmp_path / "bad" / name).write_bytes(damaged(data, rng) if rng.random() < 0.8 else data)
        try:
            result = scenes.resume(tmp_path / "bad", until=0.12, **quiet)
        except stark.InvalidArgument:
            refused += 1
        else:
            assert result.status == "complete"
            open_all(tmp_path / "bad")
    assert refused > 5


def test_runs_of_checkpoints_that_say_strange_things(tmp_path: Path) -> None:
    """What 'stark run' keeps in a checkpoint: refused, or gone on with."""
    rng = np.random.default_rng(SEED)
    quiet = {"replay": False, "picture": False, "check": False}
    scenes.run(write_scene(tmp_path), out=tmp_path / "run", until=0.05, **quiet)
    path = tmp_path / "run/checkpoint.stark"
    header, arrays = arrays_of(path)
    for k in range(COUNT // 3):
        rewrite(path, {**header, "run": strange_json(header["run"], rng)}, arrays)
        try:
            result = scenes.resume(tmp_path / "run", until=0.07, **quiet)
        except stark.InvalidArgument:
            continue
        assert result.status == "complete", f"seed {SEED}, mutation {k}"
