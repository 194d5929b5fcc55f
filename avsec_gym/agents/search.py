"""Baselines that are searched with as many environment steps as an agent learns from.

A candidate is a vector: an action for every situation, one for each driving intention, or the
parameters of the agent's own network.  It is tried on training episodes, and what it earns there
decides; the held-out scenes are never looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np

from avsec_gym.agents.arena import Act, Arena, Played
from avsec_gym.agents.extras import cma_module
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.intention import Intention

_TRIALS = 64
"""Training episodes that a candidate is tried on, fewer where the budget is small."""
_LEVELS = (-1.0, -0.5, 0.0, 0.5, 1.0)
_SPREAD = 0.5
_LARGEST_GRID = 125
_FINALISTS = 3
_KIND = {str(intention): index for index, intention in enumerate(Intention)}

Policy = Callable[[Floats], Act]
"""A function from a vector to what acts by it."""


@dataclass
class SearchBudget:
    """Environment steps that a search may take.

    Args:
        arena: The training scenes.
        steps: Steps in all.
        seed: Seed of the episodes and of the search.
        on_steps: Function that gets the steps of each trial.
        first_query: Whether candidates are tried at the first query of an episode alone: where the
            same action again has the same answer, the others would be wasted.
        candidates: How many the steps should last for: the fewer, the more episodes for each.
    """

    arena: Arena
    steps: int
    seed: int
    on_steps: Callable[[int], None] = lambda steps: None
    first_query: bool = False
    candidates: int = 256
    spent: int = 0
    trials: int = field(init=False)
    dearest: int = field(init=False)
    """Steps that a trial takes at most, or took so far."""

    def __post_init__(self) -> None:
        limit = self.arena.longest_episode
        # Without a limit, an episode is a drive: an action goes on having effects.
        self.first_query &= limit is not None
        longest = 1 if self.first_query else self.arena.steps_of_an_episode
        self.trials = int(np.clip(self.steps // (self.candidates * longest), 1, _TRIALS))
        self.dearest = self.trials * longest

    def leaves(self, candidates: int) -> bool:
        """Whether so many more candidates can be tried."""
        return self.spent + candidates * self.dearest <= self.steps

    def tried(self, act: Act) -> float:
        """The mean reward in training episodes, the same ones for every candidate."""
        return float(self.played(act).reward.mean())

    def played(self, act: Act) -> Played:
        """The training episodes of `tried`."""
        most = 1 if self.first_query else None
        first = first_training_seed(self.seed)
        played = self.arena.play(act, range(first, first + self.trials), most_steps=most)
        taken = int(played.steps.sum())
        self.spent, self.dearest = self.spent + taken, max(self.dearest, taken)
        self.on_steps(taken)
        return played


def first_training_seed(seed: int) -> int:
    """The seed of a search's first training episode.

    Far from those of the held-out ones, which begin at 0.

    Args:
        seed: The seed of the search.
    """
    return 1_000_000 * (1 + seed)


def choice_seeds(seed: int, episodes: int) -> range:
    """Seeds of the training episodes in which the best baseline is chosen.

    None is one of those that candidates are tried on: there the searched ones look better than
    they are.

    Args:
        seed: The seed of the searches.
        episodes: Number of episodes.
    """
    first = first_training_seed(seed) + _TRIALS
    return range(first, first + episodes)


def best_constant(budget: SearchBudget, space: gym.Space[Any], *, by_intention: bool) -> Act:
    """The action that earns most without looking, or one for each driving intention.

    A grid and random actions take half of the budget; CMA-ES goes on from the best of them.

    Args:
        budget: What the search may take.
        space: The action space.
        by_intention: Whether each driving intention has an action of its own.
    """
    kinds = len(_KIND) if by_intention else 1
    size = _numbers(space)

    def act_by(vector: Floats) -> Act:
        actions = _actions(vector.reshape(kinds, size), space)
        return lambda seen, ways: actions[[_KIND.get(way, 0) % kinds for way in ways]]

    best, earned = np.zeros((kinds, size)), np.full(kinds, -np.inf)
    for point in _points(size, np.random.default_rng(budget.seed)):
        if budget.spent > budget.steps / 2 or not budget.leaves(1):
            break
        played = budget.played(act_by(np.tile(point, kinds)))
        # One trial measures every intention that its episodes have.
        kind = np.array([_KIND.get(way, 0) % kinds for way in played.intention])
        for own in np.unique(kind):
            paid = played.reward[kind == own].mean()
            if paid > earned[own]:
                best[own], earned[own] = point, paid
    return act_by(evolved(budget, act_by, best.ravel()))


def random_parameters(budget: SearchBudget, policy: Any) -> Act:
    """The agent's own network with the best of random parameters.

    Args:
        budget: What the search may take.
        policy: An untrained policy of stable-baselines3.
    """
    start, act_by = _network(policy)
    generator = np.random.default_rng(budget.seed)
    best, earned = start, -np.inf
    while budget.leaves(1):
        candidate = start + generator.normal(0.0, _SPREAD, start.shape)
        paid = budget.tried(act_by(candidate))
        if paid > earned:
            best, earned = candidate, paid
    return act_by(best)


def evolved_parameters(budget: SearchBudget, policy: Any) -> Act:
    """The same with the parameters that CMA-ES finds.

    Of thousands of parameters only their own variances are adapted (Ros and Hansen 2008).
    """
    start, act_by = _network(policy)
    return act_by(evolved(budget, act_by, start, diagonal=True, bounded=False))


def _network(policy: Any) -> tuple[Floats, Policy]:
    """Parameters that a policy's actions depend on, and how it acts with others in their place."""
    import torch
    from torch.nn.utils import parameters_to_vector, vector_to_parameters

    acting = [
        value
        for name, value in policy.named_parameters()
        if not any(word in name for word in ("value", "vf_", "critic", "log_std", "target"))
    ]

    def act_by(vector: Floats) -> Act:
        def act(seen: Any, ways: Any) -> Any:
            vector_to_parameters(torch.tensor(vector, dtype=torch.float32), acting)
            return policy.predict(seen, deterministic=True)[0]

        return act

    return parameters_to_vector(acting).detach().numpy().copy(), act_by


