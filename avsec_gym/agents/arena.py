"""Where agents and rules play the same episodes: an environment, and episodes by their seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.agents.learner import batch_of, has_batches, single
from avsec_gym.geometry import Floats

Act = Callable[[Any, Sequence[str]], Any]
"""A function from a batch of observations, and the driving intention of each episode, to
actions."""

_MOST_AT_ONCE = 250
_ENDLESS = 2**31
_RATE = 10
"""Steps of a drive in a second, by default."""


@dataclass(frozen=True, eq=False)
class Played:
    """What came of N episodes.

    Args:
        success: Whether the acting agent reached its aim, shape (N,).
        reward: Sum of the rewards, shape (N,).
        steps: Environment steps, shape (N,).
        intention: The driving intentions, shape (N,).
        scenario: The scenes' ids, shape (N,); several episodes of one are alike.
    """

    success: NDArray[np.bool_]
    reward: Floats
    steps: NDArray[np.int64]
    intention: NDArray[np.str_]
    scenario: NDArray[np.str_]

    @classmethod
    def together(cls, parts: Sequence[Played]) -> Played:
        """One after the other."""
        return cls(
            np.concatenate([each.success for each in parts]),
            np.concatenate([each.reward for each in parts]),
            np.concatenate([each.steps for each in parts]),
            np.concatenate([each.intention for each in parts]),
            np.concatenate([each.scenario for each in parts]),
        )


@dataclass(eq=False)
class Arena:
    """An environment to be played in; it keeps what it has made.

    Args:
        env: The id.
        arguments: Arguments of the environment.
    """

    env: str
    arguments: Mapping[str, Any]
    playing: Any = None
    """The environment, or the batch of many, in which `play` asks for actions at present."""
    _single: gym.Env[Any, Any] | None = None
    _batches: dict[int, Any] = field(default_factory=dict)

    @property
    def environment(self) -> gym.Env[Any, Any]:
        """One environment."""
        if self._single is None:
            self._single = single(self.env, self.arguments)
        return self._single

    @property
    def longest_episode(self) -> int | None:
        """The most steps of an episode: `queries`, or the registered limit; None: there is none."""
        queries = self.arguments.get("queries")
        limit: int | None = self.environment.spec.max_episode_steps  # type: ignore[union-attr]
        return limit if queries is None else int(queries)

    @property
    def steps_of_an_episode(self) -> int:
        """About the most steps of an episode: `longest_episode`, or those of a drive's duration."""
        if self.longest_episode is not None:
            return self.longest_episode
        played: Any = self.environment.unwrapped
        duration = getattr(getattr(played, "drive", played), "duration", None)
        return 1 if duration is None else max(round(_RATE * duration), 1)

    @cached_property
    def _has_batches(self) -> bool:
        return has_batches(self.env, self.arguments)

    def play(
        self,
        act: Act,
        seeds: Sequence[int],
        on_episodes: Callable[[int], None] = lambda episodes: None,
        most_steps: int | None = None,
    ) -> Played:
        """Play an episode for each seed; the same seed is the same episode.

        Args:
            act: The policy that acts.
            seeds: Seeds of the episodes.
            on_episodes: Function that gets the number of episodes that have ended since the last
                call.
            most_steps: Steps after which an episode is left; None: it is played to its end.
        """
        size, play = (_MOST_AT_ONCE, self._batch) if self._has_batches else (1, self._one)
        parts = []
        for first in range(0, len(seeds), size):
            own = list(seeds[first : first + size])
            parts.append(play(act, own, most_steps or _ENDLESS))
            on_episodes(len(own))
        return Played.together(parts)

    def close(self) -> None:
        """Close every environment."""
        for made in filter(None, [self._single, *self._batches.values()]):
            made.close()

    def _one(self, act: Act, seeds: list[int], most: int) -> Played:
        self.playing = self.environment
        observation, info = self.environment.reset(seed=seeds[0])
        intention, scenario = str(info["intention"]), str(info["scenario"])
        total, steps, ended = 0.0, 0, False
        while not ended and steps < most:
            action = act(_as_batch(observation), [intention])[0]
            observation, reward, terminated, truncated, info = self.environment.step(action)
            total, steps = total + float(reward), steps + 1
            ended = terminated or truncated
        won = bool(info["is_success"])
        return Played(*map(np.array, ([won], [total], [steps], [intention], [scenario])))

    def _batch(self, act: Act, seeds: list[int], most: int) -> Played:
        count = len(seeds)
        if count not in self._batches:
            self._batches[count] = batch_of(self.env, count, self.arguments)
        envs = self.playing = self._batches[count]
        observations, info = envs.reset(seed=seeds)
        # What is drawn: the infos of later steps may be those of episodes that begin anew.
        intention, scenario = (
            np.array([str(each) for each in info[name]]) for name in ("intention", "scenario")
        )
        success, going = np.zeros(count, bool), np.ones(count, bool)
        reward, steps = np.zeros(count), np.zeros(count, np.int64)
        while going.any():
            actions = np.asarray(act(observations, intention.tolist()))
            observations, paid, terminated, truncated, info = envs.step(actions)
            # Episodes that have ended begin anew; those are not counted.
            reward += np.where(going, paid, 0.0)
            steps += going
            success |= going & np.asarray(info["is_success"], bool)
            going &= ~(terminated | truncated) & (steps < most)
        return Played(success, reward, steps, intention, scenario)


@dataclass(frozen=True, eq=False)
class Baseline:
    """Who plays without having learned.

    Args:
        name: The name of the baseline.
        act_in: How it acts in an arena.
        queries: Environment steps that it was searched with.
    """

    name: str
    act_in: Callable[[Arena], Act]
    queries: int

    @classmethod
    def everywhere(cls, name: str, act: Act, queries: int) -> Baseline:
        """One that acts alike in every arena."""
        return cls(name, lambda arena: act, queries)


def _as_batch(observation: Any) -> Any:
    if isinstance(observation, Mapping):
        return {name: np.asarray(value)[None] for name, value in observation.items()}
    return np.asarray(observation)[None]
