"""The page of a simulation: the commands that it gives, and that the simulation does not notice it."""

from __future__ import annotations

import contextlib
import socket
import threading
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _views import falling, free_port

import stark
from stark.array_file import WriteError
from stark.recording import Recorder, Recording
from stark.render.fields import FIELDS

pytest.importorskip("viser", reason="needs the extra 'view'")


@pytest.fixture
def sim() -> Any:
    scene = falling()
    stark.view.add_pulls(scene)
    return stark.Simulation(scene, time_step=0.01)


@pytest.fixture
def view(sim: Any, tmp_path: Path) -> Any:
    with sim.view(port=free_port(), paused=True, record_to=tmp_path / "run") as view:
        view._set_pace(False)
        yield view


def during(view: Any, *steps: Any) -> None:
    """Runs the view, and meanwhile does what a page would, each once what was asked before is done."""
    done: list[BaseException] = []

    def act() -> None:
        try:
            for step in steps:
                step()
                passed = threading.Event()
                view._later(passed.set)
                assert passed.wait(20.0)
        except BaseException as error:
            done.append(error)
        finally:
            view._later(view.close)

    thread = threading.Thread(target=act)
    thread.start()
    view.run()
    thread.join()
    if done:
        raise done[0]


def test_the_states_are_the_same_with_and_without_a_page(sim: Any) -> None:
    alone = stark.Simulation(falling(), time_step=0.01)
    alone.run_until(0.08)
    with sim.view(port=free_port(), field="stress", contacts=True) as view:
        view._set_pace(False)
        for report in sim.run(until=0.04):
            view.update(report)
            view.draw()
        view.run(0.08, stay=False)
    assert sim.state.hash == alone.state.hash


def test_pause_step_and_reset(view: Any, sim: Any) -> None:
    start = sim.state.hash
    actions, times = view._actions(), []
    note = lambda: times.append(sim.time)  # noqa: E731
    during(
        view,
        lambda: view._later(note),
        actions.step,
        lambda: view._later(lambda: None),
        lambda: view._later(note),
        actions.pause,
        lambda: threading.Event().wait(0.3),
        actions.pause,
        lambda: view._later(note),
        actions.reset,
        lambda: view._later(note),
    )
    assert times[0] == 0.0 and times[1] == 0.01 and times[2] > 0.02 and times[3] == 0.0
    assert sim.state.hash == start and not view.is_open


def test_dragging_pulls_and_letting_go_ends_it(view: Any, sim: Any) -> None:
    pulls = view._pulls
    view._dragged("ball", "start", (0.0, 0.0, 0.256), (0.0, 0.0, 0.256))
    view._dragged("ball", "update", (0.0, 0.0, 0.256), (0.0, 0.0, 0.5))
    view._take_commands()
    assert pulls.held.body == "ball"
    np.testing.assert_allclose(pulls.target, (0.0, 0.0, 0.5))
    view.paused = False
    view.run(0.3, stay=False)
    assert sim["ball"].position[2] > 0.3
    view._dragged("ball", "end", (0.0, 0.0, 0.4), (0.0, 0.0, 0.5))
    view._take_commands()
    assert pulls.held is None


def test_every_field_has_colours_and_a_scale(view: Any, sim: Any) -> None:
    for field in FIELDS:
        view._show_field(field)
        assert view._panel._bar.visible
        image = view._panel._bar.image
        assert image.dtype == np.uint8 and (image < 100).any()
    view._show_field(None)
    assert not view._panel._bar.visible


def test_colours_are_those_of_the_house(view: Any) -> None:
    from stark.palette import body_colors

    for body, color in zip(view._stage._bodies, body_colors(view._stage._bodies), strict=True):
        assert view._stage._nodes[body.name].color == tuple(round(255 * c) for c in color)


def test_rigid_bodies_move_by_their_pose_and_solids_by_their_vertices(view: Any, sim: Any) -> None:
    view.paused = False
    view.run(0.1, stay=False)
    nodes = view._stage._nodes
    np.testing.assert_allclose(nodes["ball"].position, sim["ball"].position, atol=1e-12)
    np.testing.assert_allclose(nodes["jelly"].vertices, sim["jelly"].surface_positions, atol=1e-6)
    position, rotation = sim["ball"].pose
    placed = nodes["ball"].vertices @ rotation.T + position
    np.testing.assert_allclose(placed, sim["ball"].positions, atol=1e-6)


