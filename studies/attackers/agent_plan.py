"""What is trained and judged: an entry at some budgets, with some seeds, in the same episodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.agents.agent_folder import CARD, TrainedAgent, load_agent, read_agent_card
from avsec_gym.agents.baselines import GROUPS
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_file

_ROLLOUTS = 16
"""Rollouts that a training has at least, where fewer environments side by side allow it."""
_BATCH = 64
"""Steps of a batch, which small rollouts are not divided below."""


@dataclass(frozen=True)
class Part:
    """Something that is done, and kept, by itself.

    Args:
        budget: Environment steps.
        who: The seed of an agent, or one of `GROUPS`, a group of baselines.
    """

    budget: int
    who: int | str

    @property
    def name(self) -> str:
        """A name of a file."""
        who = f"seed_{self.who}" if isinstance(self.who, int) else self.who
        return f"{self.budget}_{who.replace(', ', '_').replace(' ', '_')}"


@dataclass(frozen=True)
class AgentPlan:
    """A comparison at several budgets.

    Args:
        entry: The configuration, whose environments and batches are fitted to each budget.
        budgets: Environment steps that an agent learns from, and a search takes.
        seeds: The number of trainings at each budget.
        episodes: Held-out episodes, and training episodes in which the best baseline is chosen.
        folder: Where agents and finished parts are kept.
    """

    entry: AgentConfiguration
    budgets: tuple[int, ...]
    seeds: int
    episodes: int
    folder: Path

    def __post_init__(self) -> None:
        if self.seeds < 2:
            raise ConfigurationError("seeds are pooled: two trainings or more at each budget")
        for budget in self.budgets:
            own = fitted(self.entry, budget)
            rollout = own.n_envs * int(own.arguments.get("n_steps", 1))
            if budget % rollout:
                raise ConfigurationError(
                    f"a budget is whole rollouts, and {budget:,} is not a multiple of {rollout:,}"
                )

    @property
    def trainings(self) -> list[Part]:
        """The agents, those that take longest first."""
        budgets = sorted(self.budgets, reverse=True)
        return [Part(budget, seed) for budget in budgets for seed in range(self.seeds)]

    @property
    def parts(self) -> list[Part]:
        """All that is judged, in the order of the rows, those that take longest first."""
        budgets = sorted(self.budgets, reverse=True)
        rows = (*range(self.seeds), *GROUPS)
        return [Part(budget, who) for budget in budgets for who in rows]

    def agent_folder(self, part: Part) -> Path:
        """The folder of an agent."""
        return self.folder / f"{self.entry.algorithm}_{part.budget}_{part.who}"

    def is_trained(self, part: Part) -> bool:
        """Whether an agent has learned from its whole budget, by the entry as it is now."""
        folder = self.agent_folder(part)
        if not is_file(folder / CARD):
            return False
        card, own = read_agent_card(folder), fitted(self.entry, part.budget)
        if (card.env_kwargs, card.eval_env_kwargs) != (own.env_kwargs, own.eval_env_kwargs):
            raise DataError(
                "An agent of other scenes or arguments is here.",
                path=folder,
                remedy="Name another --runs, or remove the folder.",
            )
        return card.finished and card.steps >= part.budget

    def agent(self, part: Part) -> TrainedAgent:
        """A trained agent, named by how and with which seed it learned."""
        name = f"{self.entry.algorithm}, seed {part.who}"
        return replace(load_agent(self.agent_folder(part)), name=name)

    def untrained(self, budget: int) -> TrainedAgent:
        """The agent whose network is searched: the first one of a budget."""
        return self.agent(Part(budget, 0))

    def asked(self, part: Part) -> dict[str, Any]:
        """What a part's result depends on; what is kept of another one is made anew."""
        found = {
            "env": self.entry.env,
            "algorithm": self.entry.algorithm,
            "entry": fitted(self.entry, part.budget).entry(),
            "episodes": self.episodes,
        }
        if isinstance(part.who, int):
            found["weights"] = read_agent_card(self.agent_folder(part)).sha256
        return found


def fitted(entry: AgentConfiguration, budget: int) -> AgentConfiguration:
    """An entry for a budget: fewer environments side by side where the budget is small.

    Args:
        entry: The configuration.
        budget: Environment steps that an agent learns from.

    Returns:
        The same, with rollouts of a sixteenth of the budget at most, as far as a single environment
        allows, and with batches in proportion; random actions at the beginning take a quarter of
        the budget at most.
    """
    arguments: dict[str, Any] = dict(entry.arguments)
    count = entry.n_envs
    if "n_steps" in arguments:
        steps = int(arguments["n_steps"])
        count = int(np.clip(budget // (_ROLLOUTS * steps), 1, entry.n_envs))
        in_proportion = int(arguments.get("batch_size", _BATCH)) * count // entry.n_envs
        arguments["batch_size"] = max(in_proportion, min(_BATCH, count * steps))
    if "learning_starts" in arguments:
        arguments["learning_starts"] = min(int(arguments["learning_starts"]), budget // 4)
    return replace(entry, n_timesteps=budget, n_envs=count, arguments=arguments)


def in_scenes(entry: AgentConfiguration, learned: str, held_out: str) -> AgentConfiguration:
    """An entry with other scenes: contested ones, where its environment has such.

    Args:
        entry: The configuration.
        learned: The folder of the scenes to learn in.
        held_out: The folder of the scenes to be judged by.
    """
    # Connected vehicles are attacked in every instant: none is contested.
    chosen = {} if "Connected" in entry.env else {"contested": True}
    return replace(
        entry,
        env_kwargs=entry.env_kwargs | {"scenarios": {"source": learned, **chosen}},
        eval_env_kwargs=entry.eval_env_kwargs | {"scenarios": {"source": held_out, **chosen}},
    )


def rows_in_order(plan: AgentPlan, budget: int) -> Iterator[Part]:
    """The parts of a budget, the agents first."""
    yield from (part for part in plan.parts if part.budget == budget)
