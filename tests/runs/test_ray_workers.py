"""The same rows by actors of Ray, whatever becomes of them; skipped where Ray is not installed.

Every cluster here listens to this machine only, has no dashboard and reports to no service.
"""

from __future__ import annotations

import importlib.util
import os
import random
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.ray_cluster import ray_cluster
from avsec_gym.runs.ray_workers import RayWorkers
from avsec_gym.runs.run import Backend, run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.schedule import finished_cells

SMALL = Configuration(limit=3)
HAS_RAY = importlib.util.find_spec("ray") is not None
KILLS = 20
AT_MOST = 600
"""Seconds that a test may take: what hangs fails."""
Rows = Callable[[Path], dict[str, list[tuple[Any, ...]]]]

with_ray = [
    pytest.mark.slow,
    pytest.mark.skipif(not HAS_RAY, reason="the extra `distributed` (ray) is not installed"),
    pytest.mark.filterwarnings("default"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


def marked(test: Callable[..., None]) -> Callable[..., None]:
    for mark in with_ray:
        test = mark(test)
    return test


class Hangs(BaseException):
    """No Exception: Ray catches those, and tries again."""


@contextmanager
def no_longer_than(seconds: int) -> Iterator[None]:
    def fail(number: int, frame: FrameType | None) -> None:
        raise Hangs(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def processes_of(session: str) -> list[str]:
    """Command lines of what still runs of a Ray session."""
    found = []
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            command = (entry / "cmdline").read_bytes() if entry.name.isdigit() else b""
            if session.encode() in command:
                found.append(command.replace(b"\0", b" ").decode(errors="replace"))
    return found


class TinyCluster:
    """Machines of one core each, or as many as are asked for, all of them here."""

    def __init__(self) -> None:
        from ray.cluster_utils import Cluster

        # What dies is found dead in a second, not in half a minute.
        quick = {
            "health_check_initial_delay_ms": 0,
            "health_check_period_ms": 250,
            "health_check_timeout_ms": 2000,
            "health_check_failure_threshold": 4,
        }
        self._arguments = {"node_ip_address": "127.0.0.1", "include_dashboard": False}
        head = {**self._arguments, "num_cpus": 1, "_system_config": quick}
        self._cluster = Cluster(initialize_head=True, head_node_args=head)
        # The head has a reaper, and others leave with it; theirs need the main thread.
        self._cluster._shutdown_at_exit = False
        self.address: str = self._cluster.address
        self.session: str = self._cluster.head_node.get_session_dir_path()

    def add(self, cores: int = 1) -> Any:
        return self._cluster.add_node(**self._arguments, num_cpus=cores)

    def kill(self, machine: Any) -> None:
        self._cluster.remove_node(machine, allow_graceful=False)

    def close(self) -> None:
        import ray

        ray.shutdown()
        self._cluster.shutdown()
        deadline = time.monotonic() + 30.0
        while processes_of(self.session) and time.monotonic() < deadline:
            time.sleep(0.1)
        assert not processes_of(self.session)


@pytest.fixture
def cluster(tiny: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Iterator[TinyCluster]:
    """A machine of one core, which runs join by its address."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), os.pathsep)
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    # As on a Mac: else Ray takes the network's address of this machine for 127.0.0.1.
    monkeypatch.setattr("ray._private.ray_constants.ENABLE_RAY_CLUSTER", False)
    with no_longer_than(AT_MOST):
        made = TinyCluster()
        monkeypatch.setenv("RAY_ADDRESS", made.address)
        # Of several machines at one address, a driver stands on any: it would go with the one that
        # is killed.  Here it stands on the first.
        from ray._private import services

        head = services.get_node_to_connect_for_driver(made.address, "127.0.0.1")
        monkeypatch.setattr(services, "get_node_to_connect_for_driver", lambda *_: head)
        try:
            yield made
        finally:
            made.close()


@pytest.mark.skipif(HAS_RAY, reason="Ray is here")
def test_without_ray_the_extra_is_named(tiny: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"avsec-gym\[distributed\]"):
        run_experiments([tiny.PRECISION], SMALL, tmp_path / "run", backend=Backend.RAY)


@marked
def test_a_cluster_of_its_own_is_begun_and_ended(
    tiny: ModuleType, tmp_path: Path, rows: Rows, monkeypatch: pytest.MonkeyPatch
) -> None:
    import ray

    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), os.pathsep)
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    here, there = tmp_path / "here", tmp_path / "there"
    run_experiments([tiny.PRECISION], SMALL, here, workers=0, threads=1)
    sessions = []

    def look(done: int, total: int) -> None:
        sessions.append(ray._private.worker.global_worker.node.get_session_dir_path())

    with no_longer_than(AT_MOST):
        run_experiments(
            [tiny.PRECISION], SMALL, there, threads=1, backend=Backend.RAY, on_progress=look
        )
    assert rows(there) == rows(here)
    assert not ray.is_initialized()
    assert len(set(sessions)) == 1
    assert not processes_of(sessions[0])


@marked
def test_more_workers_than_cores(
    tiny: ModuleType, tmp_path: Path, rows: Rows, cluster: TinyCluster
) -> None:
    """One core, four workers: the other three would wait for ever, and with them their cells."""
    here, there = tmp_path / "here", tmp_path / "there"
    asked = Configuration(limit=6)
    run_experiments([tiny.PRECISION], asked, here, workers=0, threads=1)
    run_experiments([tiny.PRECISION], asked, there, workers=4, backend=Backend.RAY)
    assert rows(there) == rows(here)
    sitting = RunFolder.open(there).manifest["sittings"][-1]
    assert (sitting["workers"], RunFolder.open(there).manifest["threads"]) == (1, 1)
    with pytest.raises(ConfigurationError, match=r"2 cores .* they have 1"):
        run_experiments([tiny.PRECISION], asked, tmp_path / "wide", threads=2, backend=Backend.RAY)


@marked
def test_actors_that_die_and_works_that_cannot_be_made(
    tiny: ModuleType, diary: Path, tmp_path: Path, cluster: TinyCluster
) -> None:
    experiment = tiny.trouble("fine", "killed", "killed once", "bug", "leave")
    report = run_experiments([experiment], SMALL, tmp_path / "trouble", backend=Backend.RAY)
    errors = {cell.arguments["what"]: error for cell, error in report.failures}
    assert errors.keys() == {"killed", "leave", "bug"}
    assert errors["killed"].endswith("twice.")
    for place, told in (("no_work", "no weights"), ("deadly_work", "before they have begun")):
        with pytest.raises(DataError, match=told):
            run_experiments([tiny.only(place, 4)], SMALL, tmp_path / place, backend=Backend.RAY)


@marked
def test_actors_that_never_start_are_reported(tiny: ModuleType, cluster: TinyCluster) -> None:
    """Another job holds the only core."""
    import ray

    cells = tiny.PRECISION.cells(SMALL)
    with ray_cluster(1) as joined:
        other = ray.remote(num_cpus=1)(dict).remote()
        ray.get(other.__ray_ready__.remote())
        workers = RayWorkers(joined, SMALL, 1, 1, start_timeout=2.0)
        with pytest.raises(ConfigurationError, match="no worker of the Ray cluster has started"):
            list(finished_cells(cells, workers))
        workers.close()  # Else its actor would be the next to start.
        ray.kill(other)
        patient = RayWorkers(joined, SMALL, 1, 1)
        assert len(list(finished_cells(cells, patient))) == len(cells)


@marked
def test_addresses_where_no_cluster_is(
    tiny: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_ADDRESS", "127.0.0.1:1")
    with (
        no_longer_than(AT_MOST),
        pytest.raises(ConfigurationError, match=r"RAY_ADDRESS=127\.0\.0\.1:1 cannot be joined"),
    ):
        run_experiments([tiny.PRECISION], SMALL, tmp_path / "run", backend=Backend.RAY)


class Killer(threading.Thread):
    """Kills the second machine again and again, at random times while cells are done on it.

    When it has done so, cells need not take their time any more.
    """

    def __init__(self, cluster: TinyCluster, diary: Path, kills: int) -> None:
        super().__init__(daemon=True)
        self.cluster, self.diary, self.kills, self.error = cluster, diary, kills, ""
        self.machine = cluster.add(2)

    def run(self) -> None:
        chance = random.Random(22)
        try:
            old: set[str] = set()
            for _ in range(self.kills):
                # Some time after two processes that are new, so one of the new machine at least,
                # began a cell.
                while len(self._processes() - old) < 2:
                    time.sleep(0.02)
                time.sleep(chance.uniform(0.0, 1.0))
                self.cluster.kill(self.machine)
                old = self._processes()
                self.machine = self.cluster.add(2)
            self.diary.with_suffix(".hurry").touch()
        except Exception as error:
            self.error = repr(error)

    def _processes(self) -> set[str]:
        return {line.split()[-1] for line in self.diary.read_text().splitlines()}


@marked
def test_a_machine_that_is_killed_twenty_times(
    tiny: ModuleType, diary: Path, tmp_path: Path, rows: Rows, cluster: TinyCluster
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    cells = 2 * 150
    run_experiments([tiny.PRECISION], Configuration(limit=150), here, workers=0, threads=1)
    diary.write_text("")
    killer = Killer(cluster, diary, KILLS)
    killer.start()
    asked = Configuration(limit=150, options={"pause": 2.0})
    report = run_experiments([tiny.PRECISION], asked, there, threads=1, backend=Backend.RAY)
    assert not killer.error
    assert not killer.is_alive(), "more cells, please: the run was over before the last kill"
    assert not report.failures
    assert rows(there) == rows(here)
    begun = len(diary.read_text().splitlines())
    # A kill ends one cell or two, seldom none.
    assert cells + KILLS // 2 < begun <= cells + 2 * KILLS
