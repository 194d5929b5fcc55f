"""Games in which an attacker aims at one of the objects, with their default attacks.

Where an observation has its objects, an action its place, and when the car plans: what policies and
rules of `agents` have in common.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import gymnasium as gym

from avsec_gym.envs.closed_loop_observation import EACH, OWN, RANGE

WIDTH = 20.0
"""Metres to the left that 1 of a closed loop's observation stands for."""
AHEAD, LEFT = (5.0, 45.0), (-8.0, 8.0)
"""Where the default attack of `avsec/ClosedLoopAttack-v0` reaches, metres."""


def scaled(unit: float, span: tuple[float, float]) -> tuple[float, float]:
    """Slope and offset from a number of an observation to one of an action.

    Args:
        unit: Metres that 1 of the observation stands for.
        span: Metres that -1 and 1 of the action stand for.

    Example:
        >>> scaled(50.0, (5.0, 45.0))
        (2.5, -1.25)
    """
    low, high = span
    return 2.0 * unit / (high - low), -(high + low) / (high - low)


@dataclass(frozen=True)
class AimedGame:
    """Where a game's observation has its objects, and its action a place.

    Args:
        observation: Numbers of an observation.
        action: Numbers of an action.
        first: Index of the first object's first number, which is above 0 where there is one.
        count: Number of objects.
        size: Numbers of each.
        seen: Which of an object's numbers state its place.
        aimed: Which of an action's numbers state a place, as many.
        line: Slope and offset of each of `aimed` as a function of that of `seen`.
        switches: Which of an action's numbers, above 0, spend what there is little of.
        clock: Index of the share of an episode that is left.
        steps: Steps of an episode.
        period: Steps after which the car does the same again.
    """

    observation: int
    action: int
    first: int
    count: int
    size: int
    seen: tuple[int, ...]
    aimed: tuple[int, ...]
    line: tuple[tuple[float, float], ...]
    switches: tuple[int, ...]
    clock: int
    steps: int
    period: int

    def objects(self, observations: Any) -> Any:
        """The objects' numbers in observations (B, M), shape (B, count, size); of tensors, too."""
        rows = observations[:, self.first : self.first + self.count * self.size]
        return rows.reshape(-1, self.count, self.size)

    def fits(self, observations: gym.Space[Any], actions: gym.Space[Any]) -> bool:
        """Whether these are the spaces of the game with its default attack."""
        return (observations.shape, actions.shape) == ((self.observation,), (self.action,))


GAMES = {
    # What is hidden is named by its place.  The car plans in every fifth of 80 steps; what it
    # believes in between is forgotten.
    "closed_loop_attack": AimedGame(
        observation=177,
        action=7,
        first=OWN,
        count=16,
        size=EACH,
        seen=(1, 2),
        aimed=(5, 6),
        line=(scaled(RANGE, AHEAD), scaled(WIDTH, LEFT)),
        switches=(0, 4),
        clock=9,
        steps=80,
        period=5,
    ),
    # A spot of light is at a column and a row of the image, and so is each object.
    "facula_attack": AimedGame(
        observation=128,
        action=4,
        first=9,
        count=8,
        size=12,
        seen=(8, 9),
        aimed=(1, 2),
        line=((1.0, 0.0), (1.0, 0.0)),
        switches=(),
        clock=118,
        steps=1,
        period=1,
    ),
}
"""The games that it plays, each with its default attack."""
