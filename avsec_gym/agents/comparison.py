"""Agents beside their environment's baselines, in the same held-out episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.agents.agent_folder import TrainedAgent
from avsec_gym.agents.arena import Arena
from avsec_gym.agents.baselines import SEARCHES, number_of_baselines
from avsec_gym.agents.compared_agent import (
    ComparedAgent,
    PooledTrainings,
    difference,
    improvement,
)
from avsec_gym.agents.judged_episodes import JudgedEpisodes, act_of
from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.paired_scores import PairedDifference
from avsec_gym.progress import Progress, no_progress


@dataclass(frozen=True, eq=False)
class AgentComparison:
    """All rows, and the conclusions from them.

    Args:
        env: The environment's id.
        budget: Environment steps that each baseline was searched with.
        rows: The agents first.
        pools: Trainings of one configuration with different seeds.
    """

    env: str
    budget: int
    rows: list[ComparedAgent]
    pools: tuple[PooledTrainings, ...] = ()

    @property
    def best_baseline(self) -> ComparedAgent:
        """The baseline with the highest success rate in training episodes.

        Of equal ones that with the highest reward there.  The held-out episodes choose nothing.
        """
        return max(self.baselines, key=lambda row: row.in_training)

    @property
    def baselines(self) -> list[ComparedAgent]:
        """All rows that are no agent's."""
        return [row for row in self.rows if row.kind == "baseline"]

    def against_best(self, row: ComparedAgent) -> PairedDifference:
        """A row less the best baseline, paired."""
        return difference([row], self.best_baseline)

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
        best = self.best_baseline
        return {
            "env": self.env,
            "budget": self.budget,
            "rows": [row.to_json() for row in self.rows],
            "best_baseline": best.name,
            "against_best_baseline": [
                {
                    "agent": row.name,
                    "difference": (found := self.against_best(row)).difference,
                    "interval": found.interval and list(found.interval),
                    "mcnemar_p": found.p,
                    **improvement([row], best).columns("probability_of_improvement"),
                    "answer": self.answer(row),
                }
                for row in self.rows
                if row.kind == "agent"
            ],
            "pooled": [pool.to_json(best, self.baselines) for pool in self.pools],
        }


def held_out_result(agent: TrainedAgent, episodes: int, seed: int) -> dict[str, Any]:
    """What an agent's card holds of the held-out episodes."""
    arena = Arena(agent.configuration.env, agent.configuration.held_out_kwargs)
    played = arena.play(act_of(agent), range(seed, seed + episodes))
    arena.close()
    facts = ComparedAgent(agent.name, played, agent.card.steps).to_json()
    kept = ("episodes", "success_rate", "success_interval", "reward")
    return {"first_seed": seed} | {name: facts[name] for name in kept}


def compare(
    agents: Sequence[TrainedAgent],
    episodes: int,
    seed: int,
    queries: int | None = None,
    on_progress: Progress = no_progress,
) -> AgentComparison:
    """Judge agents and baselines in the same held-out episodes.

    Args:
        agents: Agents of one environment, with the same arguments.
        episodes: Held-out episodes, and training episodes in which the best baseline is chosen.
        seed: Seed of the first held-out one; episode k has the seed ``seed + k``.
        queries: Environment steps that each baseline is searched with; None: as many as the agent
            learned from that learned longest.
        on_progress: Function that gets environment steps done, and about how many there are in all.

    Raises:
        ConfigurationError: The agents are of several environments.
    """
    _check_environments(agents)
    # Baselines are searched with as many steps as the agents had.
    budget = max(agent.card.steps for agent in agents) if queries is None else queries
    return _compared({budget: agents}, episodes, seed, on_progress)[0]


