"""Runs experiments: what is done is kept, what is missing is done, what fails is noted."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from avsec_gym.argument_checks import thread_number
from avsec_gym.command_line import command_line
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.progress import Progress, no_progress
from avsec_gym.runs.cell_worker import Failed
from avsec_gym.runs.experiment import Cell, Configuration, Experiment, with_defaults
from avsec_gym.runs.fingerprints import environment
from avsec_gym.runs.local_workers import LocalWorkers
from avsec_gym.runs.manifest import (
    Manifest,
    begin_sitting,
    check_same_question,
    continued,
    new_manifest,
    now,
    read_manifest,
    write_manifest,
)
from avsec_gym.runs.ray_cluster import RayCluster, ray_cluster
from avsec_gym.runs.run_log import JOURNAL, log_into
from avsec_gym.runs.schedule import Workers, finished_cells
from avsec_gym.runs.shares import room, usual_threads, usual_workers
from avsec_gym.runs.store import ResultStore, has_results
from avsec_gym.runs.this_process import ThisProcess
from avsec_gym.storage.folders import make_folder

RESULTS, LOG, FIGURES = "results.sqlite", "run.log", "figures"
"""Names in a run's folder."""

_LOG = logging.getLogger(__name__)


class Backend(StrEnum):
    """Where cells are done."""

    LOCAL = "local"
    """Work by processes of this machine."""
    RAY = "ray"
    """Work by a Ray cluster."""


@dataclass(frozen=True)
class RunSummary:
    """What was done."""

    root: Path
    cells: int
    """The cells that the experiments asked for need."""
    kept: int
    """How many of those an earlier sitting had done."""
    done: int
    """How many were done now."""
    failures: tuple[tuple[Cell, str], ...]
    """Cells that failed now, and why."""
    failed_before: int
    """Cells that an earlier sitting failed at, and that were not tried again."""


def run_experiments(
    experiments: Sequence[Experiment],
    configuration: Configuration,
    root: str | Path,
    *,
    workers: int | None = None,
    threads: int | None = None,
    backend: Backend = Backend.LOCAL,
    retry: bool = False,
    on_progress: Progress = no_progress,
    besides: Collection[str] = (),
) -> RunSummary:
    """Do the cells that the experiments need, in a folder that holds the run.

    May be killed at any time and called again: finished cells are kept. Rows depend on the
    experiments, the configuration and `threads` only (and on the machine, as its arithmetic does),
    neither on `workers` nor on interruptions. Experiments may join a run later.

    Args:
        experiments: Cells that several of them need are done once.
        configuration: Options that are not given get the experiments' defaults.
        root: Folder of the run: new, empty, or with a run of the same configuration.
        workers: The number of processes; if None, as many as have cores for their threads, up to
            four on each machine; 0: this very process. A cluster takes no more than it has cores
            for.
        threads: The threads of each process; if None, those that the run began with, or the cores
            divided by the processes. A network's last digits depend on it.
        backend: The place of the processes; their cores count, not those of the machine that asks.
        retry: Whether failed cells are done again.
        on_progress: Function that gets the number of finished cells and that of all.
        besides: Names of files that may be in a new folder, since the caller has put them there.

    Raises:
        ConfigurationError: Arguments do not fit together, a work cannot be made, or the cluster
            cannot be joined, has no room or starts no worker.
        DataError: The folder holds another run or something else, is being written by another
            process, or cannot be written; or an input is missing.
    """
    # Brings half of the package with it, which a worker process has no use for.
    from avsec_gym.storage.folder_lock import locked_folder

    _check_arguments(experiments, workers, threads, backend)
    configuration = with_defaults(configuration, experiments)
    with locked_folder(root) as root, ExitStack() as stack:
        _check_empty_or_run(root, besides)
        # Where the processes are, and the run's manifest: begun here, or that of the folder.
        cluster = (
            stack.enter_context(ray_cluster(usable_cores())) if backend == Backend.RAY else None
        )
        cores = cluster.cores() if cluster else (usable_cores(),)
        manifest = _manifest(root, experiments, configuration, cores, workers, threads)
        workers = _workers(cores, workers, manifest["threads"], cluster)
        configuration = Configuration(**manifest["configuration"])
        # The cells that the experiments need, those of several once.
        needs = {each.name: _distinct(each, configuration) for each in experiments}
        cells = list({cell: cell for own in needs.values() for cell in own})
        if not manifest["sittings"]:  # Before the results, so that they belong to something.
            write_manifest(root, manifest)
        with closing(ResultStore(root / RESULTS)) as store, log_into(root / LOG):
            # Which of them the results lack.
            store.plan(needs, manifest["experiments"])
            if retry:
                store.forget_failures(cells)
            make_folder(root / FIGURES)
            write_manifest(root, manifest)
            statuses = store.statuses()
            missing = [cell for cell in cells if cell.id not in statuses]
            there = [statuses[cell.id] for cell in cells if cell.id in statuses]
            failures: list[tuple[Cell, str]] = []
            if missing:
                # A sitting: begun in the manifest, its cells done and stored one by one, closed.
                sitting = begin_sitting(manifest, environment())
                sitting |= {"command": command_line(), "workers": workers, "backend": backend}
                write_manifest(root, manifest)
                JOURNAL.info("%s: %d of %d cells", ", ".join(needs), len(missing), len(cells))
                count = min(workers, len(missing))
                team = _team(cluster, configuration, count, manifest["threads"], root / LOG)
                failures = _failures(
                    missing, team, store, lambda done: on_progress(len(there) + done, len(cells))
                )
                sitting |= {"ended": now(), "done": len(missing) - len(failures)}
                sitting["failed"] = len(failures)
                write_manifest(root, manifest)
                JOURNAL.info("%d cells done, %d failed", sitting["done"], len(failures))
    return RunSummary(
        root=root,
        cells=len(cells),
        kept=there.count("done"),
        done=len(missing) - len(failures),
        failures=tuple(failures),
        failed_before=there.count("failed"),
    )