def evolved(
    budget: SearchBudget,
    act_by: Policy,
    start: Floats,
    *,
    diagonal: bool = False,
    bounded: bool = True,
) -> Floats:
    """Where CMA-ES ends, or where it began, whichever earns more (Hansen 2016)."""
    cma = cma_module()
    options: dict[str, Any] = {"seed": budget.seed + 1, "verbose": -9, "CMA_diagonal": diagonal}
    options |= {"tolfun": 0, "tolflatfitness": 10**6, "tolx": 0}
    if bounded:
        options["bounds"] = [-1.0, 1.0]
    if len(start) == 1:  # CMA-ES has no covariance to adapt: a second number does nothing.
        lone = start
        return evolved(budget, lambda v: act_by(v[:1]), np.append(lone, 0.0), diagonal=diagonal)[:1]
    strategy = cma.CMAEvolutionStrategy(start, _SPREAD, options)
    best, earned = start, -np.inf
    while budget.leaves(strategy.popsize + _FINALISTS):
        asked = strategy.ask()
        paid = [budget.tried(act_by(each)) for each in asked]
        strategy.tell(asked, [-each for each in paid])
        if max(paid) > earned:
            best, earned = asked[int(np.argmax(paid))], max(paid)
    # The mean of the last generations, the best that was seen, and the start: noise favours none.
    if not budget.leaves(_FINALISTS):
        return best
    finalists = [start, np.asarray(best), np.asarray(strategy.result.xfavorite)]
    return max(finalists, key=lambda vector: budget.tried(act_by(vector)))


def random_actions(space: gym.Space[Any], seed: int) -> Act:
    """Actions drawn from the whole space."""
    generator = np.random.default_rng(seed)
    size = _numbers(space)
    return lambda seen, ways: _actions(generator.uniform(-1.0, 1.0, (len(ways), size)), space)


def _numbers(space: gym.Space[Any]) -> int:
    """Numbers in [-1, 1] that stand for an action.

    Raises:
        ConfigurationError: Actions are something else.
    """
    if isinstance(space, gym.spaces.Box | gym.spaces.MultiBinary):
        return int(np.prod(space.shape))
    if isinstance(space, gym.spaces.Discrete):
        return int(space.n)
    raise ConfigurationError(f"no baseline is searched for actions such as {space}")


def _actions(vectors: Floats, space: gym.Space[Any]) -> Any:
    """Actions of vectors, shape (B, ...)."""
    if isinstance(space, gym.spaces.Discrete):
        return vectors.argmax(axis=1)
    shaped = vectors.reshape(len(vectors), *(space.shape or ()))
    if isinstance(space, gym.spaces.MultiBinary):
        return (shaped > 0).astype(np.int8)
    return np.clip(shaped, -1.0, 1.0).astype(np.float32)


def _points(size: int, generator: np.random.Generator) -> Iterator[Floats]:
    """All combinations of five levels; of many numbers, one after the other pushed to an end.

    Random points come after them.
    """
    if len(_LEVELS) ** size <= _LARGEST_GRID:
        yield from (np.array(point) for point in product(_LEVELS, repeat=size))
    else:
        yield np.zeros(size)
        for axis, end in product(range(size), (1.0, -1.0)):
            point = np.full(size, -end)
            point[axis] = end
            yield point
    while True:
        yield generator.uniform(-1.0, 1.0, size)
