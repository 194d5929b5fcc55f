"""Agents beside their environment's baselines, in the same held-out episodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import torch

from avsec_gym.agents.agent_folder import TrainedAgent
from avsec_gym.agents.arena import Act, Arena, Played
from avsec_gym.agents.learner import make_policy
from avsec_gym.agents.rules import NUMBER, rules_of
from avsec_gym.agents.search import (
    SearchBudget,
    best_constant,
    evolved_parameters,
    random_actions,
    random_parameters,
)
from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.interquartile_mean import interquartile_interval, interquartile_mean
from avsec_gym.metrics.paired_scores import PairedDifference, paired_difference

BLOCK = 20
"""Held-out episodes that make a score: their success rate."""

_SEARCHES = 4
"""The searches of every environment: two of constants, two of the network's parameters."""


@dataclass(frozen=True, eq=False)
class ComparedAgent:
    """One agent or baseline.

    Args:
        name: The name of the player.
        kind: ``agent`` or ``baseline``.
        played: The results of its held-out episodes.
        queries: Environment steps that it learned from, or was searched with.
    """

    name: str
    kind: str
    played: Played
    queries: int

    @property
    def rate(self) -> float:
        """The success rate."""
        return float(self.played.success.mean())

    @property
    def share(self) -> Share:
        """The successes; episodes of one scene are a cluster of the interval."""
        return share_of(self.played.success, self.played.scenario.tolist())

    @property
    def scores(self) -> Any:
        """The success rate of each block of episodes; of fewer than a block, of each episode."""
        won = self.played.success.astype(float)
        whole = len(won) // BLOCK * BLOCK
        return won[:whole].reshape(-1, BLOCK).mean(axis=1) if whole else won

    def to_json(self) -> dict[str, Any]:
        """Rates, means and their 95 % intervals."""
        return {
            "name": self.name,
            "kind": self.kind,
            "queries": self.queries,
            "episodes": len(self.played.success),
            "success_rate": self.rate,
            "success_interval": list(self.share.interval or ()) or None,
            "interquartile_mean": float(interquartile_mean(self.scores)),
            "interquartile_interval": list(interquartile_interval([self.scores])),
            "reward": float(self.played.reward.mean()),
        }


@dataclass(frozen=True, eq=False)
class AgentComparison:
    """All rows, and the conclusions from them.

    Args:
        env: The environment's id.
        rows: The agents first.
    """

    env: str
    rows: list[ComparedAgent]

    @property
    def best_baseline(self) -> ComparedAgent:
        """The baseline with the highest success rate in the held-out episodes."""
        return max((row for row in self.rows if row.kind == "baseline"), key=lambda row: row.rate)

    def against_best(self, row: ComparedAgent) -> PairedDifference:
        """A row less the best baseline, paired."""
        best = self.best_baseline.played
        return paired_difference(row.played.success, best.success, best.scenario.tolist())

    def answer(self, row: ComparedAgent) -> str:
        """Who wins: a sentence about an agent."""
        found, other = self.against_best(row), self.best_baseline
        points = f"{100 * found.difference:+.1f} points"
        if found.interval is None:
            return f"one scene does not tell {row.name} and {other.name} apart: {points}"
        low, high = found.interval
        points += f" ({100 * low:+.1f} to {100 * high:+.1f})"
        if low > 0:
            return f"{row.name} wins against the best baseline, {other.name}: {points}"
        if high < 0:
            return f"{other.name} wins against {row.name}: {points} for the agent"
        return f"undecided between {row.name} and the best baseline, {other.name}: {points}"

    def to_json(self) -> dict[str, Any]:
        """All of it."""
        agents = [row for row in self.rows if row.kind == "agent"]
        return {
            "env": self.env,
            "rows": [row.to_json() for row in self.rows],
            "best_baseline": self.best_baseline.name,
            "against_best_baseline": [
                {
                    "agent": row.name,
                    "difference": (found := self.against_best(row)).difference,
                    "interval": found.interval and list(found.interval),
                    "mcnemar_p": found.p,
                    "answer": self.answer(row),
                }
                for row in agents
            ],
        }


