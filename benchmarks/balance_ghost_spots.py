"""Find the spots of `avsec/GhostObject-v1` and their biases; prints ghost_spots.json.

    python benchmarks/balance_ghost_spots.py > avsec_gym/envs/ghost_spots.json

A rule that sees the spots offered, road type and intention, but no object, learns a score for each
spot (a conditional logit) from drawn places.  Then the biases move by its scores: spots that it
takes for winners are offered more as losers.  That is repeated until the scores hardly help it.
`benchmarks/ghost_places.py` measures, on other scenes, what is left to such a rule.
"""

from __future__ import annotations

import argparse
import json

import numpy as np
import torch

from avsec_gym.envs import ghost_spots
from avsec_gym.envs.ghost_place_game import GhostPlaceGame
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention

CLASSES = [(road_type, intention) for road_type in RoadType for intention in Intention]
PLACES = 16
"""Places that each round offers, as many as the game does by default."""
RATE = 0.3
"""Rate of the biases."""
MOST = 6.0
"""Largest bias."""
ENOUGH = 10
"""Contested rounds of a road type and intention without which it gets the spots of all."""
RARE = 0.02
"""Share of contested rounds that a spot has to win, or it is left out."""


def wins(scenes: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Class, spots that win, spots that lose of each contested round, (R,), (R, S), (R, S)."""
    every = ghost_spots.Spots(
        ghost_spots.considered_spots(), np.zeros(len(ghost_spots.considered_spots()))
    )
    game = GhostPlaceGame({"name": "layouts", "seed": seed, "count": scenes}, places=PLACES)
    kinds, won, lost = [], [], []
    ghosts, there = every.poses[:, None], np.ones((len(every), 1), bool)
    empty: dict[object, np.ndarray] = {}
    for index in range(scenes):
        for intention in Intention:
            if not game.is_safe(index, intention):
                continue
            round = game.base.round(index, intention)
            if round.kind not in empty:
                empty[round.kind] = game.empty_road(round, every)
            unsafe = game.base.query([round] * len(every), there, ghosts)[0] > 0
            if (unsafe & empty[round.kind]).any():
                kinds.append(CLASSES.index((round.scene.road_type, intention)))
                won.append(unsafe & empty[round.kind])
                lost.append(~unsafe)
    return np.array(kinds), np.array(won), np.array(lost)


def balanced(
    kinds: np.ndarray, won: np.ndarray, lost: np.ndarray, turns: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Which spots of each class are offered, and their biases; both of shape (classes, spots)."""
    number = np.array([np.count_nonzero(kinds == c) for c in range(len(CLASSES))])
    counts = np.array([won[kinds == c].sum(axis=0) for c in range(len(CLASSES))])
    offered = (counts > RARE * number[:, None]) & (number >= ENOUGH)[:, None]
    won, lost = won & offered[kinds], lost & offered[kinds]
    fits = np.nonzero(won.any(axis=1) & (lost.sum(axis=1) >= PLACES - 1))[0]
    bias, generator = np.zeros(offered.shape), np.random.default_rng(seed)
    for _ in range(turns):
        # Places as the game draws them, the winner first.
        rows = generator.choice(fits, 6000)
        noise = generator.gumbel(size=(len(rows), won.shape[1]))
        winner = np.where(won[rows], noise - bias[kinds[rows]], -np.inf).argmax(axis=1)
        rank = np.where(lost[rows], noise + bias[kinds[rows]], -np.inf)
        losers = np.argpartition(-rank, PLACES - 1, axis=1)[:, : PLACES - 1]
        scores = learned(kinds[rows], np.column_stack([winner, losers]), offered.shape)
        scores -= (scores * offered).sum(1, keepdims=True) / np.maximum(offered.sum(1), 1)[:, None]
        bias = np.clip(bias + RATE * scores, -MOST, MOST) * offered
    return offered, bias


def learned(kinds: np.ndarray, places: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Scores of spots by which the winner, first in each row, is predicted best."""
    own, columns = torch.tensor(kinds)[:, None], torch.tensor(places)
    scores = torch.zeros(shape, requires_grad=True)
    optimiser = torch.optim.Adam([scores], 0.15)
    for _ in range(40):
        likelihood = torch.log_softmax(scores[own, columns], dim=1)[:, 0].mean()
        loss = 3e-5 * (scores**2).sum() / len(CLASSES) - likelihood
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    return scores.detach().numpy().astype(float)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=2, help="of the layouts: no other use has it")
    parser.add_argument("--turns", type=int, default=30)
    options = parser.parse_args()
    torch.set_num_threads(1)
    offered, bias = balanced(*wins(options.scenes, options.seed), options.turns, options.seed)
    spots: dict[str, dict[str, list[list[float]]]] = {}
    for c, (road_type, intention) in enumerate(CLASSES):
        spots.setdefault(str(road_type), {})[str(intention)] = [
            [*map(float, ghost_spots.considered_spots()[s]), round(float(bias[c, s]), 2)]
            for s in np.nonzero(offered[c])[0]
        ]
    made = f"benchmarks/balance_ghost_spots.py --scenes {options.scenes} --seed {options.seed}"
    rows = json.dumps({"made_by": f"{made} --turns {options.turns}", "spots": spots}, indent=1)
    # A spot a line, not a number a line.
    print(json.dumps(json.loads(rows)).replace("}, ", "},\n ").replace("]], ", "]],\n  "))


if __name__ == "__main__":
    main()
