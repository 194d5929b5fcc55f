"""Settings: what the car of a drive is made of, by a name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium as gym

from avsec_gym.envs.drivers import PLANNER, check_named_driver
from avsec_gym.envs.light_closed_loop import light_form
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.errors import ConfigurationError
from avsec_gym.registration import register_environments

ENVIRONMENT = "avsec/ClosedLoop-v0"


@dataclass(frozen=True)
class DriveSetting:
    """One way to drive.

    Args:
        name: What its drives are filed under.
        arguments: The arguments of the environment beside its scenes, JSON-able.
        driver: Who drives, a name or a dictionary.
    """

    name: str
    arguments: Mapping[str, Any]
    driver: Any = PLANNER

    @property
    def record(self) -> dict[str, Any]:
        """All that decides its drives: the arguments, and a driver that is not the planner."""
        driver = {} if self.driver == PLANNER else {"driver": self.driver}
        return {**self.arguments, **driver}

    def environment(self, scenarios: Any) -> gym.Env[Any, Any]:
        """The environment to drive in: without highway-env where that makes the same drives.

        Args:
            scenarios: The scenes, as the environment takes them.

        Raises:
            ConfigurationError: An argument does not fit; the message names the setting.
            DataError: A folder or file is missing or broken.
        """
        register_environments()
        try:
            check_named_driver(self.driver)
            with one_thread():
                made: gym.Env[Any, Any] = gym.make(
                    ENVIRONMENT, scenarios=scenarios, disable_env_checker=True, **self.arguments
                )
                return light_form(made.unwrapped) or made  # type: ignore[arg-type]
        except ConfigurationError as error:
            raise ConfigurationError(f"setting {self.name}: {error}") from error


def check_names(settings: Sequence[DriveSetting]) -> None:
    """Refuse settings whose drives could not be distinguished.

    Raises:
        ConfigurationError: Two have one name, or a name cannot be a file's.
    """
    names = [setting.name for setting in settings]
    for name in names:
        if names.count(name) > 1:
            raise ConfigurationError(f"two settings are called {name}: give each its own name")
        if not name or not all(sign.isalnum() or sign in "_-." for sign in name) or name[0] == ".":
            raise ConfigurationError(
                f"a setting is called by letters, digits, - and _, got {name!r}"
            )