def held_out_result(agent: TrainedAgent, episodes: int, seed: int) -> dict[str, Any]:
    """What an agent's card holds of the held-out episodes."""
    arena = Arena(agent.configuration.env, agent.configuration.held_out_kwargs)
    played = arena.play(_of(agent), range(seed, seed + episodes))
    arena.close()
    facts = ComparedAgent(agent.name, "agent", played, agent.card.steps).to_json()
    kept = ("episodes", "success_rate", "success_interval", "reward")
    return {"first_seed": seed} | {name: facts[name] for name in kept}


def compare(
    agents: Sequence[TrainedAgent],
    episodes: int,
    seed: int,
    queries: int | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> AgentComparison:
    """Judge agents and baselines in the same held-out episodes.

    Args:
        agents: Agents of one environment, with the same arguments.
        episodes: Held-out episodes.
        seed: Seed of the first one; episode k has the seed ``seed + k``.
        queries: Environment steps that each baseline is searched with; None: as many as the agent
            learned from that learned longest.
        on_progress: Called with environment steps done, and about how many there are in all.

    Raises:
        ConfigurationError: The agents are of several environments.
    """
    configuration = agents[0].configuration
    for other in agents[1:]:
        theirs = other.configuration
        if (theirs.env, theirs.env_kwargs, theirs.eval_env_kwargs) != (
            configuration.env,
            configuration.env_kwargs,
            configuration.eval_env_kwargs,
        ):
            raise ConfigurationError(
                f"{other.name} and {agents[0].name} are agents of different environments: compare"
                " them one by one"
            )
    # Baselines are searched with as many steps as the agents had.
    budget = max(agent.card.steps for agent in agents) if queries is None else queries
    env = configuration.env
    held_out = Arena(env, configuration.held_out_kwargs)
    training = Arena(env, configuration.env_kwargs)
    longest = held_out.environment.spec.max_episode_steps or 1  # type: ignore[union-attr]
    rows_in_all = len(agents) + 1 + _SEARCHES + NUMBER.get(env, 0)
    meter = _Meter(_SEARCHES * budget + rows_in_all * episodes * longest, on_progress)

    def judged(name: str, kind: str, act: Act, spent: int) -> ComparedAgent:
        played = held_out.play(
            act, range(seed, seed + episodes), lambda episodes: meter(episodes * longest)
        )
        return ComparedAgent(name, kind, played, spent)

    # All play the same episodes, the agents first.
    rows = [judged(agent.name, "agent", _of(agent), agent.card.steps) for agent in agents]
    rows += [
        judged(name, "baseline", act, spent)
        for name, act, spent in (
            *_searched(agents[0], training, budget, seed, meter),
            *rules_of(env, training, held_out, budget),
        )
    ]
    for arena in (held_out, training):
        arena.close()
    return AgentComparison(env, rows)


class _Meter:
    """Adds steps up."""

    def __init__(self, total: int, shown: Callable[[int, int], None]) -> None:
        self._done, self._total, self._shown = 0, total, shown

    def __call__(self, steps: int) -> None:
        self._done = min(self._done + steps, self._total)
        self._shown(self._done, self._total)


def _searched(
    agent: TrainedAgent, training: Arena, steps: int, seed: int, meter: Callable[[int], None]
) -> Iterator[tuple[str, Act, int]]:
    """Name, rule, and environment steps that finding it took."""
    space = training.environment.action_space
    yield "random actions", random_actions(space, seed), 0
    for by_intention in (False, True):
        budget = SearchBudget(training, steps, seed, meter, first_query=True)
        act = best_constant(budget, space, by_intention=by_intention)
        yield f"constant{', by intention' if by_intention else ''}", act, budget.spent
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        policy = make_policy(agent.configuration, training.environment)
    for name, search in (
        ("random search of the network", random_parameters),
        ("CMA-ES of the network", evolved_parameters),
    ):
        budget = SearchBudget(training, steps, seed, meter)
        yield name, search(budget, policy), budget.spent


def _of(agent: TrainedAgent) -> Act:
    return lambda seen, ways: agent.predict(seen)[0]
