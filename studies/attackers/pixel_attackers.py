"""Train a black-box attacker on pixels with SAC, and judge it on held-out scenes.

    python -m studies.attackers.pixel_attackers perturbation
    python -m studies.attackers.pixel_attackers patch --detector stereo_rcnn --patch FILE
    python -m studies.attackers.pixel_attackers patch --detector '{"name": "dsgn", ...}'

It is compared with random actions, and with two searches that spend as many queries on the training
scenes: random search, and CMA-ES (Hansen, `pip install cma`).  Of either, the ten actions that did
best there are tried in that order on every held-out scene.
Nearly all of the time goes into the detector: a fifth of a second to half a second for a query.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import avsec_gym
from avsec_gym.console import progress
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.progress import Progress
from studies.attackers.arguments import arguments, given
from studies.attackers.searches import evolved, random_search
from studies.attackers.training import CountedQueries, trained

GAMES = {"perturbation": "avsec/PerturbationAttack-v0", "patch": "avsec/PatchAttack-v0"}
"""Attack to the environment in which it is learned."""

Policy = Callable[[NDArray[Any], int], NDArray[Any]]
"""A function from an observation and the number of the query to an action."""


def compare(id: str, options: argparse.Namespace, **more: Any) -> dict[str, Any]:
    """Train and search on some scenes, evaluate on others.

    Args:
        id: The environment.
        options: Options of `arguments`.
        more: Further arguments of the environment.
    """
    gym.register_envs(avsec_gym)
    common = {"detector": given(options.detector), "score_threshold": options.threshold, **more}
    with progress("queries of SAC and of both searches") as shown:
        made = gym.make(id, scenarios=given(options.training), **common)
        training = CountedQueries(made, 3 * options.steps, shown)
        begun = time.perf_counter()
        agent = trained(training, options.steps, options.seed)
        seconds = time.perf_counter() - begun
        best = random_search(training, options.steps, options.seed)
        found = evolved(training, options.steps, options.seed)
    held_out = gym.make(id, scenarios=given(options.testing), **common)
    generator = np.random.default_rng([options.seed, 1])  # Not the draws of random search.
    shape = held_out.action_space.shape
    policies: dict[str, Policy] = {
        "random": lambda seen, query: generator.uniform(-1.0, 1.0, shape).astype(np.float32),
        "random_search": lambda seen, query: best[query % len(best)],
        "cma_es": lambda seen, query: found[query % len(found)],
        "sac": lambda seen, query: agent.predict(seen)[0],
    }
    results = {}
    for name, policy in policies.items():
        with progress(f"held-out scenes, {name}") as shown:
            results[name] = evaluate(held_out, policy, options.held_out, options.seed, shown)
    return {
        "environment": id,
        "detector": common["detector"],
        **results,
        "training_queries": options.steps,
        "training_seconds": round(seconds, 1),
    }


def evaluate(
    env: gym.Env[Any, Any], policy: Policy, episodes: int, seed: int, on_progress: Progress
) -> dict[str, Any]:
    """Success, queries and reward on held-out scenes.

    Args:
        env: The environment of the held-out scenes.
        policy: The attacker.
        episodes: The number of episodes.
        seed: Seed of the first episode.
        on_progress: Function that gets the number of episodes that are done, and of all.
    """
    successes, scenes, queries, rewards = [], [], [], []
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        total, over = 0.0, False
        while not over:
            action = policy(observation, info["queries"])
            observation, reward, terminated, truncated, info = env.step(action)
            total, over = total + float(reward), terminated or truncated
        on_progress(episode + 1, episodes)
        successes.append(info["is_success"])
        scenes.append(info["scenario"])
        queries.append(info["queries"])
        rewards.append(total)
    # Episodes of one scene are alike.
    low, high = share_of(successes, scenes).interval or (0.0, 1.0)
    return {
        "episodes": episodes,
        "success_rate": round(float(np.mean(successes)), 4),
        "success_interval": [round(low, 4), round(high, 4)],
        "queries": round(float(np.mean(queries)), 2),
        "reward": round(float(np.mean(rewards)), 4),
    }


def main() -> None:
    """Train, evaluate, print JSON."""
    parser = arguments((__doc__ or "").partition("\n")[0])
    parser.add_argument("attack", choices=GAMES)
    parser.add_argument("--epsilon", type=int, default=8, help="of a perturbation, grey levels")
    parser.add_argument("--patch", help="grey, noise, or a file; without: the detector's own")
    options = parser.parse_args()
    own = {
        "perturbation": {"epsilon": options.epsilon},
        "patch": {"patch": options.patch},
    }[options.attack]
    result = compare(GAMES[options.attack], options, **own)
    if options.attack == "patch":
        result["patch"] = options.patch or "the detector's own"
    sys.stdout.write(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
