"""Agents and baselines in the same held-out episodes."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
import stable_baselines3

from avsec_gym.agents.agent_folder import AgentCard, TrainedAgent, load_agent, shipped_agents
from avsec_gym.agents.arena import Arena, Played
from avsec_gym.agents.compared_agent import ComparedAgent
from avsec_gym.agents.comparison import (
    AgentComparison,
    compare,
    compare_at_budgets,
    held_out_result,
    pooled,
)
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.agents.learner import has_batches, single
from avsec_gym.agents.rules import NUMBER, rules_of
from avsec_gym.agents.search import (
    SearchBudget,
    _network,
    best_constant,
    evolved,
    random_actions,
)
from avsec_gym.envs.drivers import driver_of
from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.interquartile_mean import interquartile_mean
from avsec_gym.metrics.intervals import wilson_interval

SCENES = {"scenarios": {"name": "layouts", "seed": 0, "count": 8}}


def played(won: np.ndarray, scenes: np.ndarray | None = None) -> Played:
    """Each episode in a scene of its own, if no scenes are given."""
    count = len(won)
    of = np.arange(count).astype(str) if scenes is None else scenes
    return Played(won, won - 0.04, np.ones(count, int), np.full(count, "left"), of)


def row(
    name: str, won: np.ndarray, kind: str = "baseline", scenes: np.ndarray | None = None
) -> ComparedAgent:
    """A baseline wins in training as it does in the held-out episodes."""
    own = played(won, scenes)
    return ComparedAgent(name, own, 5, own if kind == "baseline" else None)


def test_an_episode_is_the_same_alone_and_in_a_batch() -> None:
    arena, env = Arena("avsec/GhostObject-v0", SCENES), single("avsec/GhostObject-v0", SCENES)
    action = np.linspace(-1, 1, 8, dtype=np.float32)
    found = arena.play(lambda seen, ways: np.tile(action, (len(ways), 1)), range(5))
    for seed in range(5):
        _, info = env.reset(seed=seed)
        total, ended = 0.0, False
        while not ended:
            _, reward, terminated, truncated, info = env.step(action)
            total, ended = total + float(reward), terminated or truncated
        assert info["is_success"] == found.success[seed]
        assert total == pytest.approx(found.reward[seed])
        assert info["queries"] == found.steps[seed]
        assert (info["scenario"], info["intention"]) == (
            found.scenario[seed], found.intention[seed],
        )  # fmt: skip
    alone = Arena("avsec/GhostObject-v0", SCENES)
    assert alone._one(lambda seen, ways: action[None], [2], 99).steps == found.steps[2]


@pytest.mark.slow
def test_the_search_finds_a_constant_that_wins_v0() -> None:
    """Where random actions win 3 %, and two ghosts at the best places would win always."""
    arena = Arena("avsec/GhostObject-v0", SCENES)
    budget = SearchBudget(arena, 16_000, 0, first_query=True)
    act = best_constant(budget, arena.environment.action_space, by_intention=True)
    assert 12_000 < budget.spent <= 16_000
    found = arena.play(act, range(100)).success.mean()
    chance = arena.play(random_actions(arena.environment.action_space, 0), range(100))
    assert found > 3 * chance.success.mean()


def test_cma_es_climbs_to_the_optimum() -> None:
    class Bowl(SearchBudget):
        def __post_init__(self) -> None:
            self.trials = self.dearest = 1

        def tried(self, act: object) -> float:
            self.spent += 1
            return -float(np.square(np.asarray(act) - 0.3).sum())

    for size in (1, 4):
        budget = Bowl(None, 600, 0)  # type: ignore[arg-type]
        found = evolved(budget, lambda vector: vector, np.zeros(size))  # type: ignore[arg-type, return-value]
        assert found == pytest.approx(np.full(size, 0.3), abs=0.02)
        assert budget.spent <= 600


@pytest.mark.parametrize("algorithm", ["PPO", "SAC", "TD3", "DDPG"])
def test_a_search_over_a_network_has_only_what_its_actions_depend_on(algorithm: str) -> None:
    """Three units that see three numbers, and an action of them; no critic, no copy for targets."""
    learner = getattr(stable_baselines3, algorithm)
    model = learner("MlpPolicy", gym.make("Pendulum-v1"), policy_kwargs={"net_arch": [3]})
    start, _ = _network(model.policy)
    assert len(start) == 3 * (3 + 1) + 1 * (3 + 1)


def test_who_wins_is_said_by_the_paired_interval() -> None:
    generator = np.random.default_rng(0)
    other = generator.random(200) < 0.3
    better, worse = other | (generator.random(200) < 0.3), other & (generator.random(200) < 0.3)
    said = {"wins against the best": better, "wins against agent": worse, "undecided": other}
    for word, agent in said.items():
        found = AgentComparison("x", 5, [row("agent", agent, "agent"), row("b", other)])
        assert word in found.answer(found.rows[0])
    facts = row("b", other).to_json()
    blocks = other.reshape(10, 20).mean(axis=1)
    assert facts["interquartile_mean"] == pytest.approx(float(interquartile_mean(blocks)))
    low, high = facts["interquartile_interval"]
    assert low <= facts["interquartile_mean"] <= high


def test_episodes_of_one_scene_count_less() -> None:
    """Ten scenes, each played six times and always with the same end, are ten cases."""
    won, lost = np.repeat(np.arange(10) < 7, 6), np.zeros(60, bool)
    ten, one = np.repeat(np.arange(10), 6).astype(str), np.full(60, "one")
    agent, other = row("agent", won, "agent", ten), row("b", lost, scenes=ten)
    assert agent.to_json()["success_interval"] == pytest.approx(wilson_interval(7, 10))
    found = AgentComparison("x", 5, [agent, other])
    low, high = found.against_best(agent).interval or (0.0, 0.0)
    assert high - low > 0.4
    assert found.to_json()["against_best_baseline"][0]["mcnemar_p"] is None
    agent, other = row("agent", won, "agent", one), row("b", lost, scenes=one)
    answer = AgentComparison("x", 5, [agent, other]).answer(agent)
    assert answer.startswith("one scene does not tell agent and b apart: +70.0")


def test_the_best_baseline_is_chosen_in_training_episodes() -> None:
    """One that is lucky in the held-out episodes is not the one to beat."""
    often, seldom = np.arange(100) < 60, np.arange(100) < 20
    lucky = ComparedAgent("lucky", played(often), 5, played(seldom))
    sound = ComparedAgent("sound", played(seldom), 5, played(often))
    agent = row("agent", often, "agent")
    found = AgentComparison("x", 5, [agent, lucky, sound])
    assert found.best_baseline is sound
    assert "wins against the best baseline, sound: +40.0" in found.answer(agent)
    facts = found.to_json()
    assert facts["best_baseline"] == "sound"
    rates = [each["training_success_rate"] for each in facts["rows"]]
    assert rates == [None, pytest.approx(0.2), pytest.approx(0.6)]


def agent(name: str, seed: int, steps: int = 32, algorithm: str = "ppo") -> TrainedAgent:
    configuration = AgentConfiguration("avsec/GhostObject-v0", algorithm, 10_000, env_kwargs=SCENES)
    facts = ("avsec/GhostObject-v0", SCENES, {}, algorithm, seed, steps, 1.0, True, 1, "")
    return TrainedAgent(name, configuration, AgentCard(*facts), None)


def test_trainings_that_differ_in_the_seed_alone_are_pooled() -> None:
    agents = [
        agent("a", 0), agent("b", 1), agent("again", 1),
        agent("longer", 2, 64), agent("other", 3, algorithm="a2c"),
    ]  # fmt: skip
    found = pooled(agents, [row(each.name, np.ones(40, bool), "agent") for each in agents])
    assert [(pool.name, pool.seeds) for pool in found] == [("ppo, 2 seeds", (0, 1))]
    assert [own.name for own in found[0].rows] == ["a", "b"]


@pytest.mark.parametrize(
    ("rates", "said"),
    [
        ((0.7, 0.8), "wins against every baseline, the best b: interquartile mean"),
        ((0.1, 0.2), "b wins against ppo, 2 seeds: interquartile mean"),
        ((0.4, 0.6), "undecided between ppo, 2 seeds, and the best baseline, b"),
    ],
)
def test_pooled_seeds_are_judged_by_intervals_that_are_apart(
    rates: tuple[float, ...], said: str
) -> None:
    generator = np.random.default_rng(0)
    rows = [row(f"seed {i}", generator.random(400) < rate, "agent") for i, rate in enumerate(rates)]
    best = row("b", generator.random(400) < 0.5)
    pools = pooled([agent("seed 0", 0), agent("seed 1", 1)], rows)
    found = AgentComparison("x", 5, [*rows, best], pools).to_json()
    (pool,) = found["pooled"]
    assert said in pool["answer"]
    scores = np.concatenate([own.scores for own in rows])
    assert len(scores) == 40
    assert pool["interquartile_mean"] == pytest.approx(float(interquartile_mean(scores)))
    # The pool's difference is the mean of those of its trainings.
    alone = [each["difference"] for each in found["against_best_baseline"]]
    assert pool["difference"] == pytest.approx(np.mean(alone))
    chances = [each["probability_of_improvement"] for each in found["against_best_baseline"]]
    assert pool["probability_of_improvement"] == pytest.approx(np.mean(chances))


def test_who_beats_the_best_in_training_alone_has_not_won() -> None:
    """A baseline that did worse in training episodes may do better in the held-out ones."""
    generator = np.random.default_rng(0)
    rows = [row(f"seed {i}", generator.random(400) < 0.7, "agent") for i in range(2)]
    (pool,) = pooled([agent("seed 0", 0), agent("seed 1", 1)], rows)
    best, late = (
        row(name, generator.random(400) < rate) for name, rate in (("b", 0.2), ("c", 0.7))
    )
    assert pool.winner(best, [best]) == "agent"
    assert pool.winner(best, [best, late]) == "undecided"


@pytest.mark.parametrize(
    ("budgets", "problem"),
    [([16], "small learned from 32 steps, more than"), ([40, 100], "no agent belongs to .* 100")],
)
def test_budgets_that_do_not_fit_the_agents_are_refused(budgets: list[int], problem: str) -> None:
    with pytest.raises(ConfigurationError, match=problem) as error:
        compare_at_budgets([agent("small", 0)], budgets, 10, 0)
    assert "--budgets" in str(error.value)


@pytest.mark.slow
def test_the_shipped_agent_beats_its_baselines_and_does_what_its_card_says() -> None:
    (name,) = shipped_agents()
    agent = load_agent(name)
    found = compare([agent], 200, 0, queries=3000)
    names = [each.name for each in found.rows]
    assert names[:6] == [
        name,
        "random actions",
        "constant",
        "constant, by intention",
        "random search of the network",
        "CMA-ES of the network",
    ]
    assert all(each.queries <= 3000 for each in found.rows[1:])
    assert found.answer(found.rows[0]).startswith(f"{name} wins against the best baseline")
    assert 0.35 < found.rows[0].rate < 0.6
    card = agent.card.held_out
    low, high = card["success_interval"]
    assert low <= card["success_rate"] <= high
    fresh = held_out_result(agent, 200, 0)
    assert fresh["success_rate"] == pytest.approx(found.rows[0].rate)


@pytest.mark.slow
def test_a_comparison_can_be_made_again() -> None:
    agent = load_agent("ghost_place")
    first, again = (compare([agent], 40, 3, queries=600).to_json() for _ in range(2))
    assert first == again


def test_names_of_agents_are_suggested() -> None:
    with pytest.raises(ConfigurationError, match='Did you mean "ghost_place"'):
        load_agent("ghost_places")


def test_the_drivers_that_are_rules_drive_many_as_they_drive_one() -> None:
    """What each earns in a batch is what `driver_of` drives in a single environment."""
    id, drives = "avsec/ClosedLoop-v0", {"scenarios": {"source": "layouts", "count": 6}}
    arena = Arena(id, drives)
    assert has_batches(id, drives)
    rules = list(rules_of(id, arena, 0))
    assert len(rules) == NUMBER[id] == 2
    for rule, name in zip(rules, ("planner", "idm"), strict=True):
        assert rule.queries == 0
        together = arena.play(rule.act_in(arena), range(4))
        env = single(id, drives)
        driver = driver_of(name, env)
        for seed in range(4):
            seen, _ = env.reset(seed=seed)
            total, ended = 0.0, False
            while not ended:
                action, _ = driver.predict(seen, deterministic=True)
                seen, reward, terminated, truncated, _ = env.step(action)
                total, ended = total + float(reward), terminated or truncated
            assert together.reward[seed] == pytest.approx(total, abs=1e-5)


@pytest.mark.parametrize(("queries", "longest"), [(None, 10), (2, 2), (12, 12)])
def test_searches_know_how_long_an_episode_is(queries: int | None, longest: int) -> None:
    arena = Arena("avsec/GhostObject-v0", {"queries": queries})
    assert arena.longest_episode == longest
    assert SearchBudget(arena, 256 * 30, 0).trials == 30 // longest


def test_queries_alone_make_a_longer_episode() -> None:
    """In a batch, and in a single environment."""
    arena = Arena("avsec/GhostObject-v0", {"queries": 12})
    idle = np.full(arena.environment.action_space.shape or (), -1.0)
    together = arena.play(lambda seen, ways: np.tile(idle, (len(ways), 1)), range(2))
    assert together.steps.tolist() == [12, 12]
    arena.environment.reset(seed=0)
    ends = [arena.environment.step(idle)[2:4] for _ in range(12)]
    assert ends == [(False, False)] * 11 + [(True, False)]


@pytest.mark.slow
def test_what_hides_in_the_frames_that_count_wins_more_often() -> None:
    id, drives = "avsec/ClosedLoopAttack-v0", {"source": "layouts", "seed": 0, "count": 40}
    arena = Arena(id, {"scenarios": drives, "contested": True})
    near, timed = rules_of(id, arena, 3000)
    assert NUMBER[id] == 2
    assert 0 < near.queries <= 3000
    won = [rule.act_in(arena) for rule in (near, timed)]
    near_won, timed_won = (arena.play(act, range(12)).success.sum() for act in won)
    assert timed_won >= near_won
    assert timed_won > 4
    alone = Arena(id, {"kind": {"name": "ghost", "ghosts": 2}, "scenarios": drives})
    assert not list(rules_of(id, alone, 3000)), "the rules know the default attack alone"


@pytest.mark.parametrize("id", ["avsec/ClosedLoop-v0", "avsec/ClosedLoopAttack-v0"])
def test_what_a_batch_refuses_is_played_alone(id: str) -> None:
    """Traffic that reacts is highway-env's; what cannot be made at all is refused by its name."""
    drives = {"scenarios": {"source": "layouts", "count": 3}, "duration": 1.0}
    assert has_batches(id, drives)
    reacting = drives | {"traffic": "reacting"}
    assert not has_batches(id, reacting)
    size = single(id, reacting).action_space.shape or ()
    alone = Arena(id, reacting).play(lambda seen, ways: np.zeros((len(ways), *size)), range(2))
    assert len(alone.steps) == 2
    assert alone.steps.max() <= 10
    with pytest.raises(ConfigurationError, match="traffic"):
        Arena(id, drives | {"traffic": "raecting"}).play(lambda seen, ways: None, range(2))
