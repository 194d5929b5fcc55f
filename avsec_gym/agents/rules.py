"""Rules of single environments, beside what is searched in every one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from avsec_gym.agents.aimed_games import GAMES
from avsec_gym.agents.arena import Act, Arena, Baseline
from avsec_gym.agents.hiding_rules import DISTANCES, Rule, waits, when_it_plans
from avsec_gym.agents.laser_rules import LaserRule, candidates, fits
from avsec_gym.agents.search import SearchBudget

_MOST_EPISODES = 1200
"""Training episodes that points are searched on, each of ten thousand: more would take hours."""


NUMBER = {
    "avsec/GhostObject-v1": 6,
    "avsec/ClosedLoop-v0": 2,
    "avsec/ClosedLoopAttack-v0": 2,
    "avsec/FaculaAttack-v0": 2,
}
"""How many rules an environment has, where it has some."""


def rules_of(env: str, training: Arena, steps: int) -> Iterator[Baseline]:
    """The rules that are known for an environment.

    Args:
        env: The environment's id.
        training: Where rules are chosen.
        steps: Environment steps that choosing them may take.
    """
    if env == "avsec/GhostObject-v1":
        for name, act, spent in _place_rules(training, steps):
            yield Baseline.everywhere(name, act, spent)
    if env == "avsec/ClosedLoop-v0":
        yield Baseline("the planner", partial(_driven, name="planner"), 0)
        yield Baseline("highway-env's IDM", partial(_driven, name="idm"), 0)
    if env == "avsec/ClosedLoopAttack-v0" and GAMES["closed_loop_attack"].fits(
        training.environment.observation_space, training.environment.action_space
    ):
        yield from _hiding_rules(training, steps)
    if env == "avsec/FaculaAttack-v0" and fits(
        training.environment.observation_space, training.environment.action_space
    ):
        yield from _laser_rules(training, steps)


def _place_rules(training: Arena, steps: int) -> Iterator[tuple[str, Act, int]]:
    """Those of `place_rules`, chosen on episodes of which every place is played."""
    from avsec_gym.agents.place_rules import NEAREST, Episodes, Scores, played, points, spot_table

    places = training.environment.action_space.shape
    assert places is not None
    known = played(training.arguments, max(steps // places[0], 1), seed=10)
    some = Episodes(known.observations[:_MOST_EPISODES], known.won[:_MOST_EPISODES])

    def act_by(scores: Scores) -> Act:
        def act(seen: Any, ways: Any) -> Any:
            best = scores(Episodes(seen, np.zeros((len(seen), *places), bool))).argmax(axis=1)
            return np.where(np.arange(places[0]) == best[:, None], 1.0, -1.0).astype(np.float32)

        return act

    for name in ("nearest", "nearest_to_goal", "most_room"):
        yield f"place: {name.replace('_', ' ')}", act_by(NEAREST[name]), 0
    for name, scores in points(some):
        yield f"place nearest to a {name.replace('_', ' ')}", act_by(scores), some.won.size
    yield "a score for each spot, fitted", act_by(spot_table(known)), known.won.size


def _hiding_rules(training: Arena, steps: int) -> Iterator[Baseline]:
    """Those of `hiding_rules`, each with the distance that earns most in training episodes."""
    for name, rule in (
        ("hides what is near and in the way", waits),
        ("hides it in the frames that the car plans from", when_it_plans),
    ):
        budget = SearchBudget(training, steps, seed=0, candidates=len(DISTANCES))
        earned: dict[float, float] = {}
        for distance in DISTANCES:
            if budget.leaves(1):
                earned[distance] = budget.tried(_by_observations(rule(distance)))
        best = max(earned, key=lambda distance: earned[distance], default=DISTANCES[0])
        yield Baseline.everywhere(name, _by_observations(rule(best)), budget.spent)


def _laser_rules(training: Arena, steps: int) -> Iterator[Baseline]:
    """Full light on what is in the way, and the same with what earns most in training episodes."""
    shape = training.environment.action_space.shape
    assert shape is not None
    queries, actions = training.steps_of_an_episode, shape[0]
    largest = _by_observations(LaserRule(queries, actions))
    yield Baseline.everywhere("the largest spot on what is in the way", largest, 0)
    rules = candidates(queries, actions)
    budget = SearchBudget(training, steps, seed=0, candidates=len(rules))
    earned = {
        rule: budget.tried(_by_observations(rule)) if budget.leaves(1) else -np.inf
        for rule in rules
    }
    best = _by_observations(max(earned, key=lambda rule: earned[rule]))
    name = "a spot on what is in the way, its size, height and camera chosen"
    yield Baseline.everywhere(name, best, budget.spent)


def _by_observations(rule: Rule) -> Act:
    return lambda seen, ways: rule(seen)


def _driven(arena: Arena, name: str) -> Act:
    """A driver by name in whatever environments the arena plays; each has its own."""
    from avsec_gym.envs.drivers import Driver, driver_of

    drivers: dict[Any, Driver] = {}

    def act(seen: Any, ways: Any) -> Any:
        played = arena.playing.unwrapped
        alone = getattr(played, "alone", [played])
        actions = np.zeros((len(alone), 2), np.float32)
        for i in np.flatnonzero(~getattr(played, "ended", np.zeros(1, bool))).tolist():
            if alone[i] not in drivers:
                drivers[alone[i]] = driver_of(name, alone[i])
            actions[i] = drivers[alone[i]].predict(seen[i], deterministic=True)[0]
        return actions

    return act
