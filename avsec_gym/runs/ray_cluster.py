"""The Ray cluster that a run works on: one that is there, or one begun for it."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from avsec_gym.errors import ConfigurationError

_ADDRESS = "RAY_ADDRESS"
"""Environment variable of Ray's own."""
_SECONDS_TO_ANSWER = 10.0


class RayCluster:
    """A cluster that this process has joined.

    Args:
        ray: The module.
    """

    def __init__(self, ray: Any) -> None:
        self.ray = ray

    def cores(self) -> tuple[int, ...]:
        """The whole cores of each machine that lives."""
        living = (machine for machine in self.ray.nodes() if machine["Alive"])
        return tuple(int(machine["Resources"].get("CPU", 0)) for machine in living)

    def living(self) -> frozenset[str]:
        """Names (ids) of the machines that live; one that comes back has another name."""
        return frozenset(each["NodeID"] for each in self.ray.nodes() if each["Alive"])


@contextmanager
def ray_cluster(cores: int) -> Iterator[RayCluster]:
    """Join the cluster that ``RAY_ADDRESS`` names, or begin one on this machine, for the while.

    One that this process has joined before is used as it is. One begun here listens to this
    machine only and reports to no service.

    Args:
        cores: The cores of a cluster begun here.

    Raises:
        ConfigurationError: Ray is not installed, or no cluster answers at the address.
    """
    try:
        ray: Any = import_module("ray")
    except ImportError as error:
        raise ConfigurationError(
            "--backend ray needs the extra `distributed`: pip install 'avsec-gym[distributed]'"
        ) from error
    if ray.is_initialized():
        yield RayCluster(ray)
        return
    quiet = {"log_to_driver": False, "configure_logging": False}
    try:
        if address := os.environ.get(_ADDRESS):
            _join(ray, address, quiet)
        else:
            os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
            ray.init(
                "local",
                num_cpus=cores,
                include_dashboard=False,
                _node_ip_address="127.0.0.1",
                **quiet,
            )
        yield RayCluster(ray)
    finally:
        ray.shutdown()


def _join(ray: Any, address: str, quiet: dict[str, bool]) -> None:
    problem = f"the Ray cluster of {_ADDRESS}={address} cannot be joined"
    host, _, port = address.rpartition(":")
    try:
        # Ray would try for minutes where nothing listens.
        if port.isdecimal() and "/" not in host:
            socket.create_connection((host, int(port)), timeout=_SECONDS_TO_ANSWER).close()
        ray.init(address, **quiet)
    except (OSError, OverflowError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        why = str(error).strip() or type(error).__name__
        raise ConfigurationError(f"{problem}: {why.splitlines()[0]}") from error
