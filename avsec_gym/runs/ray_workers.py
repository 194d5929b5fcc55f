"""Workers that are actors of a Ray cluster (extra ``distributed``).

Every machine needs this package, the experiments' own, and the data at the same paths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.runs.cell_worker import CellWorker, Failed, Unready
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.runs.ray_cluster import RayCluster
from avsec_gym.runs.schedule import Died, News, Ready
from avsec_gym.worker_processes import THREAD_VARIABLES

START_TIMEOUT = 300.0
"""Seconds that actors may take to start while none does anything."""


class RayCellWorker(CellWorker):
    """A worker that knows its machine."""

    def machine(self) -> str:
        """The name (id) of its machine: also the answer that it has started."""
        import ray

        return str(ray.get_runtime_context().get_node_id())


@dataclass
class _RayActor:
    """One worker, from when it was asked for."""

    handle: Any
    answer: Any
    """The machine it lives on, as soon as it has started."""
    machines: frozenset[str]
    """The machines that lived when it was asked for."""
    machine: str = ""
    """Empty until it has answered."""


class RayWorkers:
    """Actors, each with its `CellWorker`, spread over the machines by Ray.

    Args:
        cluster: The cluster where they live.
        configuration: The configuration of the run.
        count: The number of actors; no more than the cluster has room for.
        threads: The cores that each takes.
        start_timeout: The seconds that actors may take to start while none does anything.
    """

    def __init__(
        self,
        cluster: RayCluster,
        configuration: Configuration,
        count: int,
        threads: int,
        start_timeout: float = START_TIMEOUT,
    ) -> None:
        self._cluster, self._ray = cluster, cluster.ray
        self._arguments = (configuration, threads)
        self._start_timeout = start_timeout
        variables = dict.fromkeys(THREAD_VARIABLES, str(threads))
        self._kind = self._ray.remote(num_cpus=threads, max_restarts=0)(RayCellWorker).options(
            runtime_env={"env_vars": variables}
        )
        self._actors = [self._start() for _ in range(count)]
        self._in_hand: dict[int, tuple[Any, Any]] = {}

    def __len__(self) -> int:
        return len(self._actors)

    def give(self, number: int, cell: Cell) -> None:
        """Let an actor do a cell; it does one call after the other."""
        actor = self._actors[number].handle
        self._in_hand[number] = (actor.prepare.remote(cell), actor.do.remote(cell))

    def wait(self) -> list[tuple[int, News]]:
        """News of the workers: whose cell is done, who has started, or what ended them.

        Raises:
            ConfigurationError: No actor does anything, and none has started in time.
        """
        at_work = {done: number for number, (_, done) in self._in_hand.items()}
        starting = {
            actor.answer: number for number, actor in enumerate(self._actors) if not actor.machine
        }
        # Cells may take hours; what only starts may not.
        timeout = None if at_work else self._start_timeout
        heard, _ = self._ray.wait([*at_work, *starting], num_returns=1, timeout=timeout)
        if not heard:
            raise ConfigurationError(
                f"no worker of the Ray cluster has started for {self._start_timeout:g} s. Do other"
                " jobs hold its cores? See `ray status`; the same command goes on with this run."
            )
        return [
            (at_work[each], self._outcome(at_work[each]))
            if each in at_work
            else (starting[each], self._beginning(starting[each]))
            for each in heard
        ]

    def replace(self, number: int) -> None:
        """A new actor for one that died, or that nothing is heard of any more."""
        self._ray.kill(self._actors[number].handle)
        self._actors[number] = self._start()

    def close(self) -> None:
        """End all of them."""
        for actor in self._actors:
            self._ray.kill(actor.handle)

    def _start(self) -> _RayActor:
        machines = self._cluster.living()
        handle = self._kind.remote(*self._arguments)
        return _RayActor(handle, handle.machine.remote(), machines)

    def _beginning(self, number: int) -> Ready | Died:
        actor = self._actors[number]
        try:
            actor.machine = self._ray.get(actor.answer)
        except self._ray.exceptions.RayError as error:
            return self._death(actor, error, at_work=False)
        return Ready()

    def _outcome(self, number: int) -> News:
        actor, (prepared, done) = self._actors[number], self._in_hand.pop(number)
        try:
            unready: Unready | None = self._ray.get(prepared)
        except self._ray.exceptions.RayError as error:
            return self._death(actor, error, at_work=False)
        if unready is not None:
            return unready
        try:
            outcome: News = self._ray.get(done)
        except self._ray.exceptions.RayTaskError as error:
            return Failed(f"Its result cannot be sent: {error}")
        except self._ray.exceptions.RayError as error:
            return self._death(actor, error, at_work=True)
        return outcome

    def _death(self, actor: _RayActor, error: Exception, at_work: bool) -> Died:
        errors = self._ray.exceptions
        # Only these are about the actor's own process; the others are about its machine, about what
        # stood on it, or about the way to it.
        own = (errors.ActorDiedError, errors.OutOfMemoryError, errors.RuntimeEnvSetupError,
               errors.WorkerCrashedError, errors.RayTaskError)  # fmt: skip
        living = self._cluster.living()
        left = actor.machine not in living if actor.machine else bool(actor.machines - living)
        return Died(_how_it_ended(error), at_work, lost=left or not isinstance(error, own))


def _how_it_ended(error: Exception) -> str:
    """Ray's first line states that something died, its last one why."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return f"left ({' '.join(dict.fromkeys([lines[0], lines[-1]]))})" if lines else "left"
