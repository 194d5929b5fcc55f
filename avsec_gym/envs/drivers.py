"""Who drives the car that is attacked: the planner by name, or any agent that drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from avsec_gym.closed_loop.planner_policy import REPLANNING
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

PLANNER = "planner"


class Driver(Protocol):
    """An agent of `avsec/ClosedLoop-v0` with the interface of stable-baselines3."""

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, Any]:
        """The action, and a state that is not used here."""


def driver_of(what: Any, drive: Any) -> Driver:
    """The driver that a name, a dictionary or an object stands for.

    Args:
        what: ``"planner"``; ``{"name": "planner", "replanning": 0.2}``, seconds between two plans;
            or a live agent that was trained on such drives.
        drive: The environment that is driven.

    Raises:
        ConfigurationError: It is none of them, or an argument does not fit.
    """
    if not isinstance(what, str | Mapping):
        if not callable(getattr(what, "predict", None)):
            raise ConfigurationError(
                f'driver is "{PLANNER}", a dictionary of that name and `replanning`, or an agent '
                f"that has predict(observation, deterministic=True), got {what!r}"
            )
        if isinstance(what, PlannerDriver):
            raise ConfigurationError(
                "this PlannerDriver drives the environment that it was made for, not this one: "
                f'give driver="{PLANNER}", or a dictionary with its `replanning`'
            )
        live: Driver = what
        return live
    arguments: dict[str, Any] = {"name": what} if isinstance(what, str) else dict(what)
    name = arguments.pop("name", None)
    if name != PLANNER:
        raise ConfigurationError(
            unknown_name(f"there is no driver named {name!r}", str(name), [PLANNER])
        )
    for given in arguments:
        if given != "replanning":
            problem = f"the driver {name!r} has no argument {given!r}"
            raise ConfigurationError(unknown_name(problem, str(given), ["replanning"]))
    return PlannerDriver(drive, replanning=arguments.get("replanning", REPLANNING))
