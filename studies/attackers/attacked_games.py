"""The games of all attackers with their default arguments, and how long constants are searched.

What is learned or searched on some scenes is judged in others of the same kind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

from avsec_gym.agents.arena import Arena
from avsec_gym.agents.search import SearchBudget, best_constant, choice_seeds
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of

LAYOUTS = (
    {"name": "layouts", "seed": 0, "count": 400},
    {"name": "layouts", "seed": 7, "count": 600},
)
DRIVES = ({"source": "drives", "seed": 0}, {"source": "drives", "seed": 7})
DRIVEN_LAYOUTS = (
    {"source": "layouts", "seed": 0, "count": 300},
    {"source": "layouts", "seed": 7, "count": 200},
)
IMAGES = (
    {"source": "mixed", "split": "train", "assets": "train"},
    {"source": "mixed", "split": "val", "assets": "judge"},
)
INSTANTS = (
    {"source": "connected", "first": 0, "count": 4},
    {"source": "connected", "first": 4},
)


@dataclass(frozen=True)
class AttackedGame:
    """An environment in which a constant is searched.

    Args:
        env: Its id.
        scenes: Scenes to search in, and others to be judged by.
        steps: Environment steps of the search.
        episodes: Episodes that are judged.
        candidates: How many constants the steps should last for.
        arguments: What is not the default.
    """

    env: str
    scenes: tuple[Mapping[str, Any], Mapping[str, Any]]
    steps: int
    episodes: int
    candidates: int
    arguments: Mapping[str, Any] = field(default_factory=dict)


GAMES = {
    "PerturbationAttack-v0": AttackedGame("avsec/PerturbationAttack-v0", IMAGES, 1024, 100, 128),
    "PatchAttack-v0": AttackedGame("avsec/PatchAttack-v0", IMAGES, 1024, 100, 128),
    "FaculaAttack-v0": AttackedGame("avsec/FaculaAttack-v0", IMAGES, 1024, 100, 128),
    "ConnectedSpoofing-v0": AttackedGame("avsec/ConnectedSpoofing-v0", INSTANTS, 1024, 100, 128),
    "LidarSpoofing-v0": AttackedGame("avsec/LidarSpoofing-v0", IMAGES, 1024, 100, 128),
    "ClosedLoopAttack-v0": AttackedGame("avsec/ClosedLoopAttack-v0", DRIVES, 102_400, 200, 64),
    "ClosedLoopAttack-v0, contested layouts": AttackedGame(
        "avsec/ClosedLoopAttack-v0", DRIVEN_LAYOUTS, 102_400, 200, 64, {"contested": True}
    ),
    "GhostObject-v0": AttackedGame("avsec/GhostObject-v0", LAYOUTS, 65_536, 1000, 1024),
    "GhostObject-v1": AttackedGame("avsec/GhostObject-v1", LAYOUTS, 65_536, 1000, 1024),
}
"""Every attacker of the catalogue; those that take longest first."""


@dataclass(frozen=True)
class ConstantFound:
    """The best constant of a game.

    Args:
        env: The id of the environment.
        arguments: Its arguments in the scenes to be judged by.
        steps: Environment steps that the search took.
        action: What the constant does, numbers in [-1, 1].
        searched: Episodes that it wins in the scenes that it was searched in; other episodes.
        held_out: Episodes that it wins in the others.
    """

    env: str
    arguments: Mapping[str, Any]
    steps: int
    action: tuple[float, ...]
    searched: Share
    held_out: Share


def searching(seed: int) -> Callable[[str], ConstantFound]:
    """What finds the best constant of a game by its name.

    Args:
        seed: Seed of the search, and of the first episode.
    """
    return partial(constant_of, seed=seed)


def constant_of(name: str, seed: int) -> ConstantFound:
    """The best constant by grid and CMA-ES, and how often it wins.

    Where an episode is a number of queries it is judged at the first: the same action again has the
    same answer.

    Args:
        name: One of `GAMES`.
        seed: Seed of the search, and of the first episode.
    """
    game = GAMES[name]
    training, held_out = (
        Arena(game.env, {"scenarios": dict(scenes), **game.arguments}) for scenes in game.scenes
    )
    budget = SearchBudget(training, game.steps, seed, first_query=True, candidates=game.candidates)
    act = best_constant(budget, training.environment.action_space, by_intention=False)
    most = None if training.longest_episode is None else 1
    searched = training.play(act, choice_seeds(seed, game.episodes), most_steps=most)
    judged = held_out.play(act, range(seed, seed + game.episodes), most_steps=most)
    action: Floats = act(None, ["straight"])[0]
    found = ConstantFound(
        game.env,
        dict(held_out.arguments),
        budget.spent,
        tuple(round(float(number), 3) for number in action.ravel()),
        share_of(searched.success, searched.scenario.tolist()),
        share_of(judged.success, judged.scenario.tolist()),
    )
    for arena in (training, held_out):
        arena.close()
    return found


def asked(name: str, seed: int) -> dict[str, Any]:
    """What a game's result depends on; what is kept of another one is made anew.

    Args:
        name: One of `GAMES`.
        seed: Seed of the search.
    """
    return asdict(GAMES[name]) | {"seed": seed}
