"""Fields and contacts in the page: decoded to what was recorded, within a step."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation, record

from stark.recording import Recorder, Recording
from stark.replay import encode
from stark.replay.encode import _inflate
from stark.replay.encode_fields import LEVELS, MOST_CONTACTS, decode_field

STEPS = 6


def ripples(sim: Any) -> dict[str, np.ndarray]:
    """Values of both signs."""
    x = sim.bodies[0].positions[:, 0]
    return {"cloth": 3.0 * np.sin(20.0 * x + 5.0 * sim.time) - 1.0}


class Touching(FakeSimulation):
    """With contacts of the box, each with the first vertex of the cloth, of growing force."""

    count = 400

    @property
    def contacts(self) -> Any:
        points = np.linspace((0, 0, 0), (0.1, 0.0, 0.0), self.count)
        forces = np.outer(np.arange(self.count), (0.0, 0.0, 0.01 * (1.0 + self.time)))
        pairs = np.tile([1, 0], (self.count, 1))
        return SimpleNamespace(points_a=points, points_b=points, forces=forces, bodies=pairs)


def recorded(folder: Path, **options: Any) -> Recording:
    sim = Touching()
    with Recorder(folder, sim, arrays={"ripples [m]": ripples}, **options) as recorder:
        recorder.record(sim)
        for _ in range(STEPS):
            recorder.report(sim.step())
            recorder.record(sim)
    return Recording(folder)


@pytest.mark.parametrize("stride", [1, 4])
def test_a_page_has_the_recorded_values(tmp_path: Path, stride: int) -> None:
    run = recorded(tmp_path / "run")
    page = encode(run, stride=stride)
    (field,) = page.header["fields"]
    assert (field["label"], field["unit"], list(field["blocks"])) == ("ripples", "m", ["0"])
    got = decode_field(
        _inflate(page.blocks[field["blocks"]["0"]]), field["low"], field["step"], run.bodies[0].vertex_count
    )
    kept = [*range(0, STEPS + 1, stride), *([STEPS] if STEPS % stride else [])]
    expected = np.stack([run.field("ripples [m]", k)["cloth"] for k in kept])
    assert field["low"] == pytest.approx(expected.min()) and field["low"] < -3.5
    assert field["step"] == pytest.approx((expected.max() - expected.min()) / LEVELS)
    np.testing.assert_allclose(got, expected, atol=0.5001 * field["step"], rtol=0)
    assert field["limits"] == pytest.approx([expected.min(), expected.max()])


def test_colours_do_not_end_at_a_spike(tmp_path: Path) -> None:
    sim = FakeSimulation()

    def pressed(s: Any) -> dict[str, np.ndarray]:
        values = np.linspace(0.0, 1.0, len(s.bodies[0].positions))
        values[-1] = 500.0
        return {"cloth": values}

    with Recorder(tmp_path / "run", sim, arrays={"p [Pa]": pressed}) as recorder:
        recorder.record(sim)
    (field,) = encode(Recording(tmp_path / "run")).header["fields"]
    assert field["limits"][0] == 0.0 and 0.9 < field["limits"][1] < 11.0
    assert field["low"] + LEVELS * field["step"] == pytest.approx(500.0)


def test_a_page_has_the_largest_contacts(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", contacts=True)
    page = encode(run)
    contacts = page.header["contacts"]
    assert contacts["counts"] == [MOST_CONTACTS] * (STEPS + 1)
    forces = np.frombuffer(_inflate(page.blocks[contacts["forces"]]), dtype="<f4").reshape(-1, 3)
    last = np.sort(forces[-MOST_CONTACTS:, 2])
    full = 0.01 * (1.0 + STEPS / 30.0) * np.arange(Touching.count)
    np.testing.assert_allclose(last, full[-MOST_CONTACTS:], rtol=1e-6)
    pairs = np.frombuffer(_inflate(page.blocks[contacts["pairs"]]), dtype="<u2").reshape(-1, 2)
    assert (pairs == [1, 0]).all()
    sums = np.frombuffer(_inflate(page.blocks[contacts["sums"]]), dtype="<f4").reshape(STEPS + 1, -1, 3)
    np.testing.assert_allclose(sums[-1, :, 2], [-full.sum(), full.sum(), 0.0], rtol=1e-6)
    assert contacts["largest"] == pytest.approx(full[-1], rel=1e-6)


def test_pages_of_recordings_without_offer_none(tmp_path: Path) -> None:
    page = encode(record(tmp_path / "run", 3))
    assert page.header["fields"] == [] and page.header["contacts"] is None
