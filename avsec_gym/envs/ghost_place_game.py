"""The game behind `avsec/GhostObject-v1`: which of a few places makes this plan unsafe?

No place blocks an empty road: a ghost wins only together with what is really there.  One of the
places offered makes the plan unsafe, the others do not; which spots are offered is balanced so
that a spot alone does not give it away (`avsec_gym.envs.ghost_spots`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import whole_number
from avsec_gym.attacks.object_injection import inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.ghost_game import GhostGame, one_number
from avsec_gym.envs.ghost_round import OUTCOMES, SCENE_SIZE, Queried, Round, observation
from avsec_gym.envs.ghost_spots import Spots, spots_of
from avsec_gym.envs.place_features import SIZE, PlaceFeatures
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.metrics.safety import SAFE
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.roads import THESIS
from avsec_gym.scenario.scene import Motion

_SAFE = OUTCOMES.index(SAFE)
_NEVER = 1e200
"""An inverse weight that comes after all others."""


@dataclass(frozen=True, eq=False)
class Answers:
    """What the car does about a ghost on each spot of one round."""

    spots: Spots
    rows: Floats
    """The fields of `Queried` for each, shape (S, 7)."""
    features: Floats
    """Shape (S, SIZE); see `PlaceFeatures`."""
    wins: NDArray[np.bool_]
    """Whether the plan becomes unsafe, shape (S,)."""
    contested: bool
    """Whether some spots win, and enough others do not."""

    @cached_property
    def winnable(self) -> bool:
        """Whether any spot wins."""
        return bool(self.wins.any())

    @cached_property
    def weights(self) -> Floats:
        """Inverse weights with which a spot is drawn, shape (2, S): as the winner, as another."""
        bias = self.spots.bias
        return np.where([self.wins, ~self.wins], np.exp([bias, -bias]), _NEVER)


@dataclass(frozen=True, eq=False)
class PlacedRound(Round):
    """A round with the places that its attacker can reach."""

    answers: Answers
    offered: NDArray[np.int64]
    """Spots of the places, in their order, shape (K,)."""
    shown: Floats
    """What is shown of the places, as an observation shows them, shape (K, SIZE)."""

    @classmethod
    def of(
        cls, round: Round, answers: Answers, offered: NDArray[np.int64], shown: Floats
    ) -> PlacedRound:
        """A round with its places.

        Every episode makes one: copied at once, all fields take a fifth of the time that
        `__init__` needs.
        """
        placed = object.__new__(cls)
        vars(placed).update(vars(round), answers=answers, offered=offered, shown=shown)
        return placed


class GhostPlaceGame:
    """Rules and scenes.

    Args:
        scenarios: The scenes, as of `GhostGame`.
        planner: The victim's motion planner, as of `GhostGame`.
        places: The number of places that each round offers.
        motion: How much the planner knows of moving objects.
        road: The road that the car drives on, as of `GhostGame`.

    Raises:
        ConfigurationError: Fewer than two places or more than 16, or see `GhostGame`.
    """

    def __init__(
        self,
        scenarios: Any = "layouts",
        planner: Any = "astar",
        places: int = 16,
        motion: Motion | str = Motion.STATIC,
        road: str = THESIS,
    ) -> None:
        self.places = whole_number("places", places, 2, 16)
        self.base = GhostGame(scenarios, planner, ghosts=1, motion=motion, ghost="car", road=road)
        self._answers: dict[tuple[int, Intention], Answers] = {}
        self._passable: dict[tuple[Any, ...], Spots] = {}

    @property
    def action_size(self) -> int:
        """A number for each place."""
        return self.places

    @property
    def observation_size(self) -> int:
        """Start, goal and objects; places; the last query."""
        return SCENE_SIZE + (SIZE + 1) * self.places + 5

    def draw_all(
        self, generators: Sequence[np.random.Generator], options: dict[str, Any] | None
    ) -> list[Round]:
        """Rounds that one place makes unsafe, or those that options ask for, with their places.

        Args:
            generators: The random numbers that each round is drawn by.
            options: The user's options, which may pick ``scenario`` and ``intention``.

        Raises:
            ConfigurationError: No scene has the id, no such intention, or no round fits.
        """
        rounds = self.base.draw_all(generators, options, self._contested, one_number)
        answers = [self.answers(round) for round in rounds]
        # Exponential variates over weights draw without replacement, the smallest ones first: the
        # place that wins, and the others.  Where nothing wins, or hardly anything else, as in
        # rounds that options ask for, the other kind fills up.
        waits = np.ones((len(rounds), max(len(each.wins) for each in answers)))
        weights = np.full((2, *waits.shape), np.inf)
        winnable = np.array([each.winnable for each in answers])
        for b, (each, generator) in enumerate(zip(answers, generators, strict=True)):
            count = len(each.wins)
            generator.standard_exponential(out=waits[b, :count])
            weights[:, b, :count] = each.weights
        as_winner, order = waits * weights
        order[winnable, as_winner.argmin(axis=1)[winnable]] = -1.0
        offered = order.argsort(axis=1)[:, : self.places]
        for row, generator in zip(offered, generators, strict=True):
            generator.shuffle(row)
        return [
            PlacedRound.of(round, each, row, each.features.take(row, axis=0))
            for round, each, row in zip(rounds, answers, offered, strict=True)
        ]

    def _contested(self, round: Round) -> bool:
        # On a narrow road of its own, a car may pass ghosts on too few spots.
        if round.scene.own_road is not None and len(self._passable_of(round)) < self.places:
            return False
        return self.answers(round).contested

    def is_safe(self, index: int, intention: Intention) -> bool:
        """Whether a round is driven safely without an attack."""
        return self.base.is_safe(index, intention)

    def play(self, rounds: Sequence[Round], actions: Floats) -> Queried:
        """One query in each round.

        Args:
            rounds: B rounds of `draw_all`.
            actions: Shape (B, places); the ghost goes to the place with the highest number, the
                first of equals.
        """
        best = actions.argmax(axis=1)
        asked = [_placed(round) for round in rounds]
        rows = [
            round.answers.rows[round.offered[place]]
            for round, place in zip(asked, best, strict=True)
        ]
        outcome, cost, path, nearest, sm1, ghosts, hidden = np.array(rows).T
        whole = outcome.astype(int), ghosts.astype(int), hidden.astype(int)
        return Queried(whole[0], cost, path, nearest, sm1, whole[1], whole[2])

    def observe(
        self,
        rounds: Sequence[Round],
        outcomes: NDArray[np.int64],
        costs: Floats,
        left: Floats,
        actions: Floats,
    ) -> NDArray[np.float32]:
        """Observations of B episodes, as `GhostGame.observe`; actions of -1 chose nothing yet."""
        features = np.array([_placed(round).shown for round in rounds])
        last = np.zeros((len(rounds), self.places))
        last[np.arange(len(rounds)), actions.argmax(axis=1)] = outcomes >= 0
        tail = np.concatenate([features.reshape(len(rounds), -1), last], axis=1)
        return observation(rounds, outcomes, costs, left, tail)

    def believed(self, round: Round, action: Floats) -> Boxes3D:
        """The detections that the car plans on after an action, shape (places,)."""
        offered = _placed(round).offered
        pose = _placed(round).answers.spots.poses[offered[int(np.argmax(action))]]
        return inject_ghosts(round.scene.boxes, pose, self.base.range.dimensions)

    @property
    def victim(self) -> MotionPrimitivePlanner:
        """Who plans."""
        return self.base.victim

    @property
    def motion(self) -> Motion:
        """What the planner knows of motion."""
        return self.base.motion

    def answers(self, round: Round) -> Answers:
        """What the car does about each spot, planned once for each scene and intention."""
        key = (round.index, round.intention)
        if key not in self._answers:
            spots = self._passable_spots(round)
            queried = self._try(round, spots)
            features = PlaceFeatures.among(spots.positions, round.poses[:, 0], round.half_sizes)
            wins = queried.outcome != _SAFE
            contested = bool(wins.any()) and int(np.count_nonzero(~wins)) >= self.places - 1
            self._answers[key] = Answers(
                spots, np.column_stack(queried), features.encode(), wins, contested
            )
        return self._answers[key]

    def _passable_spots(self, round: Round) -> Spots:
        """The spots whose ghost an empty road leaves room for.

        Raises:
            ConfigurationError: They are too few.
        """
        spots = self._passable_of(round)
        if len(spots) < self.places:
            raise ConfigurationError(
                f"{self.places} places are too many: this planner passes ghosts on {len(spots)}"
                " spots of an empty road"
            )
        return spots

    def _passable_of(self, round: Round) -> Spots:
        """The same, however few they are."""
        if round.kind not in self._passable:
            spots = spots_of(round.scene.road_type, round.intention)
            passable = self.empty_road(round, spots)
            self._passable[round.kind] = Spots(spots.positions[passable], spots.bias[passable])
        return self._passable[round.kind]

    def empty_road(self, round: Round, spots: Spots) -> NDArray[np.bool_]:
        """Whether a ghost on each spot leaves the plan safe where nothing else is, shape (S,)."""
        none = round.poses[:0]
        alone = replace(round, poses=none, believed=none, half_sizes=round.half_sizes[:0])
        return np.asarray(self._try(alone, spots).outcome == _SAFE)

    def _try(self, round: Round, spots: Spots) -> Queried:
        """What a ghost on each spot alone leads to."""
        there = np.ones((len(spots), 1), bool)
        return self.base.query([round] * len(spots), there, spots.poses[:, None])


def _placed(round: Round) -> PlacedRound:
    assert isinstance(round, PlacedRound)
    return round
