"""The episodes in which agents and baselines are compared: held-out ones, and those of training."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from avsec_gym.agents.agent_folder import TrainedAgent
from avsec_gym.agents.arena import Act, Arena, Played
from avsec_gym.agents.baselines import GROUPS, baselines_of
from avsec_gym.agents.compared_agent import ComparedAgent
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.agents.search import choice_seeds

OnSteps = Callable[[int], None]
"""A function that gets how many environment steps were taken since its last call."""


@dataclass(frozen=True, eq=False)
class JudgedEpisodes:
    """The episodes that agents and baselines are judged by.

    Args:
        held_out: The held-out scenes.
        training: The training scenes.
        episodes: The number of episodes in either.
        seed: Seed of the first held-out one, and of the searches.
    """

    held_out: Arena
    training: Arena
    episodes: int
    seed: int

    @classmethod
    def of(cls, configuration: AgentConfiguration, episodes: int, seed: int) -> JudgedEpisodes:
        """Those of an entry.

        Args:
            configuration: The entry, which names both sets of scenes.
            episodes: The number of episodes.
            seed: Seed of the first held-out one, and of the searches.
        """
        env = configuration.env
        held_out = Arena(env, configuration.held_out_kwargs)
        return cls(held_out, Arena(env, configuration.env_kwargs), episodes, seed)

    def of_agents(
        self, agents: Sequence[TrainedAgent], on_steps: OnSteps = lambda steps: None
    ) -> list[ComparedAgent]:
        """How agents play the held-out episodes.

        Args:
            agents: Agents of this environment.
            on_steps: Function of the progress.
        """
        return [
            ComparedAgent(agent.name, self._held_out(act_of(agent), on_steps), agent.card.steps)
            for agent in agents
        ]

    def of_baselines(
        self,
        agent: TrainedAgent,
        budget: int,
        on_steps: OnSteps = lambda steps: None,
        groups: Sequence[str] = GROUPS,
    ) -> list[ComparedAgent]:
        """How baselines play them, and as many training episodes.

        Args:
            agent: The agent whose network is searched.
            budget: Environment steps that each search may take.
            on_steps: Function of the progress.
            groups: Some of `GROUPS`.
        """
        found = []
        for baseline in baselines_of(agent, self.training, budget, self.seed, on_steps, groups):
            held_out = self._held_out(baseline.act_in(self.held_out), on_steps)
            chosen = choice_seeds(self.seed, self.episodes)
            training = _played(self.training, baseline.act_in(self.training), chosen, on_steps)
            found.append(ComparedAgent(baseline.name, held_out, baseline.queries, training))
        return found

    def close(self) -> None:
        """Close both environments."""
        self.held_out.close()
        self.training.close()

    def _held_out(self, act: Act, on_steps: OnSteps) -> Played:
        own = range(self.seed, self.seed + self.episodes)
        return _played(self.held_out, act, own, on_steps)


def _played(arena: Arena, act: Act, seeds: range, on_steps: OnSteps) -> Played:
    longest = arena.steps_of_an_episode
    return arena.play(act, seeds, lambda ended: on_steps(ended * longest))


def act_of(agent: TrainedAgent) -> Act:
    """How an agent acts, without exploring."""
    return lambda seen, ways: agent.predict(seen)[0]
