"""What rules win in `avsec/ClosedLoopAttack-v0`, on drives they were not chosen on; prints JSON.

    python benchmarks/closed_loop_attackers.py                              # a quarter of an hour
    python benchmarks/closed_loop_attackers.py --episodes 5 --held-out 10   # smaller

The drives are contested: safe without an attack, and unsafe by the car's own fault where it
believes in no object at all, so that hiding everything for the whole time would win each.

- `nothing`: no attack; every drive is safe without one.
- `random`: an action of the action space at each step.
- `constant`: the same action at each step, so that the budget is spent at the beginning: a ghost, a
  hidden object or both, the best of a grid on the training episodes.
- `waits`: hides the nearest object in the car's own or intended lane once it is near, and keeps it
  hidden; the best of some distances.

Intervals are Wilson's, 95 %, widened by what episodes of one scene have in common.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from functools import partial
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np

import avsec_gym
from avsec_gym.envs.closed_loop_observation import EACH, OWN, RANGE
from avsec_gym.metrics.clustered_shares import Share, share_of

ID = "avsec/ClosedLoopAttack-v0"
TRAINING = {"source": "layouts", "seed": 0, "count": 100}
HELD_OUT = {"source": "layouts", "seed": 7, "count": 200}
AHEAD, LEFT = (5.0, 45.0), (-8.0, 8.0)
"""The attack's defaults, metres."""
OFF = np.array([-1, 0, 0, 0, -1, 0, 0], np.float32)
"""No ghost, nothing hidden."""
DISTANCES = (8.0, 12.0, 16.0, 25.0)
"""Metres within which `waits` begins to hide, of which one is chosen."""
_OBJECTS = 16
_SPREAD = 1.75
"""Metres from a lane's middle within which an object is in the way."""

Rule = Callable[[np.ndarray], np.ndarray]


def place(ahead: float, left: float) -> tuple[float, float]:
    """A place as two numbers of an action."""
    scaled = [
        2.0 * (value - low) / (high - low) - 1.0
        for value, (low, high) in ((ahead, AHEAD), (left, LEFT))
    ]
    return scaled[0], scaled[1]


def ghost_at(ahead: float, left: float, action: np.ndarray = OFF) -> np.ndarray:
    """An action with a ghost at a place, along the road."""
    return np.array([1.0, *place(ahead, left), 0.0, *action[4:]], np.float32)


def hidden_at(ahead: float, left: float) -> np.ndarray:
    """The action that hides the object nearest to a place."""
    return np.array([*OFF[:4], 1.0, *place(ahead, left)], np.float32)


def constants() -> dict[str, np.ndarray]:
    """Actions without looking."""
    found = {}
    for ahead, left in product((10.0, 20.0, 30.0), (-3.5, 0.0, 3.5)):
        found[f"hide at {ahead:g}, {left:g}"] = hidden_at(ahead, left)
    for ahead in (8.0, 14.0):
        found[f"ghost at {ahead:g}"] = ghost_at(ahead, 0.0)
    found["both"] = ghost_at(14.0, -3.5, hidden_at(20.0, 0.0))
    return found


def waits(distance: float, observation: np.ndarray) -> np.ndarray:
    """Hide what is near and in the way."""
    rows = observation[OWN : OWN + EACH * _OBJECTS].reshape(-1, EACH)
    rows = rows[rows[:, 0] > 0]
    x, y = rows[:, 1] * RANGE, rows[:, 2] * 20.0
    in_the_way = np.zeros(len(rows), bool)
    for lane in (2, 5):
        # The lane's middle beside the car, and 15 m ahead.
        beside, ahead = -10.0 * observation[lane], 10.0 * observation[lane + 2]
        in_the_way |= np.abs(y - beside - (ahead - beside) * x / 15.0) < _SPREAD
    found = np.nonzero(in_the_way & (x > 2.0) & (x < distance))[0]
    if not len(found):
        return OFF
    nearest = found[np.argmin(x[found])]
    return hidden_at(float(x[nearest]), float(y[nearest]))


def successes(env: Any, rule: Rule, episodes: int) -> Share:
    """Episodes that a rule wins; episode k is that of seed k."""
    won, scenes = [], []
    for seed in range(episodes):
        seen, info = env.reset(seed=seed)
        ended = False
        while not ended:
            seen, _, terminated, truncated, info = env.step(rule(seen))
            ended = terminated or truncated
        won.append(info["is_success"])
        scenes.append(info["scenario"])
    return share_of(won, scenes)


def always(action: np.ndarray) -> Rule:
    """The rule that does not look."""
    return lambda observation: action


def main() -> None:
    """Choose the rules, and judge them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--episodes", type=int, default=30, help="training episodes")
    parser.add_argument("--held-out", type=int, default=100, help="episodes that are judged")
    given = parser.parse_args()
    gym.register_envs(avsec_gym)
    training, held_out = (
        gym.make(ID, scenarios=each, contested=True) for each in (TRAINING, HELD_OUT)
    )
    fixed = constants()
    won = {name: successes(training, always(fixed[name]), given.episodes).count for name in fixed}
    best = max(won, key=lambda name: won[name])
    waited = {d: successes(training, partial(waits, d), given.episodes).count for d in DISTANCES}
    distance = max(waited, key=lambda d: waited[d])
    held_out.action_space.seed(0)
    rules: dict[str, Rule] = {
        "nothing": always(OFF),
        "random": lambda observation: held_out.action_space.sample(),
        "constant": always(fixed[best]),
        "waits": partial(waits, distance),
    }
    judged = {name: successes(held_out, rule, given.held_out) for name, rule in rules.items()}
    report = {
        "chosen": {"constant": best, "waits": distance},
        "training": {"episodes": given.episodes, "constants": won, "waits": waited},
        "held_out": {
            name: {
                "won": share.count,
                "episodes": share.of,
                "rate": share.rate,
                "interval": share.interval,
            }
            for name, share in judged.items()
        },
    }
    print(json.dumps(report, indent=2))


if __name__ == "__main__":
    main()