def compare_at_budgets(
    agents: Sequence[TrainedAgent],
    budgets: Sequence[int],
    episodes: int,
    seed: int,
    on_progress: Progress = no_progress,
) -> list[AgentComparison]:
    """A comparison for each budget of environment steps, with the agents that kept to it.

    An agent belongs to the smallest budget that it learned no more from; baselines are searched
    with the whole of it.

    Args:
        agents: Agents of one environment, with the same arguments.
        budgets: Environment steps.
        episodes: The number of episodes, as in `compare`.
        seed: The seed, as in `compare`.
        on_progress: Function of the progress, as in `compare`.

    Returns:
        The comparisons, the smallest budget first.

    Raises:
        ConfigurationError: The agents are of several environments, one learned from more than the
            largest budget, or a budget has no agent.
    """
    _check_environments(agents)
    return _compared(_by_budget(agents, budgets), episodes, seed, on_progress)


def pooled(
    agents: Sequence[TrainedAgent], rows: Sequence[ComparedAgent]
) -> tuple[PooledTrainings, ...]:
    """Trainings that differ in nothing but the seed, two of them or more; of a seed the first one.

    Args:
        agents: The agents.
        rows: How each of them played.
    """
    groups: dict[tuple[str, str], dict[int, ComparedAgent]] = {}
    for agent, row in zip(agents, rows, strict=True):
        configuration = agent.configuration
        # Agents that learned longer are others, whatever their entries ask for.
        entry = configuration.entry() | {"n_timesteps": agent.card.steps}
        group = groups.setdefault((configuration.algorithm, repr(sorted(entry.items()))), {})
        group.setdefault(agent.card.seed, row)
    return tuple(
        PooledTrainings(f"{algorithm}, {len(group)} seeds", tuple(group), tuple(group.values()))
        for (algorithm, _), group in groups.items()
        if len(group) > 1
    )


def _by_budget(
    agents: Sequence[TrainedAgent], budgets: Sequence[int]
) -> dict[int, list[TrainedAgent]]:
    """The agents of each budget, the smallest budget first."""
    found: dict[int, list[TrainedAgent]] = {budget: [] for budget in sorted(budgets)}
    for agent in agents:
        enough = [budget for budget in found if budget >= agent.card.steps]
        if not enough:
            raise ConfigurationError(
                f"{agent.name} learned from {agent.card.steps:,} steps, more than the largest of"
                f" --budgets, {max(budgets):,}: add a larger one, or train one by --steps, with"
                " rollouts (n_envs x n_steps) that fit into it"
            )
        found[enough[0]].append(agent)
    for budget, own in found.items():
        if not own:
            raise ConfigurationError(
                f"no agent belongs to the budget {budget:,}: train one by `avsec agents train"
                f" --steps {budget}`, or leave it out of --budgets"
            )
    return found


def _check_environments(agents: Sequence[TrainedAgent]) -> None:
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


def _compared(
    agents_of: Mapping[int, Sequence[TrainedAgent]],
    episodes: int,
    seed: int,
    on_progress: Progress,
) -> list[AgentComparison]:
    """A comparison for each budget; scenes and what was computed of them are kept in between."""
    configuration = next(iter(agents_of.values()))[0].configuration
    env = configuration.env
    judged = JudgedEpisodes.of(configuration, episodes, seed)
    longest = judged.held_out.steps_of_an_episode
    # Each baseline plays as many training episodes as held-out ones.
    total = sum(
        SEARCHES * budget + (len(agents) + 2 * number_of_baselines(env)) * episodes * longest
        for budget, agents in agents_of.items()
    )
    meter = _Meter(total, on_progress)
    found = []
    for budget, agents in agents_of.items():
        # All play the same episodes, the agents first.
        rows = judged.of_agents(agents, meter)
        pools = pooled(agents, rows)
        rows += judged.of_baselines(agents[0], budget, meter)
        found.append(AgentComparison(env, budget, rows, pools))
    judged.close()
    return found


class _Meter:
    """Adds steps up."""

    def __init__(self, total: int, shown: Progress) -> None:
        self._done, self._total, self._shown = 0, total, shown

    def __call__(self, steps: int) -> None:
        self._done = min(self._done + steps, self._total)
        self._shown(self._done, self._total)
