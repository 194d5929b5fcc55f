"""Rules of `avsec/FaculaAttack-v0`: to shine at what is in the car's way, by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.agents.aimed_games import GAMES
from avsec_gym.envs.observations import FEATURES
from avsec_gym.geometry import Floats
from avsec_gym.rig import KITTI_CAMERAS, KITTI_CENTRE, KITTI_FOCAL_LENGTH, KITTI_SIZE

_GAME = GAMES["facula_attack"]
_INTENTION = slice(2, 5)
"""Where an observation has the intention: left, straight, right, one-hot."""
_AHEAD, _LEFT = 50.0, 20.0
"""Metres that 1 of an object's place stands for."""
_LANE, _CHANGED = 3.5, 15.0
"""Metres from lane to lane, and metres ahead at which the car wants to have changed it."""
_BESIDE = 1.75
"""Metres from the way to the middle of an object within which it is in the way."""
_CAMERA = 1.65
"""Metres of KITTI's cameras above the ground."""
_HORIZON = 2.0 * KITTI_CENTRE[1] / (KITTI_SIZE[1] - 1) - 1.0
"""The row of KITTI's horizon, -1 to 1 down the image."""
_DISPARITY = (
    2.0 * KITTI_FOCAL_LENGTH / (KITTI_SIZE[0] - 1) * abs(KITTI_CAMERAS[3] - KITTI_CAMERAS[2])
)
"""Columns, -1 to 1 across the image, from the left image to the right of what is 1 m ahead."""


@dataclass(frozen=True)
class LaserRule:
    """Shines at the nearest object in the way; again at what has not been tried, if it may.

    The second query of an episode is into the other camera, the next two are at the next object,
    and so on.

    Args:
        queries: Queries of an episode.
        actions: Numbers of an action; a strength is the largest.
        radius: The size of the spot, from -1, the smallest that is allowed, to 1, the largest.
        height: Metres above the ground that are aimed at.
        right_first: Whether the first query is into the right camera.
    """

    queries: int
    actions: int = _GAME.action
    radius: float = 1.0
    height: float = 0.4
    right_first: bool = False

    def __call__(self, observations: Any) -> NDArray[np.float32]:
        """Actions for observations, shape (B, actions).

        Args:
            observations: Features, shape (B, M), or a mapping that has them.
        """
        seen = features_of(observations)
        rows = np.asarray(_GAME.objects(seen), float)
        # How many queries were spent, and so which object and which camera are next.
        spent = np.rint((1.0 - seen[:, _GAME.clock]) * self.queries).astype(int)
        there = np.maximum((rows[..., 0] > 0).sum(axis=1), 1)
        order = in_order(seen)
        one = order[np.arange(len(order)), spent // 2 % there]
        target = rows[np.arange(len(rows)), one]
        right = (spent % 2 == 1) ^ self.right_first
        return self._shining_at(target, right)

    def _shining_at(self, target: Floats, right: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Actions at an object in each observation.

        Args:
            target: The object's numbers, shape (B, 12); zeros where there is none.
            right: Whether the right camera is shone into, shape (B,).
        """
        ahead = np.maximum(_AHEAD * target[:, 1], 1.0)
        column, foot = target[:, _GAME.seen[0]], target[:, _GAME.seen[1]]
        found = np.ones((len(target), self.actions))
        found[:, 0] = np.where(right, 1.0, -1.0)
        found[:, 1] = column - np.where(right, _DISPARITY / ahead, 0.0)
        # From its foot up, in proportion: the horizon is at the camera's height.
        found[:, 2] = foot + self.height / _CAMERA * (_HORIZON - foot)
        found[:, 3] = self.radius
        return np.clip(found, -1.0, 1.0).astype(np.float32)


def candidates(queries: int, actions: int) -> list[LaserRule]:
    """Rules of some sizes, heights and cameras, of which one is chosen.

    Args:
        queries: Queries of an episode.
        actions: Numbers of an action.
    """
    sizes, heights = (1.0, 0.33, -0.33, -0.8), (0.3, 0.8)
    return [
        LaserRule(queries, actions, *others) for others in product(sizes, heights, (False, True))
    ]


def fits(observations: gym.Space[Any], actions: gym.Space[Any]) -> bool:
    """Whether a rule can play: the features are seen, and at most a strength is chosen as well.

    Args:
        observations: The environment's observation space.
        actions: Its action space.
    """
    seen = observations[FEATURES] if isinstance(observations, gym.spaces.Dict) else observations
    chosen = (actions.shape or (0,))[0]
    more = chosen - _GAME.action
    return more in (0, 1) and seen.shape == (_GAME.observation + more,)


def features_of(observations: Any) -> NDArray[Any]:
    """The features of observations that may have images beside them, shape (B, M)."""
    seen = observations[FEATURES] if isinstance(observations, Mapping) else observations
    return np.asarray(seen)


def in_order(seen: NDArray[Any]) -> NDArray[np.int64]:
    """The objects from the most in the way to the least, indices of shape (B, 8).

    First those in the way, the nearest first; then the others, those next to it first.  The way
    leads along the car's lane, or in an S from it into the lane of its goal.

    Args:
        seen: Features, shape (B, M).
    """
    rows = np.asarray(_GAME.objects(seen), float)
    x, y = rows[..., 1] * _AHEAD, rows[..., 2] * _LEFT
    lanes = np.asarray(seen, float)[:, _INTENTION] @ [1.0, 0.0, -1.0]
    share = np.clip(x / _CHANGED, 0.0, 1.0)
    beside = np.abs(y - _LANE * lanes[:, None] * share**2 * (3.0 - 2.0 * share))
    # Kilometres for what is not in the way, and more for what is not there.
    far = np.where(beside < _BESIDE, x, 1e3 + beside)
    return np.argsort(np.where(rows[..., 0] > 0, far, 1e6), axis=1, kind="stable")
