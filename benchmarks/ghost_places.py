"""What it takes to win `avsec/GhostObject-v0` and `-v1` at the first query; prints JSON.

    python benchmarks/ghost_places.py                             # procedural layouts
    python benchmarks/ghost_places.py --scenarios SCENARIOS       # and on labelled scenarios
    python benchmarks/ghost_places.py --agents 0 --episodes 200 --held-out 200   # rules, smaller

Rules are chosen on training layouts, with 5,000 evaluations each where there is something to
search, and judged on held-out ones, as PPO agents are.  An evaluation is the success of one rule
over all training episodes.  Of v1:

- `constant`, `constant_by_intention`: an action without looking.  Its highest number names a place
  by its index, so all of them are tried.
- `nearest`, ...: the place that is the first by one measure.
- `point`, `point_by_intention`: the place nearest to one point, the best of a grid and of CMA-ES.
- `spot_table`: a score for each spot, road type and intention, fitted to the training episodes:
  everything that there is to know without the objects, much more than a constant.
- `random`, `oracle` (all places tried).

Intervals are Wilson's, 95 %, widened by what episodes of one scene have in common; those of `ppo`
are of all its seeds' episodes together.  `ppo_above_spot_table` is the difference of the rates in
the same episodes, with a bootstrap over scenes.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

import avsec_gym
from avsec_gym.agents.place_policy import PlacePolicy
from avsec_gym.agents.place_rules import (
    ID,
    NEAREST,
    Scores,
    constants,
    played,
    points,
    spot_table,
    success,
)
from avsec_gym.envs.sb3 import StableBaselinesVecEnv
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.paired_scores import paired_difference

TRAINING = {"name": "layouts", "seed": 0, "count": 400}
HELD_OUT = {"name": "layouts", "seed": 7, "count": 3000}
INTENTIONS = slice(2, 5)
WALLS = np.array([[-0.1, 0.2], [-0.3, 0.1], [-0.5, -0.1]])
"""Where two ghosts of v0 stand, y in action units, for left, straight and right."""


def rate(won: np.ndarray, scenario: np.ndarray, **more: Any) -> dict[str, Any]:
    """Of episodes, shape (B,) or (B, C) of C agents, and the scene of each."""
    share = share_of(won, scenario.tolist())
    interval = [round(bound, 3) for bound in share.interval or ()]
    return {"success_rate": round(share.rate or 0.0, 3), "interval": interval, **more}


def above(won: np.ndarray, others: np.ndarray, scenario: np.ndarray) -> dict[str, Any]:
    """How much more often C agents win, shape (C, B), than a rule in the same episodes."""
    scenes = np.tile(scenario, len(won)).tolist()
    found = paired_difference(won.ravel(), np.tile(others, len(won)), scenes)
    interval = [round(bound, 3) for bound in found.interval or ()]
    return {"difference": round(found.difference, 3), "interval": interval}


def scenes_of(scenarios: Any, count: int, seed: int) -> np.ndarray:
    """The scene of each episode, shape (count,), in the order of `played`."""
    return gym.make_vec(ID, num_envs=count, scenarios=scenarios).reset(seed=seed)[1]["scenario"]


def version_1(options: argparse.Namespace, sets: dict[str, Any]) -> dict[str, Any]:
    """Rules and agents of v1, chosen and trained once, judged on each set of scenes."""
    # Each agent learns in a process of its own, beside the search for rules.
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        trained = pool.map(parameters, range(options.agents), repeat(options.steps))
        judged = {
            name: played({"scenarios": own}, options.held_out, 20) for name, own in sets.items()
        }
        training = played({"scenarios": TRAINING}, options.episodes, 10)
        rules = {**dict(constants(training)), **NEAREST, **dict(points(training))}
        table, generator = spot_table(training), np.random.default_rng(0)
        agents = [learner(weights) for weights in trained]
    result: dict[str, Any] = {}
    for name, held_out in judged.items():
        won = np.array([success(agent, held_out) for agent in agents])
        scenes = scenes_of(sets[name], options.held_out, 20)
        by_seed = [round(float(own.mean()), 3) for own in won]
        by_table = success(table, held_out)
        result[name] = {
            "random": rate(success(lambda e: generator.random(e.won.shape), held_out), scenes),
            "oracle": rate(held_out.won.any(axis=1), scenes),
            "rules": {
                rule: rate(success(scores, held_out), scenes) for rule, scores in rules.items()
            },
            "spot_table": rate(by_table, scenes),
        }
        if len(won):
            result[name]["ppo"] = rate(won.T, scenes, by_seed=by_seed)
            result[name]["ppo_above_spot_table"] = above(won, by_table, scenes)
    return result


def agent_for(seed: int) -> PPO:
    """An agent that has learned nothing yet."""
    envs = StableBaselinesVecEnv(gym.make_vec(ID, num_envs=256, scenarios=TRAINING))
    return PPO(
        PlacePolicy,
        VecMonitor(envs),
        n_steps=8,
        batch_size=512,
        n_epochs=4,
        learning_rate=2e-3,
        gamma=0.0,  # An episode is one step.
        clip_range=0.3,
        ent_coef=0.0,
        policy_kwargs={"log_std_init": -0.7},
        seed=seed,
        device="cpu",
    )


def parameters(seed: int, steps: int) -> dict[str, Any]:
    """What a PPO agent has learned."""
    torch.set_num_threads(1)
    return dict(agent_for(seed).learn(steps).policy.state_dict())


def learner(weights: dict[str, Any]) -> Scores:
    """Scores of places by a trained agent."""
    policy = agent_for(0).policy
    policy.load_state_dict(weights)
    return lambda e: policy.predict(e.observations, deterministic=True)[0]


def version_0(scenarios: Any, count: int) -> dict[str, Any]:
    """Two ghosts at fixed places 10 m ahead, one pair for each intention and one for all."""
    envs = gym.make_vec("avsec/GhostObject-v0", num_envs=count, scenarios=scenarios)

    _, drawn = envs.reset(seed=30)

    def won(y: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        observations, _ = envs.reset(seed=30)
        pairs = np.full((count, 2, 4), [1.0, -1.0, 0.0, 0.0], np.float32)
        pairs[:, :, 2] = y(observations[:, INTENTIONS].argmax(axis=1))
        return np.asarray(envs.step(pairs.reshape(count, 8))[-1]["is_success"], bool)

    single = {str(pair.tolist()): won(lambda _, p=pair: p).mean() for pair in WALLS}  # type: ignore[misc]
    return {
        "episodes": count,
        "pair_by_intention": rate(won(lambda intention: WALLS[intention]), drawn["scenario"]),
        "one_pair_for_all": {name: round(float(share), 3) for name, share in single.items()},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--episodes", type=int, default=1200, help="to search on")
    parser.add_argument("--held-out", type=int, default=6000, help="episodes to judge by")
    parser.add_argument("--agents", type=int, default=3, help="PPO agents, a seed each")
    parser.add_argument("--steps", type=int, default=80_000, help="training steps of each")
    parser.add_argument("--jobs", type=int, default=3, help="agents that learn at once")
    parser.add_argument("--scenarios", help="a scenario set to judge by, beside layouts")
    options = parser.parse_args()
    gym.register_envs(avsec_gym)
    torch.set_num_threads(1)
    sets: dict[str, Any] = {"layouts": HELD_OUT}
    if options.scenarios is not None:
        sets[Path(options.scenarios).name] = options.scenarios
    result = {
        "episodes": options.episodes,
        "held_out_episodes": options.held_out,
        "agents": options.agents,
        "training_steps": options.steps,
        "v0": {name: version_0(own, min(options.episodes, 600)) for name, own in sets.items()},
        "v1": version_1(options, sets),
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
