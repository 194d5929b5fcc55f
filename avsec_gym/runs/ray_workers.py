"""Workers that are actors of a Ray cluster (extra ``distributed``).

Every machine needs this package, the experiments' own, and the data at the same paths.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.experiment import Cell, Configuration
from avsec_gym.runs.desk import Desk, Done, Failed, Unready
from avsec_gym.runs.schedule import Died
from avsec_gym.worker_processes import THREAD_VARIABLES


class RayWorkers:
    """Actors, each with its desk.

    Joins the cluster that ``RAY_ADDRESS`` names, or starts one on this machine.

    Args:
        configuration: Of the run.
        count: Actors.
        threads: Cores that each takes.

    Raises:
        ConfigurationError: Ray is not installed.
    """

    def __init__(self, configuration: Configuration, count: int, threads: int) -> None:
        try:
            ray: Any = import_module("ray")
        except ImportError as error:
            raise ConfigurationError(
                "--backend ray needs the extra `distributed`: pip install 'avsec-gym[distributed]'"
            ) from error
        self._ray = ray
        self._arguments = (configuration, threads)
        self._begun_here = not ray.is_initialized()
        if self._begun_here:
            ray.init(log_to_driver=False, include_dashboard=False, configure_logging=False)
        variables = dict.fromkeys(THREAD_VARIABLES, str(threads))
        self._actor = ray.remote(num_cpus=threads, max_restarts=0)(Desk).options(
            runtime_env={"env_vars": variables}
        )
        self._actors = [self._actor.remote(*self._arguments) for _ in range(count)]
        self._in_hand: dict[int, tuple[Any, Any]] = {}

    def __len__(self) -> int:
        return len(self._actors)

    def give(self, number: int, cell: Cell) -> None:
        """Let an actor do a cell; it does one call after the other."""
        actor = self._actors[number]
        self._in_hand[number] = (actor.prepare.remote(cell), actor.do.remote(cell))

    def wait(self) -> list[tuple[int, Done | Failed | Unready | Died]]:
        """What came of cells in hand, or of those who had them."""
        numbers = {done: number for number, (_, done) in self._in_hand.items()}
        ready, _ = self._ray.wait(list(numbers), num_returns=1)
        return [(numbers[done], self._heard(numbers[done])) for done in ready]

    def replace(self, number: int) -> None:
        """A new actor for one that died."""
        self._actors[number] = self._actor.remote(*self._arguments)

    def close(self) -> None:
        """End all of them, and Ray if it was begun here."""
        for actor in self._actors:
            self._ray.kill(actor)
        if self._begun_here:
            self._ray.shutdown()

    def _heard(self, number: int) -> Done | Failed | Unready | Died:
        prepared, done = self._in_hand.pop(number)
        try:
            unready: Unready | None = self._ray.get(prepared)
        except self._ray.exceptions.RayActorError as error:
            return Died(_how_it_ended(error), at_work=False)
        if unready is not None:
            return unready
        try:
            outcome: Done | Failed = self._ray.get(done)
        except self._ray.exceptions.RayActorError as error:
            return Died(_how_it_ended(error), at_work=True)
        except self._ray.exceptions.RayTaskError as error:
            return Failed(f"Its result cannot be sent: {error}")
        return outcome


def _how_it_ended(error: Exception) -> str:
    return f"left ({str(error).splitlines()[0]})"
