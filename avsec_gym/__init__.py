"""avsec-gym: does a self-driving car drive safely under attack, and does it detect the attack?

Importing the package registers its environments with Gymnasium:

    import gymnasium as gym
    import avsec_gym

    gym.register_envs(avsec_gym)
    env = gym.make("avsec/GhostObject-v1")

In other processes, ``gym.make("avsec_gym:avsec/GhostObject-v1")`` imports it by itself.
"""

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import AvsecError, ConfigurationError, DataError, PlanningError
from avsec_gym.registration import register_environments
from avsec_gym.registry import make, register

__version__ = "0.2.0.dev0"

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
