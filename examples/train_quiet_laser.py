"""Train a laser to stay unnoticed, and see what that costs it in effect.

    avsec world make --suite mixed --frames 200 --seed 3 --out seen
    avsec world make --suite mixed --frames 240 --seed 2 --out unseen
    python examples/train_quiet_laser.py --training seen --testing unseen

SAC is trained twice with as many queries: the quiet one is paid for a drive that becomes unsafe
while the validator raises no alarm, the loud one for every drive that becomes unsafe.  Both are
compared on held-out scenes with random actions and with random search for the quiet aim, which
spends as many queries on the training scenes: the ten actions that did best there, tried in that
order.  All of them aim alike: an action is a place beside the nearest car, not in the image.

Played are situations in which a car is in the way (`contested`), one of ten; the default suite has
but few, so frames of one's own tell more.  A query takes half a second.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import gymnasium as gym
import numpy as np
from train_perturbation_attacker import Policy, arguments, given, search, train

import avsec_gym
from avsec_gym.metrics.intervals import wilson_interval

REACH = 0.25
"""How far beside the nearest car a laser aims, as a share of half the image."""
RADII = (30.0, 180.0)
"""Pixels: the smallest hides hardly a car, the largest is noticed always."""
NEAREST = slice(9 + 8, 9 + 8 + 2)
"""Of the observation: column and row of the nearest car's place on the road.  Before them are 9
figures of start and goal, and 8 of that car (`avsec_gym.envs.sensor_attack_features.features`)."""


class Aimed(gym.Wrapper):
    """Actions are camera, columns and rows away from the nearest car, and radius."""

    def reset(self, **options: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin, and see where the nearest car is."""
        observation, info = self.env.reset(**options)
        self._place = observation[NEAREST].copy()
        return observation, info

    def step(self, action: np.ndarray) -> tuple[np.ndarray, Any, bool, bool, dict[str, Any]]:
        """Query the car once."""
        beside = np.clip(self._place + REACH * action[1:3], -1.0, 1.0)
        return self.env.step(np.array([action[0], *beside, action[3]], np.float32))


class Loud(gym.Wrapper):
    """Every unsafe drive is paid for, whether or not the validator noticed the attack."""

    def step(self, action: np.ndarray) -> tuple[np.ndarray, Any, bool, bool, dict[str, Any]]:
        """Query the car once."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        if info["noticed"] and not info["safe"]:
            reward, terminated, truncated = float(reward) + 1.0, True, False
        return observation, reward, terminated, truncated, info


def evaluate(env: gym.Env, policy: Policy, episodes: int, seed: int) -> dict[str, Any]:
    """What the first query does, and how often all of them find a quiet success."""
    first: list[tuple[bool, bool, float]] = []
    successes = 0
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        over = False
        while not over:
            action = policy(observation, info["queries"])
            observation, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
            if info["queries"] == 1:
                first.append((not info["safe"], info["noticed"], info["radius"]))
        successes += info["is_success"]
    unsafe, noticed, radius = np.array(first, float).T
    return {
        "unsafe": share(unsafe),
        "noticed": share(noticed),
        "unsafe_and_unnoticed": share(unsafe * (1 - noticed)),
        "radius": round(float(radius.mean()), 1),
        "success_within_all_queries": share(np.arange(episodes) < successes),
    }


def share(flags: np.ndarray) -> dict[str, Any]:
    """The rate with its 95 % interval."""
    low, high = wilson_interval(int(flags.sum()), len(flags))
    return {"rate": round(float(flags.mean()), 4), "interval": [round(low, 4), round(high, 4)]}


def compare(options: argparse.Namespace) -> dict[str, Any]:
    """Train and search on some scenes, evaluate on others."""
    gym.register_envs(avsec_gym)
    common = {
        "detector": given(options.detector),
        "score_threshold": options.threshold,
        "validator": {"name": "thresholds", "rate": options.rate},
        "clean": given(options.training),
        "contested": not options.all_scenes,
        "radii": RADII,
    }

    def made(scenes: str) -> gym.Env:
        return Aimed(gym.make("avsec/FaculaAttack-v0", scenarios=given(scenes), **common))

    training = made(options.training)
    quiet = train(training, options.steps, options.seed)
    loud = train(Loud(training), options.steps, options.seed)
    best = search(training, options.steps, options.seed)
    held_out = made(options.testing)
    generator = np.random.default_rng(options.seed)
    shape = held_out.action_space.shape
    policies: dict[str, Policy] = {
        "random": lambda seen, query: generator.uniform(-1.0, 1.0, shape).astype(np.float32),
        "random_search": lambda seen, query: best[query % len(best)],
        "loud_sac": lambda seen, query: loud.predict(seen)[0],
        "quiet_sac": lambda seen, query: quiet.predict(seen)[0],
    }
    return {
        "detector": common["detector"],
        "false_alarm_rate": options.rate,
        "training_queries": options.steps,
        "episodes": options.held_out,
        **{
            name: evaluate(held_out, policy, options.held_out, options.seed)
            for name, policy in policies.items()
        },
    }


def main() -> None:
    """Train, evaluate, print JSON."""
    parser = arguments(__doc__.splitlines()[0])
    parser.add_argument("--rate", type=float, default=0.05, help="designated false alarm rate")
    parser.add_argument(
        "--all-scenes", action="store_true", help="also where nothing is in the way"
    )
    print(json.dumps(compare(parser.parse_args()), indent=1))


if __name__ == "__main__":
    main()
