"""Train a black-box attacker on pixels with SAC, and judge it on held-out scenes.

    python examples/train_perturbation_attacker.py
    python examples/train_perturbation_attacker.py --detector stereo_rcnn --steps 2000
    python examples/train_perturbation_attacker.py --detector '{"name": "dsgn", "weights": "FILE"}'

It is compared with random actions, and with two searches that spend as many queries on the training
scenes: random search, and CMA-ES (Hansen, `pip install cma`).  Of either, the ten actions that did
best there are tried in that order on every held-out scene.
Nearly all of the time goes into the detector: a fifth of a second to half a second for a query.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import Any

import cma
import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import SAC

import avsec_gym
from avsec_gym.console import ProgressDisplay, progress
from avsec_gym.metrics.clustered_shares import share_of

TRIALS = 4
"""Training episodes that a search tries an action in."""
QUERIES = 10
"""Queries of an episode."""
FEWEST_STEPS = 48
"""What the first generation of CMA-ES spends on perturbations: 12 actions, each tried 4 times."""

Policy = Callable[[np.ndarray, int], np.ndarray]
"""A function from an observation and the number of the query to an action."""


class Watched(gym.Wrapper):
    """Reports after every query how many of how many are done."""

    def __init__(self, env: gym.Env, queries: int, shown: ProgressDisplay) -> None:
        super().__init__(env)
        self._asked, self._queries, self._shown = 0, queries, shown

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """As the environment's."""
        self._asked += 1
        self._shown(min(self._asked, self._queries), self._queries)
        return self.env.step(action)


def train(env: gym.Env, queries: int, seed: int) -> SAC:
    """SAC: a query is dear, so every one is learned from many times."""
    torch.set_num_threads(1)
    agent = SAC(
        "MlpPolicy",
        env,
        learning_starts=queries // 4,
        gradient_steps=4,
        batch_size=128,
        learning_rate=1e-3,
        gamma=0.5,  # Queries hardly depend on each other.
        ent_coef=0.02,  # As an automatic one begins, the rare reward of 1 is not felt.
        policy_kwargs={"net_arch": [64, 64]},
        seed=seed,
        device="cpu",
    )
    return agent.learn(queries)


def search(env: gym.Env, queries: int, seed: int) -> np.ndarray:
    """The best of random actions, best first."""
    generator = np.random.default_rng(seed)
    actions = generator.uniform(-1.0, 1.0, (queries // TRIALS, *env.action_space.shape))
    env.reset(seed=seed)
    return best_first(actions, [tried(env, action) for action in actions])


def evolve(env: gym.Env, queries: int, seed: int) -> np.ndarray:
    """The best actions of an evolution strategy that adapts its covariances, best first."""
    return best_first(*evolution(env, queries, seed)[1:])


def evolution(
    env: gym.Env, queries: int, seed: int
) -> tuple[cma.CMAEvolutionStrategy, np.ndarray, list[float]]:
    """Where the strategy ended, the actions that it tried, and what they earned."""
    options = {"bounds": [-1.0, 1.0], "seed": seed + 1, "verbose": -9}  # 0 would be the clock
    strategy = cma.CMAEvolutionStrategy(np.zeros(env.action_space.shape), 0.5, options)
    actions: list[np.ndarray] = []
    rewards: list[float] = []
    env.reset(seed=seed)
    while len(actions) + strategy.popsize <= queries // TRIALS:
        asked = strategy.ask()
        paid = [tried(env, action) for action in asked]
        strategy.tell(asked, [-reward for reward in paid])
        actions, rewards = actions + asked, rewards + paid
    return strategy, np.array(actions), rewards


def tried(env: gym.Env, action: np.ndarray) -> float:
    """What an action earns in some training episodes as their first query."""
    total = 0.0
    for _ in range(TRIALS):
        env.reset()
        total += float(env.step(action.astype(np.float32))[1])
    return total


def best_first(actions: np.ndarray, rewards: list[float]) -> np.ndarray:
    """As many as an episode has queries."""
    return actions[np.argsort(-np.array(rewards), kind="stable")[:QUERIES]].astype(np.float32)


def evaluate(
    env: gym.Env, policy: Policy, episodes: int, seed: int, shown: ProgressDisplay
) -> dict[str, Any]:
    """Success, queries and reward on held-out scenes."""
    successes, scenes, queries, rewards = [], [], [], []
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        total, over = 0.0, False
        while not over:
            action = policy(observation, info["queries"])
            observation, reward, terminated, truncated, info = env.step(action)
            total, over = total + float(reward), terminated or truncated
        shown(episode + 1, episodes)
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


def compare(id: str, options: argparse.Namespace, **more: Any) -> dict[str, Any]:
    """Train and search on some scenes, evaluate on others."""
    gym.register_envs(avsec_gym)
    common = {"detector": given(options.detector), "score_threshold": options.threshold, **more}
    with progress("queries of SAC and of both searches") as shown:
        made = gym.make(id, scenarios=given(options.training), **common)
        training = Watched(made, 3 * options.steps, shown)
        begun = time.perf_counter()
        agent = train(training, options.steps, options.seed)
        trained = time.perf_counter() - begun
        best = search(training, options.steps, options.seed)
        evolved = evolve(training, options.steps, options.seed)
    held_out = gym.make(id, scenarios=given(options.testing), **common)
    generator = np.random.default_rng([options.seed, 1])  # Not the draws of random search.
    shape = held_out.action_space.shape
    policies: dict[str, Policy] = {
        "random": lambda seen, query: generator.uniform(-1.0, 1.0, shape).astype(np.float32),
        "random_search": lambda seen, query: best[query % len(best)],
        "cma_es": lambda seen, query: evolved[query % len(evolved)],
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
        "training_seconds": round(trained, 1),
    }


def given(text: str) -> Any:
    """A name, or a dictionary as JSON."""
    return json.loads(text) if text.startswith("{") else text


def enough(text: str) -> int:
    """Training queries, so many that both searches try something."""
    if int(text) < FEWEST_STEPS:
        raise argparse.ArgumentTypeError(f"{FEWEST_STEPS} queries or more, got {text}")
    return int(text)


def arguments(description: str) -> argparse.ArgumentParser:
    """The options of both examples."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--detector", default="dsgn", help="name, or JSON with its arguments")
    parser.add_argument("--threshold", type=float, default=0.3, help="of the detector's scores")
    parser.add_argument("--steps", type=enough, default=1000, help="training queries")
    parser.add_argument("--held-out", type=int, default=30, help="episodes or scenes to judge by")
    parser.add_argument("--seed", type=int, default=0)
    for name, split in (("training", "train"), ("testing", "val")):
        scenes = json.dumps({"source": "mixed", "split": split})
        parser.add_argument(f"--{name}", default=scenes, help="suite, folder, or JSON")
    return parser


def main() -> None:
    """Train, evaluate, print JSON."""
    parser = arguments(__doc__.splitlines()[0])
    parser.add_argument("--epsilon", type=int, default=8, help="grey levels")
    options = parser.parse_args()
    result = compare("avsec/PerturbationAttack-v0", options, epsilon=options.epsilon)
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
