"""Rules that choose a place of `avsec/GhostObject-v1`: constants, measures, points, tables.

A rule gives each place a number, and the highest is taken.  Rules that are searched are chosen on
episodes of which it is known what every place would do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import torch

from avsec_gym.agents.extras import cma_module
from avsec_gym.agents.place_policy import places_in
from avsec_gym.envs.place_features import PlaceFeatures

ID = "avsec/GhostObject-v1"
EVALUATIONS = 5000
"""Points that CMA-ES tries, each in all episodes."""
INTENTIONS = slice(2, 5)
"""Where an observation has the intention, one-hot."""


@dataclass(frozen=True, eq=False)
class Episodes:
    """Episodes of v1 with what each place would do."""

    observations: np.ndarray
    """Shape (B, M)."""
    won: np.ndarray
    """Whether a ghost at each place makes the episode unsafe, shape (B, K)."""

    @property
    def places(self) -> PlaceFeatures:
        """The places that are played, shape (B, K)."""
        return PlaceFeatures.decode(places_in(self.observations))

    @property
    def intention(self) -> np.ndarray:
        """0 left, 1 straight, 2 right, shape (B,)."""
        return self.observations[:, INTENTIONS].argmax(axis=1)

    @property
    def goals(self) -> np.ndarray:
        """x, y in m, shape (B, 2)."""
        return self.observations[:, 5:7] * (50.0, 20.0)


def played(arguments: Mapping[str, Any], count: int, seed: int) -> Episodes:
    """Every place of some episodes, played.

    Args:
        arguments: Arguments of the environment, such as its scenarios.
        count: The number of episodes.
        seed: Seed of the first episode.
    """
    envs: Any = gym.make_vec(ID, num_envs=count, **arguments)
    won = []
    for place in range(envs.single_action_space.shape[0]):
        observations, _ = envs.reset(seed=seed)
        actions = np.full(envs.action_space.shape, -1.0, np.float32)
        actions[:, place] = 1.0
        won.append(envs.step(actions)[-1]["is_success"])
    return Episodes(observations, np.stack(won, axis=1))


Scores = Callable[[Episodes], np.ndarray]
"""A number for each place, shape (B, K); the highest is taken."""


def success(scores: Scores, episodes: Episodes) -> np.ndarray:
    """Whether the place with the highest score wins, shape (B,)."""
    best = scores(episodes).argmax(axis=1)
    return episodes.won[np.arange(len(best)), best]


def away(points: np.ndarray, episodes: Episodes) -> np.ndarray:
    """Distances of places from points of shape (2,) or (B, 2), shape (B, K)."""
    return np.linalg.norm(episodes.places.positions - points[..., None, :], axis=-1)


NEAREST: dict[str, Scores] = {
    "nearest": lambda e: -away(np.zeros(2), e),
    "farthest": lambda e: away(np.zeros(2), e),
    "nearest_to_goal": lambda e: -away(e.goals, e),
    "nearest_to_half_way": lambda e: -away(e.goals / 2, e),
    "nearest_to_own_lane": lambda e: -abs(e.places.positions[..., 1]),
    "nearest_to_goal_lane": lambda e: -abs(e.places.positions[..., 1] - e.goals[:, 1:]),
    "leftmost": lambda e: e.places.positions[..., 1],
    "rightmost": lambda e: -e.places.positions[..., 1],
    "least_room": lambda e: -e.places.room.min(axis=-1),
    "least_room_beside": lambda e: -e.places.room[..., :2].min(axis=-1),
    "least_room_across": lambda e: -e.places.room[..., :2].sum(axis=-1),
    "most_room": lambda e: e.places.room.sum(axis=-1),
}


def constants(training: Episodes) -> Iterator[tuple[str, Scores]]:
    """The best index, and the best for each intention."""
    count = training.won.shape[1]
    best = int(training.won.mean(axis=0).argmax())
    each = [int(training.won[training.intention == i].mean(axis=0).argmax()) for i in range(3)]
    yield "constant", lambda e: np.tile(np.eye(count)[best], (len(e.won), 1))
    yield "constant_by_intention", lambda e: np.eye(count)[each][e.intention]


def points(training: Episodes) -> Iterator[tuple[str, Scores]]:
    """The place nearest to one point, and to one for each intention."""
    grid = np.stack(np.meshgrid(np.linspace(2, 24, 100), np.linspace(-8, 8, 50)), -1).reshape(-1, 2)
    best: list[np.ndarray] = []
    for intention in (None, 0, 1, 2):
        own = slice(None) if intention is None else training.intention == intention
        part = Episodes(training.observations[own], training.won[own])
        if not len(part.won):  # Few episodes, and none with this intention.
            best.append(best[0])
            continue

        def loss(point: np.ndarray, part: Episodes = part) -> float:
            return -float(success(lambda e: -away(np.asarray(point), e), part).mean())

        on_grid = min(grid, key=loss)
        best.append(min(on_grid, searched(loss, on_grid, 3.0), key=loss))
    yield "point", lambda e: -away(best[0], e)
    yield "point_by_intention", lambda e: -away(np.array(best[1:])[e.intention], e)


def searched(loss: Callable[[np.ndarray], float], start: np.ndarray, spread: float) -> np.ndarray:
    """The best of CMA-ES."""
    options: dict[str, Any] = {
        "maxfevals": EVALUATIONS,
        "verbose": -9,
        "seed": 1,
        "popsize": 20,
        "tolfun": 0,
    }
    return np.asarray(
        cma_module().fmin2(loss, start, spread, options | {"tolflatfitness": 10**6})[0]
    )


def spot_table(training: Episodes) -> Scores:
    """A conditional logit over spots, for each road type and intention."""

    def rows(e: Episodes) -> torch.Tensor:
        x, y = np.moveaxis(np.rint(e.places.positions).astype(int), -1, 0)
        kind = 3 * e.observations[:, 1].astype(int) + e.intention
        return torch.tensor((kind[:, None] * 32 + x) * 32 + y + 16)

    scores = torch.zeros(6 * 32 * 32, requires_grad=True)
    optimiser = torch.optim.Adam([scores], 0.1)
    own, won = rows(training), torch.tensor(training.won, dtype=torch.float32)
    for _ in range(300):
        chance = torch.softmax(scores[own], dim=1)
        loss = 1e-4 * (scores**2).sum() - torch.log((chance * won).sum(1) + 1e-9).mean()
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
    return lambda e: scores.detach()[rows(e)].numpy()
