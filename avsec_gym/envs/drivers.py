"""Who drives a car: the planner or highway-env's IDM by name, or any agent that drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from avsec_gym.closed_loop.planner_policy import REPLANNING
from avsec_gym.envs.idm_driver import IdmDriver
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

PLANNER, IDM = "planner", "idm"
_ARGUMENTS = {PLANNER: ("replanning",), IDM: ()}
"""Drivers by their names, and what each takes."""


class Driver(Protocol):
    """An agent of `avsec/ClosedLoop-v0` with the interface of stable-baselines3."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, Any]:
        """The action, and a state that is not used here."""


def driver_of(what: Any, drive: Any) -> Driver:
    """The driver that a name, a dictionary or an object stands for.

    Args:
        what: ``"planner"``; ``{"name": "planner", "replanning": 0.2}``, seconds between two plans;
            ``"idm"``, highway-env's own; or a live agent that was trained on such drives.
        drive: The environment that is driven.

    Raises:
        ConfigurationError: It is none of them, or an argument does not fit.
    """
    if not isinstance(what, str | Mapping):
        return _live(what)
    name, arguments = _named(what)
    if name == IDM:
        return IdmDriver(drive)
    return PlannerDriver(drive, replanning=arguments.get("replanning", REPLANNING))


def check_named_driver(what: Any) -> None:
    """Refuse what is not a driver's name, or a dictionary with it.

    Raises:
        ConfigurationError: It is something else, or has an argument that the driver does not take.
    """
    if not isinstance(what, str | Mapping):
        raise ConfigurationError(f"driver is a name such as {PLANNER!r} here, got {what!r}")
    _named(what)


def _named(what: str | Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Name and arguments, both known."""
    arguments: dict[str, Any] = {"name": what} if isinstance(what, str) else dict(what)
    name = arguments.pop("name", None)
    if not isinstance(name, str) or name not in _ARGUMENTS:
        raise ConfigurationError(
            unknown_name(f"there is no driver named {name!r}", str(name), _ARGUMENTS)
        )
    for given in arguments:
        if given not in _ARGUMENTS[name]:
            problem = f"the driver {name!r} has no argument {given!r}"
            raise ConfigurationError(unknown_name(problem, str(given), _ARGUMENTS[name]))
    return name, arguments


def _live(agent: Any) -> Driver:
    """An agent that can drive any environment."""
    if not callable(getattr(agent, "predict", None)):
        raise ConfigurationError(
            f'driver is "{PLANNER}", a dictionary of that name and `replanning`, "{IDM}", or an'
            f" agent that has predict(observation, deterministic=True), got {agent!r}"
        )
    if isinstance(agent, PlannerDriver | IdmDriver):
        raise ConfigurationError(
            f"this {type(agent).__name__} drives the environment that it was made for, not this"
            f' one: give driver="{PLANNER}", or a dictionary with its `replanning`, or "{IDM}"'
        )
    live: Driver = agent
    return live
