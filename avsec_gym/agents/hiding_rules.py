"""Rules of `avsec/ClosedLoopAttack-v0`: to hide what is in the car's way, and when."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.agents.aimed_games import AHEAD, GAMES, LEFT, WIDTH, scaled
from avsec_gym.envs.closed_loop_observation import RANGE
from avsec_gym.geometry import Floats

Rule = Callable[[NDArray[np.float32]], NDArray[np.float32]]
"""Observations (B, M) to actions (B, 7) of the default attack, a ghost and a hidden object."""

OFF = np.array([-1, 0, 0, 0, -1, 0, 0], np.float32)
"""No ghost, nothing hidden."""
DISTANCES = (8.0, 12.0, 16.0, 25.0, 50.0)
"""Metres ahead within which an object is hidden, of which one is chosen."""
_LANES = (2, 5)
"""Where an observation has the car's place in its own lane, and in that of its goal."""
_LOOKED_AHEAD = 15.0
"""Metres ahead at which it has the course of both."""
_BESIDE = 1.75
"""Metres from a lane's middle within which an object is in the way."""
_NEAREST = 2.0
"""Metres ahead from which on it can be."""
_GAME = GAMES["closed_loop_attack"]


def place(ahead: float, left: float) -> tuple[float, float]:
    """A place, metres, as two numbers of an action."""
    (slope, offset), (aside, middle) = scaled(1.0, AHEAD), scaled(1.0, LEFT)
    return slope * ahead + offset, aside * left + middle


def ghost_at(ahead: float, left: float, action: NDArray[np.float32] = OFF) -> NDArray[np.float32]:
    """An action with a ghost at a place, along the road."""
    return np.array([1.0, *place(ahead, left), 0.0, *action[4:]], np.float32)


def hidden_at(ahead: float, left: float) -> NDArray[np.float32]:
    """The action that hides the object nearest to a place."""
    return np.array([*OFF[:4], 1.0, *place(ahead, left)], np.float32)


def waits(distance: float) -> Rule:
    """Hide the nearest object in the way, once it is as near as `distance`, metres."""

    def act(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.array([_hides(nearest) for nearest in in_the_way(observations, distance)])

    return act


def when_it_plans(distance: float) -> Rule:
    """The same, but in the one frame of five alone from which the car plans.

    What it believes between two plans is forgotten, so that the budget lasts five times as long.
    """

    def act(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        left = np.rint(np.asarray(observations)[:, _GAME.clock] * _GAME.steps).astype(int)
        plans_next = (_GAME.steps - left) % _GAME.period == _GAME.period - 1
        return np.where(plans_next[:, None], waits(distance)(observations), OFF)

    return act


def in_the_way(observations: NDArray[np.float32], distance: float) -> list[Floats | None]:
    """The place ahead and left, metres, of the nearest object in the way, for each observation.

    In the way is what stands in the car's own lane or in that of its goal.

    Args:
        observations: Shape (B, M).
        distance: Metres ahead beyond which nothing counts.
    """
    seen = np.asarray(observations, float)
    rows = _GAME.objects(seen)
    x, y = rows[..., 1] * RANGE, rows[..., 2] * WIDTH
    within = np.zeros(x.shape, bool)
    for lane in _LANES:
        # The lane's middle beside the car, and further ahead; straight in between.
        beside, ahead = -10.0 * seen[:, [lane]], 10.0 * seen[:, [lane + 2]]
        within |= np.abs(y - beside - (ahead - beside) * x / _LOOKED_AHEAD) < _BESIDE
    within &= (rows[..., 0] > 0) & (x > _NEAREST) & (x < distance)
    nearest = np.where(within, x, np.inf).argmin(axis=1)
    return [
        np.array([x[row, one], y[row, one]]) if within[row, one] else None
        for row, one in enumerate(nearest)
    ]


def _hides(nearest: Floats | None) -> NDArray[np.float32]:
    return OFF if nearest is None else hidden_at(*nearest.tolist())