def _manifest(
    root: Path,
    experiments: Sequence[Experiment],
    configuration: Configuration,
    cores: Sequence[int],
    workers: int | None,
    threads: int | None,
) -> Manifest:
    """Of the run that begins or goes on, not written yet; all options have values."""
    there = read_manifest(root)
    if there is not None and not has_results(root / RESULTS, begun=bool(there["sittings"])):
        there = None  # Nothing is lost if it begins anew, with another configuration.
    if threads is None:
        threads = usual_threads(cores, workers) if there is None else int(there["threads"])
    if there is not None:  # Before the inputs, which may take minutes to be made.
        check_same_question(root, there, configuration, threads)
    asked = new_manifest(experiments, configuration, threads)
    return asked if there is None else continued(root, there, asked)


def _failures(
    cells: Sequence[Cell], team: Workers, store: ResultStore, on_finished: Callable[[int], None]
) -> list[tuple[Cell, str]]:
    """Have cells done and store their results; those that failed, and why.

    Args:
        cells: The cells.
        team: The workers, who are sent home at the end.
        store: The store of the results.
        on_finished: Function that is called after each cell with the number of finished ones.
    """
    failures = []
    with closing(team), closing(finished_cells(cells, team)) as outcomes:
        for finished, (cell, outcome) in enumerate(outcomes, start=1):
            stored = store.add(cell, outcome)
            if isinstance(stored, Failed):
                trace = f"\n{stored.trace}" if stored.trace else ""
                JOURNAL.error("failed: %s %s: %s%s", cell.work, cell.key, stored.error, trace)
                failures.append((cell, stored.error))
            on_finished(finished)
    return failures


def _workers(
    cores: Sequence[int], asked: int | None, threads: int, cluster: RayCluster | None
) -> int:
    """How many there will be: on a cluster, actors without a core would never start."""
    workers = usual_workers(cores, threads) if asked is None else asked
    if cluster is None:
        return workers
    if not room(cores, threads):
        raise ConfigurationError(
            f"a worker takes {threads} cores (--threads), and no machine of the Ray cluster has so"
            f" many; they have {', '.join(map(str, cores)) or 'none'}"
        )
    if workers > room(cores, threads):
        _LOG.warning("the Ray cluster has room for %d workers only", room(cores, threads))
    return min(workers, room(cores, threads))


def _team(
    cluster: RayCluster | None, configuration: Configuration, count: int, threads: int, log: Path
) -> Workers:
    if cluster is not None:
        from avsec_gym.runs.ray_workers import RayWorkers

        return RayWorkers(cluster, configuration, count, threads)
    if count == 0:
        return ThisProcess(configuration, threads)
    return LocalWorkers(configuration, count, threads, log)


def _distinct(experiment: Experiment, configuration: Configuration) -> list[Cell]:
    """An experiment's cells, each once."""
    cells = list(dict.fromkeys(experiment.cells(configuration)))
    if not cells:
        raise ConfigurationError(f"the experiment {experiment.name} has nothing to do here")
    return cells


def _check_arguments(
    experiments: Sequence[Experiment], workers: int | None, threads: int | None, backend: Backend
) -> None:
    names = [each.name for each in experiments]
    if not names or len(set(names)) < len(names):
        raise ConfigurationError(f"a run has experiments of different names, got {names}")
    least = 1 if backend == Backend.RAY else 0
    if workers is not None and workers < least:
        raise ConfigurationError(f"--workers is {least} or more, got {workers}")
    if threads is not None:
        thread_number("--threads", threads)


def usable_cores() -> int:
    """The number of cores that this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _check_empty_or_run(root: Path, besides: Collection[str]) -> None:
    names = (path.name for path in root.iterdir() if not path.name.startswith("."))
    there = sorted(set(names) - set(besides))
    if there and read_manifest(root) is None:
        raise DataError(
            f"The folder holds {there[0]} and no manifest of a run.",
            path=root,
            remedy="Name a new or empty folder with --out; nothing is overwritten.",
        )
