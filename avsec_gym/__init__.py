"""avsec-gym: does a self-driving car drive safely under attack, and does it detect the attack?

Importing the package registers its environments with Gymnasium:

    import gymnasium as gym
    import avsec_gym

    gym.register_envs(avsec_gym)
    env = gym.make("avsec/GhostObject-v1")

In other processes, ``gym.make("avsec_gym:avsec/GhostObject-v1")`` imports it by itself.
"""

from importlib.metadata import version as _version_of
from typing import Any

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import AvsecError, ConfigurationError, DataError, PlanningError
from avsec_gym.registration import register_environments
from avsec_gym.registry import make, register

__version__: str
"""The installed version; pyproject.toml holds it."""

__all__ = [
    "AvsecError",
    "Boxes3D",
    "ConfigurationError",
    "DataError",
    "PlanningError",
    "make",
    "register",
    "register_environments",
]

register_environments()


def __getattr__(name: str) -> Any:
    # Read when it is asked for: the import of the package need not wait for it.
    if name == "__version__":
        return _version_of("avsec-gym")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
