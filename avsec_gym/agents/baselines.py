"""The baselines of an environment: random actions, what is searched, and its own rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator

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

SEARCHES = 4
"""The searches of every environment: two of constants, two of the network's parameters."""


def number_of_baselines(env: str) -> int:
    """How many baselines an environment has.

    Args:
        env: The environment's id.
    """
    return 1 + SEARCHES + NUMBER.get(env, 0)


def baselines_of(
    agent: TrainedAgent, training: Arena, steps: int, seed: int, on_steps: Callable[[int], None]
) -> Iterator[Baseline]:
    """The baselines that an agent is held against, each searched when it is asked for.

    Args:
        agent: An agent, whose network is searched without its learning.
        training: The training scenes.
        steps: Environment steps that each search may take.
        seed: Seed of the searches.
        on_steps: Function that gets the steps of each trial.
    """
    space = training.environment.action_space
    yield Baseline.everywhere("random actions", random_actions(space, seed), 0)
    for by_intention in (False, True):
        budget = SearchBudget(training, steps, seed, on_steps, first_query=True)
        act = best_constant(budget, space, by_intention=by_intention)
        name = f"constant{', by intention' if by_intention else ''}"
        yield Baseline.everywhere(name, act, budget.spent)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        policy = make_policy(agent.configuration, training.environment)
    for name, search in (
        ("random search of the network", random_parameters),
        ("CMA-ES of the network", evolved_parameters),
    ):
        budget = SearchBudget(training, steps, seed, on_steps)
        act = search(budget, policy)
        yield Baseline.everywhere(name, act, budget.spent)
    yield from rules_of(agent.configuration.env, training, steps)
