"""Studies on a Ray cluster of two nodes."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from _studies import grid, write_study

import stark
from stark.study import Study, StudyError
from stark.study.table import COST

ray = pytest.importorskip("ray")
pytestmark = pytest.mark.slow

#: Each run takes a quarter of a second, and says which process makes it.
SAMPLING = grid(height=[1.0 + 0.125 * k for k in range(40)], wait=[0.05], pids=["@"])


def table(study: Study) -> list[dict[str, Any]]:
    return [{name: value for name, value in row.items() if name not in COST} for row in study.rows()]


@pytest.fixture
def cluster() -> Iterator[Any]:
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 2, "include_dashboard": False})
    made.add_node(num_cpus=2)
    made.wait_for_nodes()
    yield made
    ray.shutdown()
    made.shutdown()


def _plan(folder: Path) -> Path:
    pids = folder / "pids"
    pids.mkdir()
    plan = write_study(folder, SAMPLING.replace("@", str(pids)))
    scene = folder / "fall.py"
    text = scene.read_text().replace('"steps": 1,', '"steps": 1, "pids": "",')
    scene.write_text(
        text.replace(
            "def drive(sim):", 'def drive(sim):\n    open(options["pids"] + f"/{os.getpid()}", "w").close()'
        )
    )
    return plan


def test_forty_runs_survive_two_workers_and_a_node(tmp_path: Path, cluster: Any) -> None:
    plan, killed = _plan(tmp_path), []

    def spoil() -> None:
        """Two workers of the head are killed, then the other node is lost."""
        results = tmp_path / "out/results"
        while len(list(results.glob("*.json"))) < 6:
            time.sleep(0.02)
        for path in list((tmp_path / "pids").iterdir())[:2]:
            os.kill(int(path.name), signal.SIGKILL)
            killed.append(path.name)
        while len(list(results.glob("*.json"))) < 14:
            time.sleep(0.02)
        (other,) = [node for node in cluster.list_all_nodes() if node != cluster.head_node]
        cluster.remove_node(other, allow_graceful=False)
        killed.append("node")

    spoiler = threading.Thread(target=spoil)
    spoiler.start()
    study = stark.study.run(plan, tmp_path / "out", ray=cluster.address)
    spoiler.join()
    rows = study.rows()
    assert len(killed) == 3 and study.counts() == {"complete": 40}
    assert len({row["key"] for row in rows}) == 40
    assert len(list((tmp_path / "out/results").glob("*.json"))) == 40  # what was killed may leave a part
    # At most two runs were killed and two on the node; workers are idle next to never.
    begun = [row["cost.attempts"] for row in rows]
    assert 40 < sum(begun) <= 44 and max(begun) <= 4
    local = stark.study.run(plan, tmp_path / "local", processes=4)
    assert table(local) == table(study)
    assert stark.study.resume(tmp_path / "out", ray=cluster.address).rows() == rows


def test_addresses_where_nobody_listens_are_refused_at_once(tmp_path: Path) -> None:
    """Ray itself tries for minutes."""
    plan = write_study(tmp_path, grid(height="[1.0]"))
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        for address in (
            f"127.0.0.1:{unused.getsockname()[1]}",
            "no-such-host.invalid:6379",
            "127.0.0.1:70000",
        ):
            with pytest.raises(StudyError, match=f"ray = '{address}': no Ray cluster can be reached there"):
                stark.study.run(plan, tmp_path / "out", ray=address)


def test_addresses_without_a_cluster(tmp_path: Path) -> None:
    plan = write_study(tmp_path, grid(height="[1.0]"))
    with pytest.raises(StudyError, match="no Ray cluster can be reached there"):
        stark.study.run(plan, tmp_path / "out", ray="auto")
