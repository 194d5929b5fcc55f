"""What rules win in `avsec/ClosedLoopAttack-v0`, on drives they were not chosen on; prints JSON.

    python benchmarks/closed_loop_attackers.py                              # a quarter of an hour
    python benchmarks/closed_loop_attackers.py --episodes 5 --held-out 10   # smaller

The drives are contested: safe without an attack, and unsafe by the car's own fault where it
believes in no object at all, so that hiding everything for the whole time would win each.

- `nothing`: no attack; every drive is safe without one.
- `random`: an action of the action space at each step.
- `constant`: the same action at each step, so that the budget is spent at the beginning: a ghost, a
  hidden object or both, the best of a grid on the training episodes.
- `waits`: hides the nearest object in the car's own or intended lane once it is near; the best of
  some distances.
- `when it plans`: the same, but only in the one frame of five that the car plans from, so that the
  budget lasts for the whole drive.

Intervals are Wilson's, 95 %, widened by what episodes of one scene have in common.
"""

from __future__ import annotations

import argparse
import json
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np

import avsec_gym
from avsec_gym.agents.hiding_rules import (
    DISTANCES,
    OFF,
    Rule,
    ghost_at,
    hidden_at,
    waits,
    when_it_plans,
)
from avsec_gym.metrics.clustered_shares import Share, share_of

ID = "avsec/ClosedLoopAttack-v0"
TRAINING = {"source": "layouts", "seed": 0, "count": 100}
HELD_OUT = {"source": "layouts", "seed": 7, "count": 200}
HIDING = {"waits": waits, "when it plans": when_it_plans}


def constants() -> dict[str, np.ndarray]:
    """Actions without looking."""
    found = {}
    for ahead, left in product((10.0, 20.0, 30.0), (-3.5, 0.0, 3.5)):
        found[f"hide at {ahead:g}, {left:g}"] = hidden_at(ahead, left)
    for ahead in (8.0, 14.0):
        found[f"ghost at {ahead:g}"] = ghost_at(ahead, 0.0)
    found["both"] = ghost_at(14.0, -3.5, hidden_at(20.0, 0.0))
    return found


def successes(env: Any, rule: Rule, episodes: int) -> Share:
    """Episodes that a rule wins; episode k is that of seed k."""
    won, scenes = [], []
    for seed in range(episodes):
        seen, info = env.reset(seed=seed)
        ended = False
        while not ended:
            [action] = rule(seen[None])
            seen, _, terminated, truncated, info = env.step(action)
            ended = terminated or truncated
        won.append(info["is_success"])
        scenes.append(info["scenario"])
    return share_of(won, scenes)


def always(action: np.ndarray) -> Rule:
    """The rule that does not look."""
    return lambda observations: np.tile(action, (len(observations), 1))


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
    tried = {
        name: {d: successes(training, rule(d), given.episodes).count for d in DISTANCES}
        for name, rule in HIDING.items()
    }
    distance = {name: max(found, key=found.__getitem__) for name, found in tried.items()}
    held_out.action_space.seed(0)
    rules: dict[str, Rule] = {
        "nothing": always(OFF),
        "random": lambda observations: np.array([held_out.action_space.sample()]),
        "constant": always(fixed[best]),
        **{name: rule(distance[name]) for name, rule in HIDING.items()},
    }
    judged = {name: successes(held_out, rule, given.held_out) for name, rule in rules.items()}
    report = {
        "chosen": {"constant": best, **distance},
        "training": {"episodes": given.episodes, "constants": won, **tried},
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
