"""The motion planner as an agent with the interface of stable-baselines3: of one car, of many."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.planner_policy import REPLANNING, PlannerPolicy
from avsec_gym.envs.belief_driver import BeliefDriver
from avsec_gym.envs.closed_loop_vector import ClosedLoopVectorEnv
from avsec_gym.errors import ConfigurationError


class PlannerDriver(BeliefDriver):
    """A planner that drives `avsec/ClosedLoop-v0`: it replans, and follows its plan in between.

    It plans on what the car believes, from the state that the car has really reached.  Between two
    plans it reads no belief: a car that perceives frame by frame, by its sensors, leaves the frames
    in between out, and keeps its last belief where it was in the world.  An alarm of a validator
    then comes at the next replanning.

    Args:
        environment: The environment that is driven, with continuous actions.
        planner: A name, a dictionary or a live planner; None: the environment's.
        replanning: Seconds between two plans.

    Raises:
        ConfigurationError: The environment's actions are not continuous.

    Example:
        >>> env = gym.make("avsec_gym:avsec/ClosedLoop-v0")
        >>> driver = PlannerDriver(env)
        >>> observation, _ = env.reset(seed=0)
        >>> action, _ = driver.predict(observation)
        >>> action.shape
        (2,)
    """

    def __init__(
        self, environment: gym.Env[Any, Any], planner: Any = None, replanning: float = REPLANNING
    ) -> None:
        super().__init__(environment)
        chosen = self.played.planner if planner is None else planner
        self.policy = PlannerPolicy(chosen, replanning)

    def begin(self) -> None:
        """A new drive has begun."""
        self.policy.begin(self.played.scene, self.played.intention)

    def controls(self) -> tuple[float, float]:
        """The controls of the plan, which is made anew when it is time."""
        played = self.played
        wanted = self.policy.drive(played.state, played.belief, played.elapsed)
        played.unread_until = self.policy.next_plan
        return wanted


class PlannerDrivers:
    """Planners that drive many cars at once: each as a `PlannerDriver` does.

    Args:
        environments: The vector form of `avsec/ClosedLoop-v0`.
        planner: A name, a dictionary or a live planner; None: the environments'.
        replanning: Seconds between two plans.

    Raises:
        ConfigurationError: These are no such environments.

    Example:
        >>> many = gym.make_vec("avsec_gym:avsec/ClosedLoop-v0", num_envs=3)
        >>> drivers = PlannerDrivers(many)
        >>> observations, _ = many.reset(seed=0)
        >>> actions, _ = drivers.predict(observations)
        >>> actions.shape
        (3, 2)
    """

    def __init__(
        self, environments: Any, planner: Any = None, replanning: float = REPLANNING
    ) -> None:
        played = getattr(environments, "unwrapped", environments)
        if not isinstance(played, ClosedLoopVectorEnv):
            raise ConfigurationError(
                "many planners drive the vector form of avsec/ClosedLoop-v0: gym.make_vec("
                '"avsec/ClosedLoop-v0", num_envs=64); one drives a single one, as PlannerDriver'
            )
        self._environments = played
        self.drivers = [PlannerDriver(alone, planner, replanning) for alone in played.alone]

    def predict(
        self,
        observation: NDArray[np.float32],
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """The actions at the present instants of the drives; none where a drive is over.

        Args:
            observation: One of each; the beliefs are read from the environments.
            state: The state, which is handed through.
            episode_start: An argument of the interface that is not used: a new drive is recognised
                by itself.
            deterministic: Planners always are.

        Returns:
            Actions in [-1, 1], shape (num_envs, 2), and the state.
        """
        played = self._environments
        actions = np.zeros((played.num_envs, 2), np.float32)
        for i in np.flatnonzero(~played.ended).tolist():
            actions[i], _ = self.drivers[i].predict(observation[i])
        return actions, state
