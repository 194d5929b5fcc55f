"""`avsec agents train`, `evaluate` and `list`: agents by configuration, beside their baselines."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from avsec_gym import console
from avsec_gym.argument_checks import thread_number, whole_number
from avsec_gym.errors import ConfigurationError

if TYPE_CHECKING:
    from avsec_gym.agents.agent_folder import AgentCard
    from avsec_gym.agents.comparison import AgentComparison

_MOST_EPISODES = 1_000_000


@dataclass(frozen=True)
class AgentsTrain:
    """Train an agent by a configuration; --out holds weights, config.yml and a card then.

    Exit code 3 where time is up before all steps are done; the agent can be used all the same.
    """

    env: Annotated[str, tyro.conf.Positional]
    """Which environment, such as GhostObject-v1."""
    out: Path
    """Folder of the agent: new or empty, or see --resume."""
    algo: Literal["ppo", "a2c", "sac", "td3", "ddpg", "dqn", "tqc", "trpo"] = "ppo"
    """How it learns; tqc and trpo are sb3-contrib's."""
    config: Path | None = None
    """A file in rl-zoo3's YAML form with an entry for the environment.  Default: the package's."""
    variant: str | None = None
    """Which other game of the package's configurations: images (policies that see the camera's
    image), defender (a driver under attack), low_frequency (perturbations of long waves),
    surrogate (perturbations along another detector's gradients) or aimed (small spots of light, PPO
    alone).  Default: the usual one."""
    steps: int | None = None
    """Environment steps to learn from, all sittings together.  Default: the entry's n_timesteps."""
    minutes: float | None = None
    """Time of this sitting at most; the steps in hand are still learned from.  Default: until all
    steps are done."""
    seed: int = 0
    """Seed of weights, exploration and training episodes."""
    resume: bool = False
    """Go on with the training in --out, or begin it."""
    episodes: int = 200
    """Held-out episodes that the card's success rate is measured in; 0: none."""
    threads: int = 1
    """Threads of the processor."""
    json: bool = False
    """Print the card as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.agents.agent_folder import load_agent, write_agent_card
        from avsec_gym.agents.comparison import held_out_result
        from avsec_gym.agents.configuration import configuration_of
        from avsec_gym.agents.training import TrainingSitting, train_agent

        self._check()
        configuration = configuration_of(self.env, self.algo, self.config, self.variant)
        steps = configuration.n_timesteps if self.steps is None else self.steps
        sitting = TrainingSitting(steps, self.minutes, self.resume, self.threads)
        with console.progress("training") as shown:
            card = train_agent(configuration, self.out, self.seed, sitting, shown)
        if self.episodes:
            found = held_out_result(load_agent(self.out), self.episodes, 0)
            card = write_agent_card(self.out, replace(card, held_out=found))
        if self.json:
            console.print_json("agents.train", {"out": str(self.out), **asdict(card)})
        else:
            console.say(f"{self.out}: {_sentence(card)}")
        return console.DONE if card.finished else console.DONE_IN_PART

    def _check(self) -> None:
        for name, good in (
            ("steps", self.steps is None or self.steps >= 1),
            ("minutes", self.minutes is None or self.minutes > 0),
            ("seed", 0 <= self.seed < 2**31),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")
        whole_number("--episodes", self.episodes, 0, _MOST_EPISODES)
        thread_number("--threads", self.threads)


@dataclass(frozen=True)
class AgentsEvaluate:
    """Judge agents in held-out episodes, beside all baselines of their environment.

    Baselines are searched in the training scenes with as many environment steps as the agent
    learned from: the best constant, one for each driving intention, random search and CMA-ES of the
    agent's own network, and the environment's own rules.  The best of them is chosen in training
    episodes.  Trainings that differ in nothing but the seed are judged together, too.
    """

    agents: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Folders of agents, or names of shipped ones; several are of one environment."""
    episodes: int = 200
    """Number of held-out episodes, which are the same for all agents."""
    seed: int = 0
    """Seed of the first held-out episode, and of the searches."""
    queries: int | None = None
    """Environment steps to search each baseline with.  Default: as many as the agent learned
    from."""
    budgets: tuple[int, ...] = ()
    """Environment steps, such as 256 1024 4096 16384: a comparison for each, with the agents that
    learned from no more and baselines that are searched with as many.  Default: one comparison."""
    json: bool = False
    """Print the comparison as JSON instead of a table."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.agents.agent_folder import load_agent
        from avsec_gym.agents.comparison import compare, compare_at_budgets

        for name, good in (
            ("queries", self.queries is None or self.queries >= 1),
            ("budgets", all(budget >= 1 for budget in self.budgets)),
            ("seed", 0 <= self.seed < 2**31),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")
        whole_number("--episodes", self.episodes, 1, _MOST_EPISODES)
        if self.budgets and self.queries is not None:
            raise ConfigurationError("--budgets and --queries exclude each other: give one of them")
        agents = [load_agent(place) for place in self.agents]
        with console.progress("searching baselines and playing") as shown:
            if self.budgets:
                found = compare_at_budgets(agents, self.budgets, self.episodes, self.seed, shown)
            else:
                found = [compare(agents, self.episodes, self.seed, self.queries, shown)]
        if not self.json:
            for comparison in found:
                _show(comparison)
        elif self.budgets:
            rows = [comparison.to_json() for comparison in found]
            console.print_json("agents.evaluate.budgets", {"env": found[0].env, "budgets": rows})
        else:
            console.print_json("agents.evaluate", found[0].to_json())
        return console.DONE


@dataclass(frozen=True)
class AgentsList:
    """List the environments with their shipped configurations, and the shipped agents."""

    json: bool = False
    """Print JSON instead of tables."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.agents.agent_folder import SHIPPED, read_agent_card, shipped_agents
        from avsec_gym.agents.configuration import shipped_configurations, shipped_variants

        there = shipped_configurations()
        variants = {
            name: {env: own for env, own in shipped_configurations(name).items() if own}
            for name in shipped_variants()
        }
        cards = {name: read_agent_card(SHIPPED / name) for name in shipped_agents()}
        if self.json:
            shipped: dict[str, Any] = {name: asdict(card) for name, card in cards.items()}
            console.print_json(
                "agents.list", {"configurations": there, "variants": variants, "agents": shipped}
            )
            return console.DONE
        console.print_table(
            "configurations: `avsec agents train ENV --algo ALGO --out DIR`",
            ["environment", "algorithms"],
            [[env, ", ".join(algorithms)] for env, algorithms in there.items()],
        )
        console.print_table(
            "other games: `avsec agents train ENV --algo ALGO --variant VARIANT --out DIR`",
            ["variant", "environment", "algorithms"],
            [
                [name, env, ", ".join(own)]
                for name, entries in variants.items()
                for env, own in entries.items()
            ],
        )
        console.print_table(
            "shipped agents: `avsec agents evaluate NAME`",
            ["name", "environment", "algorithm", "steps", "held-out success, %"],
            [
                [name, card.env, card.algorithm, f"{card.steps:,}", _success(card)]
                for name, card in cards.items()
            ],
        )
        return console.DONE


