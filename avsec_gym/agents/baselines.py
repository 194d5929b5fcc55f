"""The baselines of an environment: random actions, what is searched, and its own rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import torch

from avsec_gym.agents.agent_folder import TrainedAgent
from avsec_gym.agents.arena import Arena, Baseline
from avsec_gym.agents.learner import make_policy
from avsec_gym.agents.rules import NUMBER, rules_of
from avsec_gym.agents.search import (
    SearchBudget,
    best_constant,
    evolved_parameters,
    random_actions,
    random_parameters,
)

RANDOM, RULES = "random actions", "rules"
CONSTANTS = {"constant": False, "constant, by intention": True}
"""The searches of a constant: whether each driving intention has its own."""
NETWORKS = {
    "random search of the network": random_parameters,
    "CMA-ES of the network": evolved_parameters,
}
"""The searches of the agent's own network."""
GROUPS = (RANDOM, *CONSTANTS, *NETWORKS, RULES)
"""The baselines, in their order; the last group has as many as the environment has rules."""
SEARCHES = len(CONSTANTS) + len(NETWORKS)
"""The searches of every environment."""


def number_of_baselines(env: str) -> int:
    """How many baselines an environment has.

    Args:
        env: The environment's id.
    """
    return 1 + SEARCHES + NUMBER.get(env, 0)


def baselines_of(
    agent: TrainedAgent,
    training: Arena,
    steps: int,
    seed: int,
    on_steps: Callable[[int], None] = lambda steps: None,
    groups: Sequence[str] = GROUPS,
) -> Iterator[Baseline]:
    """The baselines that an agent is held against, each searched when it is asked for.

    None depends on those before it, so that groups can be searched apart from each other.

    Args:
        agent: An agent, whose network is searched without its learning.
        training: The training scenes.
        steps: Environment steps that each search may take.
        seed: Seed of the searches.
        on_steps: Function that gets the steps of each trial.
        groups: Some of `GROUPS`.
    """
    space = training.environment.action_space
    for group in groups:
        if group == RANDOM:
            yield Baseline.everywhere(group, random_actions(space, seed), 0)
        elif group in CONSTANTS:
            budget = SearchBudget(training, steps, seed, on_steps, first_query=True)
            act = best_constant(budget, space, by_intention=CONSTANTS[group])
            yield Baseline.everywhere(group, act, budget.spent)
        elif group in NETWORKS:
            with torch.random.fork_rng(devices=[]):
                torch.manual_seed(seed)
                policy = make_policy(agent.configuration, training.environment)
            budget = SearchBudget(training, steps, seed, on_steps)
            yield Baseline.everywhere(group, NETWORKS[group](budget, policy), budget.spent)
        else:
            yield from rules_of(agent.configuration.env, training, steps)