def test_a_recording_is_a_run_folder_and_names_are_not_taken_twice(view: Any, tmp_path: Path) -> None:
    view.paused = False
    for end in (0.03, 0.06):
        view._toggle_recording()
        view.run(end, stay=False)
        view._toggle_recording()
    for folder, count in (("run", 4), ("run-2", 4)):
        recording = stark.recording.Recording(tmp_path / folder)
        assert len(recording) == count and recording.status == "complete"
    view._picture()
    assert (tmp_path / "jelly.png").stat().st_size > 1000


def test_a_program_that_rewinds_ends_the_recording_of_the_page(view: Any, tmp_path: Path) -> None:
    view.paused = False
    view._toggle_recording()
    view.run(0.03, stay=False)
    view._sim.reset()
    view.update(view._sim.step())
    recording = stark.recording.Recording(tmp_path / "run")
    assert len(recording) == 4 and recording.status == "complete"
    assert "went back in time" in view._message


def test_the_page_is_served_to_this_machine_only(view: Any) -> None:
    assert view.url.startswith("http://127.0.0.1:")
    with urllib.request.urlopen(view.url, timeout=10.0) as answer:
        assert b"<html" in answer.read().lower()


def test_a_failed_step_pauses_and_says_why(view: Any, sim: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    class Failed:
        failed, message, step, newton_iterations, contact_count, time = True, "no way", 1, 3, 0, 0.0
        energy = dict.fromkeys(("kinetic", "elastic", "gravity", "contact"), 0.0)

    view.paused = False
    monkeypatch.setattr(sim, "step", lambda **_: Failed())
    view._step(None)
    view.draw()
    assert view.paused and "no way" in view._panel._status.content


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_page_stands_upright(axis: int) -> None:
    """The camera looks from above, and the grid lies below, whatever axis is up."""
    up = np.eye(3)[axis]
    scene = stark.Scene()
    scene.add_sphere(0.05, name="ball", mass=0.6, position=0.3 * up)
    sim = stark.Simulation(scene, time_step=0.01, gravity=-9.81 * up)
    with sim.view(port=free_port()) as view:
        start, stage = view._server.initial_camera, view._stage
        assert (np.array(start.position) - start.look_at) @ up > 0.05
        grid = view._server.scene._handle_from_node_name["/ground"]
        assert np.array(grid.position) @ up == pytest.approx(0.25, abs=0.01)
        assert "xyz"[axis] not in grid.plane and stage._bounds.up == tuple(up)


def test_threads_end_with_the_page(sim: Any) -> None:
    before = set(threading.enumerate())
    sim.view(port=free_port()).close()
    for thread in set(threading.enumerate()) - before:
        thread.join(5.0)
        assert not thread.is_alive(), thread


def test_bad_arguments_and_closed_pages_are_refused(sim: Any) -> None:
    for bad, told in (
        ({"port": 0}, r"port = 0: must be a whole number from 1 to 65535"),
        ({"host": ""}, r"host = ''"),
        ({"field": "charm"}, r"field = 'charm': must be one of stress"),
        ({"drive": 3}, r"drive = 3: must be a function"),
    ):
        with pytest.raises(stark.InvalidArgument, match=told):
            sim.view(**bad)
    view = sim.view(port=free_port())
    view.close()
    with pytest.raises(stark.InvalidArgument, match=r"run\(\) after close\(\)"):
        view.run()
    with pytest.raises(stark.InvalidArgument, match=r"url after close\(\)"):
        print(view.url)
    with sim.view(port=free_port()) as view, pytest.raises(stark.InvalidArgument, match=r"until = -1"):
        view.run(-1)
    with sim.view(port=free_port()) as view:
        with pytest.raises(stark.InvalidArgument, match=r"report = 0\.01: must be the stark\.StepReport"):
            view.update(0.01)
        with pytest.raises(stark.InvalidArgument, match=r"stay = None: must be True or False"):
            view.run(until=0.01, stay=None)


def test_hosts_and_ports_that_no_server_can_have_are_refused_at_once(sim: Any) -> None:
    """The server itself waits for them without end."""
    for host in ("no-such-host.invalid", "192.0.2.1", "a" * 70 + ".org"):
        with pytest.raises(
            stark.InvalidArgument, match=rf"host = '{host}': must be .* of this machine.*; take"
        ):
            sim.view(host=host, port=free_port())
    with socket.socket() as taken:
        try:
            taken.bind(("127.0.0.1", 65535))
        except OSError:
            pytest.skip("port 65535 is in use")
        taken.listen()
        with pytest.raises(stark.Error, match=r"no port from 65535 to 65535 is free at 127\.0\.0\.1"):
            sim.view(port=65535)


def test_a_host_with_an_address_that_this_machine_lacks_is_served_at_another(
    sim: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The server waited for the first one without end."""
    found = [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (ip, 0)) for ip in ("192.0.2.1", "127.0.0.1")]
    resolve = socket.getaddrinfo
    monkeypatch.setattr(
        socket,
        "getaddrinfo",
        lambda host, *given, **more: found if host == "some-host" else resolve(host, *given, **more),
    )
    with sim.view(host="some-host", port=free_port()) as view:
        assert view.url.startswith("http://127.0.0.1:")


def test_a_taken_port_leads_to_the_next_one_and_addresses_can_be_opened(sim: Any) -> None:
    hosts = ["127.0.0.1", "localhost", "0.0.0.0"]
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET6) as probe:
        probe.bind(("::1", 0))
        hosts += ["::1", "::"]
    for host in hosts:
        with sim.view(host=host, port=free_port()) as first:
            port = int(first.url.rpartition(":")[2])
            with sim.view(host=host, port=port) as second:
                assert int(second.url.rpartition(":")[2]) > port
                urllib.request.urlopen(second.url, timeout=10.0).close()


def test_the_page_says_where_a_reset_left_the_recording_and_why_a_picture_failed(
    sim: Any, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    with sim.view(port=free_port(), record_to=tmp_path / "run") as view:
        view._actions().record()
        view._actions().reset()
        view.update()
        assert view._message == f"recorded in {tmp_path / 'run'}"
    with sim.view(port=free_port(), record_to=tmp_path / "file" / "run") as view:
        view._actions().picture()
        view.update()
        assert view._message == f"'{tmp_path / 'file'}' cannot be written: File exists; choose another place"


def test_views_and_pulls_say_what_was_misspelt_and_names_of_bodies_may_be_alike(sim: Any) -> None:
    scene = stark.Scene("two")
    for k, name in enumerate(("a", "a in colours", "colours/a")):
        scene.add_cloth(stark.mesh.grid(0.1, 0.1, 2), name=name, position=(0, 0, 0.1 * k))
    pulls = stark.view.add_pulls(scene)
    simulation = stark.Simulation(scene, time_step=0.01)
    with simulation.view(port=free_port(), field="stress") as view:
        view.run(0.02, stay=False)
        view.draw()
        assert repr(view) == f"<stark.view.View of 'two', at {view.url}>"
        with pytest.raises(AttributeError, match=r"no attribute 'paussed'; did you mean 'paused'\?"):
            view.paussed = True
        with pytest.raises(AttributeError, match=r"no attribute 'let_gow'; did you mean 'let_go'\?"):
            pulls.let_gow()
    assert repr(view) == "<stark.view.View of 'two', closed>"


def test_a_refused_value_is_no_longer_told_once_another_one_is_taken() -> None:
    scene = stark.Scene()
    wheel = scene.add_box(0.1, name="wheel", mass=1.0)
    hinge = scene.add_hinge(None, wheel, anchor=(0, 0, 0), axis="z", name="axle")
    hinge.add_motor(1.0, cap=2.0, delta=0.1, name="motor")
    with stark.Simulation(scene, time_step=0.01).view(port=free_port()) as view:
        fields = view._server.gui._gui_input_handle_from_uuid.values()
        cap = next(field for field in fields if str(field.label).startswith("cap"))
        for value, told in ((-1.0, "cap = -1 N m: must be >= 0"), (3.0, "")):
            cap._impl.value = value
            for call in cap._impl.update_cb:
                call(None)
            view.update()
            assert (told in view._message) if told else view._message == ""


def test_a_full_disk_ends_the_recording_and_not_the_simulation(
    sim: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: Any) -> None:
        raise WriteError("'frames' cannot be written: No space left on device")

    with sim.view(port=free_port(), record_to=tmp_path / "run") as view:
        view._set_pace(False)
        view._actions().record()
        view.run(0.02, stay=False)
        monkeypatch.setattr(Recorder, "record", full)
        view.run(0.05, stay=False)
        assert sim.time == pytest.approx(0.05)
        assert view._message.startswith("the recording has ended: 'frames' cannot be written: No space")
    with sim.view(port=free_port(), record_to=tmp_path / "other") as view:
        monkeypatch.undo()
        view._do(view._toggle_recording)
        monkeypatch.setattr(Recorder, "close", full)
        view._do(view._reset)
        assert sim.time == 0.0 and view._message.startswith("the recording has ended: 'frames' cannot be")
    recording = Recording(tmp_path / "run")
    assert recording.status == "failed" and "No space" in recording.manifest["message"]
    assert len(recording.telemetry) == 3