def _success(card: AgentCard) -> str:
    found = card.held_out
    return console.percent(found.get("success_rate"), found.get("success_interval"))


def _sentence(card: AgentCard) -> str:
    state = "finished" if card.finished else "time is up, --resume goes on"
    judged = f", held-out success {_success(card)} %" if card.held_out else ""
    return f"{state}; {card.steps:,} steps in {card.seconds:.0f} s{judged}"


def _show(found: AgentComparison) -> None:
    rows = [row.to_json() for row in found.rows]
    console.print_table(
        f"{found.env}: {rows[0]['episodes']} held-out episodes, baselines searched with"
        f" {found.budget:,} steps; % with 95 % intervals",
        ["who", "queries", "success", "interquartile mean", "reward", "in training, %"],
        [
            [
                row["name"],
                f"{row['queries']:,}",
                console.percent(row["success_rate"], row["success_interval"]),
                console.percent(row["interquartile_mean"], row["interquartile_interval"]),
                f"{row['reward']:.3f}",
                console.percent(row["training_success_rate"], None),
            ]
            for row in rows
        ],
    )
    facts = found.to_json()
    for judged in (*facts["against_best_baseline"], *facts["pooled"]):
        chance = console.percent(
            judged["probability_of_improvement"], judged["probability_of_improvement_interval"]
        )
        console.print_line(f"{judged['answer']}; probability of improvement {chance} %")
